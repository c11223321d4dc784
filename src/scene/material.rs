//! The materials of a scene.

use std::sync::Arc;

use super::principled::Principled;
use super::principled_thin::PrincipledThin;
use super::texture::{Color, Scalar, TextureId};
use crate::optics::{FacetDistribution, RoughTransmittance};
use crate::radiometry::Rgb;

/// The index of a [`Material`] in [`Scene::materials`](super::Scene::materials).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct MaterialId(pub u32);

/// The material of a surface, with Mitsuba's meaning of every parameter.
#[derive(Clone, Debug, PartialEq)]
pub enum Material {
    /// Lambertian on the front, black on the back; ends every specular chain.
    Diffuse {
        /// Albedo, per channel in 0..=1. Irradiance does not depend on it; the light that a camera sees does.
        reflectance: Color,
    },
    /// A smooth interface between two transparent media.
    Dielectric {
        /// The absolute index on the side the normal points away from.
        interior_ior: f64,
        /// The absolute index on the side the normal points to.
        exterior_ior: f64,
        /// A factor on every reflection, 1 in nature.
        specular_reflectance: Color,
        /// A factor on every transmission, 1 in nature. As in Mitsuba, it is applied once at each interface,
        /// whatever the length of the path inside.
        specular_transmittance: Color,
    },
    /// A pane so thin that it does not shift rays, with all internal reflections summed.
    ThinDielectric {
        /// The absolute index of the pane.
        interior_ior: f64,
        /// The absolute index around it.
        exterior_ior: f64,
        /// A factor on reflection.
        specular_reflectance: Color,
        /// A factor on transmission.
        specular_transmittance: Color,
    },
    /// A smooth mirror on the front, black on the back.
    Conductor {
        /// The real part of the complex index, relative to the medium outside.
        eta: Rgb,
        /// The imaginary part, relative to the medium outside.
        k: Rgb,
        /// A factor on every reflection, 1 in nature.
        specular_reflectance: Color,
    },
    /// A rough interface between two transparent media.
    RoughDielectric {
        /// The absolute index on the side the normal points away from.
        interior_ior: f64,
        /// The absolute index on the side the normal points to.
        exterior_ior: f64,
        /// A factor on every reflection, 1 in nature.
        specular_reflectance: Color,
        /// A factor on every transmission, 1 in nature.
        specular_transmittance: Color,
        /// The interface's roughness.
        roughness: Roughness,
    },
    /// A rough mirror on the front, black on the back.
    RoughConductor {
        /// The real part of the complex index, relative to the medium outside.
        eta: Rgb,
        /// The imaginary part, relative to the medium outside.
        k: Rgb,
        /// A factor on every reflection, 1 in nature.
        specular_reflectance: Color,
        /// The interface's roughness.
        roughness: Roughness,
    },
    /// A matt base under a smooth transparent coat on the front, black on the back.
    Plastic(Coat),
    /// A matt base under a rough transparent coat on the front, black on the back.
    RoughPlastic {
        /// The base, and the coat's index.
        coat: Coat,
        /// The distribution of the coat's slopes.
        distribution: FacetDistribution,
        /// The coat's roughness, the same in all directions.
        alpha: f64,
        /// The part of light that the coat lets through.
        transmittance: Arc<RoughTransmittance>,
    },
    /// A matt base with a sheen and a second coat, metal and rough glass, all in shares.
    Principled(Box<Principled>),
    /// A sheet without thickness, the same on both sides: matt, see-through and glossy parts, all in shares.
    PrincipledThin(Box<PrincipledThin>),
    /// Nothing: light passes as if the surface were not there.
    Null,
    /// `nested` with probability `opacity`, nothing otherwise.
    Mask {
        /// The probability, in 0..=1.
        opacity: Scalar,
        /// The material where the mask is opaque.
        nested: MaterialId,
    },
    /// One material on the front and one on the back, neither transmitting.
    TwoSided {
        /// The material on the side the normal points to.
        front: MaterialId,
        /// The material on the other side, with the normal turned round.
        back: MaterialId,
    },
    /// Two materials, in shares that add up to one.
    Blend {
        /// The share of the second one. A texture's numbers below 0 mean 0, those above 1 mean 1.
        weight: Scalar,
        /// The materials. Neither is a mask or nothing, nor wraps one.
        nested: [MaterialId; 2],
    },
    /// `nested` with a normal that a texture turns.
    Turned {
        /// The texture that turns the normal.
        by: NormalTurn,
        /// True to turn a normal that faces away from the viewer round its unturned one, so that it faces the
        /// viewer.
        flip_invalid_normals: bool,
        /// True to soften the border of shadows that turned normals make.
        use_shadowing_function: bool,
        /// The material itself: no wrapper but a blend of materials without wrappers.
        nested: MaterialId,
    },
}

