//! Stage `clamp`: beams in the view, and the parts of them in the boxes of receivers (section 3.3).

use glam::{DVec2, DVec3};

use super::beam::Beam;
use super::hull::{Hull, Hulls};
use super::quadtree::{Node, Quadtree};
use super::slicing::{LocalBox, Slicing};
use super::variants::Clamp;
use super::work::Work;

/// A beam that is drawn, between two planes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Draw {
    /// The beam, by its place in the tree's order.
    pub beam: u32,
    /// The first and the last plane.
    pub planes: [u32; 2],
}

/// The view, as planes in local coordinates: out of sight is where normal · (across, depth) > offset.
#[derive(Clone, Debug, Default)]
pub struct View {
    planes: Vec<(DVec3, f64)>,
}

/// How something lies to a view or a box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Lies {
    Outside,
    Inside,
    Across,
}

impl View {
    /// The view between planes, each a point and a normal that points out of sight.
    pub fn new(planes: &[[DVec3; 2]], slicing: &Slicing) -> Self {
        let local = |[point, normal]: &[DVec3; 2]| {
            let ((across, depth), (sideways, down)) =
                (slicing.local(*point), slicing.local_vector(*normal));
            let normal = sideways.extend(down);
            (normal, normal.dot(across.extend(depth)))
        };
        Self {
            planes: planes.iter().map(local).collect(),
        }
    }

    /// True if everything is in view, as on a receiver, which has no eye.
    pub fn is_everything(&self) -> bool {
        self.planes.is_empty()
    }

    fn lies(&self, hull: &Hull) -> Lies {
        let corners = hull.corners().map(|(across, depth)| across.extend(depth));
        let mut lies = Lies::Inside;
        for (normal, offset) in &self.planes {
            let beyond = corners
                .iter()
                .filter(|corner| normal.dot(**corner) > *offset)
                .count();
            if beyond == corners.len() {
                return Lies::Outside;
            }
            if beyond > 0 {
                lies = Lies::Across;
            }
        }
        lies
    }
}

/// How a hull lies to a receiver's box: outside, across its sides, or inside at some depth.
fn lies_to(target: &LocalBox, hull: &Hull) -> Lies {
    let low = target.depths[0].max(hull.depths[0]);
    let high = target.depths[1].min(hull.depths[1]);
    if low > high {
        return Lies::Outside;
    }
    // Each side of the hull is linear in depth: it is within a bound on an interval.
    let (from, to) = (hull.at(low), hull.at(high));
    let overlap = range_of(|i, t| {
        let least = from[0] + (to[0] - from[0]) * t;
        let largest = from[1] + (to[1] - from[1]) * t;
        [target.across[1] - least, largest - target.across[0]][i]
    });
    if overlap.is_none() {
        return Lies::Outside;
    }
    let inside = range_of(|i, t| {
        let least = from[0] + (to[0] - from[0]) * t;
        let largest = from[1] + (to[1] - from[1]) * t;
        [least - target.across[0], target.across[1] - largest][i]
    });
    if inside.is_some() {
        Lies::Inside
    } else {
        Lies::Across
    }
}

/// The part of 0..=1 on which four linear functions are not negative: the two coordinates of `value(0, t)`
/// and of `value(1, t)`.
fn range_of(value: impl Fn(usize, f64) -> DVec2) -> Option<[f64; 2]> {
    let (mut low, mut high) = (0.0_f64, 1.0_f64);
    for side in [0, 1] {
        let (start, end) = (value(side, 0.0).to_array(), value(side, 1.0).to_array());
        for (a, b) in start.into_iter().zip(end) {
            match (a >= 0.0, b >= 0.0) {
                (true, true) => {}
                (false, false) => return None,
                (true, false) => high = high.min(a / (a - b)),
                (false, true) => low = low.max(a / (a - b)),
            }
        }
    }
    (low <= high).then_some([low, high])
}

/// What stage `clamp` works on.
pub struct Culling<'a> {
    /// The hierarchy.
    pub tree: &'a Quadtree,
    /// Its beams, in its order.
    pub beams: &'a [Option<Beam>],
    /// Beams that shadow culling leaves, in the same order.
    pub is_lit: &'a [bool],
    /// The nodes' hulls, for the hierarchy.
    pub hulls: Option<&'a Hulls>,
    /// The planes.
    pub slicing: &'a Slicing,
    /// What is seen.
    pub view: &'a View,
    /// The boxes of receivers.
    pub boxes: &'a [LocalBox],
}

