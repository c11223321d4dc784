//! Pixels as averages: the weights with which the radiance round a pixel makes its value.
//!
//! With f the [filter](ReconstructionFilter), pᵢ the pixel's centre and L the radiance at film points x,
//!
//! ```text
//! pixel i = ∫ f(pᵢ − x) L(x) dx / ∫ f(pᵢ − x) dx
//! ```
//!
//! with both integrals over the film that is sampled. Beyond the film's edge that is a border of the filter's
//! width if the film asks for one (`sample_border`), or nothing. The average over more and more samples that
//! are [spread](super::splat) and divided by their weights is the same.
//!
//! Light that finds its own place on the film is [spread](PixelFilter::spread) over the pixels with
//! f / ∫ f. A pixel that looks for light chooses [places](PixelFilter::choose) by |f|.

use glam::DVec2;

use super::ReconstructionFilter;
use super::splat::{Footprint, Splatter};
use crate::numeric::WeightedChoice;

/// A film's filter, divided by its integral at each pixel.
#[derive(Clone, Debug)]
pub struct PixelFilter {
    filter: ReconstructionFilter,
    splatter: Splatter,
    /// The corners of the film that is sampled.
    sampled: [DVec2; 2],
    /// 1 / ∫ f by column and by row.
    inverse: [Vec<f64>; 2],
    /// Steps over the filter's width, by their share of ∫ |f|; `None` if f is zero everywhere.
    steps: Option<WeightedChoice>,
}

/// Steps in a pixel's width, over each of which |f| is taken to be even for choosing places: that changes
/// their weights by a few per cent, and no mean.
const STEPS: usize = 32;

impl PixelFilter {
    /// The averages over a film of `width` x `height` pixels, sampled as far as `border` pixels beyond.
    pub fn new(filter: ReconstructionFilter, [width, height]: [usize; 2], border: usize) -> Self {
        let film = DVec2::new(width as f64, height as f64);
        let border = border as f64;
        let radius = filter.radius();
        let whole = filter.integral(-radius, radius);
        let inverse = [width, height].map(|size| {
            let (low, high) = (-border, size as f64 + border);
            let of = |pixel: usize| {
                let centre = pixel as f64 + 0.5;
                let [before, behind] = [low - centre, high - centre];
                let is_whole = before <= -radius && behind >= radius;
                let integral = if is_whole {
                    whole
                } else {
                    filter.integral(before, behind)
                };
                1.0 / integral
            };
            (0..size).map(of).collect()
        });
        let count = steps_of(&filter);
        let share = |step: usize| {
            let size =
                [0.0, 0.5, 1.0].map(|part| filter.eval(place(&filter, count, step, part)).abs());
            // Simpson's rule.
            size[0] + 4.0 * size[1] + size[2]
        };
        Self {
            filter,
            splatter: Splatter::new(filter, width, height),
            sampled: [DVec2::splat(-border), film + border],
            inverse,
            steps: WeightedChoice::new((0..count).map(share)),
        }
    }

    /// True if light at film coordinates counts.
    #[inline]
    pub fn is_sampled(&self, at: DVec2) -> bool {
        let [low, high] = self.sampled;
        at.cmpge(low).all() && at.cmplt(high).all()
    }

    /// Finds the pixels that light at film coordinates goes to, with the weights f / ∫ f; none if it does not
    /// count. `footprint` is overwritten.
    pub fn spread(&self, at: DVec2, footprint: &mut Footprint) {
        self.splatter.spread(at, footprint);
        if !self.is_sampled(at) {
            footprint.columns.clear();
            return;
        }
        let starts = [footprint.left, footprint.top];
        let axes = [&mut footprint.columns, &mut footprint.rows];
        for ((weights, inverse), start) in axes.into_iter().zip(&self.inverse).zip(starts) {
            for (weight, inverse) in weights.iter_mut().zip(&inverse[start..]) {
                *weight *= inverse;
            }
        }
    }

