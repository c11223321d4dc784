//! A cylinder that mirrors inside, upright on the receiver.

use glam::DVec2;

use super::glass::{even, power};
use super::known_layer::{KnownLayer, KnownLight};
use super::parts::{Body, LightOrigin, OneLight};
use super::plane::{ReceiverPlane, is_along_normal};
use crate::geometry::Cylinder;
use crate::numeric::math;
use crate::radiometry::Rgb;
use crate::reference::closed_form::{CupLight, KnownPath, MirrorCup};
use crate::run::Refusal;
use crate::scene::Material;

/// Error of a texel as a part of the irradiance without the cup.
///
/// Each window of the quadrature is integrated to 1e-8 of it. A texel has one or two on each of two branches.
const OF_UNSHADED: f64 = 1e-7;

/// Largest angle (rad) between a side of the receiver and a direction along it.
const ALONG: f64 = 1e-13;

/// A cup in light of strength 1.
pub(super) struct MirroringCup {
    cup: MirrorCup,
    /// Foot of the cup's axis in the receiver's coordinates.
    foot: DVec2,
    /// Number of right angles from the receiver's x to the light's horizontal direction.
    quarter_turns: u32,
    reflectance: Rgb,
    strength: Rgb,
}

impl MirroringCup {
    /// The cup of a scene.
    ///
    /// # Errors
    ///
    /// If it is no perfect mirror on its inner side alone, does not stand on the receiver, or the light is
    /// not above its rim and in a plane along a side of the receiver.
    pub(super) fn new(
        plane: &ReceiverPlane,
        light: &OneLight,
        body: &Body,
        cylinder: &Cylinder,
    ) -> Result<Self, Refusal> {
        let reflectance = mirror(body)?;
        let side = cylinder.at_uv(DVec2::new(0.0, 0.5));
        let middle = cylinder.base() + cylinder.axis() * (0.5 * cylinder.length());
        if side.geometric_normal.dot(side.position - middle) > 0.0 {
            return Err(Refusal::new(format!(
                "{} mirrors outside: closed forms know cylinders that mirror inside (flip_normals true)",
                body.name
            )));
        }
        if !is_along_normal(plane.vector(cylinder.axis())) {
            return Err(Refusal::new(format!(
                "{} leans: its axis must be along the receiver's normal",
                body.name
            )));
        }
        let ends = [
            cylinder.base(),
            cylinder.base() + cylinder.axis() * cylinder.length(),
        ]
        .map(|end| plane.point(end));
        let (low, high) = (ends[0].z.min(ends[1].z), ends[0].z.max(ends[1].z));
        if !plane.coincide(low, cylinder.length()) {
            return Err(Refusal::new(format!(
                "{} begins at the height {low:e} over the receiver: it must stand on it",
                body.name
            )));
        }
        let (foot, radius) = (ends[0].truncate(), cylinder.radius());
        let (cup_light, azimuth) = light_over(plane, light, foot, radius, high)?;
        let quarter_turns = quarter_turns(azimuth).ok_or_else(|| {
            Refusal::new(format!(
                "{} shines along ({}, {}) in the receiver's plane: with a cup it must be along a side of the receiver",
                light.name, azimuth.x, azimuth.y
            ))
        })?;
        Ok(Self {
            cup: MirrorCup {
                radius,
                height: high,
                reflectance: 1.0,
                light: cup_light,
            },
            foot,
            quarter_turns,
            reflectance,
            strength: light.strength,
        })
    }

    /// Irradiance [W/m²] on the bottom without the cup, for a strength of 1.
    fn unshaded_irradiance(&self) -> f64 {
        match self.cup.light {
            CupLight::Parallel { tan_angle, .. } => 1.0 / math::hypot(1.0_f64, tan_angle),
            CupLight::Point {
                distance, height, ..
            } => height / math::powi(math::hypot(distance, height), 3),
        }
    }
}

