//! The part of a circle that lies in a rectangle.

use std::f64::consts::TAU;

use super::TexelRect;
use crate::numeric::math;

/// The fraction (0..=1/4) of the circle of `radius` about the origin that lies in `part`, a rectangle in the
/// first quadrant (corners with x, y ≥ 0).
///
/// There both coordinates are monotone along the circle: x ≤ r cos φ ≤ X and y ≤ r sin φ ≤ Y each allow
/// one interval of φ, and the answer is their overlap over 2π.
pub(super) fn circle_fraction(radius: f64, part: &TexelRect) -> f64 {
    let from = angle_of_x(radius, part.max.x).max(angle_of_y(radius, part.min.y));
    let to = angle_of_x(radius, part.min.x).min(angle_of_y(radius, part.max.y));
    (to - from).max(0.0) / TAU
}

/// The radii at which [`circle_fraction`] is not smooth: the distances of the corners, in rising order.
pub(super) fn corner_radii(part: &TexelRect) -> [f64; 4] {
    let mut radii = [
        part.min.length(),
        math::hypot(part.min.x, part.max.y),
        math::hypot(part.max.x, part.min.y),
        part.max.length(),
    ];
    radii.sort_unstable_by(f64::total_cmp);
    radii
}

/// acos(x / r), written so that nothing cancels near x = r; 0 if the circle does not reach x.
fn angle_of_x(radius: f64, x: f64) -> f64 {
    math::atan2(((radius - x).max(0.0) * (radius + x)).sqrt(), x)
}

/// asin(y / r); π/2 if the circle does not reach y.
fn angle_of_y(radius: f64, y: f64) -> f64 {
    math::atan2(y, ((radius - y).max(0.0) * (radius + y)).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rectangle_round_the_quarter_holds_a_quarter_of_the_circle() {
        assert_eq!(
            circle_fraction(1.0, &TexelRect::new(0.0, 0.0, 2.0, 2.0)),
            0.25
        );
    }

    #[test]
    fn a_rectangle_inside_or_outside_of_the_circle_holds_nothing_of_it() {
        assert_eq!(
            circle_fraction(1.0, &TexelRect::new(0.1, 0.1, 0.5, 0.6)),
            0.0
        );
        assert_eq!(
            circle_fraction(1.0, &TexelRect::new(0.8, 0.8, 1.5, 1.6)),
            0.0
        );
    }

    #[test]
    fn it_is_the_share_of_many_points_on_the_circle() {
        let part = TexelRect::new(0.3, 0.2, 0.9, 0.7);
        for radius in [0.4, 0.6, 0.75, 0.95, 1.1] {
            let count = 100_000;
            let inside = (0..count)
                .filter(|i| {
                    let (sin, cos) = math::sin_cos(TAU * (f64::from(*i) + 0.5) / f64::from(count));
                    let (x, y) = (radius * cos, radius * sin);
                    (part.min.x..part.max.x).contains(&x) && (part.min.y..part.max.y).contains(&y)
                })
                .count();
            // One arc: at most one point too many or too few at each of its two ends.
            let error = circle_fraction(radius, &part) - inside as f64 / f64::from(count);
            assert!(error.abs() <= 2.0 / f64::from(count), "{radius}: {error}");
        }
    }
}
