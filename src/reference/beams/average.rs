//! Averages over replicates of random places on area lights, with their scatter.

use super::bars::BoundedFlux;
use crate::radiometry::Rgb;
use crate::transport::flux::Flux;

/// Mean film sums \[W\] over some replicates, texel by texel, with their errors.
#[derive(Clone, Debug)]
pub struct Average {
    count: u32,
    mean: Vec<Rgb>,
    /// Sum of squared deviations from the mean.
    deviations: Vec<Rgb>,
    /// Mean of the replicates' bars: flux that cells misplace, without scatter.
    bar: Vec<Rgb>,
    /// Sum of squares of the replicates' likely errors, worst channel: their cells belong to independent
    /// places.
    variance: Vec<f64>,
    /// The squared likely error of light that is not drawn at random.
    fixed_variance: Vec<f64>,
    /// True if any replicate left light on a texel.
    is_lit: Vec<bool>,
    /// The largest flux that any replicate left on any texel.
    largest: Rgb,
}

/// One replicate's film sums \[W\].
#[derive(Clone, Debug)]
pub struct Sums {
    flux: Vec<Rgb>,
    bar: Vec<Rgb>,
    /// Squares of likely errors.
    variance: Vec<f64>,
}

impl Sums {
    /// Sums of no light on `texels` texels.
    pub fn dark(texels: usize) -> Self {
        Self {
            flux: vec![Rgb::BLACK; texels],
            bar: vec![Rgb::BLACK; texels],
            variance: vec![0.0; texels],
        }
    }

    /// The sums of one signature.
    pub fn of<const N: usize>(bounded: &BoundedFlux<N>) -> Self {
        let rgb = |values: &[Flux<N>]| values.iter().map(|flux| flux.rgb()).collect();
        Self {
            flux: rgb(&bounded.flux),
            bar: rgb(&bounded.bar),
            variance: bounded
                .likely
                .iter()
                .map(|likely| likely * likely)
                .collect(),
        }
    }

    /// Adds another signature's sums. Bars add up; likely errors add by squares, as they are independent.
    pub fn add(&mut self, other: &Self) {
        for (sum, flux) in self.flux.iter_mut().zip(&other.flux) {
            *sum += *flux;
        }
        for (sum, bar) in self.bar.iter_mut().zip(&other.bar) {
            *sum += *bar;
        }
        for (sum, variance) in self.variance.iter_mut().zip(&other.variance) {
            *sum += variance;
        }
    }
}

impl Average {
    /// The average of no replicate, over `texels` texels.
    pub fn new(texels: usize) -> Self {
        Self {
            count: 0,
            mean: vec![Rgb::BLACK; texels],
            deviations: vec![Rgb::BLACK; texels],
            bar: vec![Rgb::BLACK; texels],
            variance: vec![0.0; texels],
            fixed_variance: vec![0.0; texels],
            is_lit: vec![false; texels],
            largest: Rgb::BLACK,
        }
    }

    /// Adds a replicate, by Welford's update (*Technometrics* 4(3), 1962).
    pub fn add(&mut self, sums: &Sums) {
        self.count += 1;
        let share = 1.0 / f64::from(self.count);
        for texel in 0..self.mean.len() {
            let deviation = sums.flux[texel] - self.mean[texel];
            self.mean[texel] += deviation * share;
            self.deviations[texel] += deviation * (sums.flux[texel] - self.mean[texel]);
            self.is_lit[texel] |= !sums.flux[texel].is_black();
            for (largest, channel) in self.largest.0.iter_mut().zip(sums.flux[texel].0) {
                *largest = largest.max(channel);
            }
            let wider = sums.bar[texel] - self.bar[texel];
            self.bar[texel] += wider * share;
            self.variance[texel] += sums.variance[texel];
        }
    }

    /// Adds light that is not drawn at random.
    pub fn add_fixed(&mut self, sums: &Sums) {
        for texel in 0..self.mean.len() {
            self.mean[texel] += sums.flux[texel];
            self.bar[texel] += sums.bar[texel];
            self.fixed_variance[texel] += sums.variance[texel];
        }
    }

    /// Number of texels.
    pub fn texels(&self) -> usize {
        self.mean.len()
    }

    /// The mean of a texel.
    pub fn mean(&self, texel: usize) -> Rgb {
        self.mean[texel]
    }

    /// Largest error of the mean that the division into cells may cause.
    pub fn bar(&self, texel: usize) -> Rgb {
        self.bar[texel]
    }

    /// Likely error of the mean, for the same reason.
    pub fn likely(&self, texel: usize) -> f64 {
        let count = f64::from(self.count.max(1));
        (self.variance[texel] / (count * count) + self.fixed_variance[texel]).sqrt()
    }

    /// Flux \[W\] that an unlit texel may get, at a two-sided `confidence`: no replicate of `points` places
    /// an area light has lit it. It is black if a replicate has lit the texel, as their scatter tells more,
    /// or if nothing is drawn at random.
    ///
    /// n independent places miss a part p of the area lights, which lights the texel, with probability (1 −
    /// p)ⁿ. Well spread places miss it less often. With α = (1 − confidence)/2, p is below 1 − α^(1/n), about
    /// ln(1/α)/n (the rule of three, for α = 5 %). The light of that part is taken for that of the brightest
    /// texel of any replicate: brighter ones may exist that no place has shown.
    pub fn unseen(&self, texel: usize, points: u64, confidence: f64) -> Rgb {
        if self.count == 0 || self.is_lit[texel] {
            return Rgb::BLACK;
        }
        let places = f64::from(self.count) * points as f64;
        let miss = 0.5 * (1.0 - confidence);
        self.largest * -(miss.ln() / places).exp_m1()
    }

    /// Standard error of the mean: the scatter of the replicates; zero if there are fewer than two, as
    /// nothing is drawn at random then.
    pub fn standard_error(&self, texel: usize) -> Rgb {
        if self.count < 2 {
            return Rgb::BLACK;
        }
        let count = f64::from(self.count);
        (self.deviations[texel] * (1.0 / (count * (count - 1.0))))
            .map(|variance| variance.max(0.0).sqrt())
    }
}
