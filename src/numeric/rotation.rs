//! Angles and rotations of vectors, by [`math`]: glam's own go to the standard library.

use super::math;
use glam::{DMat3, DVec2, DVec3};

/// The unit vector at `angle` \[rad\] from the x axis, towards y.
pub fn direction(angle: f64) -> DVec2 {
    let (sin, cos) = math::sin_cos(angle);
    DVec2::new(cos, sin)
}

/// The angle \[rad\] in \[0, π\] between two vectors of any lengths, accurate near 0 and π too. It is 0 if
/// either vector is 0.
pub fn angle_between(a: DVec3, b: DVec3) -> f64 {
    math::atan2(a.cross(b).length(), a.dot(b))
}

/// The rotation by `angle` \[rad\] about the unit vector `axis`, against the clock if it points to the
/// viewer.
///
/// Rodrigues' formula: cos·I + (1 − cos)·axis axisᵀ + sin·\[axis\]ₓ.
pub fn about(axis: DVec3, angle: f64) -> DMat3 {
    let (sin, cos) = math::sin_cos(angle);
    let along =
        |unit: DVec3| axis * axis.dot(unit) * (1.0 - cos) + unit * cos + axis.cross(unit) * sin;
    DMat3::from_cols(along(DVec3::X), along(DVec3::Y), along(DVec3::Z))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    /// Entries of a rotation are sums of three products below 1: off by a few 2⁻⁵³.
    const ROUNDING: f64 = 4.0 * f64::EPSILON;

    #[test]
    fn a_quarter_turn_takes_x_to_y() {
        assert!((direction(FRAC_PI_2) - DVec2::Y).length() < ROUNDING);
        assert!((about(DVec3::Z, FRAC_PI_2) * DVec3::X - DVec3::Y).length() < ROUNDING);
        assert!((about(DVec3::X, FRAC_PI_2) * DVec3::Y - DVec3::Z).length() < ROUNDING);
    }

    #[test]
    fn a_rotation_keeps_its_axis_and_all_lengths_and_turns_by_its_angle() {
        let axis = DVec3::new(1.0, 2.0, -0.5).normalize();
        let across = axis.any_orthonormal_vector();
        for angle in [-3.0, -0.7, 1e-9, 1.1, PI] {
            let turn = about(axis, angle);
            assert!((turn * axis - axis).length() < ROUNDING);
            assert!((turn.determinant() - 1.0).abs() < ROUNDING);
            let turned = turn * across;
            assert!((turned.length() - 1.0).abs() < ROUNDING);
            assert!((angle_between(across, turned) - angle.abs()).abs() < ROUNDING);
            assert!(axis.dot(across.cross(turned)) * angle >= 0.0);
        }
    }
}
