//! Cells of light space, and summaries of their nodes.

use glam::DVec2;

use crate::transport::clearance::CellClearance;
use crate::transport::first_surface::{middles, quarters};
use crate::transport::flux::Flux;

/// A path of light, by the place where it met the first surface.
#[derive(Clone, Copy, Debug)]
pub struct BeamNode<const N: usize> {
    /// Chart coordinates.
    pub at: DVec2,
    /// Film coordinates of its end, in texels; `None` if it did not come that far.
    pub landing: Option<DVec2>,
    /// True if an interface had no light to give to the next event.
    pub turned_back: bool,
    /// Flux \[W\] that arrives for a unit of chart area.
    pub weight: Flux<N>,
    /// Flux \[W\] that set out for a unit of chart area, mean of channels.
    pub emitted: f64,
    /// The surfaces that took part: the same number for paths of one smooth topology.
    pub topology: u64,
    /// The faces of smooth meshes after the first surface: the same number for paths that met the same.
    pub faces: u64,
}

/// A triangle of light space.
#[derive(Clone, Copy, Debug)]
pub struct BeamCell<const N: usize> {
    /// Its corners.
    pub corners: [BeamNode<N>; 3],
    /// Number of times that its patch was divided.
    pub level: u32,
    /// The legs of its light that are known to have nothing in their way.
    pub clearance: CellClearance,
    /// The [`CellSummary::weight_bend`] of the cell that it is a quarter of, if that was worth noting; else
    /// 0.
    pub noted_bend: f64,
    /// The [`CellSummary::bend`] of the cell that it is a quarter of; 0 for a patch.
    pub outer_bend: f64,
    /// The light of its corners as the affine map of the cell that it is a quarter of has it. `None` if it is
    /// no quarter, or if that cell has no such map.
    pub coarser: Option<[AffineNode<N>; 3]>,
}

/// Light by an affine map.
#[derive(Clone, Copy, Debug)]
pub struct AffineNode<const N: usize> {
    /// Film coordinates, in texels.
    pub landing: DVec2,
    /// Flux \[W\] for a unit of chart area.
    pub weight: Flux<N>,
}

impl<const N: usize> AffineNode<N> {
    /// The light of a node that lands.
    fn of(node: &BeamNode<N>) -> Option<Self> {
        let landing = node.landing?;
        Some(Self {
            landing,
            weight: node.weight,
        })
    }

    fn middle(a: &Self, b: &Self) -> Self {
        Self {
            landing: 0.5 * (a.landing + b.landing),
            weight: (a.weight + b.weight) * 0.5,
        }
    }
}

impl<const N: usize> BeamCell<N> {
    /// The cell that is all of a patch.
    #[inline]
    pub fn of_patch(corners: [BeamNode<N>; 3]) -> Self {
        Self {
            corners,
            level: 0,
            clearance: CellClearance::default(),
            noted_bend: 0.0,
            outer_bend: 0.0,
            coarser: None,
        }
    }

    /// Its area in chart coordinates.
    #[inline]
    pub fn area(&self) -> f64 {
        triangle_area(&self.corners)
    }

    /// Chart coordinates of its edges' middles, each opposite to the corner of the same index.
    #[inline]
    pub fn middles(&self) -> [DVec2; 3] {
        middles(self.corners.map(|node| node.at))
    }

    /// The corners of its quarters, given its edges' middles; the one in the middle comes last.
    #[inline]
    pub fn quarter_corners(&self, middles: &[BeamNode<N>; 3]) -> [[BeamNode<N>; 3]; 4] {
        quarters(self.corners, *middles)
    }

    /// Its quarters in the same order, with what they are to know of its bends.
    #[inline]
    pub fn quarters(
        &self,
        middles: &[BeamNode<N>; 3],
        noted_bend: f64,
        outer_bend: f64,
    ) -> [Self; 4] {
        let mut coarser = self.affine_quarters().into_iter();
        self.quarter_corners(middles).map(|corners| Self {
            corners,
            level: self.level + 1,
            clearance: self.clearance,
            noted_bend,
            outer_bend,
            coarser: coarser.next().flatten(),
        })
    }

    /// The corners of its quarters by its own affine map.
    fn affine_quarters(&self) -> [Option<[AffineNode<N>; 3]>; 4] {
        let [a, b, c] = &self.corners;
        let is_one = a.topology == b.topology && b.topology == c.topology;
        let corners = is_one
            .then(|| Some([AffineNode::of(a)?, AffineNode::of(b)?, AffineNode::of(c)?]))
            .flatten();
        let Some([a, b, c]) = corners else {
            return [None; 4];
        };
        let between = AffineNode::middle;
        quarters(
            [a, b, c],
            [between(&b, &c), between(&c, &a), between(&a, &b)],
        )
        .map(Some)
    }
}

/// Area in chart coordinates.
#[inline]
pub fn triangle_area<const N: usize>(corners: &[BeamNode<N>; 3]) -> f64 {
    let [a, b, c] = corners.map(|node| node.at);
    0.5 * (b - a).perp_dot(c - a).abs()
}

