//! Cells of light space, and what is known of the light in them.

use glam::DVec2;

use crate::transport::flux::Flux;
use crate::transport::prescribed::{End, PathEnd};

/// A path, by where it met the first surface.
#[derive(Clone, Copy, Debug)]
pub struct Node<const N: usize> {
    /// Chart coordinates.
    pub at: DVec2,
    /// What became of it.
    pub path: PathEnd<N>,
}

impl<const N: usize> Node<N> {
    /// Where it fell on the film.
    #[inline]
    pub fn landing(&self) -> Option<DVec2> {
        match self.path.end {
            End::Landed(at) => Some(at),
            _ => None,
        }
    }
}

/// A triangle of light space.
#[derive(Clone, Copy, Debug)]
pub struct Cell<const N: usize> {
    /// Its corners.
    pub corners: [Node<N>; 3],
    /// How often its root was divided.
    pub level: u32,
}

impl<const N: usize> Cell<N> {
    /// Its area in chart coordinates.
    #[inline]
    pub fn area(&self) -> f64 {
        let [a, b, c] = self.corners.map(|node| node.at);
        0.5 * (b - a).perp_dot(c - a).abs()
    }

    /// Chart coordinates of its edges' middles, each opposite to the corner of the same index.
    #[inline]
    pub fn middles(&self) -> [DVec2; 3] {
        let [a, b, c] = self.corners.map(|node| node.at);
        // Sums commute: the neighbour across the edge gets the same bits.
        [0.5 * (b + c), 0.5 * (c + a), 0.5 * (a + b)]
    }

    /// Its quarters, given its edges' middles; the one in the middle comes last.
    #[inline]
    pub fn quarters(&self, middles: &[Node<N>; 3]) -> [Self; 4] {
        let [a, b, c] = self.corners;
        let [bc, ca, ab] = *middles;
        [[a, ab, ca], [ab, b, bc], [ca, bc, c], [bc, ca, ab]].map(|corners| Self {
            corners,
            level: self.level + 1,
        })
    }
}

/// What six nodes say of a cell.
#[derive(Clone, Copy, Debug)]
pub enum Look {
    /// One smooth family of light that lands.
    Smooth(Smooth),
    /// All light ended before the sensor, and the same way.
    Dark,
    /// Not one family.
    Mixed,
}

/// How far a smooth cell is from an affine map.
#[derive(Clone, Copy, Debug)]
pub struct Smooth {
    /// The largest distance of a middle's landing from the mean of its edge's ends [texels].
    pub bend: f64,
    /// The largest difference of a middle's weight from the mean of its edge's ends, the worst channel.
    pub weight_bend: f64,
    /// The box round the landings.
    pub low: DVec2,
    /// The box round the landings.
    pub high: DVec2,
}

/// Looks at a cell with its middles.
#[inline]
pub fn look<const N: usize>(cell: &Cell<N>, middles: &[Node<N>; 3]) -> Look {
    let family = cell.corners[0].path.family;
    let nodes = cell.corners.iter().chain(middles);
    if !nodes.clone().all(|node| node.path.family == family) {
        return Look::Mixed;
    }
    let mut smooth = Smooth {
        bend: 0.0,
        weight_bend: 0.0,
        low: DVec2::INFINITY,
        high: DVec2::NEG_INFINITY,
    };
    for node in nodes {
        let Some(at) = node.landing() else {
            return Look::Dark;
        };
        smooth.low = smooth.low.min(at);
        smooth.high = smooth.high.max(at);
    }
    for index in 0..3 {
        let (a, b) = (
            &cell.corners[(index + 1) % 3],
            &cell.corners[(index + 2) % 3],
        );
        let middle = &middles[index];
        let (Some(p), Some(q), Some(m)) = (a.landing(), b.landing(), middle.landing()) else {
            return Look::Dark;
        };
        smooth.bend = smooth.bend.max((m - 0.5 * (p + q)).length());
        let mean: Flux<N> = (a.path.weight + b.path.weight) * 0.5;
        smooth.weight_bend = smooth
            .weight_bend
            .max((middle.path.weight - mean).max_magnitude());
    }
    Look::Smooth(smooth)
}
