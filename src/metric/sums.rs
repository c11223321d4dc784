//! Sums over texels in a fixed order: the same bits on any number of threads.

use rayon::prelude::*;

/// Texels summed one after the other.
const CHUNK: usize = 1 << 14;

/// The results of `part` for ranges of `0..count`, in order. The ranges depend on `count` alone.
pub(super) fn parts<T: Send>(
    count: usize,
    part: impl Fn(std::ops::Range<usize>) -> T + Sync,
) -> Vec<T> {
    (0..count.div_ceil(CHUNK))
        .into_par_iter()
        .map(|chunk| part(chunk * CHUNK..count.min((chunk + 1) * CHUNK)))
        .collect()
}

/// The sums of N terms a texel over `0..count`.
pub(super) fn sums<const N: usize>(
    count: usize,
    terms: impl Fn(usize) -> [f64; N] + Sync,
) -> [f64; N] {
    let add = |mut sum: [f64; N], terms: [f64; N]| {
        for (sum, term) in sum.iter_mut().zip(terms) {
            *sum += term;
        }
        sum
    };
    parts(count, |range| range.map(&terms).fold([0.0; N], add))
        .into_iter()
        .fold([0.0; N], add)
}

/// Sums of N terms a texel over squares of `side` x `side` texels, square by square.
pub(super) fn square_sums<const N: usize>(
    [width, height]: [usize; 2],
    side: usize,
    terms: impl Fn(usize) -> [f64; N] + Sync,
) -> Vec<[f64; N]> {
    let columns = width.div_ceil(side);
    (0..height.div_ceil(side))
        .into_par_iter()
        .flat_map_iter(|band| {
            let mut squares = vec![[0.0; N]; columns];
            for y in band * side..height.min((band + 1) * side) {
                for x in 0..width {
                    let square = &mut squares[x / side];
                    for (sum, term) in square.iter_mut().zip(terms(y * width + x)) {
                        *sum += term;
                    }
                }
            }
            squares
        })
        .collect()
}
