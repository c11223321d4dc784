//! Smooth glass of one index and one colour.

use super::parts::Body;
use crate::numeric::math;
use crate::radiometry::Rgb;
use crate::reference::closed_form::KnownPath;
use crate::run::Refusal;
use crate::scene::{Color, Material};

/// Smallest index of a body relative to its surroundings.
///
/// Nearer to 1, all refraction at grazing incidence happens within so small an angle that the rule of 16
/// nodes no longer integrates it to rounding.
pub(super) const LEAST_IOR: f64 = 1.05;

/// Glass of one index, and the factors on what it reflects and lets through.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Glass {
    /// The index inside relative to that outside.
    pub(super) ior: f64,
    reflectance: Rgb,
    transmittance: Rgb,
}

impl Glass {
    /// The glass of a body; `is_inward` if its normals point inside.
    ///
    /// # Errors
    ///
    /// If it is no smooth dielectric of even colour, or less dense than its surroundings.
    pub(super) fn of(body: &Body, is_inward: bool) -> Result<Self, Refusal> {
        let Material::Dielectric {
            interior_ior,
            exterior_ior,
            specular_reflectance,
            specular_transmittance,
        } = body.material
        else {
            return Err(Refusal::new(format!(
                "{} has the material {}: closed forms know this shape as dielectric",
                body.name,
                body.material.plugin()
            )));
        };
        let ior = if is_inward {
            exterior_ior / interior_ior
        } else {
            interior_ior / exterior_ior
        };
        if ior < LEAST_IOR {
            return Err(Refusal::new(format!(
                "{} has the index {ior} relative to its surroundings: closed forms know {LEAST_IOR} and more",
                body.name
            )));
        }
        Ok(Self {
            ior,
            reflectance: even(body, specular_reflectance)?,
            transmittance: even(body, specular_transmittance)?,
        })
    }

    /// The product of all factors along a path, beside Fresnel's.
    pub(super) fn factor(&self, path: KnownPath) -> Rgb {
        let (reflections, transmissions) = match path {
            KnownPath::Direct => (0, 0),
            KnownPath::Reflected(count) => (count, 0),
            KnownPath::Through(count) => (count, 2),
        };
        power(self.reflectance, reflections) * power(self.transmittance, transmissions)
    }
}

/// The colour of a factor that is the same everywhere.
///
/// # Errors
///
/// If it is a texture.
pub(super) fn even(body: &Body, color: &Color) -> Result<Rgb, Refusal> {
    match color {
        Color::Constant(rgb) => Ok(*rgb),
        Color::Texture(_) | Color::Unknown => Err(Refusal::new(format!(
            "{} has a {} with a texture: closed forms know factors that are the same everywhere",
            body.name,
            body.material.plugin()
        ))),
    }
}

/// Each channel to a whole power.
pub(super) fn power(color: Rgb, exponent: u32) -> Rgb {
    color.map(|channel| math::powf(channel, f64::from(exponent)))
}
