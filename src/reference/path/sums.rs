//! The way from images of replicates to an image with an error bar.
//!
//! Pixel i of replicate r has the sums Aᵣ = Σ f L and Bᵣ = Σ f over its samples (f the filter's weights). The
//! image is their quotient over all replicates together, as in Mitsuba. Its error is that of a ratio of means
//! (Cochran, *Sampling Techniques*, 3rd edition 1977, equation 6.9):
//!
//! ```text
//! X = Ā / B̄        σ² = Σᵣ (Aᵣ − X Bᵣ)² / (R (R − 1) B̄²)
//! ```
//!
//! With the box filter all Bᵣ are the same, and this is a plain mean. With other filters X has a bias that
//! falls with the number of samples in all, faster than σ. Any renderer that divides by weights has this
//! bias.
//!
//! Rounds k, of nₖ samples a pixel each, are independent estimates and are combined as
//!
//! ```text
//! X = Σ nₖ Xₖ / Σ nₖ        σ² = Σ (nₖ σₖ / Σ nₖ)²
//! ```

use glam::DVec2;

use super::bands::Bands;
use super::tiles::ImageSums;
use crate::geometry::TraversalCounters;
use crate::radiometry::Rgb;
use crate::reference::shard::Shard;
use crate::run::estimate::relative_error;
use crate::run::{Layer, LayerName};
use crate::transport::path_class::PathClass;

/// Index of the sum of all classes, behind the classes.
const TOTAL: usize = PathClass::ALL.len();

/// Number of layers.
pub const LAYERS: usize = TOTAL + 1;

/// Moments over the replicates of one round, of an image or of some of its rows.
#[derive(Debug)]
pub struct RoundSums {
    /// Number of replicates.
    pub replicates: u32,
    /// By pixel, the mean of Bᵣ, and Σ (Bᵣ − B̄)².
    pub weights: Vec<[f64; 2]>,
    /// By pixel, moments of Aᵣ of each class and of their sum; empty if all replicates are black.
    pub layers: [Vec<Moments>; LAYERS],
    pub counters: TraversalCounters,
    pub cut_off: u64,
    pub not_finite: Option<(u64, DVec2)>,
}

/// Mean of Aᵣ, Σ (Aᵣ − Ā)² and Σ (Aᵣ − Ā)(Bᵣ − B̄), kept as in Welford (*Technometrics* 4(3), 1962).
#[derive(Clone, Copy, Debug, Default)]
pub struct Moments {
    pub mean: Rgb,
    pub squares: Rgb,
    pub products: Rgb,
}

impl RoundSums {
    /// The moments before any replicate, for an image of `pixels` pixels.
    pub fn new(pixels: usize) -> Self {
        Self {
            replicates: 0,
            weights: vec![[0.0; 2]; pixels],
            layers: std::array::from_fn(|_| Vec::new()),
            counters: TraversalCounters::default(),
            cut_off: 0,
            not_finite: None,
        }
    }

    /// The moments of an image of `width` columns and `height` rows, from those of the rows that each of its
    /// parts has.
    pub fn of_parts(width: usize, height: usize, parts: &[(Shard, Self)]) -> Self {
        let pixels = width * height;
        let mut image = Self::new(pixels);
        for (shard, part) in parts {
            image.replicates = part.replicates;
            image.counters += part.counters;
            image.cut_off = image.cut_off.saturating_add(part.cut_off);
            let bands = Bands::of(*shard, height);
            put_rows(&mut image.weights, &part.weights, bands, width);
            for (layer, moments) in image.layers.iter_mut().zip(&part.layers) {
                if !moments.is_empty() {
                    // A class that is black in other parts has moments of zero there.
                    if layer.is_empty() {
                        *layer = vec![Moments::default(); pixels];
                    }
                    put_rows(layer, moments, bands, width);
                }
            }
        }
        image
    }

    /// Adds a replicate.
    pub fn add(&mut self, image: &ImageSums) {
        self.replicates += 1;
        let share = 1.0 / f64::from(self.replicates);
        for ([mean, squares], weight) in self.weights.iter_mut().zip(&image.weights) {
            let deviation = weight - *mean;
            *mean += deviation * share;
            *squares += deviation * (weight - *mean);
        }
        let pixels = self.weights.len();
        for (index, layer) in self.layers.iter_mut().enumerate() {
            let value = |pixel: usize| match image.radiance.get(index) {
                Some(values) => values.get(pixel).copied().unwrap_or(Rgb::BLACK),
                None => image
                    .radiance
                    .iter()
                    .filter_map(|values| values.get(pixel).copied())
                    .sum(),
            };
            let is_dark = match image.radiance.get(index) {
                Some(values) => values.is_empty(),
                None => image.radiance.iter().all(Vec::is_empty),
            };
            if layer.is_empty() {
                if is_dark {
                    continue;
                }
                // All replicates before were black, so all moments are zero.
                layer.resize(pixels, Moments::default());
            }
            for (pixel, moments) in layer.iter_mut().enumerate() {
                let of_weight = image.weights[pixel] - self.weights[pixel][0];
                moments.add(value(pixel), of_weight, share);
            }
        }
        self.counters += image.counters;
        self.cut_off += image.cut_off;
        if self.not_finite.is_none() {
            self.not_finite = image.not_finite;
        }
    }

