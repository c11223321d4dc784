//! One randomisation of photons: they start all over light space and are followed.

use glam::DVec2;
use rayon::prelude::*;

use crate::geometry::TraversalCounters;
use crate::numeric::{FixedPoint, Stream};
use crate::radiometry::Rgb;
use crate::scene::{MaterialsAtWavelength, Scene};
use crate::spectrum::Wavelengths;
use crate::transport::chain::{Arrival, ChainSettings, ChainSink, ChainTracer, Emitted};
use crate::transport::domain::LightSpace;
use crate::transport::domain::chart::LightChart;
use crate::transport::domain::patch::ChartPatch;
use crate::transport::flux::Flux;
use crate::transport::ledger::Fate;
use crate::transport::signature::Signature;

/// Least number of photons of one task: enough to make its set-up cheap, few enough to keep all cores busy.
const TASK_PHOTONS: u64 = 4096;

/// Record of the photons of one task, in `N` channels.
pub trait Recipient<const N: usize>: Send {
    /// True if it is to hear of one photon after the other; else legs of some come between those of others.
    const IS_ORDERED: bool = false;
    /// The next photons start in a cell, if photons come one after the other.
    fn start_cell(&mut self, _cell: usize) {}
    /// A photon starts with `flux` \[W\].
    fn emitted(&mut self, flux: Flux<N>);
    /// Light arrives at a surface, and may end there or go on. Returns the fate of the light that ends.
    fn arrived(&mut self, arrival: &Arrival<N>, counters: &mut TraversalCounters) -> Fate;
    /// `flux` \[W\] ended after the events of `signature`.
    fn ended(&mut self, signature: Signature, fate: Fate, flux: Flux<N>);
    /// Adjoint shading normals added `flux` \[W\].
    fn gained(&mut self, flux: Flux<N>);
    /// The task's last photon is done.
    fn finish(&mut self);
}

/// One randomisation of a scene's photons.
#[derive(Clone, Copy)]
pub struct Job<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The light space in which photons start.
    pub light: &'a LightSpace,
    /// Settings of their chains.
    pub chains: ChainSettings,
    /// The randomisation's own stream.
    pub stream: Stream,
    /// Tells when to give up.
    pub stop: &'a (dyn Fn() -> bool + Sync),
    /// Receives the number of photons that each finished task started.
    pub finished: &'a (dyn Fn(u64) + Sync),
}

/// A finished task.
pub struct Task<R> {
    /// The record of its photons.
    pub recipient: R,
    /// The work that they took.
    pub counters: TraversalCounters,
}

/// Consecutive photons of a cell.
struct Span {
    cell: usize,
    first: u64,
    count: u64,
    /// The number of the first among the photons of all cells.
    number: u64,
}

