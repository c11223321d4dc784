//! Stage `smooth` (section 3.4): a Gaussian on the film.

use rayon::prelude::*;

use super::work::Work;
use crate::numeric::math;
use crate::radiometry::Rgb;

/// Standard deviations to which the Gaussian reaches.
const REACH: f64 = 3.0;

/// The film after a Gaussian of a standard deviation \[texels\], first along rows, then along columns. Beyond
/// the film nothing is: weights within it are divided by their sum.
pub fn smoothed(
    values: &[Rgb],
    [width, height]: [usize; 2],
    sigma: f64,
    work: &mut Work,
) -> Vec<Rgb> {
    let reach = (REACH * sigma).ceil() as usize;
    let weights: Vec<f64> = (0..=reach)
        .map(|offset| math::exp(-0.5 * math::powi(offset as f64 / sigma, 2)))
        .collect();
    work.fetches += (values.len() * 2 * (2 * reach + 1)) as u64;
    let across = transposed_blur(values, width, &weights);
    transposed_blur(&across, height, &weights)
}

/// Rows of a picture after a symmetric filter, as columns.
fn transposed_blur(values: &[Rgb], width: usize, weights: &[f64]) -> Vec<Rgb> {
    /// Columns of the result that are made together: they are read from the same lines of the cache.
    const COLUMNS: usize = 8;
    let reach = weights.len() - 1;
    let height = values.len() / width;
    let all = weights[0] + 2.0 * weights[1..].iter().sum::<f64>();
    let mut turned = vec![Rgb::BLACK; values.len()];
    turned
        .par_chunks_mut(COLUMNS * height)
        .enumerate()
        .for_each(|(block, part)| {
            let first = block * COLUMNS;
            for row in 0..height {
                let line = &values[row * width..][..width];
                for (index, column) in (first..(first + COLUMNS).min(width)).enumerate() {
                    let range = column.saturating_sub(reach)..(column + reach + 1).min(width);
                    let near = &line[range.clone()];
                    if near.iter().all(|one| one.is_black()) {
                        continue;
                    }
                    let mut sum = Rgb::BLACK;
                    let mut total = 0.0;
                    for (place, value) in range.zip(near) {
                        let weight = weights[place.abs_diff(column)];
                        sum += *value * weight;
                        total += weight;
                    }
                    let is_whole = near.len() == 2 * reach + 1;
                    part[index * height + row] = sum / if is_whole { all } else { total };
                }
            }
        });
    turned
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_becomes_a_gaussian_and_an_even_film_stays() {
        let size = [33, 21];
        let mut point = vec![Rgb::BLACK; size[0] * size[1]];
        point[10 * size[0] + 16] = Rgb([1.0, 2.0, 4.0]);
        let mut work = Work::default();
        let found = smoothed(&point, size, 1.5, &mut work);
        let sum: Rgb = found.iter().copied().sum();
        // No weight is beyond the film: all is kept, to rounding.
        assert!((sum.0[2] - 4.0).abs() < 1e-13, "{sum:?}");
        let ratio = found[10 * size[0] + 19].0[1] / found[10 * size[0] + 16].0[1];
        assert!((ratio - math::exp(-0.5_f64 * 4.0)).abs() < 1e-13);
        assert_eq!(found[13 * size[0] + 16], found[10 * size[0] + 19]);
        let even = vec![Rgb::WHITE; size[0] * size[1]];
        let found = smoothed(&even, size, 2.0, &mut work);
        assert!(found.iter().all(|one| (one.0[0] - 1.0).abs() < 1e-14));
    }
}
