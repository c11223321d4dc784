//! A glass ball over the receiver, on the axis of the light.

use super::glass::Glass;
use super::known_layer::{KnownLayer, KnownLight};
use super::parts::{Body, LightOrigin, OneLight};
use super::plane::{ReceiverPlane, is_along_normal};
use super::ring_flux::radial_maps;
use crate::geometry::Sphere;
use crate::radiometry::Rgb;
use crate::reference::closed_form::{AxialLight, GlassBall, KnownPath};
use crate::run::Refusal;

/// Largest reach of the receiver, in heights of the ball's centre: parallel direct light is followed to 1000.
const WIDEST_RECEIVER: f64 = 900.0;

/// A ball in light of strength 1.
pub(super) struct BallOnAxis {
    ball: GlassBall,
    glass: Glass,
    strength: Rgb,
}

impl BallOnAxis {
    /// The ball of a scene.
    ///
    /// # Errors
    ///
    /// If it is no glass, not on the normal through the receiver's middle, or not between the receiver and a
    /// light on that normal.
    pub(super) fn new(
        plane: &ReceiverPlane,
        light: &OneLight,
        body: &Body,
        sphere: &Sphere,
    ) -> Result<Self, Refusal> {
        let glass = Glass::of(body, sphere.is_inward())?;
        let (center, radius) = (plane.point(sphere.center()), sphere.radius());
        if !plane.is_on_axis(center) {
            return Err(Refusal::new(format!(
                "{} has its centre ({:e}, {:e}) off the axis: it must be on the normal through the receiver's middle",
                body.name, center.x, center.y
            )));
        }
        if center.z <= radius {
            return Err(Refusal::new(format!(
                "{} has its centre at the height {} over the receiver and the radius {radius}: it must be in front of \
                 the receiver and not touch it",
                body.name, center.z
            )));
        }
        let light_above = match light.origin {
            LightOrigin::Point(position) => {
                if !plane.is_on_axis(position) {
                    return Err(Refusal::new(format!(
                        "{} is ({:e}, {:e}) off the axis: with a ball it must be on the normal through the receiver's \
                         middle",
                        light.name, position.x, position.y
                    )));
                }
                if position.z - center.z <= radius {
                    return Err(Refusal::new(format!(
                        "{} has the height {} over the receiver, the top of {} the height {}: the light must be above \
                         the ball",
                        light.name,
                        position.z,
                        body.name,
                        center.z + radius
                    )));
                }
                AxialLight::Point {
                    height: position.z,
                    intensity: 1.0,
                }
            }
            LightOrigin::Parallel(direction) => {
                if direction.z >= 0.0 || !is_along_normal(direction) {
                    return Err(Refusal::new(format!(
                        "{} has the direction ({}, {}, {}) in the receiver's coordinates: with a ball it must be \
                         (0, 0, -1)",
                        light.name, direction.x, direction.y, direction.z
                    )));
                }
                if plane.reach() > WIDEST_RECEIVER * center.z {
                    return Err(Refusal::new(format!(
                        "the receiver reaches {} from its middle, and {} is {} above it: up to {WIDEST_RECEIVER} times \
                         as far is allowed",
                        plane.reach(),
                        body.name,
                        center.z
                    )));
                }
                AxialLight::Parallel { irradiance: 1.0 }
            }
            _ => {
                return Err(Refusal::new(format!(
                    "{} falls on {}: with a ball, closed forms know point and directional lights",
                    light.name, body.name
                )));
            }
        };
        Ok(Self {
            ball: GlassBall {
                radius,
                center_height: center.z,
                ior: glass.ior,
                light: light_above,
            },
            glass,
            strength: light.strength,
        })
    }
}

impl KnownLight for BallOnAxis {
    fn layers(
        &self,
        plane: &ReceiverPlane,
        max_depth: u32,
        take: &mut dyn FnMut(KnownLayer) -> bool,
    ) -> Result<(), Refusal> {
        let film = plane.grid();
        body_paths(max_depth).all(|path| {
            let (values, accuracy) = radial_maps(&[self.ball.sheet(path)], &film);
            take(KnownLayer {
                path,
                values,
                accuracy,
                factor: self.strength * self.glass.factor(path),
            })
        });
        Ok(())
    }
}

/// All paths by a convex transparent body, of up to `max_depth` events.
pub(super) fn body_paths(max_depth: u32) -> impl Iterator<Item = KnownPath> {
    let reflected = (max_depth >= 1).then_some(KnownPath::Reflected(1));
    let through = (2..=max_depth).map(|events| KnownPath::Through(events - 2));
    std::iter::once(KnownPath::Direct)
        .chain(reflected)
        .chain(through)
}
