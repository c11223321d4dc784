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
    /// Whether any replicate left light on a texel.
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

    /// How much more light than it got a texel may get \[W\] that no replicate of `points` places a lamp has lit, at
    /// a two-sided `confidence`; black where one has, whose scatter tells more, or where nothing is drawn by lot.
    ///
    /// A part p of the lamps that lights the texel is missed by n independent places with probability (1 − p)ⁿ, by well
    /// spread ones less often: with α = (1
    /// − confidence)/2, p is below 1 − α^(1/n), about ln(1/α)/n (the rule of three, for α = 5 %). The light of that part is taken
    /// for that of the brightest texel of any replicate: brighter ones may exist that no place has shown.
    pub fn unseen(&self, texel: usize, points: u64, confidence: f64) -> Rgb {
        if self.count == 0 || self.is_lit[texel] {
            return Rgb::BLACK;
        }
        let places = f64::from(self.count) * points as f64;
        let miss = 0.5 * (1.0 - confidence);
        self.largest * -(miss.ln() / places).exp_m1()
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
