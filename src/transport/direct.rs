//! `LD`: light that comes straight from an emitter to the receiver, by quadrature.
//!
//! A delta emitter's light is integrated over a texel with 2 x 2 Gauss points. Shadows have sharp
//! edges, which may run through a texel and yet miss its four points; so a texel is looked at closely
//! where its points *or its neighbours'* differ in what they see of the emitter. Then it is cut into a
//! quadtree, at least `EDGE_LEVELS` deep and down to `SHADOW_LEVELS` where any of a leaf's
//! guards, which stand a little outside of it, sees otherwise than the rest; what is
//! still mixed there is booked as error. Area lights are integrated over texel and emitter
//! together by randomised quasi-Monte Carlo.
//!
//! A shadow (or a gap in one) narrower than about half a texel can be missed, and beside an edge one
//! narrower than 1/16 of a texel.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::domain::chart::Falloff;
use super::domain::surface::{Area, LightSurface, Part, surface_point};
use super::receiver::Receiver;
use crate::geometry::{Ray, SurfacePoint, TraversalCounters};
use crate::numeric::{Stream, StreamKind};
use crate::radiometry::Rgb;
use crate::scene::{Emitter, Material, Scene};

/// How often a leaf on a shadow's edge is quartered.
const SHADOW_LEVELS: u32 = 6;

/// How often all of a texel near a shadow's edge is quartered.
const EDGE_LEVELS: u32 = 3;

/// Where else a leaf near an edge looks for the emitter: a grid of 3 x 3 points over the leaf and
/// an eighth of its size around it.
///
/// An edge that bulges into a leaf between two of them by the sagitta s²/(8R), s the leaf's size,
/// is seen from there for all radii R above s.
const GUARDS: [f64; 3] = [-0.625, 0.0, 0.625];

/// Replicates of the quadrature over an area light; their scatter is the error.
const REPLICATES: u32 = 16;

/// Samples of a texel and an area light, in each replicate.
const SAMPLES: u32 = 8;

/// Largest relative error of a light's irradiance without shadow that is taken without sampling.
const SMOOTH_ERROR: f64 = 1e-3;

/// The corners of a texel or a light, a hair inside: off the walls that either may touch.
const CORNERS: [(f64, f64); 4] = {
    const INSET: f64 = 1e-6;
    [
        (INSET, INSET),
        (1.0 - INSET, INSET),
        (INSET, 1.0 - INSET),
        (1.0 - INSET, 1.0 - INSET),
    ]
};

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

/// Measures `LD` on every texel of the receiver; `None` where `stop` said so before the end.
pub fn direct(
    scene: &Scene,
    receiver: &Receiver,
    seed: u64,
    stop: &(dyn Fn() -> bool + Sync),
) -> Option<Direct> {
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
    let mut result = Direct {
        texels: vec![DirectTexel::default(); receiver.texels()],
        counters: TraversalCounters::default(),
    };
    for (index, (emitter, surface)) in scene.emitters().iter().zip(&surfaces).enumerate() {
        let measured = if let Some(surface) = surface {
            let stream = stream.split(index as u64);
            result.by_row(scene, receiver, stop, |at, texel| {
                at.area(texel, emitter, surface, &stream.split(texel as u64))
            })?
        } else {
            let first =
                result.by_row(scene, receiver, stop, |at, texel| at.glance(texel, emitter))?;
            result.by_row(scene, receiver, stop, |at, texel| {
                if is_near_edge(&first, texel, receiver) {
                    at.edge(texel, emitter)
                } else {
                    first[texel].value
                }
            })?
        };
        for (sum, part) in result.texels.iter_mut().zip(measured) {
            sum.irradiance += part.irradiance;
            sum.error += part.error;
        }
    }
    Some(result)
}

impl Direct {
    /// What is known before anything was measured: nothing, with an error bar of NaN.
    pub fn unknown(texels: usize) -> Self {
        let texel = DirectTexel {
            irradiance: Rgb::BLACK,
            error: Rgb::grey(f64::NAN),
        };
        Self {
            texels: vec![texel; texels],
            counters: TraversalCounters::default(),
        }
    }

    /// `measure` of every texel, on all cores; counts the work.
    fn by_row<T: Send>(
        &mut self,
        scene: &Scene,
        receiver: &Receiver,
        stop: &(dyn Fn() -> bool + Sync),
        measure: impl Fn(&mut DirectLight, usize) -> T + Sync,
    ) -> Option<Vec<T>> {
        let rows: Option<Vec<(Vec<T>, TraversalCounters)>> = (0..receiver.height())
            .into_par_iter()
            .map(|row| {
                if stop() {
                    return None;
                }
                let mut at = DirectLight {
                    scene,
                    receiver,
                    counters: TraversalCounters::default(),
                };
                let texels = (0..receiver.width())
                    .map(|column| measure(&mut at, row * receiver.width() + column))
                    .collect();
                Some((texels, at.counters))
            })
            .collect();
        let mut all = Vec::with_capacity(receiver.texels());
        for (texels, counters) in rows? {
            all.extend(texels);
            self.counters += counters;
        }
        Some(all)
    }
}

