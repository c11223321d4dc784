//! Film sums of some light, in three channels.

use crate::radiometry::Rgb;

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

    /// Widens bars of light from coarse cells: any of it may be elsewhere, and texels may get as much as
    /// `may_get` \[W\] in any channel.
    pub fn widen(&mut self, may_get: &[f64]) {
        for ((bar, flux), most) in self.bar.iter_mut().zip(&self.flux).zip(may_get) {
            let widest = |channel: usize| {
                let flux = flux.0[channel];
                bar.0[channel].max(flux).max(most - flux)
            };
            *bar = Rgb([0, 1, 2].map(widest));
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_of_coarse_cells_may_be_elsewhere_or_as_much_as_paths_tell() {
        let mut sums = Sums::dark(3);
        sums.flux = [1.0, 1.0, 1.0].map(Rgb::grey).to_vec();
        sums.bar = [0.1, 0.1, 7.0].map(Rgb::grey).to_vec();
        sums.widen(&[0.5, 4.0, 4.0]);
        let bars: Vec<f64> = sums.bar.iter().map(|bar| bar.mean()).collect();
        // Down to nothing, up to 4, and no narrower than before.
        assert_eq!(bars, [1.0, 3.0, 7.0]);
    }
}
