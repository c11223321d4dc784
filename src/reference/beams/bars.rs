//! Irradiance of a signature from its sums, with lower and upper bounds.
//!
//! Three sums tell of a texel's error:
//!
//! - d is the change of the extrapolated flux when all cells were halved the last time: (4B − A)/3 less
//!   (4A − C)/3. If the light is smooth, the answer is off by a small part of d. If a fold or a border runs
//!   through a cell, it is off by a good part. Here d may vanish by accident, when the errors of several
//!   cells cancel, but not in the neighbours, too. So the largest |d| of 3 x 3 texels counts.
//! - m is what cells of many texels are likely to misplace. It is a sum of positive terms: over so many
//!   texels, d changes its sign.
//! - s is the flux of cells that no single line divides into topologies, and of borders' curvature.
//!
//! ```text
//! bar = max|d| + max(m) + max(s)          over 3 x 3 texels, for m over 3 x 3 texels of each level
//! ```
//!
//! That covers every texel of the scenes with a closed form at tolerances from coarse to fine
//! (`tests/beams/bars.rs`, `docs/beams.md`). It is measured, not proved: a feature that no node of any
//! cell saw is in none of the sums.

use super::film::{BeamFilm, FilmTexel, three_near};
use super::sums::Sums;
use crate::transport::flux::Flux;

/// Relative error of light that is known exactly but for rounding. A deposit is a dozen operations on a path
/// of a dozen more, with condition numbers of a hundred.
const ROUNDING: f64 = 1e-11;

/// Part of |d| that is the likely error, root mean square over texels. The bar must hold for each texel.
const LIKELY: f64 = 0.25;
/// Part of s, spread over the texels that it may be on, that is added to the likely error.
const LIKELY_UNCERTAIN: f64 = 0.125;

/// The fluxes of a finished film, with their bars and likely errors.
pub fn bounded<const N: usize>(film: &BeamFilm<N>) -> Sums {
    let [width, height] = film.size();
    let texels = film.texels();
    let mut result = Sums::dark(texels.len());
    for row in 0..height {
        for column in 0..width {
            let mut most = Most::<N>::default();
            for y in three_near(row, height) {
                for one in &texels[y * width..][three_near(column, width)] {
                    most.include(one);
                }
            }
            let index = row * width + column;
            let own = &texels[index];
            let bar = most.change + own.misplaced + most.uncertain + most.flux * ROUNDING;
            let likely = own.change.max_magnitude() * LIKELY + own.spread.abs() * LIKELY_UNCERTAIN;
            result.flux[index] = own.flux.rgb();
            result.bar[index] = bar.rgb();
            result.variance[index] = likely * likely + own.uneven;
        }
    }
    result
}

/// The largest magnitudes of some texels' sums, channel by channel.
#[derive(Clone, Copy, Default)]
struct Most<const N: usize> {
    flux: Flux<N>,
    change: Flux<N>,
    uncertain: Flux<N>,
}

impl<const N: usize> Most<N> {
    fn include(&mut self, texel: &FilmTexel<N>) {
        self.flux = self.flux.larger(texel.flux.magnitude());
        self.change = self.change.larger(texel.change.magnitude());
        self.uncertain = self.uncertain.larger(texel.uncertain.magnitude());
    }
}