    /// A film point for a pixel, by two numbers that are uniform in [0, 1), and the weight of the radiance
    /// there: its mean over points is the pixel's average. The weight is 0 for a point that does not count,
    /// less than a step beyond the film that is sampled.
    pub fn choose(&self, pixel: [usize; 2], numbers: [f64; 2]) -> (DVec2, f64) {
        let Some(steps) = &self.steps else {
            return (DVec2::ZERO, f64::NAN);
        };
        let count = steps_of(&self.filter);
        let width = 2.0 * self.filter.radius() / count as f64;
        let (mut at, mut weight) = ([0.0; 2], 1.0);
        for axis in 0..2 {
            let centre = pixel[axis] as f64 + 0.5;
            // The steps that overlap the film.
            let step_at = |film: f64| ((film - centre + self.filter.radius()) / width).floor();
            let [first, last] = self.sampled.map(|corner| step_at(corner[axis]));
            let (first, last) = (
                first.max(0.0) as usize,
                (last.max(0.0) as usize).min(count - 1),
            );
            let (before, behind) = (steps.below(first), steps.below(last + 1));
            let step = steps.choose(before + numbers[axis] * (behind - before));
            let offset = place(&self.filter, count, step.index, step.rest);
            let density = steps.probability(step.index) / (width * (behind - before));
            at[axis] = centre + offset;
            weight *= self.filter.eval(offset) / density * self.inverse[axis][pixel[axis]];
        }
        let at = DVec2::from_array(at);
        if self.is_sampled(at) {
            (at, weight)
        } else {
            (at, 0.0)
        }
    }
}

/// Number of steps over a filter's width.
fn steps_of(filter: &ReconstructionFilter) -> usize {
    let pixels = (2.0 * filter.radius()).ceil().clamp(1.0, 4096.0) as usize;
    pixels * STEPS
}

