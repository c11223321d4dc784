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

/// The fluxes of a finished film, with their bars and likely errors. What light on coarser texels is likely
/// off within them adds to the likely errors alone: m counts all of it.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::FixedPoint;
    use crate::reference::beams::film::{LevelTexel, TexelSums};

    #[test]
    fn the_likely_error_is_that_of_changes_and_of_uneven_light_by_squares() {
        let scale = FixedPoint::for_total(1e9).unwrap();
        let film = BeamFilm::<1>::new([64, 64], scale);
        let sums = |flux: f64, change: f64| TexelSums {
            flux: Flux([flux]),
            change: Flux([change]),
            ..TexelSums::default()
        };
        let at = |level: usize| LevelTexel {
            level,
            at: [8 >> level, 8 >> level],
        };
        film.add(at(0), &sums(5.0, 2.0));
        film.add(at(1), &sums(12.0, 0.0));
        // A quarter of 2; and a change of 3 along both axes, within texels two of the film's wide.
        let expected = 0.25 + 2.0 * 9.0 * 0.5 * 2.0 / 15.0;
        let variance = bounded(&film).variance[64 * 8 + 8];
        assert!((variance - expected).abs() < 1e-6, "{variance}");
    }
}
