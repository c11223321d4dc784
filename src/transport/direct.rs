//! `LD`: light that comes straight from an emitter to the receiver, by quadrature.
//!
//! A texel's average is integrated with 2 x 2 Gauss points on a quadtree that is refined where
//! some points of a leaf see the emitter and others do not, down to `SHADOW_LEVELS`; what is
//! still mixed there is booked as error. Area lights are integrated over texel and emitter
//! together by randomised quasi-Monte Carlo.
//!
//! A shadow smaller than the distance of the points (half a texel at level 0) can be missed.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::domain::chart::Falloff;
use super::domain::surface::{Area, LightSurface, Part, surface_point};
use super::receiver::Receiver;
use crate::geometry::{Ray, SurfacePoint, TraversalCounters};
use crate::numeric::{Stream, StreamKind};
use crate::radiometry::Rgb;
use crate::scene::{Emitter, Material, Scene};

/// How often a texel on a shadow's edge is quartered.
const SHADOW_LEVELS: u32 = 6;

/// Replicates of the quadrature over an area light; their scatter is the error.
const REPLICATES: u32 = 16;

/// Samples of a texel and an area light, in each replicate.
const SAMPLES: u32 = 8;

/// Largest relative error of a light's irradiance without shadow that is taken without sampling.
const SMOOTH_ERROR: f64 = 1e-3;

/// Half the distance of two Gauss points on an interval of length 1: 1 / (2 √3).
const GAUSS: f64 = 0.288_675_134_594_812_9;

/// A texel's direct irradiance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DirectTexel {
    /// Average irradiance [W/m²].
    pub irradiance: Rgb,
    /// For delta emitters a bound, for area lights the standard error [W/m²].
    pub error: Rgb,
}

/// Direct irradiance of every texel, and the work it took.
#[derive(Clone, Debug)]
pub struct Direct {
    /// Row by row, as the receiver's texels.
    pub texels: Vec<DirectTexel>,
    /// Shadow rays and their cost.
    pub counters: TraversalCounters,
}

/// Measures `LD` on every texel of the receiver.
pub fn direct(scene: &Scene, receiver: &Receiver, seed: u64) -> Direct {
    let stream = Stream::new(StreamKind::Sobol, seed).split(0x4c44);
    // A light whose surface is not modelled has been refused when light space was built.
    let surfaces: Vec<Option<LightSurface>> = scene
        .emitters()
        .iter()
        .map(|emitter| match emitter {
            Emitter::Area { shape, .. } => {
                LightSurface::new(&scene.world().shapes()[shape.0 as usize])
            }
            _ => None,
        })
        .collect();
    let rows: Vec<(Vec<DirectTexel>, TraversalCounters)> = (0..receiver.height())
        .into_par_iter()
        .map(|row| {
            let mut at = DirectLight {
                scene,
                receiver,
                counters: TraversalCounters::default(),
            };
            let texels = (0..receiver.width())
                .map(|column| at.texel(row * receiver.width() + column, &surfaces, &stream))
                .collect();
            (texels, at.counters)
        })
        .collect();
    let mut result = Direct {
        texels: Vec::with_capacity(receiver.texels()),
        counters: TraversalCounters::default(),
    };
    for (texels, counters) in rows {
        result.texels.extend(texels);
        result.counters += counters;
    }
    result
}

/// A part of a texel, by fractions across it.
#[derive(Clone, Copy)]
struct Leaf {
    from: DVec2,
    size: f64,
    level: u32,
}

struct DirectLight<'a> {
    scene: &'a Scene,
    receiver: &'a Receiver,
    counters: TraversalCounters,
}

