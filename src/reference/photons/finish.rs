//! The way from exact sums to an estimate.
//!
//! Rounds k are independent estimates Eₖ of nₖ photons in all. They are combined as
//!
//! ```text
//! E = Σ nₖ Eₖ / Σ nₖ        σ² = Σ (nₖ σₖ / Σ nₖ)²
//! ```
//!
//! with weights that do not depend on the estimates, so that there is no bias.

use rayon::prelude::*;

use super::bounds::{Bounds, largest_possible};
use super::layers::LayerMap;
use super::sums::RoundSums;
use super::weights::Largest;
use crate::film::Accumulator;
use crate::geometry::TraversalCounters;
use crate::radiometry::Rgb;
use crate::reference::target::{LitTexels, Target};
use crate::run::estimate::{brightness, relative_error};
use crate::run::{Estimate, Interval, Layer, LayerName};
use crate::transport::direct::Direct;
use crate::transport::ledger::{FluxByFate, Ledger};
use crate::transport::signature::Signature;

/// Photons times flux, and its variance, by texel.
#[derive(Clone)]
pub(in crate::reference) struct Weighted {
    pub flux: Vec<Rgb>,
    pub variance: Vec<Rgb>,
}

impl Weighted {
    pub fn new(texels: usize) -> Self {
        Self {
            flux: vec![Rgb::BLACK; texels],
            variance: vec![Rgb::BLACK; texels],
        }
    }

    /// Adds a round of `weight` photons.
    pub fn add(&mut self, sums: &Accumulator, weight: f64) {
        self.flux
            .par_iter_mut()
            .zip(&mut self.variance)
            .enumerate()
            .for_each(|(texel, (flux, variance))| {
                let (mean, error) = texel_estimate(sums, texel);
                *flux += mean * weight;
                *variance += error.map(|error| (error * weight) * (error * weight));
            });
    }

    /// Relative standard error over lit texels.
    pub fn relative_error(&self) -> Option<f64> {
        relative_error(
            self.flux
                .iter()
                .zip(&self.variance)
                .map(|(flux, variance)| brightness(*flux, variance.map(f64::sqrt))),
        )
    }

    /// Averages by the target's measure, of rounds of `weight` photons in all.
    pub fn layer(&self, name: LayerName, weight: f64, target: &Target) -> Layer {
        // A texel without surface receives nothing; its irradiance is defined as zero.
        let per_measure = |texel: usize| match target.measure(texel) {
            0.0 => 0.0,
            measure => 1.0 / (weight * measure),
        };
        Layer {
            name,
            values: (0..self.flux.len())
                .map(|texel| self.flux[texel] * per_measure(texel))
                .collect(),
            standard_error: (0..self.flux.len())
                .map(|texel| self.variance[texel].map(f64::sqrt) * per_measure(texel))
                .collect(),
            interval: None,
            sampling: None,
        }
    }

    /// Bounds of a layer that hold for few photons, by the target's measure: `counts` are contributions of
    /// all layers, and `largest` is the largest that this one may get.
    fn sampling(
        &self,
        bounds: &Bounds,
        counts: &[u64],
        largest: Rgb,
        per_measure: &[f64],
    ) -> Interval {
        let ends = bounds.of_texels(&self.flux, &self.variance, counts, largest);
        let [low, high] = ends.map(|mut end| {
            for (bound, factor) in end.iter_mut().zip(per_measure) {
                *bound *= *factor;
            }
            end
        });
        Interval { low, high }
    }
}

/// Mean flux of a texel \[W\] and its standard error, NaN below two replicates.
fn texel_estimate(sums: &Accumulator, texel: usize) -> (Rgb, Rgb) {
    let channel = |channel: usize| {
        sums.estimate(texel, channel).map_or((0.0, f64::NAN), |it| {
            (it.mean, it.standard_error.unwrap_or(f64::NAN))
        })
    };
    if sums.channels() == 1 {
        let (mean, error) = channel(0);
        return (Rgb::grey(mean), Rgb::grey(error));
    }
    let all = [channel(0), channel(1), channel(2)];
    (Rgb(all.map(|it| it.0)), Rgb(all.map(|it| it.1)))
}

