//! From sums to an estimate, its standard error and its bias.
//!
//! A lookup of radius r measures irradiance blurred by a disc of that radius. Where irradiance is smooth, the
//! blur adds b(r) = r²/8 ΔE: the difference D of the lookups with √2 r and with r is b(r) itself. Where it
//! jumps, b grows as r, and D is (√2 − 1) b(r). So
//!
//! ```text
//! |bias| ≤ |D| / (√2 − 1)        for biases that grow as r^a, 1 ≤ a ≤ 2
//! ```
//!
//! Both are linear, so that means over passes of any radii obey the same. Where light is much finer than
//! the radius *and* than the pixel (a focus, at a pixel's border) no two radii can tell; there the bound is
//! too small until the radius has shrunk.

use super::setup::Setup;
use super::sums::RoundSums;
use crate::geometry::TraversalCounters;
use crate::numeric::distributions::critical_value;
use crate::numeric::math;
use crate::radiometry::Rgb;
use crate::reference::photons::finish::Weighted;
use crate::run::{Estimate, Interval, Layer, LayerName};
use crate::transport::ledger::Ledger;

/// The two-sided confidence of bounds, as far as they are random.
pub const CONFIDENCE: f64 = 0.999;

/// The bias by the difference of two radii, at most: 1 / (√2 − 1).
const BIAS_BY_DIFFERENCE: f64 = std::f64::consts::SQRT_2 + 1.0;

/// The report of a run of photon maps, beside its estimate.
#[derive(Clone, Debug, serde::Serialize)]
pub struct PhotonMapReport {
    /// Number of maps of each replicate.
    pub passes: u64,
    /// The radius of the first and of the last map's lookups, in pixels.
    pub radius: [f64; 2],
    /// By pixel, row by row: the bias of the total's radiance [W/m²/sr] if light is smooth, D.
    #[serde(skip)]
    pub bias: Vec<Rgb>,
    /// Its standard error.
    #[serde(skip)]
    pub bias_standard_error: Vec<Rgb>,
    /// Root mean square of D over lit pixels, its noise subtracted, relative to the mean radiance; `None` if
    /// nothing is lit or no error is known.
    pub relative_bias: Option<f64>,
}

/// One layer's rounds so far.
struct Pair {
    value: Weighted,
    difference: Weighted,
}

/// The rounds of a run, combined so far: weighted by their passes, which do not look at the results.
pub struct Rounds<'a> {
    setup: &'a Setup<'a>,
    layers: Vec<Pair>,
    total: Pair,
    counters: TraversalCounters,
    passes: u64,
    /// Photons started.
    paths: u64,
    /// The fewest of a round; all before any.
    replicates: u32,
}

impl<'a> Rounds<'a> {
    /// No round yet.
    pub fn new(setup: &'a Setup<'a>) -> Self {
        let pair = || Pair {
            value: Weighted::new(setup.target.texels()),
            difference: Weighted::new(setup.target.texels()),
        };
        Self {
            setup,
            layers: (0..setup.layers()).map(|_| pair()).collect(),
            total: pair(),
            counters: TraversalCounters::default(),
            passes: 0,
            paths: 0,
            replicates: setup.settings.photons.replicates,
        }
    }

    /// Passes of each replicate so far.
    pub fn passes(&self) -> u64 {
        self.passes
    }

    /// Adds a round.
    pub fn add(&mut self, sums: &RoundSums) {
        let weight = sums.passes as f64;
        let films = sums.films.values.iter().zip(&sums.films.differences);
        for (layer, (value, difference)) in self.layers.iter_mut().zip(films) {
            layer.value.add(value, weight);
            layer.difference.add(difference, weight);
        }
        self.total.value.add(&sums.total, weight);
        self.total.difference.add(&sums.total_difference, weight);
        self.counters += sums.counters;
        self.passes += sums.passes;
        let photons = sums.passes * self.setup.settings.map_photons;
        self.paths += photons * u64::from(sums.replicates());
        self.replicates = self.replicates.min(sums.replicates());
    }

    /// Relative standard error over lit pixels, without the bias.
    pub fn relative_error(&self) -> Option<f64> {
        self.total.value.relative_error()
    }

