//! The directions in which a point sees a ball's shining side.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use crate::geometry::{Frame, Sphere};
use crate::numeric::math;

/// The view of a ball from a point.
///
/// Every direction towards the shining side is as likely as any other. From outside these directions fill a
/// cone. The ball shows its near side if it shines outward, and its far side if it shines inward. From inside
/// the directions are all or none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum BallView {
    /// Its shining side cannot be seen.
    Hidden,
    /// It fills a cone.
    Cone {
        /// The direction of its middle, a unit vector.
        axis: DVec3,
        /// Distance of the ball's middle.
        distance: f64,
        /// Distance of the ball's middle less its radius.
        gap: f64,
        /// 1 − the cosine of the cone's half angle.
        width: f64,
    },
    /// It is all round.
    Around {
        /// Vector from the ball's middle to the point.
        offset: DVec3,
        /// True if the point is on the ball itself, as far as can be told.
        is_on_surface: bool,
    },
}

/// A direction towards the shining side.
pub(super) struct BallSample {
    pub(super) direction: DVec3,
    pub(super) distance: f64,
    /// The cosine between the light's normal and the way back.
    pub(super) cos_light: f64,
}

impl BallView {
    /// The view of `ball` from `from`.
    pub(super) fn new(ball: &Sphere, from: DVec3) -> Self {
        let to_middle = ball.center() - from;
        let (distance, radius) = (to_middle.length(), ball.radius());
        // A point found on the ball is this far off it at most, and `from` may have been moved by as much to
        // leave it.
        let margin = 4.0 * ball.along(DVec3::Z).position_error.length();
        let gap = distance - radius;
        if gap > margin {
            let ratio = radius / distance;
            let cos = (gap * (distance + radius)).sqrt() / distance;
            Self::Cone {
                axis: to_middle / distance,
                distance,
                gap,
                // This is 1 − cos, which would cancel.
                width: ratio * ratio / (1.0 + cos),
            }
        } else if ball.is_inward() {
            Self::Around {
                offset: -to_middle,
                is_on_surface: gap >= -margin,
            }
        } else {
            Self::Hidden
        }
    }

    /// The density [1/sr] of [`sample`](Self::sample), the same in all its directions.
    pub(super) fn pdf_solid_angle(&self) -> f64 {
        match *self {
            Self::Hidden => 0.0,
            Self::Cone { width, .. } => 1.0 / (TAU * width),
            Self::Around { .. } => 1.0 / (4.0 * PI),
        }
    }

    /// A direction to the shining side, from uniform numbers.
    pub(super) fn sample(&self, ball: &Sphere, u: [f64; 2]) -> Option<BallSample> {
        let (sin_phi, cos_phi) = math::sin_cos(TAU * u[1]);
        match *self {
            Self::Hidden => None,
            Self::Cone {
                axis,
                distance,
                gap,
                width,
            } => {
                let below_one = u[0] * width;
                let cos = 1.0 - below_one;
                let sin_squared = below_one * (2.0 - below_one);
                let sin = sin_squared.sqrt();
                let local = DVec3::new(sin * cos_phi, sin * sin_phi, cos);
                // Half of the chord inside the ball: r² less the squared distance of line and middle.
                let radius = ball.radius();
                let miss = distance * sin;
                let half_chord = ((radius - miss) * (radius + miss)).max(0.0).sqrt();
                let far = distance * cos + half_chord;
                Some(BallSample {
                    direction: Frame::around(axis).to_world(local).normalize(),
                    distance: if ball.is_inward() {
                        far
                    } else {
                        gap * (distance + radius) / far
                    },
                    cos_light: half_chord / radius,
                })
            }
            Self::Around {
                offset,
                is_on_surface,
            } => {
                let cos = 1.0 - 2.0 * u[0];
                let sin = 2.0 * (u[0] * (1.0 - u[0])).sqrt();
                let direction = DVec3::new(sin * cos_phi, sin * sin_phi, cos).normalize();
                let outward = offset.dot(direction);
                if is_on_surface && outward >= 0.0 {
                    return None; // out of the ball, through the very point
                }
                let radius = ball.radius();
                let miss = (offset - direction * outward).length();
                let half_chord = ((radius - miss) * (radius + miss)).max(0.0).sqrt();
                Some(BallSample {
                    direction,
                    distance: half_chord - outward,
                    cos_light: half_chord / radius,
                })
            }
        }
    }
}
