//! Lights that a point sees in single directions only.

use glam::DVec3;

use super::sample::LightSample;
use crate::geometry::SurfacePoint;
use crate::radiometry::Rgb;
use crate::scene::{Emitter, Scene};
use crate::transport::domain::chart::Falloff;
use crate::transport::domain::normal_light::NormalLight;

/// A point, a spot or parallel light.
#[derive(Clone, Debug)]
pub(super) struct DeltaLight<'a> {
    place: DeltaPlace,
    /// Of an emitter with an image: that shines through it.
    slide: Option<&'a Emitter>,
    /// Radiant intensity [W/sr] on the axis, or irradiance [W/m²] across parallel light.
    strength: Rgb,
}

#[derive(Clone, Debug)]
enum DeltaPlace {
    /// Light in all directions from one point.
    At(DVec3, Falloff),
    /// Light that travels along a unit vector.
    FarAway(DVec3),
}

impl<'a> DeltaLight<'a> {
    /// A point that shines in all directions, with an intensity [W/sr] that may depend on them.
    pub(super) fn at(position: DVec3, intensity: Rgb, falloff: Falloff) -> Self {
        Self {
            place: DeltaPlace::At(position, falloff),
            slide: None,
            strength: intensity,
        }
    }

    /// The same, through the image of an emitter that has one.
    pub(super) fn through(self, emitter: &'a Emitter) -> Self {
        Self {
            slide: emitter.slide().map(|_| emitter),
            ..self
        }
    }

    /// Light that travels along a unit vector, with an irradiance [W/m²] across it.
    pub(super) fn far_away(direction: DVec3, irradiance: Rgb) -> Self {
        Self {
            place: DeltaPlace::FarAway(direction),
            slide: None,
            strength: irradiance,
        }
    }

    /// The one direction towards the light; `None` at the light itself and out of a spot's cone.
    pub(super) fn sample(&self, point: &SurfacePoint) -> Option<LightSample> {
        let (direction, distance, irradiance) = match &self.place {
            DeltaPlace::FarAway(travel) => (-*travel, f64::INFINITY, self.strength),
            DeltaPlace::At(position, falloff) => {
                let offset = *position - point.position;
                let distance = offset.length();
                let direction = offset.try_normalize()?;
                let factor = falloff.factor(-direction) / (distance * distance);
                let image = self.slide.and_then(|it| it.slide_factor(-direction));
                let strength = image.map_or(self.strength, |image| self.strength * image);
                (direction, distance, strength * factor)
            }
        };
        if irradiance.is_black() || !irradiance.is_finite() {
            return None;
        }
        Some(LightSample {
            direction,
            distance,
            reach: distance,
            radiance_over_pdf: irradiance,
            pdf_solid_angle: 1.0,
            is_delta: true,
            emitter: 0,
        })
    }
}

/// A surface that shines along its normals.
#[derive(Clone, Debug)]
pub(super) struct NormalLights(Vec<(NormalLight, DeltaPlace, Rgb)>);

impl NormalLights {
    /// The parts of an emitter; none if its surface is not modelled.
    pub(super) fn new(scene: &Scene, emitter: &Emitter) -> Self {
        let parts = NormalLight::parts(scene, emitter).unwrap_or_default();
        let seen = parts.into_iter().map(|part| {
            let emitter = part.without_size();
            let place = match emitter {
                Emitter::Point { position, .. } => DeltaPlace::At(position, Falloff::None),
                Emitter::Directional { direction, .. } => DeltaPlace::FarAway(direction),
                _ => DeltaPlace::FarAway(DVec3::Z),
            };
            (part, place, emitter.strength())
        });
        Self(seen.collect())
    }

    /// The direction towards one of the parts, each chosen as often; `None` if that sends nothing to the
    /// point.
    pub(super) fn sample(&self, point: &SurfacePoint, u: f64) -> Option<LightSample> {
        let count = self.0.len();
        let index = ((u * count as f64) as usize).min(count.checked_sub(1)?);
        let (part, place, strength) = &self.0[index];
        let ray = part.meets(point)?;
        let whole = DeltaLight {
            place: place.clone(),
            slide: None,
            strength: *strength * ray.value,
        };
        let sample = whole.sample(point)?;
        Some(LightSample {
            distance: ray.reach,
            reach: ray.reach,
            radiance_over_pdf: sample.radiance_over_pdf * count as f64,
            pdf_solid_angle: 1.0 / count as f64,
            ..sample
        })
    }
}