    /// X and σ² of one pixel.
    fn estimate(&self, moments: &Moments, pixel: usize) -> (Rgb, Rgb) {
        let [weight, of_weights] = self.weights[pixel];
        let value = moments.mean / weight;
        let replicates = f64::from(self.replicates);
        let variance = Rgb(std::array::from_fn(|c| {
            let slope = value.0[c];
            let residuals = moments.squares.0[c] - 2.0 * slope * moments.products.0[c]
                + slope * slope * of_weights;
            // If all replicates agree, rounding may leave a negative rest.
            residuals.max(0.0) / (replicates * (replicates - 1.0) * weight * weight)
        }));
        (value, variance)
    }

    /// √(mean σ²) / mean X over lit pixels.
    pub fn relative_error(&self) -> Option<f64> {
        let pixels = self.layers[TOTAL].iter().enumerate();
        relative_error(pixels.map(|(pixel, moments)| {
            let (value, variance) = self.estimate(moments, pixel);
            (value.mean(), variance.map(f64::sqrt).mean())
        }))
    }
}

/// Puts values of some rows of `width` pixels where they belong.
fn put_rows<T: Copy>(image: &mut [T], values: &[T], bands: Bands, width: usize) {
    for (row, values) in bands.rows().zip(values.chunks_exact(width)) {
        image[row * width..(row + 1) * width].copy_from_slice(values);
    }
}

impl Moments {
    /// Adds a replicate. `of_weight` is the distance of its weight from the mean of all weights, its own
    /// included.
    #[inline]
    fn add(&mut self, value: Rgb, of_weight: f64, share: f64) {
        let deviation = value - self.mean;
        self.mean += deviation * share;
        self.squares += deviation * (value - self.mean);
        self.products += deviation * of_weight;
    }
}

/// The rounds of a run, combined so far.
pub struct Rounds {
    pixels: usize,
    /// Σ nₖ.
    samples: u64,
    /// Σ nₖ Xₖ and Σ nₖ² σₖ² of each class and of their sum; empty if black.
    layers: [Vec<[Rgb; 2]>; LAYERS],
    pub counters: TraversalCounters,
    pub cut_off: u64,
}

impl Rounds {
    /// The state before any round.
    pub fn new(pixels: usize) -> Self {
        Self {
            pixels,
            samples: 0,
            layers: std::array::from_fn(|_| Vec::new()),
            counters: TraversalCounters::default(),
            cut_off: 0,
        }
    }

    /// Number of samples of a pixel, of all rounds and replicates.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// Adds a round of `samples` samples a pixel and replicate. A round without replicates adds nothing.
    pub fn add(&mut self, round: &RoundSums, samples: u64) {
        let samples = samples.saturating_mul(round.replicates.into());
        let weight = samples as f64;
        for (sums, layer) in self.layers.iter_mut().zip(&round.layers) {
            if sums.is_empty() && !layer.is_empty() {
                sums.resize(self.pixels, [Rgb::BLACK; 2]);
            }
            for (pixel, ([value, variance], moments)) in sums.iter_mut().zip(layer).enumerate() {
                let (x, of_x) = round.estimate(moments, pixel);
                *value += x * weight;
                *variance += of_x * (weight * weight);
            }
        }
        self.samples = self.samples.saturating_add(samples);
        self.counters += round.counters;
        self.cut_off = self.cut_off.saturating_add(round.cut_off);
    }

    /// √(mean σ²) / mean X over lit pixels.
    pub fn relative_error(&self) -> Option<f64> {
        relative_error(
            self.layers[TOTAL]
                .iter()
                .map(|[value, variance]| (value.mean(), variance.map(f64::sqrt).mean())),
        )
    }

    /// The image of all classes; unknown before any round.
    pub fn total(&self) -> Layer {
        let mut layer = self.layer(LayerName::Total, &self.layers[TOTAL]);
        if self.samples == 0 {
            layer.make_unknown();
        }
        layer
    }

    /// The classes that are not black.
    pub fn classes(&self) -> Vec<Layer> {
        PathClass::ALL
            .into_iter()
            .zip(&self.layers)
            .filter(|(_, sums)| !sums.is_empty())
            .map(|(class, sums)| self.layer(LayerName::Class(class), sums))
            .collect()
    }

    fn layer(&self, name: LayerName, sums: &[[Rgb; 2]]) -> Layer {
        let mut layer = Layer::dark(name, self.pixels);
        let share = 1.0 / self.samples as f64;
        for (pixel, [value, variance]) in sums.iter().enumerate() {
            layer.values[pixel] = *value * share;
            layer.standard_error[pixel] = variance.map(f64::sqrt) * share;
        }
        layer
    }
}
