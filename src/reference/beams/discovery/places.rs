//! Places where a discovery starts paths.

use glam::DVec2;

use crate::reference::beams::light::BeamLight;
use crate::scene::Scene;
use crate::transport::first_surface::{Source, SurfaceChart, SurfacePatch};

/// A place of a first surface.
#[derive(Clone, Copy)]
pub(super) struct StartPlace {
    /// The chart.
    pub chart: SurfaceChart,
    /// Coordinates of the chart.
    pub at: DVec2,
    /// The chart area that it stands for.
    pub area: f64,
}

impl StartPlace {
    /// The place between two places of one chart. It stands for half of the smaller one's area.
    pub fn halfway(&self, other: &Self) -> Self {
        Self {
            chart: self.chart,
            at: 0.5 * (self.at + other.at),
            area: 0.5 * self.area.min(other.area),
        }
    }
}

/// About `count` places on the first surfaces of a light, at least `least` and one on each shape.
pub(super) fn places_of(
    scene: &Scene,
    light: &BeamLight,
    count: usize,
    least: usize,
) -> Vec<StartPlace> {
    let shapes = light
        .patches
        .chunk_by(|a, b| a.chart.shape() == b.chart.shape());
    let a_shape = count.div_ceil(shapes.clone().count().max(1));
    let a_shape = a_shape.max(least).max(1);
    shapes
        .flat_map(|patches| places_on(scene, &light.source, patches, a_shape))
        .collect()
}

/// `count` places on a shape, spread over its patches by the light that falls on them and by their area. So
/// the bright ones are not passed over, however many others there are.
fn places_on(
    scene: &Scene,
    source: &Source,
    patches: &[SurfacePatch],
    count: usize,
) -> Vec<StartPlace> {
    let lit = |patch: &SurfacePatch| {
        let [a, b, c] = patch.corners;
        let emitted = |at| {
            patch
                .chart
                .emitted(scene.world(), source, at)
                .unwrap_or(0.0)
        };
        let most = [a, b, c, (a + b + c) / 3.0].map(emitted);
        most.into_iter().fold(0.0, f64::max) * patch.area()
    };
    let lit: Vec<f64> = patches.iter().map(lit).collect();
    let areas: Vec<f64> = patches.iter().map(SurfacePatch::area).collect();
    // Half by light, half by area: most light of many reflections set out at a grazing angle.
    let by = |values: &[f64]| 0.5 / values.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    let (by_light, by_area) = (by(&lit), by(&areas));
    let shares = lit
        .iter()
        .zip(&areas)
        .map(|(lit, area)| lit * by_light + area * by_area);
    let total: f64 = shares.clone().sum();
    let mut places = Vec::with_capacity(count);
    let mut passed = 0.0;
    for (patch, share) in patches.iter().zip(shares) {
        passed += share;
        // One place for each part 1/count of the light.
        while places.len() < count && (places.len() as f64 + 0.5) * total <= passed * count as f64 {
            let area = patch.area() * total / (share * count as f64);
            places.push(StartPlace {
                chart: patch.chart,
                at: inside(patch, places.len()),
                area,
            });
        }
    }
    places
}

/// Points of Roberts' R2 sequence, folded into the triangle.
fn inside(patch: &SurfacePatch, index: usize) -> DVec2 {
    let [a, b, c] = patch.corners;
    let mut at = DVec2::new(
        (0.5 + 0.754_877_666_246_692_8 * index as f64).fract(),
        (0.5 + 0.569_840_290_998_053_3 * index as f64).fract(),
    );
    if at.x + at.y > 1.0 {
        at = DVec2::ONE - at;
    }
    a + (b - a) * at.x + (c - a) * at.y
}