/// Relative standard error of the sums of a round so far.
pub(super) fn relative_error_of(sums: &RoundSums) -> Option<f64> {
    relative_error((0..sums.total.texels()).map(|texel| {
        let (mean, error) = texel_estimate(&sums.total, texel);
        brightness(mean, error)
    }))
}

/// The rounds of a run, combined so far.
pub struct Rounds {
    layers: Vec<Weighted>,
    total: Weighted,
    counts: Vec<u64>,
    ledger: Ledger,
    counters: TraversalCounters,
    paths: u64,
    /// The largest contributions of each layer, in photons times flux.
    largest: Vec<Largest>,
    /// The fewest of a round; 0 before any.
    replicates: u32,
    /// True if contributions may be below zero.
    is_signed: bool,
}

impl Rounds {
    /// The state before any round. `is_signed` if contributions may be below zero, as those of a single
    /// wavelength are.
    pub fn new(texels: usize, map: &LayerMap, is_signed: bool) -> Self {
        Self {
            layers: vec![Weighted::new(texels); map.len()],
            total: Weighted::new(texels),
            counts: vec![0; texels],
            ledger: Ledger::default(),
            counters: TraversalCounters::default(),
            paths: 0,
            largest: vec![Largest::NONE; map.len()],
            replicates: 0,
            is_signed,
        }
    }

    /// Photons started in all rounds.
    pub fn paths(&self) -> u64 {
        self.paths
    }

    /// Adds a round. A round without replicates adds nothing.
    pub fn add(&mut self, sums: &RoundSums, map: &LayerMap) {
        let replicates = sums.replicates();
        let photons = sums.photons * u64::from(replicates);
        if photons == 0 {
            return;
        }
        let weight = photons as f64;
        for (layer, accumulator) in self.layers.iter_mut().zip(&sums.layers) {
            layer.add(accumulator, weight);
        }
        self.total.add(&sums.total, weight);
        for (texel, count) in self.counts.iter_mut().enumerate() {
            *count += sums.total.count(texel).unwrap_or(0);
        }
        add_ledger(
            &mut self.ledger,
            &sums.ledger.ledger(map, replicates),
            weight,
        );
        // A contribution of a replicate is divided among them, and the round counts by its photons.
        let largest = sums
            .weights
            .largest(sums.total.scale(), sums.photons as f64);
        for (largest, of_round) in self.largest.iter_mut().zip(&largest) {
            largest.with(of_round);
        }
        self.replicates = match self.replicates {
            0 => replicates,
            fewest => fewest.min(replicates),
        };
        self.counters += sums.counters;
        self.paths += photons;
    }

    /// The largest flux \[W\] of a photon at its start.
    pub fn largest_start(&self) -> Rgb {
        self.largest_of_all().emitted * (1.0 / (self.paths as f64).max(1.0))
    }

    /// The largest contributions of all layers together.
    fn largest_of_all(&self) -> Largest {
        let mut all = Largest::NONE;
        for layer in &self.largest {
            all.with(layer);
        }
        all
    }

    /// Relative standard error over lit texels, of all rounds.
    pub fn relative_error(&self) -> Option<f64> {
        self.total.relative_error()
    }

    /// The same relative to other light, which is `lit`; `None` if nothing arrived, or without an error bar.
    pub fn error_relative_to(&self, lit: LitTexels, target: &Target) -> Option<f64> {
        if self.total.flux.iter().all(|flux| flux.is_black()) {
            return None;
        }
        let texels = self.total.flux.iter().zip(&self.total.variance);
        let squares = texels.enumerate().map(|(texel, (flux, variance))| {
            let measure = target.measure(texel) * self.paths as f64;
            if measure == 0.0 {
                return 0.0;
            }
            let (_, error) = brightness(*flux, variance.map(f64::sqrt));
            (error / measure) * (error / measure)
        });
        let error = lit.relative_error(squares.sum());
        error.is_finite().then_some(error)
    }

