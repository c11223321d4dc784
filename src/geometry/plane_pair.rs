//! The space between two parallel planes.

use glam::DVec3;

/// All points whose dot product with a direction is within a range. A shape is beside it if that shows that
/// the two have no point in common.
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

    /// True if no point of the convex hull of `points` is in it: all are above, or all below. It is false if
    /// something is not a number.
    #[inline]
    pub fn is_beside(&self, points: &[DVec3]) -> bool {
        let (mut are_above, mut are_below) = (true, true);
        for point in points {
            let at = self.along.dot(*point);
            are_above &= at > self.high;
            are_below &= at < self.low;
        }
        are_above || are_below
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_beside_planes_if_all_are_above_or_all_below() {
        let pair = PlanePair {
            along: DVec3::Z,
            low: 1.0,
            high: 2.0,
        };
        let at = |heights: [f64; 2]| pair.is_beside(&heights.map(|height| DVec3::Z * height));
        assert!(at([2.5, 3.0]) && at([0.0, 0.5]));
        // One of them in it, on its border, or the two on either side.
        assert!(!at([1.5, 3.0]) && !at([2.0, 3.0]) && !at([0.5, 3.0]));
        assert!(!PlanePair::above(DVec3::Z, 1.0).is_beside(&[DVec3::Z * 9.0]));
        assert!(!PlanePair::below(DVec3::Z, 1.0).is_beside(&[DVec3::Z * -9.0]));
        assert!(!PlanePair::EVERYWHERE.is_beside(&[DVec3::ONE]));
    }

    #[test]
    fn what_is_not_a_number_is_beside_nothing() {
        let unknown = DVec3::Z * f64::NAN;
        assert!(!PlanePair::above(DVec3::Z, 1.0).is_beside(&[unknown]));
        assert!(!PlanePair::above(unknown, 1.0).is_beside(&[DVec3::ZERO]));
        assert!(!PlanePair::above(DVec3::Z, f64::NAN).is_beside(&[DVec3::ZERO]));
    }
}