/// Whether a texel and its neighbours do not all see the same share of the emitter.
fn is_near_edge(first: &[Glance], texel: usize, receiver: &Receiver) -> bool {
    let (column, row) = (texel % receiver.width(), texel / receiver.width());
    let near = |i: usize, count: usize| i.saturating_sub(1)..(i + 2).min(count);
    let mut seen = first[texel].passed;
    for row in near(row, receiver.height()) {
        for column in near(column, receiver.width()) {
            seen = seen.with(first[row * receiver.width() + column].passed);
        }
    }
    seen.is_mixed()
}

/// The least and the largest share of an emitter that some points see.
#[derive(Clone, Copy)]
struct Passed {
    least: f64,
    most: f64,
}

impl Passed {
    const NOTHING_SEEN: Self = Self {
        least: f64::INFINITY,
        most: f64::NEG_INFINITY,
    };

    fn with(self, other: Self) -> Self {
        Self {
            least: self.least.min(other.least),
            most: self.most.max(other.most),
        }
    }

    fn with_share(self, share: f64) -> Self {
        self.with(Self {
            least: share,
            most: share,
        })
    }

    fn is_mixed(self) -> bool {
        self.least < self.most
    }
}

/// A texel's irradiance from few points, and what these see of the emitter.
struct Glance {
    value: DirectTexel,
    passed: Passed,
}

/// A part of a texel, by fractions across it.
#[derive(Clone, Copy)]
struct Leaf {
    from: DVec2,
    size: f64,
    level: u32,
}

impl Leaf {
    /// All of a texel.
    const TEXEL: Self = Self {
        from: DVec2::ZERO,
        size: 1.0,
        level: 0,
    };

    fn quarters(&self) -> [Self; 4] {
        [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)].map(|(i, j)| Self {
            from: self.from + DVec2::new(i, j) * (0.5 * self.size),
            size: 0.5 * self.size,
            level: self.level + 1,
        })
    }

    /// The point (x, y) sizes from the middle.
    fn at(&self, x: f64, y: f64) -> DVec2 {
        self.from + (DVec2::new(x, y) + 0.5) * self.size
    }
}

/// What a leaf's points see.
struct Look {
    /// The leaf's share of its texel's irradiance.
    irradiance: Rgb,
    /// The same without shadow.
    unshadowed: Rgb,
    passed: Passed,
}

struct DirectLight<'a> {
    scene: &'a Scene,
    receiver: &'a Receiver,
    counters: TraversalCounters,
}

