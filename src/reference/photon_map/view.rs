//! The way from the camera along specular chains to the points where photons are looked up.

use glam::{DVec2, DVec3};

use crate::geometry::{SurfacePoint, TraversalCounters};
use crate::numeric::Extras;
use crate::radiometry::Rgb;
use crate::scene::Scene;
use crate::transport::bsdf::{Bsdf, Scattering, Transport};
use crate::transport::camera::Camera;
use crate::transport::chain::MAX_PASSES;
use crate::transport::scatter::ShadingNormals;

/// A point of a scattering surface that the camera sees, directly or by way of mirrors and glass.
pub struct VisiblePoint<'a> {
    /// Radiance at the camera per radiance that leaves the point, divided by the probability of the chain.
    pub weight: Rgb,
    /// The surface.
    pub bsdf: Bsdf<'a>,
    /// Its shape.
    pub shape: u32,
    /// The place.
    pub point: SurfacePoint,
    /// Unit vector towards the place from which it is seen.
    pub wi: DVec3,
    /// The side of a pixel there \[m\], as if it were seen straight and head on.
    pub pixel_size: f64,
    /// True if there was a mirror or glass on the way.
    pub by_specular: bool,
}

impl VisiblePoint<'_> {
    /// Radiance leaving the point [W/m²/sr] per irradiance [W/m²] that arrives along `direction`.
    ///
    /// [`Bsdf::eval`] holds the cosine of the shading normal. Irradiance holds that of the surface on which
    /// photons are counted. By [`ShadingNormals::Flux`] a surface reflects the light that its true normal
    /// receives. By [`ShadingNormals::Adjoint`] it is that of the shading normal (as
    /// [`Camera::with_shading_normals`]).
    #[inline]
    pub fn radiance(&self, direction: DVec3, shading_normals: ShadingNormals) -> Rgb {
        let wo = -direction;
        let normal = match shading_normals {
            ShadingNormals::Flux => self.point.shading_normal,
            ShadingNormals::Adjoint => self.point.geometric_normal,
        };
        // If the two normals disagree about sides, no light goes, as for photons that meet mirrors.
        if !self.bsdf.is_consistent(self.wi, wo) {
            return Rgb::BLACK;
        }
        self.bsdf.eval(self.wi, wo, Transport::Radiance) / wo.dot(normal).abs()
    }
}

/// Follows one ray from the film point `at` and the point `lens` of the camera's lens, and reports each
/// scattering surface it meets.
///
/// At mirrors and glass one branch is chosen at random, with the probability of its share. So the mean over
/// `choices` is that over the whole Fresnel tree of any depth. The chain ends at a surface that scatters and
/// has no delta part, past `max_depth` specular events, or in the void.
pub fn follow<'a>(
    scene: &'a Scene,
    camera: &Camera,
    [at, lens]: [DVec2; 2],
    max_depth: u32,
    choices: Extras,
    counters: &mut TraversalCounters,
    mut visit: impl FnMut(&VisiblePoint<'a>, &mut TraversalCounters),
) {
    let view = camera.ray_through(at, lens);
    let beside = [DVec2::X, DVec2::Y].map(|step| camera.ray_through(at + step, lens).ray);
    let (mut ray, mut reach) = (view.ray, view.reach);
    let mut medium = view.medium;
    let (mut weight, mut distance) = (Rgb::WHITE, 0.0);
    let (mut events, mut passes) = (0, 0);
    while let Some(hit) = scene.world().closest_hit(&ray, reach, counters) {
        let point = scene.world().surface_point(&ray, &hit);
        let bsdf = Bsdf::at(scene, &hit, &point);
        let wi = -ray.direction;
        distance += hit.distance;
        weight = weight * scene.transmittance(medium, hit.distance);
        let [right, down] = beside.map(|other| other.at(distance) - view.ray.at(distance));
        if !bsdf.is_delta() {
            let seen = VisiblePoint {
                weight,
                bsdf: bsdf.clone(),
                shape: hit.shape,
                point,
                wi,
                pixel_size: right.cross(down).length().sqrt(),
                by_specular: events > 0,
            };
            visit(&seen, counters);
        }
        let dimension = 3 * (events + passes);
        let u = [0, 1, 2].map(|k| choices.at(dimension + k));
        let Some(sample) = bsdf.sample(wi, u, Transport::Radiance) else {
            return;
        };
        match sample.scattering {
            Scattering::Passed => passes += 1,
            _ => events += 1,
        }
        weight = weight * sample.weight;
        if !sample.is_delta || weight.is_black() || events > max_depth || passes > MAX_PASSES {
            return;
        }
        ray = point.spawn(sample.wo);
        medium = scene.medium_beyond(hit.shape, point.geometric_normal, sample.wo, medium);
        // The far plane cuts only surfaces that the camera sees directly.
        reach = f64::INFINITY;
    }
}
