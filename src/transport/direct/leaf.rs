//! Square parts of a texel, and the points of a quadrature over them.

use glam::DVec2;

/// Half the distance of two Gauss points on an interval of length 1: 1 / (2 √3).
pub(super) const GAUSS: f64 = 0.288_675_134_594_812_9;

/// Number of times that a leaf on a shadow's edge is quartered.
pub(super) const SHADOW_LEVELS: u32 = 6;

/// A part of a texel, by fractions across it.
#[derive(Clone, Copy)]
pub(super) struct Leaf {
    pub(super) from: DVec2,
    pub(super) size: f64,
    pub(super) level: u32,
}

impl Leaf {
    /// All of a texel.
    pub(super) const TEXEL: Self = Self {
        from: DVec2::ZERO,
        size: 1.0,
        level: 0,
    };

    pub(super) fn quarters(&self) -> [Self; 4] {
        [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)].map(|(i, j)| Self {
            from: self.from + DVec2::new(i, j) * (0.5 * self.size),
            size: 0.5 * self.size,
            level: self.level + 1,
        })
    }

    /// Points of weight 1/4 each, exact for polynomials of degree 3 in each direction.
    pub(super) fn gauss_points(&self) -> [DVec2; 4] {
        [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)]
            .map(|(i, j)| self.at(i * GAUSS, j * GAUSS))
    }

    /// The point (x, y) sizes from the middle.
    pub(super) fn at(&self, x: f64, y: f64) -> DVec2 {
        self.from + (DVec2::new(x, y) + 0.5) * self.size
    }
}
