//! Irradiance of a signature from its sums, with lower and upper bounds.
//!
//! Three sums tell of a texel's error:
//!
//! - q = B − A is the change when all cells are halved once. The answer is (4B − A)/3 = B + q/3. If the light
//!   is smooth, A is off by 4q/3 and the answer by much less. If a fold or a border runs through a cell, the
//!   answer is off by a part of q. Here q may vanish by accident, when the errors of several cells cancel,
//!   but not in the neighbours, too. So the largest |q| of 3 x 3 texels counts.
//! - a is the flux of quarter cells within their bend of a texel line. It is a sum of positive terms, and
//!   covers errors that cancel in q.
//! - s is the flux of cells that no single line divides into topologies, and of borders' curvature.
//!
//! ```text
//! bar = max|q| + max(a)/32 + max(s)          over 3 x 3 texels
//! ```
//!
//! The factors cover every texel of the scenes with a closed form at tolerances from coarse to fine
//! (`tests/beams/bars.rs`, `docs/beams.md`). They are measured, not proved: a feature that no node of any
//! cell saw is in none of the sums.

use super::film::{BeamFilm, FilmTexel, TexelSums};
use crate::transport::flux::Flux;

/// Factor of |q|.
const OF_DIFFERENCE: f64 = 1.0;
/// Factor of a.
const OF_NEAR_LINES: f64 = 1.0 / 32.0;

/// Relative error of light that is known exactly but for rounding. A deposit is a dozen operations on a path
/// of a dozen more, with condition numbers of a hundred.
const ROUNDING: f64 = 1e-11;

/// Part of |q| that is the likely error, root mean square over texels. The bar must hold for each texel.
const LIKELY: f64 = 0.25;
/// Part of s, spread over the texels that it may be on, that is added to the likely error.
const LIKELY_UNCERTAIN: f64 = 0.125;

/// Flux \[W\] of one signature, texel by texel.
pub struct BoundedFlux<const N: usize> {
    /// The answer.
    pub flux: Vec<Flux<N>>,
    /// Largest distance of the truth from the answer.
    pub bar: Vec<Flux<N>>,
    /// Likely distance of the truth from the answer, root mean square, worst channel.
    pub likely: Vec<f64>,
}

/// The fluxes of a finished film, with their bars.
pub fn bounded<const N: usize>(film: &BeamFilm<N>) -> BoundedFlux<N> {
    let [width, height] = film.size();
    let texels = film.texels();
    let near = |at: usize, end: usize| at.saturating_sub(1)..(at + 2).min(end);
    let mut result = BoundedFlux {
        flux: Vec::with_capacity(texels.len()),
        bar: Vec::with_capacity(texels.len()),
        likely: Vec::with_capacity(texels.len()),
    };
    for row in 0..height {
        for column in 0..width {
            let mut most = FilmTexel::<N>::default();
            for y in near(row, height) {
                for one in &texels[y * width..][near(column, width)] {
                    most = larger(&most, one);
                }
            }
            let own = &texels[row * width + column];
            result.flux.push(own.sums.flux);
            result.bar.push(
                most.sums.difference * OF_DIFFERENCE
                    + most.sums.near_lines * OF_NEAR_LINES
                    + most.uncertain
                    + most.sums.flux * ROUNDING,
            );
            result
                .likely
                .push(own.sums.difference.max_magnitude() * LIKELY + own.spread * LIKELY_UNCERTAIN);
        }
    }
    result
}

/// The larger magnitudes, channel by channel.
fn larger<const N: usize>(a: &FilmTexel<N>, b: &FilmTexel<N>) -> FilmTexel<N> {
    let of =
        |a: &Flux<N>, b: &Flux<N>| Flux(std::array::from_fn(|c| a.0[c].abs().max(b.0[c].abs())));
    FilmTexel {
        sums: TexelSums {
            flux: of(&a.sums.flux, &b.sums.flux),
            difference: of(&a.sums.difference, &b.sums.difference),
            near_lines: of(&a.sums.near_lines, &b.sums.near_lines),
        },
        uncertain: of(&a.uncertain, &b.uncertain),
        spread: a.spread.max(b.spread),
    }
}