impl KnownLight for MirroringCup {
    fn layers(
        &self,
        plane: &ReceiverPlane,
        max_depth: u32,
        take: &mut dyn FnMut(KnownLayer) -> bool,
    ) -> Result<(), Refusal> {
        let film = plane.grid_about(self.foot, self.quarter_turns);
        let accuracy = OF_UNSHADED * self.unshaded_irradiance();
        let paths =
            std::iter::once(KnownPath::Direct).chain((1..=max_depth).map(KnownPath::Reflected));
        let reflections = |path: KnownPath| match path {
            KnownPath::Reflected(count) => count,
            _ => 0,
        };
        // Light that is down before its next reflection leaves nothing to look for in any texel.
        let is_known = |path: &KnownPath| {
            *path == KnownPath::Direct || self.cup.bottom_flux(reflections(*path)) > 0.0
        };
        paths.filter(is_known).all(|path| {
            let values = film.in_film_order(&self.cup.map(path, &film.grid));
            take(KnownLayer {
                path,
                accuracy: vec![accuracy; values.len()],
                values,
                factor: self.strength * power(self.reflectance, reflections(path)),
            })
        });
        Ok(())
    }
}

/// The reflectance of a mirror that is the same at all angles.
fn mirror(body: &Body) -> Result<Rgb, Refusal> {
    let Material::Conductor {
        eta,
        specular_reflectance,
        ..
    } = body.material
    else {
        return Err(Refusal::new(format!(
            "{} has the material {}: closed forms know cylinders of material conductor",
            body.name,
            body.material.plugin()
        )));
    };
    if !eta.is_black() {
        return Err(Refusal::new(format!(
            "{} is a conductor of index eta ({}, {}, {}), which reflects by the angle: closed forms know material none \
             (eta 0)",
            body.name, eta.0[0], eta.0[1], eta.0[2]
        )));
    }
    even(body, specular_reflectance)
}

/// The light in the cup's frame, and the direction of that frame's x axis in the receiver's coordinates.
fn light_over(
    plane: &ReceiverPlane,
    light: &OneLight,
    foot: DVec2,
    radius: f64,
    rim: f64,
) -> Result<(CupLight, DVec2), Refusal> {
    match light.origin {
        LightOrigin::Parallel(direction) => {
            if direction.z >= 0.0 {
                return Err(Refusal::new(format!(
                    "{} comes from behind the receiver: it must fall into the cup",
                    light.name
                )));
            }
            let across = direction.truncate();
            let is_upright = is_along_normal(direction);
            let tan_angle = if is_upright {
                0.0
            } else {
                across.length() / -direction.z
            };
            let cup_light = CupLight::Parallel {
                tan_angle,
                irradiance: 1.0,
            };
            Ok((cup_light, if is_upright { DVec2::X } else { across }))
        }
        LightOrigin::Point(position) => {
            if position.z <= rim {
                return Err(Refusal::new(format!(
                    "{} has the height {} over the receiver, the cup's rim {rim}: the light must be above the rim",
                    light.name, position.z
                )));
            }
            let to_axis = foot - position.truncate();
            let mut distance = to_axis.length();
            // Above the wall itself the formula has a case of its own.
            if plane.coincide(distance - radius, radius) {
                distance = radius;
            }
            let is_central = plane.coincide(distance, radius);
            if is_central {
                distance = 0.0;
            }
            let cup_light = CupLight::Point {
                distance,
                height: position.z,
                intensity: 1.0,
            };
            Ok((cup_light, if is_central { DVec2::X } else { to_axis }))
        }
        _ => Err(Refusal::new(format!(
            "{} shines into a cup: with it, closed forms know point and directional lights",
            light.name
        ))),
    }
}

/// Number of right angles from x to a direction that is along x or y, either way.
fn quarter_turns(direction: DVec2) -> Option<u32> {
    let unit = direction.normalize();
    let axes = [DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y];
    let along = axes
        .iter()
        .position(|axis| axis.perp_dot(unit).abs() <= ALONG && axis.dot(unit) > 0.0)?;
    u32::try_from(along).ok()
}
