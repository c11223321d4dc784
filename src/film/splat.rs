//! Splatting: the pixels that a sample goes to, and their weights.
//!
//! A sample of value L at the film point x adds f(pᵢ − x) L to each pixel i near it, pᵢ its centre and f the
//! [filter](ReconstructionFilter). Paths from a camera spread their samples evenly over the film, and divide
//! by the weights they gave: pixel i is Σ f(pᵢ − xₛ) Lₛ / Σ f(pᵢ − xₛ) over the samples s. Light that is
//! connected to a camera chooses its own places, and is divided by the mean of those weights: see
//! [`PixelFilter`](super::PixelFilter).

use glam::DVec2;

use super::ReconstructionFilter;

/// A filter on a film of some size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Splatter {
    filter: ReconstructionFilter,
    width: usize,
    height: usize,
}

/// The pixels that a sample goes to: a rectangle, and a weight for each of its columns and rows.
#[derive(Clone, Debug, Default)]
pub struct Footprint {
    /// The rectangle's left column.
    pub left: usize,
    /// The rectangle's top row.
    pub top: usize,
    /// A weight a column.
    pub columns: Vec<f64>,
    /// A weight a row.
    pub rows: Vec<f64>,
}

impl Splatter {
    /// A filter on a film of `width` x `height` pixels.
    pub fn new(filter: ReconstructionFilter, width: usize, height: usize) -> Self {
        Self {
            filter,
            width,
            height,
        }
    }

    /// Finds the pixels that a sample at `at` goes to, with the weights f; none if it reaches no pixel of the
    /// film. `at` is in pixels, the film's top left corner at (0, 0); it may lie outside.
    ///
    /// `footprint` is overwritten: its memory serves the next sample.
    pub fn spread(&self, at: DVec2, footprint: &mut Footprint) {
        footprint.left = self.axis(at.x, self.width, &mut footprint.columns);
        footprint.top = self.axis(at.y, self.height, &mut footprint.rows);
    }

    /// The first pixel within reach of `at` along one axis, and the weights from there on.
    fn axis(&self, at: f64, size: usize, weights: &mut Vec<f64>) -> usize {
        weights.clear();
        let last = size as f64 - 1.0;
        let (first, end) = if self.filter == ReconstructionFilter::Box {
            // Centre and radius are not used: rounding could put a sample into both of two pixels, or none.
            (at.floor(), at.floor())
        } else {
            // Only pixels nearer than the radius count: at its end the weight is zero.
            let radius = self.filter.radius();
            (
                (at - 0.5 - radius).floor() + 1.0,
                (at - 0.5 + radius).ceil() - 1.0,
            )
        };
        let is_within = first <= last && end >= 0.0;
        if !is_within {
            return 0;
        }
        let (first, end) = (first.max(0.0) as usize, end.min(last) as usize);
        weights.extend((first..=end).map(|pixel| {
            if self.filter == ReconstructionFilter::Box {
                1.0
            } else {
                self.filter.eval(pixel as f64 + 0.5 - at)
            }
        }));
        first
    }
}

impl Footprint {
    /// True if no pixel is reached.
    pub fn is_empty(&self) -> bool {
        self.columns.is_empty() || self.rows.is_empty()
    }

    /// Column, row and weight of every pixel, row by row.
    pub fn pixels(&self) -> impl Iterator<Item = (usize, usize, f64)> {
        self.rows.iter().enumerate().flat_map(move |(row, by_row)| {
            self.columns
                .iter()
                .enumerate()
                .map(move |(column, by_column)| {
                    (self.left + column, self.top + row, by_row * by_column)
                })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILTERS: [ReconstructionFilter; 4] = [
        ReconstructionFilter::Box,
        ReconstructionFilter::Gaussian { stddev: 0.5 },
        ReconstructionFilter::CatmullRom,
        ReconstructionFilter::Tent { radius: 1.7 },
    ];

    fn spread(splatter: &Splatter, at: DVec2) -> Vec<(usize, usize, f64)> {
        let mut footprint = Footprint::default();
        splatter.spread(at, &mut footprint);
        footprint.pixels().collect()
    }

    #[test]
    fn a_footprint_holds_every_pixel_with_a_weight_and_that_weight() {
        for filter in FILTERS {
            let splatter = Splatter::new(filter, 7, 5);
            for (x, y) in [
                (0.0, 0.0),
                (3.2, 2.9),
                (6.999, 0.1),
                (-0.7, 5.6),
                (3.0, 2.5),
            ] {
                let found = spread(&splatter, DVec2::new(x, y));
                for row in 0..5 {
                    for column in 0..7 {
                        let offset = [column as f64 + 0.5 - x, row as f64 + 0.5 - y];
                        // A box is half open at the other end if seen from the pixel.
                        let of = |d: f64| match filter {
                            ReconstructionFilter::Box => filter.eval(-d),
                            _ => filter.eval(d),
                        };
                        let expected = of(offset[0]) * of(offset[1]);
                        let weight = found
                            .iter()
                            .find(|pixel| (pixel.0, pixel.1) == (column, row))
                            .map_or(0.0, |pixel| pixel.2);
                        assert_eq!(weight, expected, "{filter:?} at {x}, {y}: {column}, {row}");
                    }
                }
            }
        }
    }

    #[test]
    fn what_falls_far_outside_reaches_nothing() {
        for filter in FILTERS {
            let splatter = Splatter::new(filter, 7, 5);
            for at in [
                DVec2::new(-4.0, 2.0),
                DVec2::new(3.0, 1e300),
                DVec2::new(f64::NAN, 2.0),
            ] {
                assert!(spread(&splatter, at).is_empty(), "{filter:?} at {at}");
            }
        }
    }
}