/// The roughness of an interface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Roughness {
    /// The shape of the distribution of slopes.
    pub distribution: FacetDistribution,
    /// Roughness along the first tangent, along which u grows.
    pub alpha_u: Scalar,
    /// Roughness along the second tangent.
    pub alpha_v: Scalar,
}

/// A matt base under a transparent coat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coat {
    /// The absolute index of the coat.
    pub interior_ior: f64,
    /// The absolute index of the medium around.
    pub exterior_ior: f64,
    /// Albedo of the base.
    pub diffuse_reflectance: Color,
    /// A factor on what the coat reflects, 1 in nature.
    pub specular_reflectance: Color,
    /// True if light that is reflected back and forth below the coat takes on the base's colour each time.
    pub nonlinear: bool,
}

/// The texture that turns a normal, and its meaning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NormalTurn {
    /// A height over the surface, in scene units once multiplied by `scale`.
    Height {
        /// A texture; only its luminance counts.
        texture: TextureId,
        /// A factor.
        scale: f64,
    },
    /// The normal itself in the frame of the surface, each coordinate x stored as (x + 1)/2.
    Normal {
        /// A colour; red, green and blue count.
        color: Color,
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
            Self::RoughDielectric { .. } => "roughdielectric",
            Self::RoughConductor { .. } => "roughconductor",
            Self::Plastic(_) => "plastic",
            Self::RoughPlastic { .. } => "roughplastic",
            Self::Principled(_) => "principled",
            Self::PrincipledThin(_) => "principledthin",
            Self::Blend { .. } => "blendbsdf",
            Self::Turned {
                by: NormalTurn::Height { .. },
                ..
            } => "bumpmap",
            Self::Turned { .. } => "normalmap",
            Self::Null => "null",
            Self::Mask { .. } => "mask",
            Self::TwoSided { .. } => "twosided",
        }
    }

    /// The materials that it wraps.
    pub fn nested(&self) -> impl Iterator<Item = MaterialId> {
        let (first, second) = match self {
            Self::Mask { nested, .. } | Self::Turned { nested, .. } => (Some(*nested), None),
            Self::TwoSided { front, back } => (Some(*front), Some(*back)),
            Self::Blend { nested: [a, b], .. } => (Some(*a), Some(*b)),
            _ => (None, None),
        };
        first.into_iter().chain(second)
    }

    /// The share (0..=1) of a surface that is there, the product of its masks, and what they hold. If that is
    /// nothing, so is the share. `value_of` is a mask's opacity.
    pub fn below_masks<'a>(
        &'a self,
        all: &'a [Self],
        value_of: impl Fn(Scalar) -> f64,
    ) -> (f64, &'a Self) {
        let (mut material, mut share) = (self, 1.0);
        while let Self::Mask { opacity, nested } = material {
            share *= value_of(*opacity).clamp(0.0, 1.0);
            material = &all[nested.0 as usize];
        }
        match material {
            Self::Null => (0.0, material),
            _ => (share, material),
        }
    }

    /// True if `test` holds for it or for anything it wraps.
    pub fn holds(&self, all: &[Self], test: &impl Fn(&Self) -> bool) -> bool {
        let mut nested = self.nested();
        test(self) || nested.any(|id| all[id.0 as usize].holds(all, test))
    }

    /// The ids of the materials that it wraps, to be changed.
    pub(super) fn nested_mut(&mut self) -> impl Iterator<Item = &mut MaterialId> {
        let (first, second) = match self {
            Self::Mask { nested, .. } | Self::Turned { nested, .. } => (Some(nested), None),
            Self::TwoSided { front, back } => (Some(front), Some(back)),
            Self::Blend { nested: [a, b], .. } => (Some(a), Some(b)),
            _ => (None, None),
        };
        first.into_iter().chain(second)
    }

    /// The colours of the material itself that may vary, without those of materials it wraps.
    pub fn colors(&self) -> impl Iterator<Item = Color> {
        let (first, second) = match self {
            Self::Diffuse { reflectance } => (Some(*reflectance), None),
            Self::Dielectric {
                specular_reflectance,
                specular_transmittance,
                ..
            }
            | Self::ThinDielectric {
                specular_reflectance,
                specular_transmittance,
                ..
            }
            | Self::RoughDielectric {
                specular_reflectance,
                specular_transmittance,
                ..
            } => (Some(*specular_reflectance), Some(*specular_transmittance)),
            Self::Conductor {
                specular_reflectance,
                ..
            }
            | Self::RoughConductor {
                specular_reflectance,
                ..
            } => (Some(*specular_reflectance), None),
            Self::Plastic(coat) | Self::RoughPlastic { coat, .. } => (
                Some(coat.diffuse_reflectance),
                Some(coat.specular_reflectance),
            ),
            Self::Turned {
                by: NormalTurn::Normal { color },
                ..
            } => (Some(*color), None),
            Self::Principled(principled) => (Some(principled.base_color), None),
            Self::PrincipledThin(sheet) => (Some(sheet.base_color), None),
            _ => (None, None),
        };
        first.into_iter().chain(second)
    }

    /// The numbers of the material itself that may vary, without those of materials it wraps.
    pub fn scalars(&self) -> impl Iterator<Item = Scalar> {
        let (first, second) = match self {
            Self::Mask { opacity, .. } => (Some(*opacity), None),
            Self::Blend { weight, .. } => (Some(*weight), None),
            Self::RoughDielectric { roughness, .. } | Self::RoughConductor { roughness, .. } => {
                (Some(roughness.alpha_u), Some(roughness.alpha_v))
            }
            _ => (None, None),
        };
        let principled = match self {
            Self::Principled(principled) => Some(principled.scalars().map(|(_, scalar)| scalar)),
            _ => None,
        };
        let sheet = match self {
            Self::PrincipledThin(sheet) => Some(sheet.scalars()),
            _ => None,
        };
        let own = first.into_iter().chain(second);
        own.chain(principled.into_iter().flatten())
            .chain(sheet.into_iter().flatten())
    }

    /// True if light can leave it along a specular chain: by mirror reflection or refraction, looking through
    /// masks, two-sided wrappers and blends.
    ///
    /// `Null` is not specular: it changes no direction. Neither are rough interfaces and turned normals (see
    /// [`Self::is_rough_interface`]): specular chains end there, and photons go on from the former.
    pub fn is_specular(&self, all: &[Self]) -> bool {
        match self {
            Self::Dielectric { .. } | Self::ThinDielectric { .. } | Self::Conductor { .. } => true,
            Self::Mask { opacity, .. } if !opacity.may_exceed_zero() => false,
            Self::Mask { .. } | Self::TwoSided { .. } | Self::Blend { .. } => {
                self.nested().any(|id| all[id.0 as usize].is_specular(all))
            }
            _ => false,
        }
    }

    /// True if some part of it mirrors or refracts without blur, in whatever wrapper: a coat, or with a
    /// turned normal, too.
    pub fn has_delta(&self, all: &[Self]) -> bool {
        let is_one = |it: &Self| {
            matches!(
                it,
                Self::Dielectric { .. }
                    | Self::ThinDielectric { .. }
                    | Self::Conductor { .. }
                    | Self::Plastic(_)
            )
        };
        self.holds(all, &is_one)
    }

    /// True if light can leave it in many directions by a rough interface, looking through masks and
    /// two-sided wrappers: chains of photons go on there by lot. They end at the rough parts of blends (see
    /// [`Self::is_blended_gloss`]).
    pub fn is_glossy(&self, all: &[Self]) -> bool {
        let is_one = |it: &Self| {
            matches!(
                it,
                Self::RoughDielectric { .. } | Self::RoughConductor { .. }
            )
        };
        self.has_unblended(all, &is_one)
    }

    /// True if it is a coat over a matt base.
    pub fn is_coat(&self) -> bool {
        matches!(self, Self::Plastic(_) | Self::RoughPlastic { .. })
    }

    /// True if light can leave it by a coat of either kind, as [`Self::has_smooth_coat`].
    pub fn has_coat(&self, all: &[Self]) -> bool {
        self.has_unblended(all, &Self::is_coat)
    }

    /// True if light can leave it by a smooth coat over a matt base, looking through masks and two-sided
    /// wrappers.
    pub fn has_smooth_coat(&self, all: &[Self]) -> bool {
        self.has_unblended(all, &|it| matches!(it, Self::Plastic(_)))
    }

    /// The same of rough coats.
    pub fn has_rough_coat(&self, all: &[Self]) -> bool {
        self.has_unblended(all, &|it| matches!(it, Self::RoughPlastic { .. }))
    }

    fn has_unblended(&self, all: &[Self], is_one: &impl Fn(&Self) -> bool) -> bool {
        match self {
            Self::Mask { opacity, .. } if !opacity.may_exceed_zero() => false,
            Self::Mask { .. } | Self::TwoSided { .. } => self
                .nested()
                .any(|id| all[id.0 as usize].has_unblended(all, is_one)),
            _ => is_one(self),
        }
    }

    /// True if it blends a rough interface with another material, or wraps such a blend whose normals no
    /// texture turns.
    pub fn is_blended_gloss(&self, all: &[Self]) -> bool {
        let mut nested = self.nested().map(|id| &all[id.0 as usize]);
        match self {
            Self::Turned { .. } => false,
            Self::Blend { .. } => nested.any(|it| it.is_glossy(all) || it.is_blended_gloss(all)),
            _ => nested.any(|it| it.is_blended_gloss(all)),
        }
    }

    /// True if it blends a coat over a matt base with another material, or wraps such a blend whose normals
    /// no texture turns.
    pub fn is_blended_coat(&self, all: &[Self]) -> bool {
        let mut nested = self.nested().map(|id| &all[id.0 as usize]);
        match self {
            Self::Turned { .. } => false,
            Self::Blend { .. } => nested.any(|it| it.holds(all, &Self::is_coat)),
            _ => nested.any(|it| it.is_blended_coat(all)),
        }
    }

    /// True if it blends a smooth interface with another material, or wraps such a blend.
    pub fn is_blended_interface(&self, all: &[Self]) -> bool {
        match self {
            Self::Blend { .. } => self.is_specular(all),
            Self::Turned { .. } => false,
            _ => self
                .nested()
                .any(|id| all[id.0 as usize].is_blended_interface(all)),
        }
    }

    /// True if it mirrors or refracts with a blur, or with normals that a texture turns. Such light is no
    /// part of specular chains, though it may make caustics.
    pub fn is_rough_interface(&self, all: &[Self]) -> bool {
        let of = |id: MaterialId| all[id.0 as usize].is_rough_interface(all);
        match self {
            Self::RoughDielectric { .. } | Self::RoughConductor { .. } => true,
            Self::Principled(principled) => principled.is_interface(),
            Self::PrincipledThin(sheet) => sheet.is_interface(),
            Self::Turned { nested, .. } => {
                let nested = &all[nested.0 as usize];
                nested.is_specular(all)
                    || nested.is_rough_interface(all)
                    || nested.holds(all, &Self::is_coat)
            }
            _ => self.nested().any(of),
        }
    }

    /// True if it mirrors or refracts, smooth or rough, with normals that a texture turns.
    pub fn is_turned_interface(&self, all: &[Self]) -> bool {
        if matches!(self, Self::Turned { .. }) {
            return self.is_rough_interface(all);
        }
        self.nested()
            .any(|id| all[id.0 as usize].is_turned_interface(all))
    }

    /// True if it is a `principled` with metal or glass, a `principledthin` that mirrors, or wraps one whose
    /// normals no texture turns.
    pub fn is_principled_interface(&self, all: &[Self]) -> bool {
        let mut nested = self.nested();
        match self {
            Self::Principled(principled) => principled.is_interface(),
            Self::PrincipledThin(sheet) => sheet.is_interface(),
            Self::Turned { .. } => false,
            _ => nested.any(|id| all[id.0 as usize].is_principled_interface(all)),
        }
    }

    /// True if light passes it as if nothing were there, and has no other way to go.
    #[inline]
    pub fn is_passed(&self, all: &[Self]) -> bool {
        match self {
            Self::Null => true,
            Self::Mask { opacity, nested } => {
                !opacity.may_exceed_zero() || all[nested.0 as usize].is_passed(all)
            }
            _ => false,
        }
    }

    /// True if light has two ways without an event between them: past the surface, and by the material it
    /// holds.
    pub fn is_partly_passed(&self, all: &[Self]) -> bool {
        match self {
            Self::Mask { opacity, nested } => {
                let nested = &all[nested.0 as usize];
                let is_partly = opacity.is_partial() && !nested.is_passed(all);
                is_partly || (opacity.may_exceed_zero() && nested.is_partly_passed(all))
            }
            Self::TwoSided { front, back } => [front, back]
                .iter()
                .any(|id| all[id.0 as usize].is_partly_passed(all)),
            _ => false,
        }
    }

    /// True if every factor on light that stays on chains of mirrors and glass is the same in red, green and
    /// blue.
    pub fn is_achromatic(&self, all: &[Self]) -> bool {
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
            }
            | Self::RoughDielectric {
                specular_reflectance,
                specular_transmittance,
                ..
            } => specular_reflectance.is_grey() && specular_transmittance.is_grey(),
            Self::Conductor {
                eta,
                k,
                specular_reflectance,
            }
            | Self::RoughConductor {
                eta,
                k,
                specular_reflectance,
                ..
            } => eta.is_grey() && k.is_grey() && specular_reflectance.is_grey(),
            Self::Plastic(coat) | Self::RoughPlastic { coat, .. } => {
                coat.specular_reflectance.is_grey()
            }
            // A material that scatters light ends the chain: its colour changes no irradiance.
            _ => self
                .nested()
                .all(|id| all[id.0 as usize].is_achromatic(all)),
        }
    }
}