impl DirectLight<'_> {
    fn receiver_point(&self, texel: usize, at: DVec2) -> SurfacePoint {
        self.receiver.point(self.scene, texel, at)
    }

    /// Average over a texel of a delta emitter's light, as few points see it.
    fn glance(&mut self, texel: usize, emitter: &Emitter) -> Glance {
        let mut result = Glance {
            value: DirectTexel::default(),
            passed: Passed::NOTHING_SEEN,
        };
        let (width, height) = (self.receiver.width(), self.receiver.height());
        let is_end = |i: usize, count: usize| i == 0 || i + 1 == count;
        let is_border = is_end(texel % width, width) || is_end(texel / width, height);
        let mut pending = vec![Leaf::TEXEL];
        while let Some(leaf) = pending.pop() {
            if self.is_coarse(texel, &leaf, emitter) {
                pending.extend(leaf.quarters());
                continue;
            }
            let look = self.look(texel, &leaf, emitter);
            result.value.irradiance += look.irradiance;
            result.passed = result.passed.with(look.passed);
            if is_border {
                // No neighbours on one side: nobody else looks there.
                result.passed = self.guarded(texel, &leaf, emitter, result.passed);
            }
        }
        result
    }

    /// Average over a texel of a delta emitter's light, where a shadow's edge may run through it.
    fn edge(&mut self, texel: usize, emitter: &Emitter) -> DirectTexel {
        let mut result = DirectTexel::default();
        let mut pending = vec![Leaf::TEXEL];
        while let Some(leaf) = pending.pop() {
            if leaf.level < EDGE_LEVELS || self.is_coarse(texel, &leaf, emitter) {
                pending.extend(leaf.quarters());
                continue;
            }
            let look = self.look(texel, &leaf, emitter);
            let passed = self.guarded(texel, &leaf, emitter, look.passed);
            let mixed = passed.is_mixed() && !look.unshadowed.is_black();
            if mixed && leaf.level < SHADOW_LEVELS {
                pending.extend(leaf.quarters());
                continue;
            }
            result.irradiance += look.irradiance;
            if mixed {
                // The share that passes is somewhere between the least and the most.
                result.error += look.unshadowed * (passed.most - passed.least);
            }
        }
        result
    }

    /// A leaf's share of its texel's irradiance, by 2 x 2 Gauss points.
    fn look(&mut self, texel: usize, leaf: &Leaf, emitter: &Emitter) -> Look {
        let mut look = Look {
            irradiance: Rgb::BLACK,
            unshadowed: Rgb::BLACK,
            passed: Passed::NOTHING_SEEN,
        };
        let weight = leaf.size * leaf.size / 4.0;
        for (i, j) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
            let point = self.receiver_point(texel, leaf.at(i * GAUSS, j * GAUSS));
            let (arriving, passed) = self.arriving(&point, emitter);
            look.unshadowed += arriving * weight;
            look.irradiance += arriving * (passed * weight);
            look.passed = look.passed.with_share(passed);
        }
        look
    }

    /// What a leaf's guards see beside its points. On the receiver's border they stand on the border.
    fn guarded(&mut self, texel: usize, leaf: &Leaf, emitter: &Emitter, seen: Passed) -> Passed {
        let mut passed = seen;
        for i in GUARDS {
            for j in GUARDS {
                if passed.is_mixed() {
                    return passed;
                }
                let at = self.receiver.clamped(texel, leaf.at(i, j));
                let point = self.receiver_point(texel, at);
                passed = passed.with_share(self.arriving(&point, emitter).1);
            }
        }
        passed
    }

    /// Whether a leaf is too large for 2 x 2 Gauss points: to integrate 1/r² and the cosine, or
    /// the edges of a spot's beam.
    ///
    /// For the former their relative error is about (size / distance)⁴ / 100: a ratio of 1/64
    /// leaves 1e-9. A spot's falloff has kinks where the beam starts to fall and where it ends;
    /// leaves across them, and leaves that could hold the whole beam, are divided to the end.
    fn is_coarse(&self, texel: usize, leaf: &Leaf, emitter: &Emitter) -> bool {
        let from = match emitter {
            Emitter::Point { position, .. } => *position,
            Emitter::Spot { to_world, .. } => to_world.point(DVec3::ZERO),
            Emitter::Directional { .. } | Emitter::Area { .. } => return false,
        };
        if leaf.level >= SHADOW_LEVELS {
            return false;
        }
        let middle = self.receiver_point(texel, leaf.at(0.0, 0.0)).position;
        let distance = middle.distance(from);
        let size = self.receiver.texel_area(texel).sqrt() * leaf.size;
        if size > distance / 64.0 {
            return true;
        }
        let Emitter::Spot {
            to_world,
            cutoff_angle,
            beam_width,
            ..
        } = emitter
        else {
            return false;
        };
        let radius = [(-0.5, -0.5), (0.5, -0.5), (-0.5, 0.5), (0.5, 0.5)]
            .map(|(x, y)| self.receiver_point(texel, leaf.at(x, y)).position)
            .map(|corner| corner.distance(middle))
            .into_iter()
            .fold(0.0, f64::max);
        // The leaf is seen within about this angle of its middle.
        let reach = 1.1 * radius / distance;
        let angle = (middle - from).angle_between(to_world.vector(DVec3::Z));
        (angle - cutoff_angle).abs() < reach || (angle - beam_width).abs() < reach || angle < reach
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
        let mut unshadowed = 0.0;
        for replicate in 0..REPLICATES {
            let stream = stream.split(u64::from(replicate));
            let mut mean = 0.0;
            for sample in 0..SAMPLES {
                let [u, v, s, t] = stream.point4(u64::from(sample));
                let point = self.receiver_point(texel, DVec2::new(u, v));
                let (arriving, passed) = self.area_sample(&point, light, DVec2::new(s, t));
                mean += arriving * passed;
                unshadowed += arriving;
            }
            mean /= f64::from(SAMPLES);
            sum += mean;
            sum_squares += mean * mean;
        }
        let n = f64::from(REPLICATES);
        let variance = ((sum_squares - sum * sum / n) / (n - 1.0)).max(0.0);
        // Stratified samples often agree on how many of them see the light, in all replicates:
        // then their scatter is none, but the edge is known to one sample only.
        let samples = n * f64::from(SAMPLES);
        let is_mixed = sum > 0.0 && sum * f64::from(SAMPLES) < unshadowed;
        let one_sample = if is_mixed {
            unshadowed / (samples * samples)
        } else {
            0.0
        };
        DirectTexel {
            irradiance: *radiance * (sum / n),
            error: *radiance * (variance / n).sqrt().hypot(one_sample),
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
        let corners = CORNERS.map(|(u, v)| self.receiver_point(texel, DVec2::new(u, v)));
        let whole = light.rectangle()?;
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
        // On which side of a straight edge a ray passes is bilinear in its two ends: an edge that
        // hides any of the light from any of the texel does so for a pair of corners.
        for (u, v) in CORNERS {
            let sample = surface_point(whole.0.point(DVec2::new(u, v)), whole.1);
            for corner in &corners {
                if let Some(seen) = kernel(corner, &sample)
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
        let Some(seen) = light.sample(at).and_then(|sample| kernel(point, &sample)) else {
            return (0.0, 0.0);
        };
        let passed = self.transmittance(point, seen.towards, seen.reach);
        (seen.value * light.area(), passed)
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
