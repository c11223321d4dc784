//! Light of a delta emitter at a point of the receiver.

use glam::{DVec2, DVec3};

use super::light::DirectLight;
use crate::geometry::SurfacePoint;
use crate::radiometry::Rgb;
use crate::scene::Emitter;
use crate::transport::domain::chart::Falloff;
use crate::transport::domain::normal_light::NormalLight;

/// Part of a spot's cone, at its border, in which its falloff counts as a step.
const STEP: f64 = 1e-3;

/// True for a spot whose light ends in a step, not in a falloff.
pub(super) fn ends_in_a_step(emitter: &Emitter) -> bool {
    matches!(emitter, Emitter::Spot { cutoff_angle, beam_width, .. }
        if cutoff_angle - beam_width <= STEP * cutoff_angle)
}

impl DirectLight<'_> {
    /// A delta emitter's unshadowed irradiance at a point, and the share (0..=1) that passes.
    pub(super) fn arriving(&mut self, point: &SurfacePoint, emitter: &Emitter) -> (Rgb, f64) {
        let (irradiance, towards, distance) = unshadowed(point, emitter);
        if irradiance.is_black() {
            return (Rgb::BLACK, 0.0);
        }
        let passed = self.passed(point, towards, distance);
        (irradiance, passed)
    }

    /// The share of a delta emitter that passes to a point, whether or not it shines there; none beyond the
    /// edge of a beam that ends in a step.
    pub(super) fn share(&mut self, point: &SurfacePoint, emitter: &Emitter) -> f64 {
        let (irradiance, towards, distance) = unshadowed(point, emitter);
        if distance == 0.0 || irradiance.is_black() && ends_in_a_step(emitter) {
            0.0
        } else {
            self.passed(point, towards, distance)
        }
    }

    /// True if some points of a texel, its corners among them, meet rays of a part and some do not.
    pub(super) fn is_divided_by_end(&self, texel: usize, part: &NormalLight) -> bool {
        /// A hair inside the texel: its border may be that of the light.
        const PLACES: [f64; 3] = [1e-6, 0.5, 1.0 - 1e-6];
        let mut met = [false; 2];
        for (u, v) in PLACES.into_iter().flat_map(|u| PLACES.map(|v| (u, v))) {
            if let Some(patch) = self.patch(texel, DVec2::new(u, v)) {
                met[usize::from(part.meets(&patch.point).is_some())] = true;
            }
        }
        met == [true; 2]
    }

    /// The share (0..=1) of light that passes along `-towards` to a point, from the emitter's part if it has
    /// one: none if no ray from there meets the point.
    fn passed(&mut self, point: &SurfacePoint, towards: DVec3, distance: f64) -> f64 {
        let reach = match self.part {
            None => Some(distance),
            Some(part) => part.meets(point).map(|ray| ray.reach),
        };
        reach.map_or(0.0, |reach| self.transmittance(point, towards, reach))
    }
}

/// Irradiance of a delta emitter at a point if nothing is in the way, the direction towards it and its
/// distance \[m\]. Other emitters give none.
pub(super) fn unshadowed(point: &SurfacePoint, emitter: &Emitter) -> (Rgb, DVec3, f64) {
    let from = |position, intensity| from_point(point, position, intensity, emitter);
    match emitter {
        Emitter::Directional {
            direction,
            irradiance,
        } => {
            let cos = -direction.dot(point.geometric_normal);
            (*irradiance * cos.max(0.0), -*direction, f64::INFINITY)
        }
        Emitter::Point {
            position,
            intensity,
        } => from(*position, *intensity),
        Emitter::Spot {
            to_world,
            intensity,
            ..
        } => from(to_world.point(DVec3::ZERO), *intensity),
        Emitter::Projector { slide, irradiance } => from(slide.origin(), *irradiance),
        Emitter::Area { .. }
        | Emitter::DirectionalArea { .. }
        | Emitter::Constant { .. }
        | Emitter::Envmap(_)
        | Emitter::Sunsky(_) => (Rgb::BLACK, DVec3::Z, f64::INFINITY),
    }
}

/// Irradiance from a point: I(ω) cos θ / r², and what an image makes of it.
fn from_point(
    point: &SurfacePoint,
    position: DVec3,
    intensity: Rgb,
    emitter: &Emitter,
) -> (Rgb, DVec3, f64) {
    let offset = position - point.position;
    let distance = offset.length();
    if distance == 0.0 {
        return (Rgb::BLACK, DVec3::Z, 0.0);
    }
    let towards = offset / distance;
    let cos = towards.dot(point.geometric_normal).max(0.0);
    let factor = Falloff::of(emitter).factor(-towards) * cos / (distance * distance);
    let irradiance = match emitter.slide_factor(-towards) {
        Some(image) => intensity * image * factor,
        None => intensity * factor,
    };
    (irradiance, towards, distance)
}
