//! The light of a beam at a point: stages `density`, `occlusion` and `cosine`, and what others leave to
//! points.

use glam::{DVec2, DVec3};

use super::beam::Beam;
use super::sums::{Format, Sum};
use super::variants::{Cosine, Density, Occlusion, Transmittance, WaterShadow};
use super::volume::{FlatWater, Lit};
use super::work::Work;
use crate::approximation::Receivers;
use crate::approximation::interface::Fresnel;
use crate::approximation::sensor::SensorPoint;
use crate::geometry::TraversalCounters;

/// What the light of one source at a point depends on.
#[derive(Clone, Copy)]
pub struct Shading<'a> {
    /// The source's beams.
    pub lit: Lit<'a>,
    /// The source's light in flat water.
    pub flat: &'a FlatWater,
    /// The format of sums.
    pub format: Format,
    /// What may hide points from the water's surface.
    pub receivers: &'a Receivers,
}

/// Work and rays at points.
#[derive(Clone, Copy, Debug, Default)]
pub struct ShadeWork {
    /// Sums.
    pub accumulate: Work,
    /// Points.
    pub inside: Work,
    /// Shadows on the water.
    pub shadow: Work,
    /// Shadows below.
    pub occlusion: Work,
}

impl std::ops::AddAssign for ShadeWork {
    fn add_assign(&mut self, other: Self) {
        self.accumulate += other.accumulate;
        self.inside += other.inside;
        self.shadow += other.shadow;
        self.occlusion += other.occlusion;
    }
}

