//! What happens to light at a surface.

use crate::radiometry::Rgb;

/// The index of a [`Material`] in [`Scene::materials`](super::Scene::materials).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct MaterialId(pub u32);

/// What happens to light at a surface, with Mitsuba's meaning of every parameter.
#[derive(Clone, Debug, PartialEq)]
pub enum Material {
    /// Lambertian on the front, black on the back; ends every specular chain.
    Diffuse {
        /// Albedo, per channel in 0..=1; `None` where the file gives a texture or a spectrum from a
        /// file, which are not modelled. No irradiance depends on it; what a camera sees does.
        reflectance: Option<Rgb>,
    },
    /// A smooth interface between two transparent media.
    Dielectric {
        /// The absolute index on the side the normal points away from.
        interior_ior: f64,
        /// The absolute index on the side the normal points to.
        exterior_ior: f64,
        /// A factor on every reflection, 1 in nature.
        specular_reflectance: Rgb,
        /// A factor on every transmission, 1 in nature. It is applied once an
        /// interface, whatever the length of the path inside, as Mitsuba does.
        specular_transmittance: Rgb,
    },
    /// A pane so thin that it does not shift rays; all internal reflections summed.
    ThinDielectric {
        /// The absolute index of the pane.
        interior_ior: f64,
        /// The absolute index around it.
        exterior_ior: f64,
        /// A factor on reflection.
        specular_reflectance: Rgb,
        /// A factor on transmission.
        specular_transmittance: Rgb,
    },
    /// A smooth mirror on the front, black on the back.
    Conductor {
        /// The real part of the complex index, relative to the medium outside.
        eta: Rgb,
        /// The imaginary part, relative to the medium outside.
        k: Rgb,
        /// A factor on every reflection, 1 in nature.
        specular_reflectance: Rgb,
    },
    /// Nothing: light passes as if the surface were not there.
    Null,
    /// `nested` with probability `opacity`, nothing otherwise.
    Mask {
        /// In 0..=1.
        opacity: f64,
        /// What stands where the mask is opaque.
        nested: MaterialId,
    },
    /// One material on the front and one on the back, neither transmitting.
    TwoSided {
        /// On the side the normal points to.
        front: MaterialId,
        /// On the other side, with the normal turned round.
        back: MaterialId,
    },
}

impl Material {
    /// The name of Mitsuba's plugin.
    pub fn plugin(&self) -> &'static str {
        match self {
            Self::Diffuse { .. } => "diffuse",
            Self::Dielectric { .. } => "dielectric",
            Self::ThinDielectric { .. } => "thindielectric",
            Self::Conductor { .. } => "conductor",
            Self::Null => "null",
            Self::Mask { .. } => "mask",
            Self::TwoSided { .. } => "twosided",
        }
    }

    /// Whether light can leave it by mirror reflection or refraction, looking through masks
    /// and two-sided wrappers. `Null` is not: it changes no direction.
    pub fn is_specular(&self, all: &[Self]) -> bool {
        let of = |id: &MaterialId| all[id.0 as usize].is_specular(all);
        match self {
            Self::Dielectric { .. } | Self::ThinDielectric { .. } | Self::Conductor { .. } => true,
            Self::Diffuse { .. } | Self::Null => false,
            Self::Mask { opacity, nested } => *opacity > 0.0 && of(nested),
            Self::TwoSided { front, back } => of(front) || of(back),
        }
    }

    /// Whether light passes it as if nothing were there, without any other way to go.
    #[inline]
    pub fn is_passed(&self, all: &[Self]) -> bool {
        match self {
            Self::Null => true,
            Self::Mask { opacity, nested } => {
                *opacity == 0.0 || all[nested.0 as usize].is_passed(all)
            }
            _ => false,
        }
    }

    /// Whether light has two ways without an event between them: past it and by what it holds.
    pub fn is_partly_passed(&self, all: &[Self]) -> bool {
        match self {
            Self::Mask { opacity, nested } => {
                *opacity > 0.0 && *opacity < 1.0 && !all[nested.0 as usize].is_passed(all)
            }
            Self::TwoSided { front, back } => [front, back]
                .iter()
                .any(|id| all[id.0 as usize].is_partly_passed(all)),
            _ => false,
        }
    }

    /// Whether every factor on light is the same in red, green and blue.
    pub fn is_achromatic(&self, all: &[Self]) -> bool {
        let of = |id: &MaterialId| all[id.0 as usize].is_achromatic(all);
        match self {
            Self::Dielectric {
                specular_reflectance,
                specular_transmittance,
                ..
            }
            | Self::ThinDielectric {
                specular_reflectance,
                specular_transmittance,
                ..
            } => specular_reflectance.is_grey() && specular_transmittance.is_grey(),
            Self::Conductor {
                eta,
                k,
                specular_reflectance,
            } => eta.is_grey() && k.is_grey() && specular_reflectance.is_grey(),
            // A diffuse surface ends the chain: its colour changes no irradiance.
            Self::Diffuse { .. } | Self::Null => true,
            Self::Mask { nested, .. } => of(nested),
            Self::TwoSided { front, back } => of(front) && of(back),
        }
    }
}
