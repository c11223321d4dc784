//! One wave on water, and light straight down through it.

use super::branches::Branches;
use super::quadrature::integrate;
use super::{TexelGrid, TexelRect};
use crate::numeric::math;
use crate::optics::dielectric_reflectance;

/// A water surface z = `depth` + A sin(k x + p) over the plane z = 0, in light that falls straight down (path
/// `LTD`).
///
/// At x the surface has the slope s = A k cos(k x + p); light meets it at θ = atan s, is refracted to sin t =
/// sin θ / n, and is turned by θ − t towards the side where the water stands higher (all angles signed):
///
/// ```text
/// x' = x + z(x) tan(θ − t),     dΦ per metre of y = E (1 − F(θ)) dx
/// ```
///
/// The irradiance averaged over a texel [x₀, x₁] is the integral of E (1 − F) over all x with x' in it,
/// divided by its width; x' is inverted on each of its monotone branches, so that folds (caustic lines) need
/// no care. The wave reaches from −`half_width` to `half_width`; y does not matter.
#[derive(Clone, Debug)]
pub struct SineWater {
    wave: SineWave,
    branches: Branches,
}

/// The parameters of [`SineWater`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SineWave {
    /// The mean height of the surface (m).
    pub depth: f64,
    /// A (m).
    pub amplitude: f64,
    /// k [rad/m].
    pub wave_number: f64,
    /// p (rad).
    pub phase: f64,
    /// The index n of the water relative to air.
    pub ior: f64,
    /// E on a horizontal plane [W/m²].
    pub irradiance: f64,
    /// Distance of the surface's ends from the middle (m).
    pub half_width: f64,
}

impl SineWater {
    /// Prepares the map: finds its folds.
    pub fn new(wave: SineWave) -> Self {
        let branches = Branches::new(-wave.half_width, wave.half_width, &|x| {
            Some(wave.landing(x))
        });
        Self { wave, branches }
    }

    /// The irradiance [W/m²] averaged over a texel of the plane.
    pub fn texel_irradiance(&self, texel: &TexelRect) -> f64 {
        let landing = |x: f64| Some(self.wave.landing(x));
        let per_metre: f64 = self
            .branches
            .iter()
            .map(|branch| {
                let (a, b) = (
                    branch.inverse(texel.min.x, &landing),
                    branch.inverse(texel.max.x, &landing),
                );
                let (a, b) = (a.min(b), a.max(b));
                if a == b {
                    return 0.0;
                }
                // 16 nodes for each tenth of a radian of the wave.
                let panels = (10.0 * (b - a) * self.wave.wave_number.abs())
                    .ceil()
                    .max(1.0);
                integrate(a, b, panels as usize, |x| self.wave.transmitted(x))
            })
            .sum();
        per_metre / (texel.max.x - texel.min.x)
    }

    /// The irradiance [W/m²] of every texel of a grid, in the order of [`TexelGrid::map`].
    pub fn map(&self, grid: &TexelGrid) -> Vec<f64> {
        let row: Vec<f64> = (0..grid.columns)
            .map(|column| self.texel_irradiance(&grid.texel(column, 0)))
            .collect();
        row.repeat(grid.rows)
    }

    /// Places x' (m) at which the light folds on the plane, in the order of the surface's points it comes
    /// from.
    pub fn fold_positions(&self) -> Vec<f64> {
        self.branches
            .iter()
            .skip(1)
            .map(|branch| self.wave.landing(branch.range().0))
            .collect()
    }
}

impl SineWave {
    fn landing(&self, x: f64) -> f64 {
        let (sin, cos) = math::sin_cos(self.wave_number * x + self.phase);
        let slope = self.amplitude * self.wave_number * cos;
        let angle = math::atan(slope);
        let turned = angle - math::asin(math::sin(angle) / self.ior);
        x + (self.depth + self.amplitude * sin) * math::tan(turned)
    }

    fn transmitted(&self, x: f64) -> f64 {
        let slope =
            self.amplitude * self.wave_number * math::cos(self.wave_number * x + self.phase);
        self.irradiance
            * (1.0 - dielectric_reflectance(1.0 / math::hypot(1.0_f64, slope), self.ior))
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    const WAVE: SineWave = SineWave {
        depth: 0.8,
        amplitude: 0.04,
        wave_number: 12.0,
        phase: 0.4,
        ior: 1.33,
        irradiance: 1000.0,
        half_width: 1.0,
    };

    #[test]
    fn flat_water_lets_the_normal_transmittance_pass_everywhere() {
        let water = SineWater::new(SineWave {
            amplitude: 0.0,
            ..WAVE
        });
        let exact = 1000.0 * (1.0 - math::powi(0.33_f64 / 2.33, 2));
        let irradiance = water.texel_irradiance(&TexelRect::new(0.1, 0.0, 0.2, 0.1));
        assert!(
            (irradiance / exact - 1.0).abs() < 1e-13,
            "{irradiance} {exact}"
        );
    }

    #[test]
    fn all_of_the_floor_receives_all_that_enters() {
        let water = SineWater::new(WAVE);
        let on_floor = water.texel_irradiance(&TexelRect::new(-2.0, 0.0, 2.0, 1.0)) * 4.0;
        let entering = integrate(-1.0, 1.0, 64, |x| WAVE.transmitted(x));
        assert!((on_floor / entering - 1.0).abs() < 1e-13);
        let grid = TexelGrid {
            bounds: TexelRect::new(-1.5, 0.0, 1.5, 1.0),
            columns: 777,
            rows: 1,
        };
        let sum: f64 = water.map(&grid).iter().sum::<f64>() * 3.0 / 777.0;
        assert!((sum / entering - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_texel_on_a_fold_agrees_with_brute_force() {
        let water = SineWater::new(WAVE);
        let fold = water.fold_positions()[2];
        let texel = TexelRect::new(fold - 0.002, 0.0, fold + 0.002, 1.0);
        let count = 2_000_000;
        let step = 2.0 / f64::from(count);
        let brute: f64 = (0..count)
            .map(|i| step * (f64::from(i) + 0.5) - 1.0)
            .filter(|&x| (texel.min.x..texel.max.x).contains(&WAVE.landing(x)))
            .map(|x| WAVE.transmitted(x) * step)
            .sum::<f64>()
            / 0.004;
        let irradiance = water.texel_irradiance(&texel);
        // At most 2 steps lost or gained at each end of at most 3 branches: 6 · 1e-6 · 1000 / 0.004.
        assert!((irradiance - brute).abs() < 1.5, "{irradiance} {brute}");
        assert!(irradiance > 2000.0);
    }

    #[test]
    fn the_pattern_repeats_with_the_wave() {
        let water = SineWater::new(WAVE);
        let length = TAU / 12.0;
        let at = |x: f64| water.texel_irradiance(&TexelRect::new(x, 0.0, x + 0.01, 1.0));
        // The inverse is right to a few ulp of 1, on a width of 0.01, and folds amplify by a square root.
        assert!((at(-0.3) / at(-0.3 + length) - 1.0).abs() < 1e-9);
    }
}
