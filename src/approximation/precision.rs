//! The precision of a technique's buffers: what is left of numbers that a device stores.

use glam::DVec3;
use half::f16;

use super::light_view::LightView;
use crate::geometry::SurfacePoint;
use crate::setting::words::words;

words! {
    /// The format of a light view's pictures: positions, normals and depths.
    Precision {
        /// Half floats (16 bits); depths in 24 bits, as a depth buffer of a pyramid has them
        F16 = "f16",
        /// Floats (32 bits); depths in 24 bits
        F32 = "f32",
        /// As computed
        Exact = "exact",
    }
}

impl Precision {
    /// Bytes of a number.
    pub fn bytes(self) -> u64 {
        match self {
            Self::F16 => 2,
            Self::F32 => 4,
            Self::Exact => 8,
        }
    }

    /// A vector as the buffer holds it.
    pub fn of_vector(self, v: DVec3) -> DVec3 {
        match self {
            Self::Exact => v,
            Self::F32 => v.map(|x| f64::from(x as f32)),
            Self::F16 => v.map(|x| f16::from_f64(x).to_f64()),
        }
    }

    /// A surface point as the buffer holds it. The error of its position grows, so that rays leave the
    /// surface from where it is stored. `None` if it lies beyond the buffer's largest number: 65504 of half
    /// floats.
    pub fn of_point(self, mut point: SurfacePoint) -> Option<SurfacePoint> {
        let unit = match self {
            Self::Exact => return Some(point),
            Self::F32 => f64::from(f32::EPSILON),
            Self::F16 => f16::EPSILON.to_f64(),
        };
        let stored = self.of_vector(point.position);
        // Half a unit in the last place, and half of the smallest half float.
        point.position_error += stored.abs() * (0.5 * unit) + 3e-8;
        point.position = stored;
        point.geometric_normal = self.of_vector(point.geometric_normal).normalize();
        point.shading_normal = self.of_vector(point.shading_normal).normalize();
        stored.is_finite().then_some(point)
    }

    /// A depth as a 24-bit depth buffer holds it: evenly in 1/depth between the nearest and the farthest; for
    /// parallel light evenly in depth.
    pub fn of_depth(self, depth: f64, view: &LightView) -> f64 {
        const STEPS: f64 = 16_777_215.0;
        if self == Self::Exact {
            return depth;
        }
        let stored = |place: f64| (place.clamp(0.0, 1.0) * STEPS).round() / STEPS;
        let [near, far] = view.range();
        if view.is_parallel() {
            return near + stored((depth - near) / (far - near)) * (far - near);
        }
        let (a, b) = (1.0 / near, 1.0 / far);
        1.0 / (a - stored((a - 1.0 / depth) / (a - b)) * (a - b))
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;

    fn stored(x: f64, precision: Precision) -> Option<SurfacePoint> {
        let point = SurfacePoint {
            position: DVec3::splat(x),
            position_error: DVec3::ZERO,
            geometric_normal: DVec3::Z,
            shading_normal: DVec3::Z,
            uv: DVec2::ZERO,
        };
        precision.of_point(point)
    }

    #[test]
    fn what_is_stored_is_within_the_error_that_is_told() {
        for precision in [Precision::Exact, Precision::F32, Precision::F16] {
            for x in [0.0, 1e-7, 0.1, -3.3, 60_000.0] {
                let point = stored(x, precision).unwrap();
                let off = (point.position - DVec3::splat(x)).abs();
                assert!(
                    off.cmple(point.position_error).all(),
                    "{precision:?} {x}: {off}"
                );
            }
        }
    }

    #[test]
    fn what_is_beyond_half_floats_is_not_stored() {
        assert!(stored(7e4, Precision::F16).is_none());
        assert!(stored(7e4, Precision::F32).is_some());
        assert!(stored(1e39, Precision::F32).is_none());
    }
}
