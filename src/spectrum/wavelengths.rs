//! Wavelengths as samples of RGB light.
//!
//! Channel c of light is spread over wavelengths by a weight w(λ) \[1/nm\] of its own with ∫ w dλ = 1. White
//! light, RGB (1, 1, 1), stands for illuminant D65, and the weights are what it gives each channel at λ:
//!
//! ```text
//! w_c(λ) = D65(λ) Σ_k M_ck x̄_k(λ) / ∫ D65 Σ_k M_ck x̄_k dλ,   380 nm ≤ λ ≤ 780 nm
//! ```
//!
//! with the CIE's x̄, ȳ, z̄ (2° observer, 1931); M makes linear sRGB of XYZ: see
//! [`observer`](super::observer). The curves are straight lines between nodes 5 nm apart, products of the
//! tables' values. So all integrals here are exact, and light that nothing disperses keeps its RGB.
//!
//! **Signs.** Spectral light is more colourful than sRGB's primaries can mix: at most wavelengths some weight
//! is below zero. That is no error: it is what takes the other wavelengths' share of a channel back where all
//! come together. Cut off at zero, white would not stay white.
//!
//! **Density.** A sample has a wavelength of the density
//!
//! ```text
//! p(λ) = Σ_c |w_c(λ)| / Z,   Z = ∫ Σ_c |w_c| dλ
//! ```
//!
//! with Σ |w| at the nodes and straight lines between. It counts w/p in each channel. Their magnitudes sum
//! to at most Z, however rare the wavelength.
//!
//! **Errors.** The tables have 5 nm, the curves between them are off by up to 0.9 % of their peak (z̄; an
//! eighth of the second difference). Light beyond 380 and 780 nm, left out, has up to 0.03 % of a
//! channel. Each channel is divided by its own integral, which brings white back; before that the three
//! differ by 0.03 %. Tests in this file hold these figures.

use std::sync::LazyLock;

use super::observer::{CURVES, FIRST_NM, STEP_NM, xyz_to_srgb};

/// The first and the last wavelength that light is traced at \[nm\].
pub const VISIBLE_NM: [f64; 2] = [380.0, 780.0];

/// Number of nodes from the first to the last visible wavelength.
const NODES: usize = ((VISIBLE_NM[1] - VISIBLE_NM[0]) / STEP_NM) as usize + 1;

/// A wavelength drawn for a photon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wavelength {
    /// The wavelength in vacuum or air \[nm\]: the two differ by 0.03 %, which is ignored.
    pub nm: f64,
    /// What the photon counts in red, green and blue; the mean over wavelengths is one in each.
    pub weights: [f64; 3],
}

/// The density of wavelengths, and the weights of channels.
#[derive(Clone, Debug)]
pub struct Wavelengths {
    /// The weights of channels at each node \[1/nm\].
    weights: [[f64; 3]; NODES],
    /// The sum of their magnitudes at each node \[1/nm\].
    sums: [f64; NODES],
    /// The integral of that up to each node.
    cumulated: [f64; NODES],
}

