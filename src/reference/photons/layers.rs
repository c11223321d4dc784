//! The path signatures that get a layer of their own.

use std::collections::BTreeMap;

use super::replicate::{Job, Recipient};
use crate::film::PixelFilter;
use crate::geometry::TraversalCounters;
use crate::numeric::FixedPoint;
use crate::radiometry::Rgb;
use crate::reference::Target;
use crate::scene::Scene;
use crate::transport::chain::Arrival;
use crate::transport::flux::Flux;
use crate::transport::ledger::Fate;
use crate::transport::screen::Screen;
use crate::transport::signature::Signature;

/// Path signatures and the layers in which they are counted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LayerMap {
    signatures: Vec<Signature>,
}

impl LayerMap {
    /// A layer for each of these signatures; all others share one more.
    pub fn new(mut signatures: Vec<Signature>) -> Self {
        signatures.sort_unstable();
        signatures.dedup();
        Self { signatures }
    }

    /// A layer for each of the `max_layers` signatures with the most flux, in any unit. Ties go to the
    /// smaller signature.
    pub fn of_brightest(
        received: impl IntoIterator<Item = (Signature, i128)>,
        max_layers: usize,
    ) -> Self {
        let mut ranked: Vec<(Signature, i128)> = received.into_iter().collect();
        ranked.sort_by_key(|(signature, flux)| (std::cmp::Reverse(*flux), *signature));
        ranked.truncate(max_layers);
        Self::new(ranked.into_iter().map(|(signature, _)| signature).collect())
    }

    /// The signatures with a layer of their own, sorted.
    pub fn signatures(&self) -> &[Signature] {
        &self.signatures
    }

    /// Number of layers, including the shared one (the last).
    pub fn len(&self) -> usize {
        self.signatures.len() + 1
    }

    /// Always false: the shared layer is always there.
    pub fn is_empty(&self) -> bool {
        false
    }

    /// The layer of a signature.
    #[inline]
    pub fn layer(&self, signature: Signature) -> usize {
        // There are a handful of signatures: looking at each is faster than hashing.
        self.signatures
            .iter()
            .position(|kept| *kept == signature)
            .unwrap_or(self.signatures.len())
    }
}

/// Photons of the pilot run that finds the bright signatures. Its photons are used for nothing else.
pub const PILOT_PHOTONS: u64 = 1 << 16;

/// The layers for the `max_layers` signatures that bring the most flux to the target.
///
/// Flux is compared as exact integers and ties go to the smaller signature, so the choice does not depend on
/// the number of threads.
pub fn pilot(job: &Job, target: &Target, max_layers: usize) -> LayerMap {
    let scale = job.scale(target.headroom());
    let found = job.trace(PILOT_PHOTONS, || Pilot {
        scene: job.scene,
        screen: target.screen(),
        filter: target.filter(),
        scale,
        received: BTreeMap::new(),
    });
    let mut received: BTreeMap<Signature, i128> = BTreeMap::new();
    for task in found {
        for (signature, flux) in task.recipient.received {
            *received.entry(signature).or_default() += flux;
        }
    }
    LayerMap::of_brightest(received, max_layers)
}

/// A counter of flux by signature.
struct Pilot<'a> {
    scene: &'a Scene,
    screen: Screen<'a>,
    filter: Option<&'a PixelFilter>,
    scale: FixedPoint,
    received: BTreeMap<Signature, i128>,
}

impl Pilot<'_> {
    /// The factor from flux to what the sensor counts; `None` if it counts nothing.
    fn factor(&self, arrival: &Arrival<3>, counters: &mut TraversalCounters) -> Option<Rgb> {
        let Some(filter) = self.filter else {
            return Some(self.screen.texel(self.scene, arrival, counters)?.1);
        };
        let is_sampled = |at| filter.is_sampled(at);
        Some(
            self.screen
                .seen(self.scene, arrival, is_sampled, counters)?
                .1,
        )
    }
}

impl Recipient<3> for Pilot<'_> {
    fn arrived(&mut self, arrival: &Arrival<3>, counters: &mut TraversalCounters) -> Fate {
        if let Some(factor) = self.factor(arrival, counters)
            && !arrival.signature.is_empty()
        {
            // A wavelength counts below zero in some channel.
            let counted = (Rgb(arrival.flux.rgb().0.map(f64::abs)) * factor).mean();
            // The run itself reports flux that does not fit.
            let quanta = self.scale.quantise(counted).unwrap_or(0);
            *self.received.entry(arrival.signature).or_default() += i128::from(quanta);
        }
        Fate::Absorbed
    }

    fn ended(&mut self, _signature: Signature, _fate: Fate, _flux: Flux<3>) {}

    fn gained(&mut self, _flux: Flux<3>) {}

    fn emitted(&mut self, _flux: Flux<3>) {}

    fn finish(&mut self) {}
}