/// The offset from a pixel's centre of the place that is `part` (0..=1) through a step.
fn place(filter: &ReconstructionFilter, count: usize, step: usize, part: f64) -> f64 {
    let radius = filter.radius();
    let width = 2.0 * radius / count as f64;
    (-radius + (step as f64 + part) * width).min(radius.next_down())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::{SampleMoments, Stream, StreamKind};

    const FILTERS: [ReconstructionFilter; 6] = [
        ReconstructionFilter::Box,
        ReconstructionFilter::Tent { radius: 1.3 },
        ReconstructionFilter::Gaussian { stddev: 0.5 },
        ReconstructionFilter::Mitchell {
            b: 1.0 / 3.0,
            c: 1.0 / 3.0,
        },
        ReconstructionFilter::CatmullRom,
        ReconstructionFilter::Lanczos { lobes: 3 },
    ];

    const SIZE: [usize; 2] = [7, 5];

    /// Places a pixel and axis at which integrals are sums: multiples of its parts, but for a tenth of one.
    const PLACES: usize = 200;

    /// A film whose radiance varies.
    fn radiance(at: DVec2) -> f64 {
        2.0 + 0.3 * at.x - 0.1 * at.y * at.y
    }

    /// ∫ f L / ∫ f of a pixel, by the midpoint rule.
    fn average(filter: &ReconstructionFilter, border: usize, pixel: [usize; 2]) -> f64 {
        let (mut sum, mut weights) = (0.0, 0.0);
        let points = |axis: usize| {
            let first = border * PLACES;
            (0..(SIZE[axis] + 2 * border) * PLACES)
                .map(move |k| (k as f64 + 0.5 - first as f64) / PLACES as f64)
                .filter(move |x| (x - pixel[axis] as f64 - 0.5).abs() <= filter.radius())
        };
        for y in points(1) {
            let row = filter.eval(pixel[1] as f64 + 0.5 - y);
            for x in points(0) {
                let weight = row * filter.eval(pixel[0] as f64 + 0.5 - x);
                sum += weight * radiance(DVec2::new(x, y));
                weights += weight;
            }
        }
        sum / weights
    }

    /// Pixels in the middle, at an edge and in a corner.
    const PIXELS: [[usize; 2]; 3] = [[3, 2], [0, 2], [6, 4]];

    /// The midpoint rule's error is h²/24 (f'(b) − f'(a)) an axis: slopes are below 2, times a radiance of up
    /// to 4, over both ends of up to eight smooth parts. The tent's kinks are not at its steps, and cost one
    /// step of the slope's jump: as much again.
    const TOLERANCE: f64 = 2.0 * 8.0 * 2.0 * 2.0 * 4.0 / (24.0 * (PLACES * PLACES) as f64);

    #[test]
    fn light_that_is_spread_over_pixels_sums_to_their_averages() {
        for filter in FILTERS {
            for border in [0, filter.border()] {
                let pixels = PixelFilter::new(filter, SIZE, border);
                let mut film = vec![0.0; SIZE[0] * SIZE[1]];
                let mut footprint = Footprint::default();
                let side = |axis: usize| (SIZE[axis] + 2 * border) * PLACES;
                let at = |k: usize| (k as f64 + 0.5) / PLACES as f64 - border as f64;
                for (row, column) in (0..side(1)).flat_map(|y| (0..side(0)).map(move |x| (y, x))) {
                    let at = DVec2::new(at(column), at(row));
                    pixels.spread(at, &mut footprint);
                    for (x, y, weight) in footprint.pixels() {
                        film[y * SIZE[0] + x] += weight * radiance(at) / (PLACES * PLACES) as f64;
                    }
                }
                for pixel in PIXELS {
                    let expected = average(&filter, border, pixel);
                    let found = film[pixel[1] * SIZE[0] + pixel[0]];
                    let difference = (found - expected).abs();
                    assert!(
                        difference < TOLERANCE,
                        "{filter:?} {border} {pixel:?}: {found} for {expected}"
                    );
                }
            }
        }
    }

    #[test]
    fn places_that_pixels_choose_have_their_averages() {
        for filter in FILTERS {
            for border in [0, filter.border()] {
                let pixels = PixelFilter::new(filter, SIZE, border);
                for pixel in PIXELS {
                    let stream = Stream::new(StreamKind::Random, 7);
                    let mut moments = SampleMoments::default();
                    for index in 0..1 << 17 {
                        let (at, weight) = pixels.choose(pixel, stream.point2(index));
                        moments.add(weight * radiance(at));
                    }
                    let (found, error) =
                        (moments.mean().unwrap(), moments.standard_error().unwrap());
                    let expected = average(&filter, border, pixel);
                    // Of 36 means, one is more than five deviations off with a probability of 2e-5.
                    let tolerance = 5.0 * error + TOLERANCE;
                    assert!(
                        tolerance < 0.06,
                        "{filter:?} {pixel:?}: {tolerance} says little"
                    );
                    assert!(
                        (found - expected).abs() < tolerance,
                        "{filter:?} {border} {pixel:?}: {found} for {expected}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_filter_much_wider_than_the_film_wastes_no_place() {
        let wide = ReconstructionFilter::Gaussian { stddev: 20.0 };
        let pixels = PixelFilter::new(wide, SIZE, 0);
        let stream = Stream::new(StreamKind::Random, 3);
        for pixel in PIXELS {
            let weights = (0..4096).map(|index| pixels.choose(pixel, stream.point2(index)).1);
            let lost = weights.filter(|weight| *weight == 0.0).count();
            // A step of 1/32 pixel beyond each end of seven and of five pixels.
            assert!(lost < 4096 / 20, "{pixel:?}: {lost}");
        }
    }

    #[test]
    fn light_beyond_the_film_counts_only_if_it_is_sampled() {
        let filter = ReconstructionFilter::Gaussian { stddev: 0.5 };
        let mut footprint = Footprint::default();
        let beyond = DVec2::new(-0.3, 2.5);
        PixelFilter::new(filter, SIZE, 0).spread(beyond, &mut footprint);
        assert!(footprint.is_empty());
        PixelFilter::new(filter, SIZE, 2).spread(beyond, &mut footprint);
        assert!(!footprint.is_empty());
    }

    #[test]
    fn a_box_film_counts_light_in_its_pixel_alone_with_weight_one() {
        let pixels = PixelFilter::new(ReconstructionFilter::Box, SIZE, 0);
        let mut footprint = Footprint::default();
        pixels.spread(DVec2::new(3.0, 4.99), &mut footprint);
        let found: Vec<_> = footprint.pixels().collect();
        assert_eq!(found, [(3, 4, 1.0)]);
    }

    #[test]
    fn filters_that_dip_below_zero_say_so() {
        for filter in FILTERS {
            let least = (0..=1000)
                .map(|k| filter.eval(filter.radius() * f64::from(k) / 1000.0))
                .fold(0.0, f64::min);
            assert_eq!(filter.has_negative_lobes(), least < 0.0, "{filter:?}");
        }
    }
}