impl Wavelengths {
    /// The one that there is.
    pub fn get() -> &'static Self {
        static WAVELENGTHS: LazyLock<Wavelengths> = LazyLock::new(Wavelengths::new);
        &WAVELENGTHS
    }

    fn new() -> Self {
        let integrals = channels_of_white(VISIBLE_NM);
        let weights = std::array::from_fn(|node| {
            let channels = response(row_of(VISIBLE_NM[0]) + node);
            std::array::from_fn(|c| channels[c] / integrals[c])
        });
        let sums = weights.map(|channels: [f64; 3]| channels.map(f64::abs).iter().sum());
        let mut cumulated = [0.0; NODES];
        for node in 1..NODES {
            cumulated[node] = cumulated[node - 1] + STEP_NM * 0.5 * (sums[node - 1] + sums[node]);
        }
        Self {
            weights,
            sums,
            cumulated,
        }
    }

    /// Z, the largest magnitude that a weight of [`Wavelengths::at`] can have.
    pub fn largest_weight(&self) -> f64 {
        self.cumulated[NODES - 1]
    }

    /// The wavelength below which a share `u` of all samples is; `u` in [0, 1].
    pub fn at(&self, u: f64) -> Wavelength {
        let goal = u * self.largest_weight();
        let above = self.cumulated.partition_point(|sum| *sum <= goal);
        let node = above.clamp(1, NODES - 1) - 1;
        let (first, last) = (self.sums[node], self.sums[node + 1]);
        let area = STEP_NM * 0.5 * (first + last);
        let share = ((goal - self.cumulated[node]) / area).clamp(0.0, 1.0);
        // The root t of first t + (last - first) t²/2 = share (first + last)/2, without cancellation.
        let root = (first * first + share * (last * last - first * first)).sqrt();
        let t = (share * (first + last) / (first + root)).min(1.0);
        let density = (first + (last - first) * t) / self.largest_weight();
        let [low, high] = [self.weights[node], self.weights[node + 1]];
        Wavelength {
            nm: VISIBLE_NM[0] + STEP_NM * (node as f64 + t),
            weights: std::array::from_fn(|c| (low[c] + (high[c] - low[c]) * t) / density),
        }
    }

    /// The weights of channels at a wavelength \[1/nm\]; zero where nothing is visible.
    pub fn weights(&self, wavelength_nm: f64) -> [f64; 3] {
        let [first, last] = VISIBLE_NM;
        if !(first..=last).contains(&wavelength_nm) {
            return [0.0; 3];
        }
        let place = (wavelength_nm - first) / STEP_NM;
        let node = (place as usize).min(NODES - 2);
        let t = place - node as f64;
        let [low, high] = [self.weights[node], self.weights[node + 1]];
        std::array::from_fn(|c| low[c] + (high[c] - low[c]) * t)
    }
}

/// The row of a wavelength in the CIE's table.
const fn row_of(wavelength_nm: f64) -> usize {
    ((wavelength_nm - FIRST_NM) / STEP_NM) as usize
}

/// What D65 gives red, green and blue at the wavelength of a row, in no particular unit.
fn response(row: usize) -> [f64; 3] {
    let [x, y, z, d65] = CURVES[row];
    xyz_to_srgb([x, y, z]).0.map(|channel| channel * d65)
}

