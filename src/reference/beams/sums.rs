//! Film sums of some light, in three channels.

use super::bars::BoundedFlux;
use crate::radiometry::Rgb;
use crate::transport::flux::Flux;

/// Film sums \[W\] of one signature or of several, texel by texel.
#[derive(Clone, Debug)]
pub struct Sums {
    /// The answer.
    pub flux: Vec<Rgb>,
    /// Largest distance of the truth from the answer.
    pub bar: Vec<Rgb>,
    /// Squares of the likely errors, worst channel.
    pub variance: Vec<f64>,
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

    /// Number of texels.
    pub fn texels(&self) -> usize {
        self.flux.len()
    }
}
