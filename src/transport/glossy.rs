//! Rough interfaces and rough coats on the way of light: one direction of many, drawn by lot.
//!
//! The lot is that of paths from a camera, [`Bsdf::sample`]. What flux is multiplied by is the adjoint of the
//! bsdf times the cosine, divided by the density: refraction does not scale it by n², as it does radiance. At
//! a surface with interpolated normals it is taken in the frame of the shading normal, as smooth interfaces
//! are: [`ShadingNormals`] says if Veach's factor comes on top.
//!
//! Of a coat only what its facets reflect goes on: the base below is matt, and light ends there.
//!
//! Facets send light on once. What they send to other facets is lost, so that a lossless surface absorbs
//! some. The fitted shadowing of Beckmann's facets may also let 0.35 % more through than there is.

use glam::DVec3;

use super::bsdf::{Bsdf, Scattering, Transport};
use super::flux::Flux;
use super::scatter::{Branch, ShadingNormals};
use super::signature::Event;
use crate::geometry::{Hit, Ray, SurfacePoint};
use crate::scene::Scene;

/// True if light along `ray` meets a rough interface, on the side that it comes from.
pub fn is_met(scene: &Scene, hit: &Hit, point: &SurfacePoint, ray: &Ray) -> bool {
    let point = scene.world().with_uv(*point, hit);
    Bsdf::at(scene, hit, &point).is_glossy(-ray.direction)
}

/// The branch along which light goes on from a rough interface or coat, which may have masks over it, and the
/// event; without one if it passed the mask. `None` if it is absorbed.
///
/// `point` may be without `uv`. `direction` is that of travel, and `u` are uniform in [0, 1).
pub fn draw<const N: usize>(
    scene: &Scene,
    (hit, point): (&Hit, &SurfacePoint),
    direction: DVec3,
    shading_normals: ShadingNormals,
    u: [f64; 3],
) -> Option<(Branch<N>, Option<Event>)> {
    let point = scene.world().with_uv(*point, hit);
    let bsdf = Bsdf::at(scene, hit, &point).without_bases();
    let wi = -direction;
    let sample = bsdf.sample(wi, u, Transport::Flux)?;
    if sample.scattering == Scattering::Passed {
        let tint = Flux::WHITE;
        return Some((Branch { direction, tint }, None));
    }
    // If the two normals disagree about sides, no light goes, as at mirrors.
    if !bsdf.is_consistent(wi, sample.wo) {
        return None;
    }
    let mut weight = sample.weight;
    if shading_normals == ShadingNormals::Flux && point.shading_normal != point.geometric_normal {
        let cosines = |normal: DVec3| (wi.dot(normal) / sample.wo.dot(normal)).abs();
        weight *= cosines(point.geometric_normal) / cosines(point.shading_normal);
    }
    let branch = Branch {
        direction: sample.wo,
        tint: Flux::of(weight),
    };
    Some((branch, Some(Event::Glossy)))
}
