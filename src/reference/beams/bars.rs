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
//! bar = max|d| + max(m) + max(s)          over 3 x 3 texels
//! ```
//!
//! That covers every texel of the scenes with a closed form at tolerances from coarse to fine
//! (`tests/beams/bars.rs`, `docs/beams.md`). It is measured, not proved: a feature that no node of any
//! cell saw is in none of the sums.

use super::film::{BeamFilm, FilmTexel, TexelSums};
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
    // Three in a row at the film's border, too.
    let near = |at: usize, end: usize| {
        let first = at.saturating_sub(1).min(end.saturating_sub(3));
        first..(first + 3).min(end)
    };
    let mut result = Sums::dark(texels.len());
    for row in 0..height {
        for column in 0..width {
            let mut most = FilmTexel::<N>::default();
            for y in near(row, height) {
                for one in &texels[y * width..][near(column, width)] {
                    most = larger(&most, one);
                }
            }
            let index = row * width + column;
            let own = &texels[index];
            let bar =
                most.sums.change + most.sums.misplaced + most.uncertain + most.sums.flux * ROUNDING;
            let likely =
                own.sums.change.max_magnitude() * LIKELY + own.spread.abs() * LIKELY_UNCERTAIN;
            result.flux[index] = own.sums.flux.rgb();
            result.bar[index] = bar.rgb();
            result.variance[index] = likely * likely;
        }
    }
    result
}

/// The larger magnitudes, channel by channel.
fn larger<const N: usize>(a: &FilmTexel<N>, b: &FilmTexel<N>) -> FilmTexel<N> {
    let of = |a: &Flux<N>, b: &Flux<N>| a.magnitude().larger(b.magnitude());
    FilmTexel {
        sums: TexelSums {
            flux: of(&a.sums.flux, &b.sums.flux),
            change: of(&a.sums.change, &b.sums.change),
            misplaced: of(&a.sums.misplaced, &b.sums.misplaced),
        },
        uncertain: of(&a.uncertain, &b.uncertain),
        spread: a.spread.abs().max(b.spread.abs()),
    }
}
