//! Angles as surface parameters.

use crate::numeric::math;

/// An angle as a fraction of a full turn, in `0..1`.
pub(super) fn turn_fraction(y: f64, x: f64) -> f64 {
    let turns = math::atan2(y, x) * std::f64::consts::FRAC_1_PI * 0.5;
    // A negative angle of less than u rounds up to a full turn: that is angle 0.
    let wrapped = if turns < 0.0 { turns + 1.0 } else { turns };
    if wrapped < 1.0 { wrapped } else { 0.0 }
}