    /// The estimate, and its bias.
    pub fn estimate(self, incomplete: bool) -> (Estimate, PhotonMapReport) {
        let setup = self.setup;
        let weight = (self.passes as f64).max(1.0);
        let widths = critical_value(CONFIDENCE, f64::from(self.replicates) - 1.0);
        let camera = setup.camera();
        let least = camera.map_or(0.0, |camera| camera.filter().least_light());
        let layer = |name, pair: &Pair| {
            let mut value = pair.value.layer(name, weight, &setup.target);
            let difference = pair.difference.layer(name, weight, &setup.target);
            value.interval = Some(bounds(&value, &difference, widths, least));
            (value, difference)
        };
        let (mut total, bias) = layer(LayerName::Total, &self.total);
        let names = setup.layer_names();
        let mut layers = Vec::new();
        for (name, pair) in names.into_iter().zip(&self.layers) {
            let is_empty = pair.value.flux.iter().all(|flux| flux.is_black());
            // In most scenes all paths have layers, and nothing is left over.
            if !(is_empty && name == LayerName::Other) {
                layers.push(layer(name, pair).0);
            }
        }
        if self.passes == 0 && incomplete {
            for layer in layers.iter_mut().chain([&mut total]) {
                layer.make_unknown();
                layer.standard_error.fill(Rgb::grey(f64::NAN));
            }
        }
        let relative_bias = relative_bias(&total, &bias);
        let report = setup.report(self.passes, bias, relative_bias);
        let [width, height] = setup.target.size();
        let estimate = Estimate {
            quantity: setup.target.quantity(),
            width,
            height,
            total,
            layers,
            counts: vec![0; width * height],
            ledger: Ledger::default(),
            paths: self.paths,
            counters: self.counters,
            relative_error: self.relative_error(),
            incomplete,
        };
        (estimate, report)
    }
}

/// value ± √((t σ)² + (C t s)²) + C |D|, nothing below `least`, with s the standard error of D: σ and s are
/// made of the same photons, and are added as if they were not, since the annulus between the radii has
/// photons of its own.
fn bounds(value: &Layer, difference: &Layer, widths: f64, least: f64) -> Interval {
    let mut interval = Interval::default();
    for texel in 0..value.values.len() {
        let half_width = Rgb(std::array::from_fn(|c| {
            let random = widths * value.standard_error[texel].0[c];
            let of_bias = widths * difference.standard_error[texel].0[c];
            let bias = difference.values[texel].0[c].abs();
            math::hypot(random, BIAS_BY_DIFFERENCE * of_bias) + BIAS_BY_DIFFERENCE * bias
        }));
        let low = value.values[texel] - half_width;
        // `max` would turn an unknown bound (NaN) into 0.
        interval
            .low
            .push(low.map(|low| if low < least { least } else { low }));
        interval.high.push(value.values[texel] + half_width);
    }
    interval
}

/// √(mean (D² − s²)) / mean L over lit pixels, s the standard error of D; 0 where noise explains all of D.
fn relative_bias(total: &Layer, bias: &Layer) -> Option<f64> {
    let lit: Vec<usize> = (0..total.values.len())
        .filter(|&texel| total.values[texel].mean() > 0.0)
        .collect();
    let count = lit.len() as f64;
    let light: f64 = lit.iter().map(|&i| total.values[i].mean()).sum();
    let square = |i: &usize| {
        let (value, error) = (bias.values[*i].mean(), bias.standard_error[*i].mean());
        value * value - error * error
    };
    let mean_square = lit.iter().map(square).sum::<f64>() / count;
    let is_known = !lit.is_empty() && mean_square.is_finite();
    is_known.then(|| mean_square.max(0.0).sqrt() * count / light)
}

impl Setup<'_> {
    /// The layers' names, in their order.
    pub(in crate::reference) fn layer_names(&self) -> Vec<LayerName> {
        let of = |by_specular: bool| {
            let name = move |signature| {
                if by_specular {
                    LayerName::Seen(signature)
                } else {
                    LayerName::Path(signature)
                }
            };
            let signatures = self.map.signatures().iter().copied();
            signatures.map(name).chain([LayerName::Other])
        };
        [false, true]
            .into_iter()
            .filter(|by_specular| self.settings.seen.includes(*by_specular))
            .flat_map(of)
            .collect()
    }

    fn report(&self, passes: u64, bias: Layer, relative_bias: Option<f64>) -> PhotonMapReport {
        let settings = &self.settings;
        let radius = |pass: u64| {
            settings.radius * super::settings::radius_squared_factor(pass, settings.alpha).sqrt()
        };
        PhotonMapReport {
            passes,
            radius: [radius(0), radius(passes.saturating_sub(1))],
            bias: bias.values,
            bias_standard_error: bias.standard_error,
            relative_bias,
        }
    }
}
