//! Environments: randomised quasi-Monte Carlo over a texel and the directions above it.

use std::f64::consts::{FRAC_1_PI, PI};

use glam::{DVec2, DVec3};

use super::glance::Glance;
use super::light::DirectLight;
use crate::geometry::{Bounds, Frame, Shape, SurfacePoint};
use crate::numeric::Stream;
use crate::radiometry::Rgb;
use crate::scene::Scene;
use crate::transport::bsdf::cosine_hemisphere;
use crate::transport::lights::Environment;
use crate::transport::receiver::Receiver;

impl DirectLight<'_> {
    /// Average irradiance of an environment over a texel: E = ∫ L cos θ dω over texel and directions, with
    /// `each` samples in each replicate. `is_open` is true if nothing can hide any of it.
    pub(super) fn environment(
        &mut self,
        texel: usize,
        light: &Environment,
        stream: &Stream,
        each: u32,
        is_open: bool,
    ) -> Glance {
        let found = self.sampled(texel, stream, each, |at, point, place| {
            let Some((towards, arriving)) = arriving(point, light, place) else {
                return ([0.0; 3], 0.0);
            };
            let passed = at.transmittance(point, towards, f64::INFINITY);
            (arriving.0, passed)
        });
        if is_open {
            found.into()
        } else {
            found.with_unseen(each).into()
        }
    }
}

/// True if nothing is above a flat receiver: all of it sees all of the sky.
pub(super) fn is_open(scene: &Scene, receiver: &Receiver) -> bool {
    let own = receiver.shape();
    let is_flat = matches!(
        scene.world().shapes()[own as usize],
        Shape::Rectangle(_) | Shape::Disk(_)
    );
    let Some(point) = receiver.home(scene, 0).filter(|_| is_flat) else {
        return false;
    };
    let up = point.geometric_normal;
    let is_above = |bounds: &Bounds| {
        let highest = bounds.center().dot(up) + 0.5 * bounds.extent().dot(up.abs());
        highest > point.position.dot(up)
    };
    !(scene.world()).any_primitive_box(|shape| shape != own, is_above)
}

/// A direction to an environment and L cos θ by its density, without shadow; `None` if the receiver turns its
/// back.
///
/// Where all directions are alike, the density is cos θ / π, and an open texel has E = π L in each sample.
/// Of an image half of the samples are by its light and half by the cosine. Each counts by the density of
/// both together (Veach's balance heuristic, 1997), so that no sun is lost, be it at a pole.
fn arriving(point: &SurfacePoint, light: &Environment, at: DVec2) -> Option<(DVec3, Rgb)> {
    let normal = point.geometric_normal;
    let by_cosine = |u: [f64; 2]| {
        Frame::around(normal)
            .to_world(cosine_hemisphere(u))
            .normalize()
    };
    if light.is_even() {
        let towards = by_cosine([at.x, at.y]);
        return Some((towards, light.radiance(towards) * PI));
    }
    let towards = if at.x < 0.5 {
        light.sample([2.0 * at.x, at.y])?.direction
    } else {
        by_cosine([2.0 * at.x - 1.0, at.y])
    };
    let cosine = towards.dot(normal);
    if cosine <= 0.0 {
        return None;
    }
    let (radiance, pdf) = light.radiance_and_pdf(towards);
    let both = 0.5 * (pdf + cosine * FRAC_1_PI);
    Some((towards, radiance * (cosine / both)))
}
