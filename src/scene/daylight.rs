//! A clear sky with the sun in it: Mitsuba's `sunsky`.

use glam::{DMat3, DMat4, DVec3};

use super::Envmap;
use super::environment::EnvmapError;
use super::sun_disc::SunDisc;
use crate::geometry::Transform;
use crate::radiometry::Rgb;
use crate::spectrum::daylight::ClearSky;

/// A clear sky, and the sun in it if it shines.
///
/// As in Mitsuba, its radiance is per nanometre of wavelength where that of other emitters is not: it is the
/// only light of most scenes, and ratios are right.
#[derive(Clone, Debug, PartialEq)]
pub struct Daylight {
    /// All but the sun itself.
    pub sky: Envmap,
    /// The sun.
    pub sun: Option<SunDisc>,
}

impl Daylight {
    /// A sky whose z axis `to_world` turns to the scene's zenith, times `scale`, with or without a sun.
    ///
    /// # Errors
    ///
    /// If `to_world` is more than a rotation (mirrored or not) and a scale.
    pub fn new(
        sky: ClearSky,
        sun: Option<SunDisc>,
        to_world: &Transform,
        scale: f64,
    ) -> Result<Self, EnvmapError> {
        // The frame of an image, whose y axis points to the zenith, for a sky whose z axis does.
        let turn = DMat4::from_mat3(DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y));
        let upright =
            Transform::from_matrix(to_world.matrix() * turn).map_err(|_| EnvmapError::Stretched)?;
        Ok(Self {
            sky: Envmap::of_sky(sky, &upright, scale)?,
            sun,
        })
    }

    /// Radiance [W/m²/sr] that comes from a direction, a unit vector.
    pub fn radiance(&self, direction: DVec3) -> Rgb {
        let sun = self.sun.as_ref().map(|sun| sun.radiance(direction));
        self.sky.radiance(direction) + sun.unwrap_or_default()
    }

    /// At least the radiance of any direction, channel by channel [W/m²/sr].
    pub fn peak(&self) -> Rgb {
        self.sky.peak() + self.sun.as_ref().map(SunDisc::peak).unwrap_or_default()
    }
}
