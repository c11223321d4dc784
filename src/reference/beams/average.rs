//! Averages over replicates of random places on area lights, with their scatter.

use super::bars::BoundedFlux;
use crate::radiometry::Rgb;
use crate::transport::flux::Flux;

/// Film sums \[W\], texel by texel: the mean over some replicates, with what is known of its error.
#[derive(Clone, Debug)]
pub struct Average {
    count: u32,
    mean: Vec<Rgb>,
    /// Sum of squared deviations from the mean.
    deviations: Vec<Rgb>,
    /// Mean of the replicates' bars: what cells misplace, and no scatter.
    bar: Vec<Rgb>,
    /// Sum of squares of the replicates' likely errors, worst channel: their cells belong to
    /// places that know nothing of each other.
    variance: Vec<f64>,
    /// The squared likely error of what was not drawn by lot.
    fixed_variance: Vec<f64>,
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
    /// No light on `texels` texels.
    pub fn dark(texels: usize) -> Self {
        Self {
            flux: vec![Rgb::BLACK; texels],
            bar: vec![Rgb::BLACK; texels],
            variance: vec![0.0; texels],
        }
    }

    /// One signature's.
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

    /// Adds another signature's: bars add up; likely errors by squares, as they know nothing of
    /// each other.
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
    /// Of no replicate, over `texels` texels.
    pub fn new(texels: usize) -> Self {
        Self {
            count: 0,
            mean: vec![Rgb::BLACK; texels],
            deviations: vec![Rgb::BLACK; texels],
            bar: vec![Rgb::BLACK; texels],
            variance: vec![0.0; texels],
            fixed_variance: vec![0.0; texels],
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
            let wider = sums.bar[texel] - self.bar[texel];
            self.bar[texel] += wider * share;
            self.variance[texel] += sums.variance[texel];
        }
    }

    /// Adds light that was not drawn by lot.
    pub fn add_fixed(&mut self, sums: &Sums) {
        for texel in 0..self.mean.len() {
            self.mean[texel] += sums.flux[texel];
            self.bar[texel] += sums.bar[texel];
            self.fixed_variance[texel] += sums.variance[texel];
        }
    }

    /// How many texels.
    pub fn texels(&self) -> usize {
        self.mean.len()
    }

    /// The mean of a texel.
    pub fn mean(&self, texel: usize) -> Rgb {
        self.mean[texel]
    }

    /// How far the mean may be off because of how cells were dealt out.
    pub fn bar(&self, texel: usize) -> Rgb {
        self.bar[texel]
    }

    /// How far it is likely to be.
    pub fn likely(&self, texel: usize) -> f64 {
        let count = f64::from(self.count.max(1));
        (self.variance[texel] / (count * count) + self.fixed_variance[texel]).sqrt()
    }

    /// The standard error of the mean: the scatter of the replicates; none below two, where
    /// nothing was drawn by lot.
    pub fn standard_error(&self, texel: usize) -> Rgb {
        if self.count < 2 {
            return Rgb::BLACK;
        }
        let count = f64::from(self.count);
        (self.deviations[texel] * (1.0 / (count * (count - 1.0))))
            .map(|variance| variance.max(0.0).sqrt())
    }
}
