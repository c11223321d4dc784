//! A few photons that tell what light there is, before the run.

use std::collections::{BTreeMap, BTreeSet};

use super::layers::LayerMap;
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

/// Photons of the pilot run that finds the bright signatures. Its photons are used for nothing else.
pub const PILOT_PHOTONS: u64 = 1 << 16;

/// What [`PILOT_PHOTONS`] photons bring to a target, by signature.
#[derive(Clone, Debug, Default)]
pub struct PilotLight {
    /// The light of each signature.
    pub received: BTreeMap<Signature, Received>,
    /// Rays that they took.
    pub rays: u64,
}

/// The light of one signature.
#[derive(Clone, Copy, Debug, Default)]
pub struct Received {
    /// Flux, in quanta of the scale.
    pub quanta: i128,
    /// Flux \[W\].
    pub flux: f64,
    /// Sum of the squared contributions \[W²\]: about the variance of the flux, all texels together.
    pub squares: f64,
}

impl PilotLight {
    /// Traces the pilot's photons.
    pub fn of(job: &Job, target: &Target) -> Self {
        let scale = job.scale(target.headroom());
        let found = job.trace(PILOT_PHOTONS, || Pilot {
            counter: Counter::new(job, target),
            scale,
            received: BTreeMap::new(),
        });
        let mut light = Self::default();
        for task in found {
            light.rays += task.counters.rays;
            for (signature, one) in task.recipient.received {
                let sum = light.received.entry(signature).or_default();
                sum.quanta += one.quanta;
                sum.squares += one.squares;
            }
        }
        for one in light.received.values_mut() {
            one.flux = scale.value_i128(one.quanta);
        }
        light
    }

    /// The layers for the `most` signatures that bring the most flux, some left out.
    ///
    /// Flux is compared as exact integers and ties go to the smaller signature, so the choice does not depend
    /// on the number of threads.
    pub fn layers(&self, most: usize, left_out: BTreeSet<Signature>) -> LayerMap {
        let counted = self.received.iter();
        let counted = counted.filter(|(signature, _)| !left_out.contains(signature));
        let flux = counted.map(|(signature, one)| (*signature, one.quanta));
        LayerMap::of_brightest(flux, most).without(left_out)
    }
}

/// What a target counts of the light that arrives.
struct Counter<'a> {
    scene: &'a Scene,
    screen: Screen<'a>,
    filter: Option<&'a PixelFilter>,
}

impl<'a> Counter<'a> {
    fn new(job: &Job<'a>, target: &'a Target) -> Self {
        Self {
            scene: job.scene,
            screen: target.screen(),
            filter: target.filter(),
        }
    }

    /// Mean of channels; `None` if it counts nothing.
    fn counted(&self, arrival: &Arrival<3>, counters: &mut TraversalCounters) -> Option<f64> {
        let factor = match self.filter {
            None => self.screen.texel(self.scene, arrival, counters)?.1,
            Some(filter) => {
                let is_sampled = |at| filter.is_sampled(at);
                let seen = self.screen.seen(self.scene, arrival, is_sampled, counters);
                seen?.1
            }
        };
        // A wavelength counts below zero in some channel.
        Some((Rgb(arrival.flux.rgb().0.map(f64::abs)) * factor).mean())
    }
}

/// A recipient that counts light by signature.
struct Pilot<'a> {
    counter: Counter<'a>,
    scale: FixedPoint,
    received: BTreeMap<Signature, Received>,
}

impl Recipient<3> for Pilot<'_> {
    fn arrived(&mut self, arrival: &Arrival<3>, counters: &mut TraversalCounters) -> Fate {
        if !arrival.signature.is_empty()
            && let Some(counted) = self.counter.counted(arrival, counters)
        {
            // The run itself reports flux that does not fit.
            let quanta = self.scale.quantise(counted).unwrap_or(0);
            let received = self.received.entry(arrival.signature).or_default();
            received.quanta += i128::from(quanta);
            received.squares += counted * counted;
        }
        Fate::Absorbed
    }

    fn ended(&mut self, _signature: Signature, _fate: Fate, _flux: Flux<3>) {}

    fn gained(&mut self, _flux: Flux<3>) {}

    fn emitted(&mut self, _flux: Flux<3>) {}

    fn finish(&mut self) {}
}

/// Photons that tell from which cells light comes: some dozens a cell.
const AIM_PHOTONS: u64 = 1 << 16;

/// Sum of the squared contributions of each cell's photons \[W²\], of light that has a layer.
pub fn squares_by_cell(job: &Job, target: &Target, map: &LayerMap) -> Vec<f64> {
    let found = job.trace(AIM_PHOTONS, || Aim {
        counter: Counter::new(job, target),
        map,
        by_cell: Vec::new(),
    });
    let mut squares = vec![0.0; job.light.cells().len()];
    for task in found {
        for (cell, sum) in task.recipient.by_cell {
            squares[cell] += sum;
        }
    }
    squares
}

/// A recipient that counts light by cell.
struct Aim<'a> {
    counter: Counter<'a>,
    map: &'a LayerMap,
    /// The cells so far, the present one last.
    by_cell: Vec<(usize, f64)>,
}

impl Recipient<3> for Aim<'_> {
    const IS_ORDERED: bool = true;

    fn start_cell(&mut self, cell: usize) {
        self.by_cell.push((cell, 0.0));
    }

    fn arrived(&mut self, arrival: &Arrival<3>, counters: &mut TraversalCounters) -> Fate {
        if !arrival.signature.is_empty()
            && self.map.counts(arrival.signature)
            && let Some(counted) = self.counter.counted(arrival, counters)
            && let Some((_, sum)) = self.by_cell.last_mut()
        {
            *sum += counted * counted;
        }
        Fate::Absorbed
    }

    fn ended(&mut self, _signature: Signature, _fate: Fate, _flux: Flux<3>) {}

    fn gained(&mut self, _flux: Flux<3>) {}

    fn emitted(&mut self, _flux: Flux<3>) {}

    fn finish(&mut self) {}
}
