//! Hulls of the hierarchy's nodes: parent beams (section 3.3).

use glam::DVec2;

use super::beam::Beam;
use super::quadtree::{Node, Quadtree};
use super::slicing::{LocalBox, Rectangle, Slicing, join};
use super::variants::NodeHull;

/// The convex hull of two rectangles at two depths.
#[derive(Clone, Copy, Debug)]
pub struct Hull {
    /// The upper rectangle: its least and largest coordinates.
    pub top: Rectangle,
    /// The lower one.
    pub bottom: Rectangle,
    /// Their depths.
    pub depths: [f64; 2],
}

impl Hull {
    /// That of a beam, from its highest ray's start to the lowest plane.
    pub fn of_beam(beam: &Beam, slicing: &Slicing) -> Self {
        let depths = [beam.top(), slicing.bottom()];
        Self {
            top: beam.reach(depths[0]),
            bottom: beam.reach(depths[1]),
            depths,
        }
    }

    /// That of a beam's rays, from the top plane to the lowest one at `bottom`.
    pub fn of_rays(beam: &Beam, bottom: f64) -> Self {
        Self {
            top: beam.reach(0.0),
            bottom: beam.reach(bottom),
            depths: [0.0, bottom],
        }
    }

    /// The hull of both, if they are between the same depths.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self {
            top: join(self.top, other.top),
            bottom: join(self.bottom, other.bottom),
            depths: self.depths,
        }
    }

    /// The rectangle in which it is cut at a depth.
    #[inline]
    pub fn at(&self, depth: f64) -> Rectangle {
        let [from, to] = self.depths;
        let t = (depth - from) / (to - from);
        [0, 1].map(|i| self.top[i] + (self.bottom[i] - self.top[i]) * t)
    }

    /// Its eight corners, in local coordinates.
    pub fn corners(&self) -> [(DVec2, f64); 8] {
        std::array::from_fn(|i| {
            let rectangle = if i & 4 == 0 { self.top } else { self.bottom };
            let x = rectangle[i & 1].x;
            let y = rectangle[i >> 1 & 1].y;
            (DVec2::new(x, y), self.depths[i >> 2])
        })
    }

    /// True if a beam's rays leave it, between their starts and the lowest plane.
    pub fn is_left_by(&self, beam: &Beam) -> bool {
        beam.rulings.iter().any(|ruling| {
            [ruling.start, self.depths[1]].into_iter().any(|depth| {
                let ([low, high], place) = (self.at(depth), ruling.at(depth));
                // Ends of rays are computed twice; a thousandth of the hull's size is no escape of any beam's
                // light.
                let rounding = 1e-12 * (low.abs().max(high.abs()));
                let is_above = depth < self.depths[0];
                is_above || place.cmplt(low - rounding).any() || place.cmpgt(high + rounding).any()
            })
        })
    }
}

/// The hulls of all nodes, level by level; `None` of nodes without beams.
pub struct Hulls(Vec<Vec<Option<Hull>>>);

impl Hulls {
    /// The hulls of the nodes of a tree, whose beams are in its order.
    pub fn new(tree: &Quadtree, beams: &[Option<Beam>], slicing: &Slicing, kind: NodeHull) -> Self {
        let deepest = tree.levels() - 1;
        let leaf = |index: u32| {
            let node = Node {
                level: deepest,
                index,
            };
            let beams = beams[tree.triangles(node)].iter().flatten();
            let all = beams.map(|beam| Hull::of_rays(beam, slicing.bottom()));
            let padded = all.reduce(Hull::union)?;
            Some(match kind {
                NodeHull::Padded => padded,
                NodeHull::Paper => {
                    let mut top = LocalBox::EMPTY;
                    for corner in tree.corners(node) {
                        top.extend(slicing.local(corner));
                    }
                    Hull {
                        top: top.across,
                        bottom: square(padded.bottom),
                        depths: [top.depths[0], slicing.bottom()],
                    }
                }
            })
        };
        let mut levels: Vec<Vec<Option<Hull>>> = vec![(0..tree.nodes(deepest)).map(leaf).collect()];
        for _ in 0..deepest {
            let below = levels.last().map_or(&[][..], Vec::as_slice);
            let above = below
                .chunks(4)
                .map(|children| children.iter().copied().flatten().reduce(Hull::union));
            levels.push(above.collect());
        }
        levels.reverse();
        Self(levels)
    }

    /// A node's hull; `None` if it has no beams.
    pub fn of(&self, node: Node) -> Option<&Hull> {
        self.0[node.level as usize][node.index as usize].as_ref()
    }

    /// Bytes of all hulls on a device: two rectangles of four floats each.
    pub fn bytes(&self) -> u64 {
        self.0.iter().map(|level| 32 * level.len() as u64).sum()
    }
}

/// The square about a rectangle.
fn square([low, high]: Rectangle) -> Rectangle {
    let (middle, half) = (0.5 * (low + high), 0.5 * (high - low).max_element());
    [middle - half, middle + half]
}
