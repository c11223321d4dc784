//! The emitters of a scene.

use glam::DVec3;

use super::{Daylight, Envmap, ShapeId, Slide, TextureId};
use crate::geometry::Transform;
use crate::radiometry::Rgb;

/// Largest number of triangles in a mesh that shines, if light is followed from it. Each triangle has charts
/// of its own, and more of them would not fit the number of cells.
pub const MAX_SHINING_TRIANGLES: usize = 1024;

/// A source of light, with Mitsuba's meaning of every parameter.
// A scene holds a handful of them: boxing the one large variant would only cost clarity.
#[allow(clippy::large_enum_variant)]
#[derive(Clone, Debug, PartialEq)]
pub enum Emitter {
    /// A point that shines the same in all directions.
    Point {
        /// World space.
        position: DVec3,
        /// Radiant intensity [W/sr].
        intensity: Rgb,
    },
    /// A point that shines along +z of its frame, fading towards a cone's border.
    ///
    /// With θ the angle to the axis, the intensity is constant for θ up to `beam_width`, falls linearly in θ
    /// to zero at `cutoff_angle`, and is zero beyond.
    Spot {
        /// Its frame. Only rotation and translation matter.
        to_world: Transform,
        /// Radiant intensity on the axis [W/sr].
        intensity: Rgb,
        /// Half the opening angle of the cone \[rad\].
        cutoff_angle: f64,
        /// The angle up to which the intensity is constant \[rad\].
        beam_width: f64,
        /// The image that it shines through, if any: a factor on the intensity.
        slide: Option<Slide>,
    },
    /// A point that throws an image: on the plane at unit distance across its axis, the irradiance is the
    /// image's value times a factor.
    Projector {
        /// The image, and the point behind it.
        slide: Slide,
        /// The factor [W/m²].
        irradiance: Rgb,
    },
    /// Parallel light from infinitely far away.
    Directional {
        /// The direction of travel, a unit vector.
        direction: DVec3,
        /// Irradiance of a surface perpendicular to the light [W/m²].
        irradiance: Rgb,
    },
    /// The front side of a shape, shining the same in all directions.
    Area {
        /// The shape that shines.
        shape: ShapeId,
        /// Radiance [W/m²/sr]; with a texture, a factor on the texture's values.
        radiance: Rgb,
        /// The texture that varies the radiance over the surface, if any.
        texture: Option<TextureId>,
    },
    /// The front side of a shape, each place of which shines along its normal only.
    DirectionalArea {
        /// The shape that shines.
        shape: ShapeId,
        /// Radiant exitance, flux by the shape's area [W/m²]; with a texture, a factor on the texture's
        /// values. Mitsuba calls it `radiance`.
        exitance: Rgb,
        /// The texture that varies the exitance over the surface, if any.
        texture: Option<TextureId>,
    },
    /// The same light from all directions, infinitely far away.
    Constant {
        /// Radiance [W/m²/sr].
        radiance: Rgb,
    },
    /// An image of the light from all directions, infinitely far away.
    Envmap(Envmap),
    /// A clear sky with the sun in it, infinitely far away.
    Sunsky(Daylight),
}

impl Emitter {
    /// The name of Mitsuba's plugin.
    pub fn plugin(&self) -> &'static str {
        match self {
            Self::Point { .. } => "point",
            Self::Spot { .. } => "spot",
            Self::Projector { .. } => "projector",
            Self::Directional { .. } => "directional",
            Self::Area { .. } => "area",
            Self::DirectionalArea { .. } => "directionalarea",
            Self::Constant { .. } => "constant",
            Self::Envmap(_) => "envmap",
            Self::Sunsky(_) => "sunsky",
        }
    }

    /// True if a receiver point sees no more than single directions of its light.
    pub fn is_delta(&self) -> bool {
        !matches!(self, Self::Area { .. }) && !self.is_environment()
    }

    /// True if its light comes from all round, infinitely far away.
    pub fn is_environment(&self) -> bool {
        matches!(
            self,
            Self::Constant { .. } | Self::Envmap(_) | Self::Sunsky(_)
        )
    }

    /// True if red, green and blue of all its light are known to be the same; for a texture they are not
    /// known.
    pub fn is_grey(&self) -> bool {
        match self {
            Self::Envmap(map) => map.is_grey(),
            Self::Projector { slide, .. }
            | Self::Spot {
                slide: Some(slide), ..
            } => slide.is_grey() && self.strength().is_grey(),
            Self::Area {
                texture: Some(_), ..
            }
            | Self::DirectionalArea {
                texture: Some(_), ..
            } => false,
            _ => self.strength().is_grey(),
        }
    }

    /// The image through which a point shines.
    pub fn slide(&self) -> Option<&Slide> {
        match self {
            Self::Spot { slide, .. } => slide.as_ref(),
            Self::Projector { slide, .. } => Some(slide),
            _ => None,
        }
    }

    /// What its image makes of the light in a direction of travel (a unit vector): a factor on the strength,
    /// in [1/sr] for a projector. `None` without an image.
    #[inline]
    pub(crate) fn slide_factor(&self, direction: DVec3) -> Option<Rgb> {
        match self {
            Self::Spot { slide, .. } => slide.as_ref().map(|it| it.towards(direction)),
            Self::Projector { slide, .. } => Some(slide.projected(direction)),
            _ => None,
        }
    }

    /// The shape that shines.
    pub fn shape(&self) -> Option<ShapeId> {
        match self {
            Self::Area { shape, .. } | Self::DirectionalArea { shape, .. } => Some(*shape),
            _ => None,
        }
    }

    /// The point that shines, in world space.
    pub fn position(&self) -> Option<DVec3> {
        match self {
            Self::Point { position, .. } => Some(*position),
            Self::Spot { to_world, .. } => Some(to_world.point(DVec3::ZERO)),
            Self::Projector { slide, .. } => Some(slide.origin()),
            _ => None,
        }
    }

    /// The texture by which a shape shines unevenly.
    pub fn texture(&self) -> Option<TextureId> {
        match self {
            Self::Area { texture, .. } | Self::DirectionalArea { texture, .. } => *texture,
            _ => None,
        }
    }

    /// Its strength, in the unit of its kind. For an environment's image and a sky: the largest of all
    /// directions, channel by channel. For a textured shape and a point that shines through an image: the
    /// factor on it.
    pub fn strength(&self) -> Rgb {
        match self {
            Self::Point { intensity, .. } | Self::Spot { intensity, .. } => *intensity,
            Self::Directional { irradiance, .. } | Self::Projector { irradiance, .. } => {
                *irradiance
            }
            Self::DirectionalArea { exitance, .. } => *exitance,
            Self::Area { radiance, .. } | Self::Constant { radiance } => *radiance,
            Self::Envmap(map) => map.peak(),
            Self::Sunsky(daylight) => daylight.peak(),
        }
    }
}