/// The integral of the response between two rows' wavelengths.
fn channels_of_white([first, last]: [f64; 2]) -> [f64; 3] {
    let mut integrals = [0.0; 3];
    for row in row_of(first)..row_of(last) {
        let ends = [response(row), response(row + 1)];
        for (c, integral) in integrals.iter_mut().enumerate() {
            *integral += STEP_NM * 0.5 * (ends[0][c] + ends[1][c]);
        }
    }
    integrals
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::observer::LAST_NM;

    /// ∫ f dλ over the visible wavelengths by Simpson's rule in each step: exact for products of two straight
    /// lines.
    fn integral(f: impl Fn(f64) -> f64) -> f64 {
        (0..NODES - 1)
            .map(|node| {
                let low = VISIBLE_NM[0] + STEP_NM * node as f64;
                let [a, b, c] = [0.0, 0.5, 1.0].map(|t| f(low + STEP_NM * t));
                STEP_NM / 6.0 * (a + 4.0 * b + c)
            })
            .sum()
    }

    #[test]
    fn white_keeps_its_three_channels() {
        let all = Wavelengths::get();
        for c in 0..3 {
            let sum = integral(|nm| all.weights(nm)[c]);
            // 81 additions of numbers below 0.03, each off by half a unit of 1 at most.
            assert!(
                (sum - 1.0).abs() < 81.0 * f64::EPSILON,
                "channel {c}: {sum}"
            );
        }
    }

    /// Weights over even samples of the density average to one: the two are of one another.
    #[test]
    fn samples_of_the_density_average_to_white() {
        let all = Wavelengths::get();
        // The rule of midpoints errs by h²/24 times the jump of the slope, summed over the 80 steps' ends:
        // W_c changes by up to Z within a step, whose width in u is some hundredths.
        let count = 1 << 16;
        let mut sums = [0.0; 3];
        for index in 0..count {
            let at = all.at((f64::from(index) + 0.5) / f64::from(count));
            for (sum, weight) in sums.iter_mut().zip(at.weights) {
                *sum += weight / f64::from(count);
            }
        }
        assert!(sums.iter().all(|sum| (sum - 1.0).abs() < 1e-7), "{sums:?}");
    }

    #[test]
    fn the_share_below_a_wavelength_is_what_it_was_drawn_by() {
        let all = Wavelengths::get();
        let z = all.largest_weight();
        for index in 0..=1000 {
            let u = f64::from(index) / 1000.0;
            let drawn = all.at(u);
            assert!((VISIBLE_NM[0]..=VISIBLE_NM[1]).contains(&drawn.nm));
            // ∫ Σ|w| up to the wavelength, by Simpson within whole steps and the rest.
            let f = |nm: f64| -> f64 {
                let place = (nm - VISIBLE_NM[0]) / STEP_NM;
                let node = (place as usize).min(NODES - 2);
                all.sums[node] + (all.sums[node + 1] - all.sums[node]) * (place - node as f64)
            };
            let place = (drawn.nm - VISIBLE_NM[0]) / STEP_NM;
            let node = (place as usize).min(NODES - 1);
            let low = VISIBLE_NM[0] + STEP_NM * node as f64;
            let rest = (drawn.nm - low) * 0.5 * (f(low) + f(drawn.nm));
            let below = (all.cumulated[node] + rest) / z;
            assert!((below - u).abs() < 1e-12, "{u}: {below}");
            let sum: f64 = drawn.weights.iter().map(|weight| weight.abs()).sum();
            assert!(sum <= z * (1.0 + 1e-12), "{sum} is above {z}");
        }
        let ends = [0.0, 1.0].map(|u| all.at(u).nm);
        assert!(
            (0..2).all(|k| (ends[k] - VISIBLE_NM[k]).abs() < 1e-9),
            "{ends:?}"
        );
    }

    #[test]
    fn lines_of_the_spectrum_have_the_colours_that_one_sees() {
        let brightest = |nm: f64| {
            let weights = Wavelengths::get().weights(nm);
            (0..3).max_by(|a, b| weights[*a].total_cmp(&weights[*b]))
        };
        // Lines F, e and C of hydrogen and mercury, and sodium's.
        assert_eq!(brightest(656.3), Some(0));
        assert_eq!(brightest(589.3), Some(0));
        assert_eq!(brightest(546.1), Some(1));
        assert_eq!(brightest(486.1), Some(2));
        // Cyan is beyond red's primary, and green beyond red and blue.
        assert!(Wavelengths::get().weights(500.0)[0] < 0.0);
        assert!(Wavelengths::get().weights(530.0)[2] < 0.0);
        assert_eq!(Wavelengths::get().weights(300.0), [0.0; 3]);
    }

    /// The figures of the module's text.
    #[test]
    fn errors_are_as_small_as_the_text_says() {
        let all = channels_of_white([FIRST_NM, LAST_NM]);
        let visible = channels_of_white(VISIBLE_NM);
        for c in 0..3 {
            let left_out = (all[c] - visible[c]) / all[c];
            assert!(left_out.abs() < 3e-4, "channel {c}: {left_out}");
        }
        let ends = visible.iter().fold([f64::MAX, 0.0f64], |[low, high], it| {
            [low.min(*it), high.max(*it)]
        });
        assert!(ends[1] / ends[0] < 1.0003, "{visible:?}");
        for k in 0..3 {
            let peak = CURVES.iter().map(|row| row[k]).fold(0.0, f64::max);
            let bent = CURVES
                .windows(3)
                .map(|rows| (rows[0][k] - 2.0 * rows[1][k] + rows[2][k]).abs() / 8.0 / peak);
            let worst = bent.fold(0.0, f64::max);
            assert!(worst < 9e-3, "curve {k}: {worst}");
        }
    }
}