impl Job<'_> {
    /// Traces `photons` photons.
    ///
    /// Every photon is keyed by (stream, cell, number in the cell), so its path depends on nothing else. The
    /// wavelength of an area light's or an environment's is keyed by its number among those of all cells.
    /// Tasks come in the order of their cells.
    ///
    /// After `stop` asked for an end, the tasks not yet started are missing.
    pub fn trace<const N: usize, R: Recipient<N>>(
        &self,
        photons: u64,
        recipient: impl Fn() -> R + Sync,
    ) -> Vec<Task<R>> {
        if self.light.is_empty() || photons == 0 {
            return Vec::new();
        }
        self.tasks(photons)
            .into_par_iter()
            .filter(|_| !(self.stop)())
            .map(|spans| {
                let mut tracer = ChainTracer::new(self.scene, self.chains);
                let mut recipient = recipient();
                let mut sink = Sink(&mut recipient);
                match MaterialsAtWavelength::new(self.scene) {
                    Some(mut spectrum) => {
                        for span in &spans {
                            sink.0.start_cell(span.cell);
                            self.disperse_span(
                                span,
                                photons,
                                &mut spectrum,
                                &mut tracer,
                                &mut sink,
                            );
                        }
                    }
                    None if R::IS_ORDERED => {
                        for span in &spans {
                            sink.0.start_cell(span.cell);
                            self.emit(span, photons)
                                .for_each(|it| tracer.trace(&it, &mut sink));
                        }
                    }
                    None => {
                        let mut all = spans.iter().flat_map(|span| self.emit(span, photons));
                        tracer.trace_all(&mut all, &mut sink);
                    }
                }
                recipient.finish();
                (self.finished)(spans.iter().map(|span| span.count).sum());
                Task {
                    recipient,
                    counters: tracer.counters,
                }
            })
            .collect()
    }

    /// The fixed-point scale that holds `headroom` times all flux of the light space in one texel.
    pub fn scale(&self, headroom: f64) -> FixedPoint {
        let mut total = self.light.flux_bound().max_channel() * headroom;
        if !self.scene.dispersion().is_empty() {
            total *= Wavelengths::get().largest_weight();
        }
        // Outside 1e±250 W there is no scale. With that of 1 W, deposits that are too large are refused as
        // not representable, and those that are too small round to zero.
        FixedPoint::for_total(total).unwrap_or(FixedPoint::OF_ONE)
    }

    /// Cuts the photons of all cells into tasks of about the same size.
    fn tasks(&self, photons: u64) -> Vec<Vec<Span>> {
        // The offset has twenty bits: with the counts below 2³², no rounding can add a photon.
        let offset =
            (self.stream.extra(0, u32::MAX) * f64::from(1 << 20)).floor() / f64::from(1 << 20);
        // There are never more than about 2¹⁶ tasks, since each leaves a ledger until the replicate ends.
        let task_photons = TASK_PHOTONS.max(photons >> 16);
        let mut tasks = Vec::new();
        let mut task = Vec::new();
        let (mut size, mut number) = (0, 0);
        for cell in 0..self.light.cells().len() {
            let allotted = self.light.allotment(cell, photons, offset);
            let mut first = 0;
            while first < allotted {
                let count = (allotted - first).min(task_photons - size);
                task.push(Span {
                    cell,
                    first,
                    count,
                    number,
                });
                first += count;
                number += count;
                size += count;
                if size == task_photons {
                    tasks.push(std::mem::take(&mut task));
                    size = 0;
                }
            }
        }
        if !task.is_empty() {
            tasks.push(task);
        }
        tasks
    }

    /// The photons of a span.
    fn emit<const N: usize>(
        &self,
        span: &Span,
        photons: u64,
    ) -> impl Iterator<Item = Emitted<N>> + use<'_, N> {
        let start = Start::new(self, span.cell, photons);
        (span.first..span.first + span.count).map(move |index| start.photon(index))
    }

    /// Traces the photons of a scene with dispersion: each has a wavelength of its own.
    ///
    /// Out of line: scenes without dispersion are not to pay for it.
    #[cold]
    #[inline(never)]
    fn disperse_span<const N: usize>(
        &self,
        span: &Span,
        photons: u64,
        spectrum: &mut MaterialsAtWavelength,
        tracer: &mut ChainTracer<N>,
        sink: &mut Sink<'_, impl Recipient<N>>,
    ) {
        let start = Start::new(self, span.cell, photons);
        let wavelengths = Wavelengths::get();
        let numbers = self.stream.split(SPECTRAL);
        for index in span.first..span.first + span.count {
            let u = if start.has_area {
                // All dimensions of a point are taken: even among all photons, and so among a cell's. Groups
                // have an order of their own, since the points' one would go together with theirs.
                numbers.padded4(span.number + index - span.first, 0)[0]
            } else {
                // Even among a cell's photons and their directions, taken together.
                start.stream.point4(index)[2]
            };
            let wavelength = wavelengths.at(u);
            let mut light = start.photon(index);
            light.flux = light.flux * Flux::of(Rgb(wavelength.weights));
            tracer.trace_among(spectrum.at(wavelength.nm), &light, sink);
        }
    }
}

/// The start of a cell's photons.
struct Start<'a, const N: usize> {
    stream: Stream,
    chart: &'a LightChart,
    patch: &'a ChartPatch,
    has_area: bool,
    /// Photons that one stands for, by its share of them.
    weight: f64,
    strength: Flux<N>,
}

/// The key of the stream of wavelengths; no cell has it.
const SPECTRAL: u64 = u64::MAX;

impl<'a, const N: usize> Start<'a, N> {
    fn new(job: &Job<'a>, cell: usize, photons: u64) -> Self {
        let chart = job.light.chart(cell);
        // Each photon of the cell stands for all light with probability `share`.
        let weight = 1.0 / (photons as f64 * job.light.share(cell));
        Self {
            stream: job.stream.split(cell as u64),
            chart,
            patch: job.light.cells()[cell].patch(),
            has_area: chart.has_area(),
            weight,
            strength: Flux::of(chart.strength() * weight),
        }
    }

    /// A photon at its start.
    #[inline]
    fn photon(&self, index: u64) -> Emitted<N> {
        let (at, start) = if self.has_area {
            let [x, y, u, v] = self.stream.point4(index);
            (DVec2::new(x, y), DVec2::new(u, v))
        } else {
            (DVec2::from_array(self.stream.point2(index)), DVec2::ZERO)
        };
        let emission = self.chart.emit(self.patch, at, start);
        let strength = match emission.color {
            Some(color) => Flux::of(self.chart.strength() * color * self.weight),
            None => self.strength,
        };
        Emitted {
            ray: emission.ray,
            flux: strength * emission.measure,
            choices: self.stream.extras(index),
        }
    }
}

/// A sink that hands photons' ends to their task.
struct Sink<'a, R>(&'a mut R);

impl<const N: usize, R: Recipient<N>> ChainSink<N> for Sink<'_, R> {
    #[inline]
    fn emitted(&mut self, flux: Flux<N>) {
        self.0.emitted(flux);
    }

    #[inline]
    fn arrived(&mut self, arrival: &Arrival<N>, counters: &mut TraversalCounters) -> Fate {
        self.0.arrived(arrival, counters)
    }

    #[inline]
    fn ended(&mut self, signature: Signature, fate: Fate, flux: Flux<N>) {
        self.0.ended(signature, fate, flux);
    }

    #[inline]
    fn gained(&mut self, flux: Flux<N>) {
        self.0.gained(flux);
    }
}
