//! Exact sums over the replicates of one round.

use super::layers::LayerMap;
use super::replicate::{Job, Recipient};
use super::weights::Weights;
use crate::film::splat::Footprint;
use crate::film::{Accumulator, AccumulatorError, PixelFilter};
use crate::geometry::TraversalCounters;
use crate::numeric::FixedPoint;
use crate::radiometry::Rgb;
use crate::reference::Target;
use crate::run::Error;
use crate::scene::Scene;
use crate::transport::chain::Arrival;
use crate::transport::flux::Flux;
use crate::transport::ledger::{Fate, FluxByFate, Ledger};
use crate::transport::screen::Screen;
use crate::transport::signature::Signature;

/// Sums of a round of replicates, or of a shard of it.
///
/// All of them are integers, so any order and any division of the work gives the same bits.
#[derive(Debug)]
pub struct RoundSums {
    /// Flux \[W\] by texel, one accumulator a layer of the [`LayerMap`].
    pub layers: Vec<Accumulator>,
    /// Flux \[W\] by texel, all layers together. Its error bar needs the sums of each replicate.
    pub total: Accumulator,
    /// Flux \[W\] by fate.
    pub ledger: LedgerSums,
    /// The largest contributions.
    pub weights: Weights,
    /// Work done.
    pub counters: TraversalCounters,
    /// Photons of each replicate.
    pub photons: u64,
}

impl RoundSums {
    /// Empty sums for a target and its layers. One channel stands for three if nothing in the scene is
    /// coloured.
    pub fn new(job: &Job, target: &Target, map: &LayerMap, photons: u64) -> Self {
        let channels = if target.is_achromatic(job.scene) {
            1
        } else {
            3
        };
        let scale = job.scale(target.headroom());
        let accumulator = || Accumulator::new(target.texels(), channels, scale);
        Self {
            layers: (0..map.len()).map(|_| accumulator()).collect(),
            total: accumulator().with_counts(),
            ledger: LedgerSums::new(scale, map.len() + 1),
            weights: Weights::new(map.len()),
            counters: TraversalCounters::default(),
            photons,
        }
    }

    /// Number of replicates in the sums.
    pub fn replicates(&self) -> u32 {
        self.total.replicates()
    }

    /// Traces one more replicate. False, with unchanged sums, if it was stopped.
    ///
    /// # Errors
    ///
    /// If a contribution is not representable or a sum overflows.
    pub fn add_replicate(
        &mut self,
        job: &Job,
        target: &Target,
        map: &LayerMap,
    ) -> Result<bool, Error> {
        if self.total.channels() == 1 {
            self.add_replicate_of::<1>(job, target, map)
        } else {
            self.add_replicate_of::<3>(job, target, map)
        }
    }

    fn add_replicate_of<const N: usize>(
        &mut self,
        job: &Job,
        target: &Target,
        map: &LayerMap,
    ) -> Result<bool, Error> {
        let tasks = job.trace(self.photons, || Tally::<N> {
            scene: job.scene,
            screen: target.screen(),
            filter: target.filter(),
            footprint: Footprint::default(),
            layers: &self.layers,
            total: &self.total,
            map,
            scale: self.total.scale(),
            kept: Vec::with_capacity(KEPT_DEPOSITS),
            ledger: TaskLedger::new(map.len() + 1),
            weights: Weights::new(map.len()),
            refused: 0,
            example: Signature::DIRECT,
        });
        if (job.stop)() {
            for layer in &mut self.layers {
                layer.discard();
            }
            return Ok(false);
        }
        let refused: u64 = tasks.iter().map(|task| task.recipient.refused).sum();
        if let Some(bad) = tasks.iter().find(|task| task.recipient.refused > 0) {
            return Err(Error::NotRepresentable(format!(
                "{refused} photon contributions are NaN, infinite or out of range; the first ended after {}",
                bad.recipient.example
            )));
        }
        for task in tasks {
            self.counters += task.counters;
            self.ledger.add(&task.recipient.ledger);
            self.weights.merge(&task.recipient.weights);
        }
        for layer in &mut self.layers {
            self.total.deposit_all(layer)?;
            layer.flush()?;
        }
        self.total.flush()?;
        Ok(true)
    }

    /// Adds the replicates of another part of the same round.
    ///
    /// # Errors
    ///
    /// If the two are not of the same round, or a sum overflows.
    pub fn merge(&mut self, other: &Self) -> Result<(), AccumulatorError> {
        for (layer, others) in self.layers.iter_mut().zip(&other.layers) {
            layer.merge(others)?;
        }
        self.total.merge(&other.total)?;
        self.ledger.merge(&other.ledger);
        self.weights.merge(&other.weights);
        self.counters += other.counters;
        Ok(())
    }
}

/// Quanta on their way to a texel.
struct Deposit<const N: usize> {
    layer: u32,
    texel: u32,
    quanta: [i64; N],
}

