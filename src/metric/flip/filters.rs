//! FLIP's convolution kernels, each a product of two kernels of one dimension.

use std::f32::consts::PI;

use crate::numeric::math::single;

/// The eye's response to a channel of the opponent space: Gaussians a √(π/b) exp(−π² x²/b) over the angle x
/// \[degrees\], by (a, b) (Andersson et al. 2020, table 1).
const ACHROMATIC: (f32, f32) = (1.0, 0.0047);
const RED_GREEN: (f32, f32) = (1.0, 0.0053);
/// The response to the blue-yellow channel: a sum of two Gaussians.
const BLUE_YELLOW: [(f32, f32); 2] = [(34.1, 0.04), (13.5, 0.025)];

/// Width of the edges and points to be found \[degrees\]: two standard deviations (section 4.2).
const FEATURE_WIDTH: f32 = 0.082;

/// The kernels at one number of pixels a degree. All have odd lengths.
pub(super) struct Filters {
    /// The achromatic channel's kernel.
    pub(super) achromatic: Vec<f32>,
    /// The red-green channel's kernel.
    pub(super) red_green: Vec<f32>,
    /// The blue-yellow channel's kernels: two, whose two-dimensional products are added.
    pub(super) blue_yellow: [Vec<f32>; 2],
    /// A Gaussian, across features.
    pub(super) smooth: Vec<f32>,
    /// Its first derivative: finds edges.
    pub(super) edge: Vec<f32>,
    /// Its second derivative: finds points.
    pub(super) point: Vec<f32>,
}

impl Filters {
    /// The kernels for `pixels_per_degree`.
    pub(super) fn new(pixels_per_degree: f32) -> Self {
        let widest = BLUE_YELLOW[0].1;
        let radius = (3.0 * (widest / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil() as i32;
        let angle = |x: i32| x as f32 / pixels_per_degree;
        let gaussian = |b: f32, x: i32| single::exp(-PI * PI * angle(x) * angle(x) / b);
        let places = || -radius..=radius;
        let single = |(a, b): (f32, f32)| {
            normalised(
                places()
                    .map(|x| a * (PI / b).sqrt() * gaussian(b, x))
                    .collect(),
            )
        };
        // The amplitude is that of the two-dimensional kernel; each dimension takes its root.
        let [mut wide, mut narrow] = BLUE_YELLOW.map(|(a, b)| {
            let amplitude = (a * (PI / b).sqrt()).sqrt();
            places()
                .map(|x| amplitude * gaussian(b, x))
                .collect::<Vec<f32>>()
        });
        // The two-dimensional sum is to be one: (Σ wide)² + (Σ narrow)².
        let norm = single::hypot(wide.iter().sum::<f32>(), narrow.iter().sum::<f32>());
        for weight in wide.iter_mut().chain(&mut narrow) {
            *weight /= norm;
        }

        let deviation = 0.5 * FEATURE_WIDTH * pixels_per_degree;
        let radius = (3.0 * deviation).ceil() as i32;
        let places = || (-radius..=radius).map(|x| x as f32);
        let bell = |x: f32| single::exp(-x * x / (2.0 * deviation * deviation));
        Self {
            achromatic: single(ACHROMATIC),
            red_green: single(RED_GREEN),
            blue_yellow: [wide, narrow],
            smooth: normalised(places().map(bell).collect()),
            edge: balanced(places().map(|x| -x * bell(x)).collect()),
            point: balanced(
                places()
                    .map(|x| (x * x / (deviation * deviation) - 1.0) * bell(x))
                    .collect(),
            ),
        }
    }

    /// Number of texels on each side of a texel that decide its error.
    pub(super) fn reach(&self) -> usize {
        self.achromatic.len().max(self.smooth.len()) / 2
    }
}

/// Weights that sum to one.
fn normalised(mut weights: Vec<f32>) -> Vec<f32> {
    let sum: f32 = weights.iter().sum();
    for weight in &mut weights {
        *weight /= sum;
    }
    weights
}

/// Weights whose positive ones sum to 1 and whose negative ones to −1.
fn balanced(mut weights: Vec<f32>) -> Vec<f32> {
    let positive: f32 = weights.iter().filter(|weight| **weight > 0.0).sum();
    let negative: f32 = weights.iter().filter(|weight| **weight < 0.0).sum();
    for weight in &mut weights {
        *weight /= if *weight > 0.0 { positive } else { -negative };
    }
    weights
}

/// out\[x\] = Σ weights\[k\] input\[x + k\] for all x of `out`.
#[inline]
pub(super) fn along(input: &[f32], weights: &[f32], out: &mut [f32]) {
    strided(input, 1, weights, out);
}

/// out\[x\] = Σ weights\[k\] input\[x + k stride\] for all x of `out`.
#[inline]
pub(super) fn strided(input: &[f32], stride: usize, weights: &[f32], out: &mut [f32]) {
    /// As many sums at once as registers hold.
    const LANES: usize = 16;
    let mut chunks = out.chunks_exact_mut(LANES);
    let mut x = 0;
    for chunk in &mut chunks {
        let mut sums = [0.0; LANES];
        for (k, weight) in weights.iter().enumerate() {
            let from = x + k * stride;
            for (sum, value) in sums.iter_mut().zip(&input[from..from + LANES]) {
                *sum += weight * value;
            }
        }
        chunk.copy_from_slice(&sums);
        x += LANES;
    }
    for (i, place) in chunks.into_remainder().iter_mut().enumerate() {
        *place = weights
            .iter()
            .enumerate()
            .map(|(k, weight)| weight * input[x + i + k * stride])
            .sum();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kernels_keep_what_is_constant_and_derivatives_do_not_see_it() {
        let filters = Filters::new(67.0);
        let sum = |weights: &[f32]| weights.iter().sum::<f32>();
        // Some twenty terms in f32.
        let close = |value: f32, expected: f32| (value - expected).abs() < 32.0 * f32::EPSILON;
        assert!(close(sum(&filters.achromatic), 1.0));
        assert!(close(sum(&filters.red_green), 1.0));
        assert!(close(sum(&filters.smooth), 1.0));
        assert!(close(sum(&filters.edge), 0.0));
        assert!(close(sum(&filters.point), 0.0));
        let [wide, narrow] = &filters.blue_yellow;
        assert!(close(
            sum(wide) * sum(wide) + sum(narrow) * sum(narrow),
            1.0
        ));
    }

    #[test]
    fn a_convolution_is_its_definition_at_any_length() {
        let input: Vec<f32> = (0..100).map(|i| (i * i % 17) as f32).collect();
        let weights = [1.0, -2.0, 4.0];
        for length in [0, 1, 15, 16, 17, 40] {
            let mut out = vec![0.0; length];
            strided(&input, 3, &weights, &mut out);
            for (x, value) in out.iter().enumerate() {
                assert_eq!(*value, input[x] - 2.0 * input[x + 3] + 4.0 * input[x + 6]);
            }
        }
    }
}
