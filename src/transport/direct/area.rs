//! Area lights: quadrature if nothing is in the way, otherwise randomised quasi-Monte Carlo.

use std::cell::Cell;

use glam::{DVec2, DVec3};

use super::glance::Glance;
use super::leaf::GAUSS;
use super::light::DirectLight;
use super::look::ShareRange;
use super::texel::DirectTexel;
use crate::geometry::SurfacePoint;
use crate::numeric::Stream;
use crate::radiometry::Rgb;
use crate::transport::domain::surface::{Area, LightPart, LightSurface, surface_point};
use crate::transport::domain::textured::TexturedSurface;

/// Largest relative error of a light's irradiance without shadow that is accepted without sampling.
///
/// A texel with a larger error gets the samples that are asked for.
pub(super) const SMOOTH_ERROR: f64 = 1e-3;

/// The corners of a texel or a light, a hair inside. So they are off the walls that either may touch.
const CORNERS: [(f64, f64); 4] = {
    const INSET: f64 = 1e-6;
    [
        (INSET, INSET),
        (1.0 - INSET, INSET),
        (INSET, 1.0 - INSET),
        (1.0 - INSET, 1.0 - INSET),
    ]
};

impl DirectLight<'_> {
    /// Average irradiance of an area light of a radiance [W/m²/sr] over a texel: E = ∫ L cos θ cos θ′ / r² dA
    /// over light and texel, with `each` samples in each replicate.
    pub(super) fn area(
        &mut self,
        texel: usize,
        radiance: Rgb,
        light: &LightSurface,
        stream: &Stream,
        each: u32,
    ) -> Glance {
        if let Some((value, error)) = self.unshadowed(texel, light) {
            return Glance {
                value: DirectTexel {
                    irradiance: radiance * value,
                    error: radiance * error,
                },
                passed: ShareRange::NOTHING_SEEN.with_share(1.0),
            };
        }
        let found = self.sampled(texel, stream, each, |at, point, place| {
            let (arriving, passed) = at.area_sample(point, light, place);
            ([arriving], passed)
        });
        Glance {
            value: DirectTexel {
                irradiance: radiance * found.mean[0],
                error: radiance * found.error[0],
            },
            passed: found.passed,
        }
    }

    /// The same for a light with a texture, whose places are chosen by it.
    ///
    /// Samples may miss what is brightest. So the error has what a bright place may send that has no sample
    /// (`unseen`, [`TexturedSurface::unseen`]), from the nearest place that a sample has.
    pub(super) fn textured_area(
        &mut self,
        texel: usize,
        radiance: Rgb,
        (light, unseen): (&TexturedSurface, Rgb),
        stream: &Stream,
        each: u32,
    ) -> Glance {
        let nearest = Cell::new(0.0_f64);
        let found = self.sampled(texel, stream, each, |at, point, place| {
            let (sample, value) = light.sample(place);
            let Some(seen) = geometry_term(point, &sample) else {
                return ([0.0; 3], 0.0);
            };
            let passed = at.transmittance(point, seen.towards, seen.reach);
            nearest.set(nearest.get().max(seen.value * passed));
            ((radiance * value * seen.value).0, passed)
        });
        found.with_missed(radiance * unseen * nearest.get()).into()
    }

    /// ∫ cos θ cos θ′ / r² dA over all of a light made of parallelograms, at the middle of a texel, and a
    /// bound on its error.
    ///
    /// `None` if any part may be hidden, the receiver is not one surface, or the error is above
    /// `SMOOTH_ERROR`.
    ///
    /// Each part is integrated with 2 x 2 Gauss points, at the texel's middle. The corners tell the error of
    /// the midpoint rule: the mean of the corners less the middle is three times that error. The difference
    /// to one point a part bounds the error of the parts.
    fn unshadowed(&mut self, texel: usize, light: &LightSurface) -> Option<(f64, f64)> {
        let middle = self.patch(texel, DVec2::splat(0.5))?;
        let mut corners = [middle.point; 4];
        for (corner, (u, v)) in corners.iter_mut().zip(CORNERS) {
            let patch = self.patch(texel, DVec2::new(u, v))?;
            if !patch.continues(&middle) {
                return None;
            }
            *corner = patch.point;
        }
        let middle = middle.point;
        let whole = light.rectangle()?;
        let (mut coarse, mut fine, mut at_corners) = (0.0, 0.0, 0.0);
        for part in light.parts() {
            let LightPart::Flat(area @ Area::Parallelogram { .. }, normal) = part else {
                return None;
            };
            let size = area.area();
            let point = |u: f64, v: f64| surface_point(area.point(DVec2::new(u, v)), *normal);
            let center = point(0.5, 0.5);
            let value =
                |from: &SurfacePoint| geometry_term(from, &center).map_or(0.0, |it| it.value);
            coarse += value(&middle) * size;
            at_corners += corners.iter().map(value).sum::<f64>() * size / 4.0;
            for (i, j) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
                let sample = point(0.5 + i * GAUSS, 0.5 + j * GAUSS);
                if let Some(seen) = geometry_term(&middle, &sample) {
                    if self.transmittance(&middle, seen.towards, seen.reach) < 1.0 {
                        return None;
                    }
                    fine += seen.value * size / 4.0;
                }
            }
        }
        // The side of a straight edge on which a ray passes is bilinear in the ray's two ends. So an edge
        // that hides any of the light from any of the texel does so for a pair of corners.
        for (u, v) in CORNERS {
            let sample = surface_point(whole.0.point(DVec2::new(u, v)), whole.1);
            for corner in &corners {
                if let Some(seen) = geometry_term(corner, &sample)
                    && self.transmittance(corner, seen.towards, seen.reach) < 1.0
                {
                    return None;
                }
            }
        }
        let error = (fine - coarse).abs() + (at_corners - coarse).abs() / 3.0;
        (error <= SMOOTH_ERROR * fine).then_some((fine, error))
    }

    /// One sample of ∫ cos θ cos θ′ / r² dA without shadows, and the share (0..=1) that passes.
    fn area_sample(&mut self, point: &SurfacePoint, light: &LightSurface, at: DVec2) -> (f64, f64) {
        let Some(seen) = light
            .sample(at)
            .and_then(|sample| geometry_term(point, &sample))
        else {
            return (0.0, 0.0);
        };
        let passed = self.transmittance(point, seen.towards, seen.reach);
        (seen.value * light.area(), passed)
    }
}

/// Geometry term of a point of an area light and a point of the receiver.
struct GeometryTerm {
    /// cos θ cos θ′ / r² [1/m²].
    value: f64,
    towards: DVec3,
    /// Length of a shadow ray: up to the light, not onto it.
    reach: f64,
}

/// The geometry term of a point of an area light; `None` if either surface turns its back.
fn geometry_term(point: &SurfacePoint, sample: &SurfacePoint) -> Option<GeometryTerm> {
    let offset = sample.position - point.position;
    let distance_squared = offset.length_squared();
    let distance = distance_squared.sqrt();
    let towards = offset / distance;
    let cos_receiver = towards.dot(point.geometric_normal);
    let cos_light = -towards.dot(sample.geometric_normal);
    if !(cos_receiver > 0.0 && cos_light > 0.0) {
        return None;
    }
    let margin = sample.position_error.length() + point.position_error.length();
    Some(GeometryTerm {
        value: cos_receiver * cos_light / distance_squared,
        towards,
        reach: distance * (1.0 - 8.0 * f64::EPSILON) - 2.0 * margin / cos_light,
    })
}