/// Deposits that a task keeps back.
///
/// An addition that all threads see makes the processor finish everything it has begun. One at a time, such
/// additions would cost the next photon's head start.
const KEPT_DEPOSITS: usize = 1024;

/// One task's share of a replicate.
struct Tally<'a, const N: usize> {
    scene: &'a Scene,
    screen: Screen<'a>,
    /// Spreads light over a camera's pixels, if they are no plain averages.
    filter: Option<&'a PixelFilter>,
    /// The pixels of the last light that was spread.
    footprint: Footprint,
    layers: &'a [Accumulator],
    total: &'a Accumulator,
    map: &'a LayerMap,
    scale: FixedPoint,
    kept: Vec<Deposit<N>>,
    ledger: TaskLedger<N>,
    weights: Weights,
    refused: u64,
    example: Signature,
}

impl<const N: usize> Tally<'_, N> {
    #[cold]
    fn refuse(&mut self, signature: Signature) {
        self.refused += 1;
        self.example = signature;
    }

    #[inline]
    fn quantise(&mut self, signature: Signature, flux: Flux<N>) -> [i64; N] {
        flux.0.map(|channel| {
            self.scale.quantise(channel).unwrap_or_else(|| {
                self.refuse(signature);
                0
            })
        })
    }

    /// The row of a signature: 0 for light without events, then the layers.
    #[inline]
    fn row(&self, signature: Signature) -> usize {
        if signature.is_empty() {
            0
        } else {
            self.map.layer(signature) + 1
        }
    }

    /// Keeps light that fell into a texel.
    #[inline]
    fn keep(&mut self, signature: Signature, texel: usize, counted: Flux<N>) {
        let quanta = self.quantise(signature, counted);
        let layer = self.map.layer(signature);
        self.weights.count(layer, quanta);
        self.put(layer, texel, quanta);
    }

    #[inline]
    fn put(&mut self, layer: usize, texel: usize, quanta: [i64; N]) {
        if self.kept.len() == KEPT_DEPOSITS {
            self.write();
        }
        self.kept.push(Deposit {
            layer: layer as u32,
            texel: texel as u32,
            quanta,
        });
    }

    /// Keeps light on a surface that a camera sees.
    fn see(&mut self, arrival: &Arrival<N>, counters: &mut TraversalCounters) {
        let Some(filter) = self.filter else {
            if let Some((pixel, factor)) = self.screen.texel(self.scene, arrival, counters) {
                self.keep(arrival.signature, pixel, arrival.flux * Flux::of(factor));
            }
            return;
        };
        let is_sampled = |at| filter.is_sampled(at);
        let Some((at, factor)) = self.screen.seen(self.scene, arrival, is_sampled, counters) else {
            return;
        };
        let mut footprint = std::mem::take(&mut self.footprint);
        filter.spread(at, &mut footprint);
        if footprint.is_empty() {
            // It falls between the pixels of a narrow filter.
            self.footprint = footprint;
            return;
        }
        let (width, layer) = (self.screen.size()[0], self.map.layer(arrival.signature));
        let counted = arrival.flux * Flux::of(factor);
        // Light counts once, by the pixel that gains most: its pixels are not independent.
        let mut largest = [0; N];
        for (column, row, weight) in footprint.pixels() {
            let quanta = self.quantise(arrival.signature, counted * weight);
            for (largest, quanta) in largest.iter_mut().zip(quanta) {
                *largest = quanta.max(*largest);
            }
            self.put(layer, row * width + column, quanta);
        }
        self.weights.count(layer, largest);
        self.footprint = footprint;
    }

    /// Adds the deposits kept back to the films.
    fn write(&mut self) {
        for deposit in &self.kept {
            let texel = deposit.texel as usize;
            let inside = self.layers[deposit.layer as usize].deposit(texel, deposit.quanta);
            self.refused += u64::from(!inside);
            self.total.count_deposit(texel);
        }
        self.kept.clear();
    }
}

impl<const N: usize> Recipient<N> for Tally<'_, N> {
    #[inline]
    fn emitted(&mut self, flux: Flux<N>) {
        let quanta = self.quantise(Signature::DIRECT, flux);
        self.weights.start(quanta);
        add(&mut self.ledger.emitted, quanta);
    }

    #[inline]
    fn arrived(&mut self, arrival: &Arrival<N>, counters: &mut TraversalCounters) -> Fate {
        match self.screen {
            Screen::Receiver(_) => {
                let Some((texel, _)) = self.screen.texel(self.scene, arrival, counters) else {
                    return Fate::Absorbed;
                };
                if arrival.signature.is_empty() {
                    return Fate::Direct;
                }
                if self.map.counts(arrival.signature) {
                    self.keep(arrival.signature, texel, arrival.flux);
                }
                Fate::Received
            }
            Screen::Camera { .. } => {
                // A surface takes the light, and a camera sees only the light that is reflected. Direct light
                // does not count here: photons are for light that meets specular geometry.
                if !arrival.signature.is_empty() && self.map.counts(arrival.signature) {
                    self.see(arrival, counters);
                }
                Fate::Absorbed
            }
        }
    }

    #[inline]
    fn ended(&mut self, signature: Signature, fate: Fate, flux: Flux<N>) {
        let quanta = self.quantise(signature, flux);
        let row = self.row(signature);
        add(&mut self.ledger.rows[row][fate.index()], quanta);
    }

    #[inline]
    fn gained(&mut self, flux: Flux<N>) {
        let quanta = self.quantise(Signature::DIRECT, flux);
        add(&mut self.ledger.shading_gain, quanta);
    }

    fn finish(&mut self) {
        self.write();
        // Tasks are kept until the replicate's end, up to 2¹⁶ of them, so they give back the memory of these
        // deposits.
        self.kept = Vec::new();
    }
}

