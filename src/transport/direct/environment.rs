//! Environments: randomised quasi-Monte Carlo over a texel and the directions above it.

use std::f64::consts::{FRAC_1_PI, TAU};

use glam::{DVec2, DVec3};

use super::glance::Glance;
use super::light::DirectLight;
use super::texel::DirectTexel;
use crate::geometry::SurfacePoint;
use crate::numeric::Stream;
use crate::numeric::math;
use crate::radiometry::Rgb;
use crate::transport::lights::Environment;

impl DirectLight<'_> {
    /// Average irradiance of an environment over a texel: E = ∫ L cos θ dω over texel and directions, with
    /// `each` samples in each replicate.
    pub(super) fn environment(
        &mut self,
        texel: usize,
        light: &Environment,
        stream: &Stream,
        each: u32,
    ) -> Glance {
        let found = self.sampled(texel, stream, each, |at, point, place| {
            let Some((towards, arriving)) = arriving(point, light, place) else {
                return ([0.0; 3], 0.0);
            };
            let passed = at.transmittance(point, towards, f64::INFINITY);
            (arriving.0, passed)
        });
        Glance {
            value: DirectTexel {
                irradiance: Rgb(found.mean),
                error: Rgb(found.error),
            },
            passed: found.passed,
        }
    }
}

/// A direction to an environment and L cos θ by its density, without shadow; `None` if the receiver turns its
/// back.
///
/// Where all directions are alike, the density is cos θ / π, and an open texel has E = π L in each sample.
/// Of an image half of the samples are by its light and half by the cosine. Each counts by the density of
/// both together (Veach's balance heuristic, 1997), so that neither a sun nor a pole is lost.
fn arriving(point: &SurfacePoint, light: &Environment, at: DVec2) -> Option<(DVec3, Rgb)> {
    let normal = point.geometric_normal;
    let density = |towards: DVec3| towards.dot(normal).max(0.0) * FRAC_1_PI;
    if light.is_even() {
        let towards = by_cosine(normal, at);
        return Some((towards, light.radiance(towards) * std::f64::consts::PI));
    }
    let towards = if at.x < 0.5 {
        light.sample([2.0 * at.x, at.y])?.direction
    } else {
        by_cosine(normal, DVec2::new(2.0 * at.x - 1.0, at.y))
    };
    let cosine = towards.dot(normal);
    if cosine <= 0.0 {
        return None;
    }
    let both = 0.5 * (light.pdf_solid_angle(towards) + density(towards));
    Some((towards, light.radiance(towards) * (cosine / both)))
}

/// A direction about a normal, with the density cos θ / π (Malley's way: a place of the disc, lifted).
fn by_cosine(normal: DVec3, at: DVec2) -> DVec3 {
    let (sin, cos) = math::sin_cos(TAU * at.y);
    let (x, y) = normal.any_orthonormal_pair();
    let across = at.x.sqrt();
    let up = (1.0 - at.x).max(0.0).sqrt();
    ((x * cos + y * sin) * across + normal * up).normalize()
}