    /// The estimate, with the direct light if it was measured.
    ///
    /// The sums of each layer go as the layer comes: both together would take half as much again.
    pub fn estimate(
        mut self,
        target: &Target,
        map: &LayerMap,
        direct: Option<&Direct>,
        incomplete: bool,
    ) -> Estimate {
        // Without any photon nothing is known of the caustics, unless there can be none.
        let unmeasured = self.paths == 0 && incomplete;
        let relative_error = self.relative_error();
        let weight = (self.paths as f64).max(1.0);
        // What a texel without surface gets is zero, as its irradiance is.
        let per_measure: Vec<f64> = (0..self.counts.len())
            .map(|texel| match target.measure(texel) {
                0.0 => 0.0,
                measure => 1.0 / (weight * measure),
            })
            .collect();
        let bounds = Bounds::new(self.replicates);
        let all = self.largest_of_all();
        let camera = match target {
            Target::Camera { camera, .. } => Some(camera),
            Target::Receiver(_) => None,
        };
        let is_camera = camera.is_some();
        // Bounds of few contributions take these for positive.
        let is_signed =
            self.is_signed || camera.is_some_and(|camera| camera.filter().has_negative_lobes());
        let sampling = |weighted: &Weighted, largest: &Largest| {
            if is_signed {
                return None;
            }
            let largest = if self.paths == 0 && !incomplete {
                // There can be none.
                Rgb::BLACK
            } else {
                largest_possible(largest, &all, is_camera)
            };
            Some(weighted.sampling(&bounds, &self.counts, largest, &per_measure))
        };
        let mut layers = Vec::new();
        let names = map
            .signatures()
            .iter()
            .map(|signature| LayerName::Path(*signature))
            .chain([LayerName::Other]);
        let sums = std::mem::take(&mut self.layers);
        for ((name, weighted), largest) in names.zip(sums).zip(&self.largest) {
            // In most scenes all paths have layers, and nothing is left over.
            let is_empty = weighted.flux.iter().all(|flux| flux.is_black());
            if !(name == LayerName::Other && is_empty) {
                layers.push(Layer {
                    sampling: sampling(&weighted, largest),
                    ..weighted.layer(name, weight, target)
                });
            }
        }
        let sums = std::mem::replace(&mut self.total, Weighted::new(0));
        let mut total = Layer {
            sampling: sampling(&sums, &all),
            ..sums.layer(LayerName::Total, weight, target)
        };
        drop(sums);
        if unmeasured {
            for layer in layers.iter_mut().chain([&mut total]) {
                layer.make_unknown();
            }
        }
        let mut counters = self.counters;
        if let Some(direct) = direct {
            let ends = direct.texels.iter().map(|texel| {
                let of = |c: usize| bounds.of_normal(texel.irradiance.0[c], texel.error.0[c]);
                let ends: [[f64; 2]; 3] = std::array::from_fn(of);
                (Rgb(ends.map(|it| it[0])), Rgb(ends.map(|it| it[1])))
            });
            let (low, high) = ends.unzip();
            let direct_layer = Layer {
                name: LayerName::Path(Signature::DIRECT),
                values: direct.texels.iter().map(|texel| texel.irradiance).collect(),
                standard_error: direct.texels.iter().map(|texel| texel.error).collect(),
                interval: None,
                sampling: Some(Interval { low, high }),
            };
            total.add(&direct_layer);
            layers.insert(0, direct_layer);
            counters += direct.counters;
        }
        let is_unknown = total.is_unknown();
        let mut ledger = Ledger::default();
        add_ledger(&mut ledger, &self.ledger, 1.0 / weight);
        let [width, height] = target.size();
        Estimate {
            quantity: target.quantity(),
            width,
            height,
            total,
            layers,
            counts: self.counts,
            ledger,
            paths: self.paths,
            counters,
            relative_error,
            incomplete: incomplete || is_unknown,
        }
    }
}

fn add_ledger(sum: &mut Ledger, addend: &Ledger, weight: f64) {
    let add_row = |sum: &mut FluxByFate, addend: &FluxByFate| {
        sum.received += addend.received * weight;
        sum.direct += addend.direct * weight;
        sum.escaped += addend.escaped * weight;
        sum.absorbed += addend.absorbed * weight;
        sum.cut_off += addend.cut_off * weight;
    };
    sum.emitted += addend.emitted * weight;
    sum.shading_gain += addend.shading_gain * weight;
    for (signature, row) in &addend.rows {
        add_row(sum.rows.entry(*signature).or_default(), row);
    }
    add_row(&mut sum.other, &addend.other);
}
