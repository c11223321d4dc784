//! What a light's image must hold: shapes as they are seen, not their boxes.

use glam::DVec3;

use crate::geometry::{Bounds, Frame, Shape};
use crate::numeric::math;

/// What a light's image must hold.
#[derive(Clone, Copy, Debug)]
pub enum Extent<'a> {
    /// A box.
    Box(Bounds),
    /// A ball.
    Ball {
        /// Its middle.
        center: DVec3,
        /// Its radius \[m\].
        radius: f64,
    },
    /// The convex hull of some points.
    Points(&'a [DVec3]),
}

/// How far something reaches in the image of a view.
#[derive(Clone, Copy, Debug)]
pub struct Reach {
    /// The largest distance from the axis along either side of the image: on the plane at distance 1 of a
    /// pyramid, of parallel light in scene units. Infinite where something is beside or behind the light.
    pub half: f64,
    /// The least depth.
    pub ahead: f64,
}

impl<'a> Extent<'a> {
    /// That of a shape: exact for balls and meshes, its box for others.
    pub fn of(shape: &'a Shape) -> Self {
        match shape {
            Shape::Sphere(sphere) => Self::Ball {
                center: sphere.center(),
                radius: sphere.radius(),
            },
            Shape::Mesh(mesh) => Self::Points(mesh.positions()),
            Shape::Rectangle(_) | Shape::Disk(_) | Shape::Cylinder(_) => Self::Box(shape.bounds()),
        }
    }

    /// Its box.
    pub fn bounds(&self) -> Bounds {
        match *self {
            Self::Box(bounds) => bounds,
            Self::Ball { center, radius } => {
                Bounds::from_points([center - radius, center + radius])
            }
            Self::Points(points) => Bounds::from_points(points.iter().copied()),
        }
    }

    /// How far it reaches along the sides of a pyramid from `origin` about the frame's normal.
    pub fn in_pyramid(&self, frame: &Frame, origin: DVec3) -> Reach {
        let point = |place: DVec3| {
            let p = frame.to_local(place - origin);
            let half = if p.z > 0.0 {
                (p.x / p.z).abs().max((p.y / p.z).abs())
            } else {
                f64::INFINITY
            };
            Reach { half, ahead: p.z }
        };
        match *self {
            Self::Box(bounds) => farthest(bounds.corners().into_iter().map(point)),
            Self::Points(points) => farthest(points.iter().map(|place| point(*place))),
            Self::Ball { center, radius } => {
                let p = frame.to_local(center - origin);
                // Seen along the other side, a ball is a disc: its tangents are asin(R/d) from its middle.
                let half = [p.x, p.y]
                    .map(|across| {
                        let angle = math::atan2(across, p.z).abs()
                            + math::asin(radius / math::hypot(across, p.z));
                        if angle < std::f64::consts::FRAC_PI_2 {
                            math::tan(angle)
                        } else {
                            f64::INFINITY
                        }
                    })
                    .into_iter();
                Reach {
                    // From within, there is no tangent.
                    half: half
                        .map(|one| if one.is_nan() { f64::INFINITY } else { one })
                        .fold(0.0, f64::max),
                    ahead: p.z - radius,
                }
            }
        }
    }

    /// How far it reaches along the sides of a box of parallel light about `middle`; depths are from there.
    pub fn in_beam(&self, frame: &Frame, middle: DVec3) -> Reach {
        let around = |place: DVec3, radius: f64| {
            let p = frame.to_local(place - middle);
            Reach {
                half: p.x.abs().max(p.y.abs()) + radius,
                ahead: p.z - radius,
            }
        };
        match *self {
            Self::Box(bounds) => {
                let corners = bounds.corners().into_iter();
                farthest(corners.map(|corner| around(corner, 0.0)))
            }
            Self::Points(points) => farthest(points.iter().map(|place| around(*place, 0.0))),
            Self::Ball { center, radius } => around(center, radius),
        }
    }
}

/// The reach of all of some things.
pub fn farthest(all: impl Iterator<Item = Reach>) -> Reach {
    let nothing = Reach {
        half: 0.0,
        ahead: f64::INFINITY,
    };
    all.fold(nothing, |all, one| Reach {
        half: all.half.max(one.half),
        ahead: all.ahead.min(one.ahead),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_balls_tangents_bound_its_points_and_are_met_by_them() {
        let frame = Frame::along(DVec3::new(0.2, -0.4, -1.0).normalize(), DVec3::X);
        let (origin, center, radius) = (DVec3::new(0.3, 0.1, 4.0), DVec3::new(-0.5, 0.8, 0.6), 0.9);
        // A dense set of the ball's points, by spherical coordinates.
        let points: Vec<DVec3> = (0..400 * 800)
            .map(|index| {
                let polar = (f64::from(index / 800) + 0.5) / 400.0 * std::f64::consts::PI;
                let turn = f64::from(index % 800) / 800.0 * std::f64::consts::TAU;
                let (s, c) = (math::sin(polar), math::cos(polar));
                center + DVec3::new(s * math::cos(turn), s * math::sin(turn), c) * radius
            })
            .collect();
        let (ball, dense) = (Extent::Ball { center, radius }, Extent::Points(&points));
        for (exact, sampled) in [
            (
                ball.in_pyramid(&frame, origin),
                dense.in_pyramid(&frame, origin),
            ),
            (ball.in_beam(&frame, origin), dense.in_beam(&frame, origin)),
        ] {
            // Points are at most half a step of π/400 from the touching one: (π/800)²/2 of its radius short.
            for (exact, sampled) in [(exact.half, sampled.half), (sampled.ahead, exact.ahead)] {
                let short = exact - sampled;
                assert!((0.0..2e-5).contains(&short), "{exact} {sampled}");
            }
        }
    }

    #[test]
    fn what_is_around_or_behind_a_light_has_no_image() {
        let frame = Frame::along(DVec3::Z, DVec3::X);
        for center in [
            DVec3::ZERO,
            DVec3::new(0.3, 0.2, 0.1),
            DVec3::new(0.0, 5.0, 0.5),
        ] {
            let ball = Extent::Ball {
                center,
                radius: 1.0,
            };
            assert_eq!(ball.in_pyramid(&frame, DVec3::ZERO).half, f64::INFINITY);
        }
        let behind = [DVec3::new(0.0, 0.0, -1.0)];
        let behind = Extent::Points(&behind).in_pyramid(&frame, DVec3::ZERO);
        assert_eq!((behind.half, behind.ahead), (f64::INFINITY, -1.0));
    }
}