/// A summary of the six nodes of a cell: its corners and its edges' middles.
#[derive(Clone, Copy, Debug)]
pub struct CellSummary<const N: usize> {
    /// Number of topologies.
    pub topologies: u32,
    /// True if they met different faces of smooth meshes: then the map has kinks between them.
    pub is_kinked: bool,
    /// True if any landed.
    pub any_landed: bool,
    /// True if an interface turned any back.
    pub any_turned_back: bool,
    /// Largest distance \[texels\] of a middle's landing from the mean of its edge's ends, over edges of one
    /// topology.
    pub bend: f64,
    /// Largest difference of a middle's weight from the mean of its edge's ends likewise, the worst channel.
    pub weight_bend: f64,
    /// The box round all landings: its least corner.
    pub low: DVec2,
    /// Its greatest corner.
    pub high: DVec2,
    /// Area \[texels\] of the triangle between the corners' landings; of the box if not all landed.
    pub image_area: f64,
    /// The largest weight, channel by channel.
    pub weight: Flux<N>,
    /// The largest emission.
    pub emitted: f64,
}

impl<const N: usize> CellSummary<N> {
    /// The summary of a cell.
    #[inline]
    pub fn at(corners: &[BeamNode<N>; 3], middles: &[BeamNode<N>; 3]) -> Self {
        let topology = corners[0].topology;
        let mut is_one = true;
        let mut look = Self {
            topologies: 1,
            is_kinked: false,
            any_landed: false,
            any_turned_back: false,
            bend: 0.0,
            weight_bend: 0.0,
            low: DVec2::INFINITY,
            high: DVec2::NEG_INFINITY,
            image_area: 0.0,
            weight: Flux::BLACK,
            emitted: 0.0,
        };
        for node in corners.iter().chain(middles) {
            is_one &= node.topology == topology;
            look.is_kinked |= node.faces != corners[0].faces;
            look.emitted = look.emitted.max(node.emitted);
            look.any_turned_back |= node.turned_back;
            if let Some(at) = node.landing {
                look.any_landed = true;
                look.low = look.low.min(at);
                look.high = look.high.max(at);
                look.weight = look.weight.larger(node.weight);
            }
        }
        if !is_one {
            let nodes = [0, 1, 2, 3, 4, 5].map(|i| {
                if i < 3 {
                    corners[i].topology
                } else {
                    middles[i - 3].topology
                }
            });
            look.topologies = (0..6).filter(|&i| !nodes[..i].contains(&nodes[i])).count() as u32;
        }
        look.image_area = match corners.map(|node| node.landing) {
            [Some(a), Some(b), Some(c)] => 0.5 * (b - a).perp_dot(c - a).abs(),
            _ if look.any_landed => (look.high - look.low).element_product(),
            _ => 0.0,
        };
        for (index, middle) in middles.iter().enumerate() {
            let (a, b) = (&corners[(index + 1) % 3], &corners[(index + 2) % 3]);
            if let (Some(p), Some(q), Some(m)) = (a.landing, b.landing, middle.landing)
                && a.topology == middle.topology
                && b.topology == middle.topology
            {
                look.bend = look.bend.max((m - 0.5 * (p + q)).length());
                let mean = (a.weight + b.weight) * 0.5;
                look.weight_bend = look.weight_bend.max((middle.weight - mean).max_magnitude());
            }
        }
        look
    }

    /// True if all nodes are of one topology.
    #[inline]
    pub fn is_one_topology(&self) -> bool {
        self.topologies == 1
    }

    /// Number of texels of a film, about, that the cell's image meets: those along its length, and those of
    /// the part of its area that is on the film.
    #[inline]
    pub fn texels(&self, film: [usize; 2]) -> f64 {
        let on_film = self.high.min(end_of(film)) - self.low.max(DVec2::ZERO);
        let on_film = on_film.max(DVec2::ZERO);
        let size = self.high - self.low;
        let box_area = size.x * size.y;
        let part = if box_area > 0.0 {
            on_film.x * on_film.y / box_area
        } else {
            1.0
        };
        1.0 + on_film.max_element() + self.image_area * part
    }

    /// True if all that lands, lands beside a film of this size. The cell may bend as much again between its
    /// nodes as they show.
    #[inline]
    pub fn is_off(&self, size: [usize; 2]) -> bool {
        let margin = if self.is_one_topology() {
            DVec2::splat(2.0 * self.bend)
        } else {
            // Light that the nodes did not see may reach as far as light that they saw.
            (self.high - self.low).min(end_of(size))
        };
        self.is_off_by(margin, size)
    }

    /// True if all that lands, lands beside a film of this size, and farther from it than any two landings
    /// are from each other.
    #[inline]
    pub fn is_far_off(&self, size: [usize; 2]) -> bool {
        let margin = (self.high - self.low).max(DVec2::splat(2.0 * self.bend));
        self.is_off_by(margin, size)
    }

    #[inline]
    fn is_off_by(&self, margin: DVec2, size: [usize; 2]) -> bool {
        (self.high + margin).cmplt(DVec2::ZERO).any()
            || (self.low - margin).cmpgt(end_of(size)).any()
    }
}

/// The far corner of a film.
#[inline]
fn end_of(size: [usize; 2]) -> DVec2 {
    DVec2::new(size[0] as f64, size[1] as f64)
}