impl DirectLight<'_> {
    fn texel(
        &mut self,
        texel: usize,
        surfaces: &[Option<LightSurface>],
        stream: &Stream,
    ) -> DirectTexel {
        let mut sum = DirectTexel::default();
        for (index, (emitter, surface)) in self.scene.emitters().iter().zip(surfaces).enumerate() {
            let part = match surface {
                None => self.delta(texel, emitter),
                Some(surface) => {
                    let stream = stream.split(index as u64).split(texel as u64);
                    self.area(texel, emitter, surface, &stream)
                }
            };
            sum.irradiance += part.irradiance;
            sum.error += part.error;
        }
        sum
    }

    fn receiver_point(&self, texel: usize, at: DVec2) -> SurfacePoint {
        self.receiver.point(self.scene, texel, at)
    }

    /// Average over a texel of a delta emitter's light.
    fn delta(&mut self, texel: usize, emitter: &Emitter) -> DirectTexel {
        let mut result = DirectTexel::default();
        let mut pending = vec![Leaf {
            from: DVec2::ZERO,
            size: 1.0,
            level: 0,
        }];
        while let Some(leaf) = pending.pop() {
            let middle = leaf.from + 0.5 * leaf.size;
            let weight = leaf.size * leaf.size / 4.0;
            let mut sum = Rgb::BLACK;
            let mut unshadowed = Rgb::BLACK;
            let mut passed_range = (1.0_f64, 0.0_f64);
            for (i, j) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
                let at = middle + DVec2::new(i, j) * (GAUSS * leaf.size);
                let point = self.receiver_point(texel, at);
                let (arriving, passed) = self.arriving(&point, emitter);
                unshadowed += arriving * weight;
                sum += arriving * (passed * weight);
                passed_range = (passed_range.0.min(passed), passed_range.1.max(passed));
            }
            let mixed = passed_range.0 < passed_range.1 && !unshadowed.is_black();
            if (mixed && leaf.level < SHADOW_LEVELS) || self.is_coarse(texel, &leaf, emitter) {
                for (i, j) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
                    pending.push(Leaf {
                        from: leaf.from + DVec2::new(i, j) * (0.5 * leaf.size),
                        size: 0.5 * leaf.size,
                        level: leaf.level + 1,
                    });
                }
                continue;
            }
            result.irradiance += sum;
            if mixed {
                // The lit share of the leaf is somewhere between none and all.
                result.error += unshadowed;
            }
        }
        result
    }

    /// Whether a leaf is too large for 2 x 2 Gauss points to integrate 1/r² and the cosine.
    ///
    /// Their relative error is about (size / distance)⁴ / 100: a ratio of 1/64 leaves 1e-9.
    fn is_coarse(&self, texel: usize, leaf: &Leaf, emitter: &Emitter) -> bool {
        let from = match emitter {
            Emitter::Point { position, .. } => *position,
            Emitter::Spot { to_world, .. } => to_world.point(DVec3::ZERO),
            Emitter::Directional { .. } | Emitter::Area { .. } => return false,
        };
        if leaf.level >= SHADOW_LEVELS {
            return false;
        }
        let middle = leaf.from + 0.5 * leaf.size;
        let distance = self.receiver_point(texel, middle).position.distance(from);
        let size = self.receiver.texel_area(texel).sqrt() * leaf.size;
        size > distance / 64.0
    }

    /// A delta emitter's unshadowed irradiance at a point, and the share (0..=1) that passes.
    fn arriving(&mut self, point: &SurfacePoint, emitter: &Emitter) -> (Rgb, f64) {
        let normal = point.geometric_normal;
        let (irradiance, towards, distance) = match emitter {
            Emitter::Directional {
                direction,
                irradiance,
            } => {
                let cos = -direction.dot(normal);
                (*irradiance * cos.max(0.0), -*direction, f64::INFINITY)
            }
            Emitter::Point {
                position,
                intensity,
            } => from_point(point, *position, *intensity, Falloff::None),
            Emitter::Spot {
                to_world,
                intensity,
                cutoff_angle,
                beam_width,
            } => from_point(
                point,
                to_world.point(DVec3::ZERO),
                *intensity,
                Falloff::Spot {
                    axis: to_world.vector(DVec3::Z).normalize(),
                    cutoff_angle: *cutoff_angle,
                    beam_width: *beam_width,
                },
            ),
            Emitter::Area { .. } => return (Rgb::BLACK, 0.0),
        };
        if irradiance.is_black() {
            return (Rgb::BLACK, 0.0);
        }
        let passed = self.transmittance(point, towards, distance);
        (irradiance, passed)
    }

    /// The share of light that reaches `point` along `-towards` past null surfaces and masks.
    fn transmittance(&mut self, point: &SurfacePoint, towards: DVec3, distance: f64) -> f64 {
        let scene = self.scene;
        let ray = point.spawn(towards);
        let mut meets_mask = false;
        let blocked = scene.world().any_hit(
            &ray,
            distance,
            |hit| match scene.material_of(hit.shape) {
                Material::Null => false,
                Material::Mask { opacity, .. } => {
                    meets_mask = true;
                    *opacity == 1.0
                }
                _ => true,
            },
            &mut self.counters,
        );
        match (blocked, meets_mask) {
            (true, _) => 0.0,
            (false, false) => 1.0,
            (false, true) => self.masked_transmittance(ray, distance),
        }
    }

    /// The share of light that passes masks, met one after the other: `any_hit` reports a round
    /// shape once even where a ray crosses it twice.
    fn masked_transmittance(&mut self, mut ray: Ray, mut distance: f64) -> f64 {
        let scene = self.scene;
        let mut passed = 1.0;
        while passed > 0.0 {
            let hit = scene
                .world()
                .closest_hit(&ray, distance, &mut self.counters);
            let Some(hit) = hit else { break };
            passed *= match scene.material_of(hit.shape) {
                Material::Null => 1.0,
                Material::Mask { opacity, .. } => 1.0 - opacity,
                _ => 0.0,
            };
            distance -= hit.distance;
            ray = scene.world().bounce_point(&ray, &hit).spawn(ray.direction);
        }
        passed
    }

    /// Average over a texel of an area light: E = ∫ L cos θ cos θ′ / r² dA over light and texel.
    fn area(
        &mut self,
        texel: usize,
        emitter: &Emitter,
        light: &LightSurface,
        stream: &Stream,
    ) -> DirectTexel {
        let Emitter::Area { radiance, .. } = emitter else {
            return DirectTexel::default();
        };
        if let Some((value, error)) = self.unshadowed(texel, light) {
            return DirectTexel {
                irradiance: *radiance * value,
                error: *radiance * error,
            };
        }
        let mut sum = 0.0;
        let mut sum_squares = 0.0;
        for replicate in 0..REPLICATES {
            let stream = stream.split(u64::from(replicate));
            let mut mean = 0.0;
            for sample in 0..SAMPLES {
                let [u, v, s, t] = stream.point4(u64::from(sample));
                let point = self.receiver_point(texel, DVec2::new(u, v));
                mean += self.area_sample(&point, light, DVec2::new(s, t));
            }
            mean /= f64::from(SAMPLES);
            sum += mean;
            sum_squares += mean * mean;
        }
        let n = f64::from(REPLICATES);
        let variance = ((sum_squares - sum * sum / n) / (n - 1.0)).max(0.0);
        DirectTexel {
            irradiance: *radiance * (sum / n),
            error: *radiance * (variance / n).sqrt(),
        }
    }

    /// ∫ cos θ cos θ′ / r² dA over all of a light made of parallelograms, at the middle of a
    /// texel, and a bound on its error; `None` where any part may be hidden, or the error is more
    /// than `SMOOTH_ERROR`.
    ///
    /// Each part is integrated with 2 x 2 Gauss points, at the texel's middle and, for what the
    /// middle leaves out, at its corners: the mean of the corners less the middle is three times
    /// the midpoint rule's error. The difference to one point a part bounds that of the parts.
    fn unshadowed(&mut self, texel: usize, light: &LightSurface) -> Option<(f64, f64)> {
        let middle = self.receiver_point(texel, DVec2::splat(0.5));
        let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)]
            .map(|(u, v)| self.receiver_point(texel, DVec2::new(u, v)));
        let (mut coarse, mut fine, mut at_corners) = (0.0, 0.0, 0.0);
        for part in light.parts() {
            let Part::Flat(area @ Area::Parallelogram { .. }, normal) = part else {
                return None;
            };
            let size = area.area();
            let point = |u: f64, v: f64| surface_point(area.point(DVec2::new(u, v)), *normal);
            let center = point(0.5, 0.5);
            let value = |from: &SurfacePoint| kernel(from, &center).map_or(0.0, |it| it.value);
            coarse += value(&middle) * size;
            at_corners += corners.iter().map(value).sum::<f64>() * size / 4.0;
            for (i, j) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
                let sample = point(0.5 + i * GAUSS, 0.5 + j * GAUSS);
                if let Some(seen) = kernel(&middle, &sample) {
                    if self.transmittance(&middle, seen.towards, seen.reach) < 1.0 {
                        return None;
                    }
                    fine += seen.value * size / 4.0;
                }
            }
        }
        let error = (fine - coarse).abs() + (at_corners - coarse).abs() / 3.0;
        (error <= SMOOTH_ERROR * fine).then_some((fine, error))
    }

    /// One sample of ∫ cos θ cos θ′ / r² dA.
    fn area_sample(&mut self, point: &SurfacePoint, light: &LightSurface, at: DVec2) -> f64 {
        let Some(seen) = light.sample(at).and_then(|sample| kernel(point, &sample)) else {
            return 0.0;
        };
        let passed = self.transmittance(point, seen.towards, seen.reach);
        passed * seen.value * light.area()
    }
}

/// A point of an area light, as seen from the receiver.
struct Seen {
    /// cos θ cos θ′ / r² [1/m²].
    value: f64,
    towards: DVec3,
    /// How far a shadow ray goes: up to the light, not onto it.
    reach: f64,
}

/// What a point of an area light does to a receiver point; `None` where either turns its back.
fn kernel(point: &SurfacePoint, sample: &SurfacePoint) -> Option<Seen> {
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
    Some(Seen {
        value: cos_receiver * cos_light / distance_squared,
        towards,
        reach: distance * (1.0 - 8.0 * f64::EPSILON) - 2.0 * margin / cos_light,
    })
}

/// Irradiance from a point: I(ω) cos θ / r².
fn from_point(
    point: &SurfacePoint,
    position: DVec3,
    intensity: Rgb,
    falloff: Falloff,
) -> (Rgb, DVec3, f64) {
    let offset = position - point.position;
    let distance = offset.length();
    if distance == 0.0 {
        return (Rgb::BLACK, DVec3::Z, 0.0);
    }
    let towards = offset / distance;
    let cos = towards.dot(point.geometric_normal).max(0.0);
    let factor = falloff.factor(-towards) * cos / (distance * distance);
    (intensity * factor, towards, distance)
}
