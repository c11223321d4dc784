//! Stage `smooth` (section 3.4): a Gaussian on the film.

use std::ops::Range;

use rayon::prelude::*;

use super::work::Work;
use crate::numeric::math;
use crate::radiometry::Rgb;

/// Standard deviations to which the Gaussian reaches.
const REACH: f64 = 3.0;

/// The film after a Gaussian of a standard deviation \[texels\], first along rows, then along columns. Beyond
/// the film nothing is: weights within it are divided by their sum.
pub fn smoothed(
    mut values: Vec<Rgb>,
    [width, height]: [usize; 2],
    sigma: f64,
    work: &mut Work,
) -> Vec<Rgb> {
    let filter = Gaussian::new(sigma);
    let reach = filter.reach();
    work.fetches += (values.len() * 2 * (2 * reach + 1)) as u64;
    // Rows in their own place, with the columns that are not black then.
    let lit: Vec<Range<usize>> = values
        .par_chunks_mut(width)
        .map(|row| {
            let before = row.to_vec();
            let lit = widened(&lit(&before), reach, width);
            for column in lit.clone() {
                row[column] = filter.average(column, width, |place| before[place]);
            }
            lit
        })
        .collect();
    let mut smooth = vec![Rgb::BLACK; values.len()];
    let rows = smooth.par_chunks_mut(width).enumerate();
    rows.for_each(|(row, into)| {
        let near = row.saturating_sub(reach)..(row + reach + 1).min(height);
        let near = lit[near].iter().filter(|lit| !lit.is_empty());
        let first = near.clone().map(|lit| lit.start).min().unwrap_or(0);
        let end = near.map(|lit| lit.end).max().unwrap_or(0);
        for (column, into) in (first..end).zip(&mut into[first..end]) {
            *into = filter.average(row, height, |place| values[place * width + column]);
        }
    });
    smooth
}

/// The part of a row outside of which all is black.
fn lit(row: &[Rgb]) -> Range<usize> {
    let is_lit = |value: &Rgb| !value.is_black();
    match (row.iter().position(is_lit), row.iter().rposition(is_lit)) {
        (Some(first), Some(last)) => first..last + 1,
        _ => 0..0,
    }
}

/// A part of a row, longer by the filter's reach at both ends; empty if it is.
fn widened(part: &Range<usize>, reach: usize, length: usize) -> Range<usize> {
    if part.is_empty() {
        return 0..0;
    }
    part.start.saturating_sub(reach)..(part.end + reach).min(length)
}

/// A filter along a line.
struct Gaussian {
    /// From its middle on.
    weights: Vec<f64>,
    /// The sum of both sides, added up in an order that does not depend on the place.
    all: f64,
}

impl Gaussian {
    fn new(sigma: f64) -> Self {
        let reach = (REACH * sigma).ceil() as usize;
        let weights: Vec<f64> = (0..=reach)
            .map(|offset| math::exp(-0.5 * math::powi(offset as f64 / sigma, 2)))
            .collect();
        let all = weights[0] + 2.0 * weights[1..].iter().sum::<f64>();
        Self { weights, all }
    }

    fn reach(&self) -> usize {
        self.weights.len() - 1
    }

    /// The mean about a place of a line.
    #[inline]
    fn average(&self, place: usize, length: usize, value: impl Fn(usize) -> Rgb) -> Rgb {
        let reach = self.reach();
        let near = place.saturating_sub(reach)..(place + reach + 1).min(length);
        let is_whole = near.len() == 2 * reach + 1;
        let (mut sum, mut total) = (Rgb::BLACK, 0.0);
        for other in near {
            let weight = self.weights[other.abs_diff(place)];
            sum += value(other) * weight;
            total += weight;
        }
        sum / if is_whole { self.all } else { total }
    }
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
        let found = smoothed(point, size, 1.5, &mut work);
        let sum: Rgb = found.iter().copied().sum();
        // No weight is beyond the film: all is kept, to rounding.
        assert!((sum.0[2] - 4.0).abs() < 1e-13, "{sum:?}");
        let ratio = found[10 * size[0] + 19].0[1] / found[10 * size[0] + 16].0[1];
        assert!((ratio - math::exp(-0.5_f64 * 4.0)).abs() < 1e-13);
        assert_eq!(found[13 * size[0] + 16], found[10 * size[0] + 19]);
        let even = vec![Rgb::WHITE; size[0] * size[1]];
        let found = smoothed(even, size, 2.0, &mut work);
        assert!(found.iter().all(|one| (one.0[0] - 1.0).abs() < 1e-14));
    }
}