impl Culling<'_> {
    /// The beams to draw, in the tree's order, with the planes to draw them between.
    pub fn draws(&self, clamp: Clamp, work: &mut Work) -> Vec<Draw> {
        let mut draws = Vec::new();
        match clamp {
            Clamp::Exact => {
                let planes = [0, self.slicing.slices()];
                let lit = (0_u32..)
                    .zip(self.beams)
                    .filter(|(place, beam)| beam.is_some() && self.is_lit[*place as usize]);
                draws.extend(lit.map(|(beam, _)| Draw { beam, planes }));
            }
            Clamp::Beams => {
                let all: Vec<usize> = (0..self.boxes.len()).collect();
                for place in 0..self.beams.len() {
                    let is_seen = self.view.is_everything();
                    self.beam(place, is_seen, &all, &[], &mut draws, work);
                }
            }
            Clamp::Hierarchy => {
                let all: Vec<usize> = (0..self.boxes.len()).collect();
                for root in self.tree.roots() {
                    let is_seen = self.view.is_everything();
                    self.node(root, is_seen, &all, &[], &mut draws, work);
                }
            }
        }
        draws
    }

    /// A node: `is_seen` if all of it is known to be in view; `open` are boxes to test, `certain` boxes that
    /// all its beams meet.
    fn node(
        &self,
        node: Node,
        mut is_seen: bool,
        open: &[usize],
        certain: &[usize],
        draws: &mut Vec<Draw>,
        work: &mut Work,
    ) {
        let Some(hull) = self.hulls.and_then(|hulls| hulls.of(node)) else {
            return;
        };
        work.nodes += 1;
        if !is_seen {
            work.tests += 1;
            match self.view.lies(hull) {
                Lies::Outside => {
                    let is_there =
                        |place: &usize| self.beams[*place].is_some() && self.is_lit[*place];
                    work.culled += self.tree.triangles(node).filter(is_there).count() as u64;
                    return;
                }
                Lies::Inside => is_seen = true,
                Lies::Across => {}
            }
        }
        let (mut still, mut sure) = (Vec::new(), certain.to_vec());
        for &index in open {
            work.tests += 1;
            match lies_to(&self.boxes[index], hull) {
                Lies::Outside => {}
                Lies::Inside => sure.push(index),
                Lies::Across => still.push(index),
            }
        }
        if still.is_empty() && sure.is_empty() {
            return;
        }
        match self.tree.children(node) {
            Some(children) => {
                for child in children {
                    self.node(child, is_seen, &still, &sure, draws, work);
                }
            }
            None => {
                for place in self.tree.triangles(node) {
                    self.beam(place, is_seen, &still, &sure, draws, work);
                }
            }
        }
    }

    /// A beam by itself.
    fn beam(
        &self,
        place: usize,
        is_seen: bool,
        open: &[usize],
        certain: &[usize],
        draws: &mut Vec<Draw>,
        work: &mut Work,
    ) {
        let Some(beam) = self.beams[place].as_ref().filter(|_| self.is_lit[place]) else {
            return;
        };
        let hull = Hull::of_beam(beam, self.slicing);
        if !is_seen {
            work.tests += 1;
            if self.view.lies(&hull) == Lies::Outside {
                work.culled += 1;
                return;
            }
        }
        let met = open.iter().filter(|&&index| {
            work.tests += 1;
            lies_to(&self.boxes[index], &hull) != Lies::Outside
        });
        let mut ranges: Vec<[u32; 2]> = met
            .chain(certain)
            .map(|&index| self.slicing.planes_around(self.boxes[index].depths))
            .collect();
        ranges.sort_unstable();
        let mut merged: Vec<[u32; 2]> = Vec::with_capacity(ranges.len());
        for range in ranges {
            match merged.last_mut() {
                // Ranges that touch are one.
                Some(last) if range[0] <= last[1] => last[1] = last[1].max(range[1]),
                _ => merged.push(range),
            }
        }
        draws.extend(merged.into_iter().map(|planes| Draw {
            beam: place as u32,
            planes,
        }));
    }
}