impl Shading<'_> {
    /// Adds the light of a beam at a point in it.
    ///
    /// - `weights`, `depth`: the point's in the beam.
    #[inline]
    pub fn add(
        &self,
        sum: &mut Sum,
        beam: &Beam,
        (weights, depth): ([f64; 3], f64),
        point: &SensorPoint,
        work: &mut ShadeWork,
    ) {
        let slope = beam.slope(weights);
        let Some(factor) = self.left_to_points(beam, weights, depth, point, work) else {
            return;
        };
        let scale = factor / self.flat.irradiance;
        let intensities = self.intensities(beam, slope, depth).map(|it| it * scale);
        let mut mixed = 0.0;
        for (weight, intensity) in weights.iter().zip(intensities) {
            mixed += weight * intensity;
        }
        let is_full = match self.lit.settings.cosine {
            Cosine::Flat => sum.add(self.format, self.within(mixed)),
            Cosine::Exact => sum.add(self.format, self.within(mixed) * self.cos(point, slope)),
            Cosine::Vector => {
                let mut vector = DVec3::ZERO;
                for i in 0..3 {
                    let towards = -self.lit.slicing.direction(beam.rulings[i].slope);
                    vector += towards * (weights[i] * self.within(intensities[i]));
                }
                sum.add_vector(self.format, vector)
            }
        };
        self.count(1, u64::from(is_full), &mut work.accumulate);
    }

    /// Counts sums that were written, and those of them that reached the largest number.
    #[inline]
    pub fn count(&self, blends: u64, saturated: u64, work: &mut Work) {
        work.blends += blends;
        work.saturated += saturated;
        // Read and written: four channels, of which vectors need three.
        work.bytes += blends * 2 * 4 * self.format.bytes();
    }

    /// The product of the stages that are exact at points, at one that a stencil buffer takes to be in a
    /// beam; with stage `cosine` exact, also of the cosine. Beside the beam, light goes as in its middle.
    pub fn factor_at(&self, beam: &Beam, point: &SensorPoint, work: &mut ShadeWork) -> f64 {
        let settings = self.lit.settings;
        let is_asked = settings.cosine == Cosine::Exact
            || settings.fresnel == Transmittance::Exact
            || settings.shadow == WaterShadow::Exact
            || settings.occlusion == Occlusion::Exact;
        if !is_asked {
            return 1.0;
        }
        let (across, depth) = self.lit.slicing.local(point.point.position);
        let weights = beam
            .section(depth)
            .weights(across)
            .unwrap_or([1.0 / 3.0; 3]);
        let slope = beam.slope(weights);
        let left = self
            .left_to_points(beam, weights, depth, point, work)
            .unwrap_or(0.0);
        match settings.cosine {
            Cosine::Flat | Cosine::Vector => left,
            Cosine::Exact => left * self.cos(point, slope),
        }
    }

    /// The cosine of the angle at which light of a slope falls on a point; 0 on its back.
    #[inline]
    fn cos(&self, point: &SensorPoint, slope: DVec2) -> f64 {
        (-point.normal.dot(self.lit.slicing.direction(slope))).max(0.0)
    }

    /// A value as the format can have it, at most.
    #[inline]
    pub fn within(&self, value: f64) -> f64 {
        value.min(self.format.largest())
    }

    /// Stage `density`: light by area, by each ray as if all were its own; infinite in a focus.
    #[inline]
    fn intensities(&self, beam: &Beam, slope: DVec2, depth: f64) -> [f64; 3] {
        match self.lit.settings.density {
            Density::Exact => {
                let cos = 1.0 / (1.0 + slope.length_squared()).sqrt();
                let by_area = 1.0 / (beam.section(depth).area() * cos);
                beam.light.map(|light| density(light, by_area))
            }
            Density::Slices => {
                let by_area = beam.by_area(self.lit.slicing, depth);
                beam.light.map(|light| density(light, by_area))
            }
            Density::Perpendicular => {
                let by_area = beam.by_area(self.lit.slicing, depth);
                [0, 1, 2].map(|i| density(beam.light[i], by_area / beam.rulings[i].cos()))
            }
        }
    }

    /// The light at a vertex of a beam, in one of the planes.
    #[inline]
    pub fn at_vertex(&self, beam: &Beam, ray: usize, by_area: f64) -> f64 {
        let light = density(beam.light[ray], by_area) / self.flat.irradiance;
        match self.lit.settings.density {
            Density::Slices => light,
            // In the plane the area across the vertex' own ray is exact.
            Density::Perpendicular | Density::Exact => light / beam.rulings[ray].cos(),
        }
    }

    /// The product of the stages that are exact at points; `None` if it is zero.
    #[inline]
    fn left_to_points(
        &self,
        beam: &Beam,
        weights: [f64; 3],
        depth: f64,
        point: &SensorPoint,
        work: &mut ShadeWork,
    ) -> Option<f64> {
        let Lit {
            scene,
            settings,
            water,
            ..
        } = self.lit;
        let mut factor = 1.0;
        let is_exact =
            settings.fresnel == Transmittance::Exact || settings.shadow == WaterShadow::Exact;
        if is_exact {
            let place = water.place(scene, beam.triangle, beam.corner(weights))?;
            if settings.fresnel == Transmittance::Exact {
                factor *= self.lit.refracted(&place, Fresnel::Exact)?.share;
            }
            if settings.shadow == WaterShadow::Exact {
                let mut counters = TraversalCounters::default();
                factor *= self.lit.reaches(&place, &mut counters);
                work.shadow.add_rays(counters);
            }
        }
        if settings.occlusion == Occlusion::Exact && factor > 0.0 {
            let mut counters = TraversalCounters::default();
            let is_hidden = self.is_hidden(beam, weights, depth, point, &mut counters);
            work.occlusion.add_rays(counters);
            if is_hidden {
                return None;
            }
        }
        (factor > 0.0).then_some(factor)
    }

    /// True if a receiver hides a point from where its ray leaves the water's surface. The surface itself,
    /// which beams approximate, hides nothing.
    fn is_hidden(
        &self,
        beam: &Beam,
        weights: [f64; 3],
        depth: f64,
        point: &SensorPoint,
        counters: &mut TraversalCounters,
    ) -> bool {
        let ruling = beam.ruling(weights);
        let towards = -self.lit.slicing.direction(ruling.slope);
        let distance = (depth - ruling.start) / ruling.cos();
        distance > 0.0
            && self
                .receivers
                .hide(&point.point.spawn(towards), distance, counters)
    }

    /// Irradiance at a point by the source's strength, from the sum over its beams.
    pub fn irradiance(&self, sum: &Sum, point: &SensorPoint) -> f64 {
        let value = match self.lit.settings.cosine {
            Cosine::Flat => sum.scalar * (-point.normal.dot(self.flat.direction)).max(0.0),
            Cosine::Exact => sum.scalar,
            Cosine::Vector => point.normal.dot(sum.vector).max(0.0),
        };
        value * self.flat.irradiance
    }
}

/// Light by area; none of no light, also in a focus.
#[inline]
fn density(light: f64, by_area: f64) -> f64 {
    if light == 0.0 { 0.0 } else { light * by_area }
}