/// A task's part of the ledger, in as many channels as the scene needs.
struct TaskLedger<const N: usize> {
    emitted: [i128; N],
    shading_gain: [i128; N],
    /// Rows as in [`LedgerSums`].
    rows: Vec<[[i128; N]; 5]>,
}

impl<const N: usize> TaskLedger<N> {
    fn new(rows: usize) -> Self {
        Self {
            emitted: [0; N],
            shading_gain: [0; N],
            rows: vec![[[0; N]; 5]; rows],
        }
    }
}

/// A [`Ledger`] in quanta, summed over replicates. The sums are integers, so order cannot matter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LedgerSums {
    scale: FixedPoint,
    emitted: [i128; 3],
    shading_gain: [i128; 3],
    /// The row of light without events, then one a layer.
    rows: Vec<[[i128; 3]; 5]>,
}

#[inline]
fn add<const N: usize>(sum: &mut [i128; N], quanta: [i64; N]) {
    for (sum, quanta) in sum.iter_mut().zip(quanta) {
        *sum += i128::from(quanta);
    }
}

impl LedgerSums {
    fn new(scale: FixedPoint, rows: usize) -> Self {
        Self {
            scale,
            emitted: [0; 3],
            shading_gain: [0; 3],
            rows: vec![[[0; 3]; 5]; rows],
        }
    }

    /// Adds a task's part; one channel stands for three.
    fn add<const N: usize>(&mut self, task: &TaskLedger<N>) {
        let all = |sum: &mut [i128; 3], part: &[i128; N]| {
            for (c, sum) in sum.iter_mut().enumerate() {
                *sum += part[c.min(N - 1)];
            }
        };
        all(&mut self.emitted, &task.emitted);
        all(&mut self.shading_gain, &task.shading_gain);
        for (sums, parts) in self.rows.iter_mut().zip(&task.rows) {
            for (sum, part) in sums.iter_mut().zip(parts) {
                all(sum, part);
            }
        }
    }

    /// All sums, as [`LedgerSums::from_numbers`] takes them.
    pub fn numbers(&self) -> impl Iterator<Item = i128> {
        self.emitted
            .into_iter()
            .chain(self.shading_gain)
            .chain(self.rows.iter().flatten().flatten().copied())
    }

    /// Sums for `rows` rows from their numbers; `None` if there are too few.
    pub fn from_numbers(
        scale: FixedPoint,
        rows: usize,
        mut numbers: impl Iterator<Item = i128>,
    ) -> Option<Self> {
        let mut sums = Self::new(scale, rows);
        let all = sums
            .emitted
            .iter_mut()
            .chain(&mut sums.shading_gain)
            .chain(sums.rows.iter_mut().flatten().flatten());
        for sum in all {
            *sum = numbers.next()?;
        }
        Some(sums)
    }

    fn merge(&mut self, other: &Self) {
        let theirs: Vec<i128> = other.numbers().collect();
        let ours = self
            .emitted
            .iter_mut()
            .chain(&mut self.shading_gain)
            .chain(self.rows.iter_mut().flatten().flatten());
        for (ours, theirs) in ours.zip(theirs) {
            *ours += theirs;
        }
    }

    /// The ledger of the mean replicate \[W\].
    pub fn ledger(&self, map: &LayerMap, replicates: u32) -> Ledger {
        let mean = |sum: [i128; 3]| {
            Rgb(sum.map(|quanta| self.scale.value_i128(quanta) / f64::from(replicates.max(1))))
        };
        let row = |index: usize| FluxByFate::from_fates(self.rows[index].map(mean));
        let names = std::iter::once(Signature::DIRECT).chain(map.signatures().iter().copied());
        Ledger {
            emitted: mean(self.emitted),
            shading_gain: mean(self.shading_gain),
            rows: names
                .enumerate()
                .map(|(index, name)| (name, row(index)))
                .collect(),
            other: row(self.rows.len() - 1),
            elsewhere: None,
        }
    }
}
