//! The space between two parallel planes.

use glam::DVec3;

/// All points whose dot product with a direction is within a range. A shape is beside it if that tells.
#[derive(Clone, Copy, Debug)]
pub struct PlanePair {
    /// A unit vector across the planes, or zero if all points are in it.
    pub(super) along: DVec3,
    pub(super) low: f64,
    pub(super) high: f64,
}

impl PlanePair {
    /// All space.
    pub const EVERYWHERE: Self = Self {
        along: DVec3::ZERO,
        low: f64::NEG_INFINITY,
        high: f64::INFINITY,
    };

    /// The points whose product with the unit vector `along` is at least `low`.
    pub fn above(along: DVec3, low: f64) -> Self {
        Self {
            along,
            low,
            high: f64::INFINITY,
        }
    }

    /// The points whose product with the unit vector `along` is at most `high`.
    pub fn below(along: DVec3, high: f64) -> Self {
        Self {
            along,
            low: f64::NEG_INFINITY,
            high,
        }
    }

    /// True if all values of this range are below it, or all above. It is false where something is not a
    /// number.
    #[inline]
    pub(super) fn is_apart_from(&self, least: f64, most: f64) -> bool {
        least > self.high || most < self.low
    }

    /// True if no point of the convex hull of `points` is in it.
    #[inline]
    pub fn is_beside(&self, points: &[DVec3]) -> bool {
        let mut least = f64::INFINITY;
        let mut most = f64::NEG_INFINITY;
        for point in points {
            let at = self.along.dot(*point);
            least = least.min(at);
            most = most.max(at);
        }
        self.is_apart_from(least, most)
    }
}
