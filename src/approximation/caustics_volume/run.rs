//! The stages one after the other.

use std::ops::Range;

use super::beams::Beams;
use super::buffers::{Pictures, Slab};
use super::darkness;
use super::demands::Volume;
use super::draw::draw;
use super::ellipse::ellipses;
use super::emission::{Lattice, lattices};
use super::frames::{Frames, Landed};
use super::ledger::{Fate, Flow};
use super::lod;
use super::photon::{Landing, PHOTON_BYTES, Photon};
use super::projector::Projectors;
use super::settings::Settings;
use super::slab::Passed;
use super::smooth::smoothed;
use super::splat::discs;
use super::sweep::{Queue, Tracer, in_chunks};
use super::update::Last;
use super::variants::{BySteps, Layers, STAGES, Smooth, Splat, Step, Update};
use super::work::Work;
use crate::approximation::clock::{Clocked, Done};
use crate::approximation::sources::flux_bound;
use crate::approximation::{ExactFilm, Frame, Receivers, SensorFilm};
use crate::geometry::Bounds;
use crate::radiometry::Rgb;
use crate::run::{Counters, Error, Progress, StageWork};
use crate::scene::{Scene, Sensor};
use crate::transport::chain_limits;

/// What outlives a frame.
#[derive(Debug)]
pub struct Kept {
    /// The volume: of frames that trail behind it stays as long as all that mirrors or refracts is in it.
    volume: Volume,
    /// The last frame, if frames are made anew in part.
    last: Option<Last>,
    /// What is underway between frames.
    frames: Frames,
}

impl Kept {
    /// The volume.
    pub fn volume(&self) -> &Volume {
        &self.volume
    }

    /// What is known before the first frame.
    ///
    /// # Errors
    ///
    /// As [`Volume::new`].
    pub fn new(scene: &Scene, settings: &Settings) -> Result<Self, Error> {
        Ok(Self {
            volume: Volume::new(scene, settings)?,
            last: None,
            frames: Frames::default(),
        })
    }
}

/// Work and time by pass: of each slab, and last of the projectors and the film.
type ByPasses = Vec<BySteps<Done<Work>>>;

/// Fills a sensor with light by way of the volume.
///
/// A wish to stop ends the frame before its next pass: the image has what landed so far, and nothing outlives
/// the frame.
///
/// # Errors
///
/// As [`Volume::new`] and [`SensorFilm::new`], and if sums of light are not representable.
pub fn run(
    settings: &Settings,
    kept: &mut Kept,
    scene: &Scene,
    sensor: &Sensor,
    progress: &Progress,
) -> Result<Frame, Error> {
    let film = SensorFilm::new(scene, sensor)?;
    let fresh = Volume::new(scene, settings)?;
    // Frames that trail behind need a box that lasts. All others have the bits of a frame by itself.
    let is_same = fresh.cuboid == kept.volume.cuboid;
    let held = fresh
        .within(scene, settings, &kept.volume.cuboid)
        .filter(|_| is_same || settings.trails());
    let is_held = held.is_some();
    let volume = held.unwrap_or(fresh);
    let last = kept.last.take().filter(|_| is_held);
    let slabs = lod::slabs(settings, &volume, &film) as usize;
    kept.frames.keep_sweep_of(slabs, is_held);
    let is_seen = !settings.frustum || lod::is_seen(&volume, &film);
    let mut pipeline = Pipeline {
        settings,
        scene,
        volume: &volume,
        film: &film,
        progress,
        passes: vec![Default::default(); slabs + 1],
        flow: Flow::default(),
        warnings: chain_limits::left_out(scene),
    };
    let [width, height] = film.size();
    let mut values = if is_seen {
        let (light, next) = pipeline.light(last, &mut kept.frames)?;
        kept.last = next;
        light
    } else {
        vec![Rgb::BLACK; width * height]
    };
    if progress.is_stopped() {
        (kept.last, kept.frames) = (None, Frames::default());
    }
    pipeline.flow.drawn = pipeline.flux_of(&values);
    if is_seen && settings.smooth == Smooth::Gaussian {
        values = pipeline.timed((slabs, Step::Smooth), |_, work| {
            smoothed(values, [width, height], settings.sigma, work)
        });
    }
    pipeline.flow.image = pipeline.flux_of(&values);
    let frame = pipeline.frame(values, is_seen);
    kept.volume = volume;
    Ok(frame)
}

struct Pipeline<'a> {
    settings: &'a Settings,
    scene: &'a Scene,
    volume: &'a Volume,
    film: &'a SensorFilm,
    progress: &'a Progress,
    passes: ByPasses,
    flow: Flow,
    warnings: Vec<String>,
}

impl Clocked for Pipeline<'_> {
    /// A pass, and its stage.
    type Step = (usize, Step);
    type Work = Work;

    fn done(&mut self, (pass, step): Self::Step) -> &mut Done<Work> {
        &mut self.passes[pass][step as usize]
    }
}

impl Pipeline<'_> {
    fn add_work(&mut self, pass: usize, work: &BySteps<Work>) {
        for (done, one) in self.passes[pass].iter_mut().zip(work) {
            done.work += *one;
        }
    }

    /// Flux \[W\] of an image; none of a camera's.
    fn flux_of(&self, values: &[Rgb]) -> Rgb {
        let is_meter = self.film.shape().is_some();
        // Most texels may be black: they add nothing.
        let texels = values.iter().enumerate();
        texels
            .filter(|(_, value)| is_meter && !value.is_black())
            .map(|(texel, value)| *value * self.film.measure(texel))
            .sum()
    }

    /// Stages `emission` to `splat`; and what a later frame may begin with.
    fn light(
        &mut self,
        last: Option<Last>,
        frames: &mut Frames,
    ) -> Result<(Vec<Rgb>, Option<Last>), Error> {
        let (settings, scene, volume) = (self.settings, self.scene, self.volume);
        let count = self.passes.len() - 1;
        let slabs: Vec<Slab> = (0..count)
            .map(|slab| Slab {
                scene,
                cuboid: &volume.cuboid,
                depths: volume.cuboid.slab(slab, count),
                side: settings.g_buffer as usize,
            })
            .collect();
        let last = last
            .unwrap_or_default()
            .against(scene, volume, settings, count);
        // The passes of this frame: not all, if a sweep is shared out over frames.
        let first = frames.sweep.as_ref().map_or(0, |(_, pass)| *pass);
        let passes = match settings.amortise {
            0 => 0..count + 1,
            _ if frames.shown.is_none() => 0..count + 1,
            some => first..(first + some as usize).min(count + 1),
        };
        let mut pictures = Vec::new();
        for (index, (slab, kept)) in slabs.iter().zip(last.pictures).enumerate() {
            pictures.push(match kept {
                Some(kept) => kept,
                // No photon asks for it.
                None if !passes.contains(&index) || self.progress.is_stopped() => Pictures::None,
                None => self.timed((index, Step::Buffers), |_, work| {
                    Pictures::new(slab, settings, work)
                }),
            });
        }
        let projectors = match last.projectors {
            Some(kept) => kept,
            None if !passes.contains(&count) || self.progress.is_stopped() => Projectors::default(),
            None => self.timed((count, Step::Projector), |_, work| {
                Projectors::new(scene, volume, settings, work)
            }),
        };
        let tracer = Tracer {
            scene,
            settings,
            volume,
            slabs: &slabs,
            pictures: &pictures,
            projectors: &projectors,
        };
        let all = lattices(scene, settings, volume);
        match settings.splat {
            Splat::Exact => Ok((self.beams(&tracer, &all)?, None)),
            Splat::Quads | Splat::Ellipses if settings.amortise > 0 => {
                let queue = frames.sweep.take().map(|(queue, _)| queue);
                let queue = match queue {
                    Some(queue) => queue,
                    None => self.emitted(&tracer, &all, [0, 1]),
                };
                if let Some(queue) = self.some_passes(&tracer, passes.clone(), queue, frames) {
                    frames.sweep = Some((queue, passes.end));
                }
                let (landed, tally) = frames.shown.clone().unwrap_or_default();
                self.flow.tally += tally;
                Ok((self.drawn(&all, &landed), None))
            }
            Splat::Quads | Splat::Ellipses => {
                let (first, queue) = match last.queue {
                    Some(start) => start,
                    None => (0, self.emitted(&tracer, &all, frames.share(settings))),
                };
                let (passed, queues) = self.all_passes(&tracer, first, queue, last.queues);
                let (landed, tally) = frames.with_others(settings, passed);
                self.flow.tally += tally;
                let next = (settings.update == Update::Changed)
                    .then(|| Last::new(scene, volume, pictures, projectors, queues));
                Ok((self.drawn(&all, &landed), next))
            }
        }
    }

    /// Stage `emission`: a share of the photons before all slabs, with the flux of all.
    fn emitted(&mut self, tracer: &Tracer, lattices: &[Lattice], share: [u64; 2]) -> Queue {
        self.timed((0, Step::Emission), |_, work| {
            let cells: Vec<(usize, u64)> = (0..lattices.len())
                .flat_map(|lattice| (0..lattices[lattice].cells()).map(move |cell| (lattice, cell)))
                .filter(|(_, cell)| Frames::is_in(*cell, share))
                .collect();
            let mut passed = in_chunks(&cells, |(lattice, cell), into: &mut Passed| {
                let work = into.work(Step::Emission);
                if let Some(mut photon) = lattices[*lattice].cell(*cell, work) {
                    photon.flux *= share[1] as f64;
                    into.tally.add(Fate::SetsOut, photon.flux);
                    into.out.push((super::cuboid::Face::Entry, photon));
                }
            });
            let photons: Vec<Photon> = passed.out.drain(..).map(|(_, photon)| photon).collect();
            *work += std::mem::take(&mut passed.work)[Step::Emission as usize];
            work.bytes += photons.len() as u64 * PHOTON_BYTES;
            let mut queue = Queue::new(&photons, tracer);
            queue.passed = passed;
            queue
        })
    }

    /// The stage that the time of a slab's pass counts for.
    fn slab_step(&self) -> Step {
        match self.settings.layers {
            Layers::Exact => Step::Layers,
            Layers::NearFar | Layers::Peel => Step::March,
        }
    }

    /// The pass of a slab, or, after the last one, of the projectors.
    fn pass(&mut self, tracer: &Tracer, pass: usize, queue: &mut Queue) {
        if self.progress.is_stopped() {
            return;
        }
        let (step, done);
        if pass < tracer.slabs.len() {
            step = self.slab_step();
            done = self.timed((pass, step), |_, _| queue.pass(pass, tracer));
        } else {
            step = Step::Projector;
            done = self.timed((pass, step), |_, _| queue.project(tracer));
        }
        self.add_work(pass, &done);
    }

    /// Stages `march` to `projector`, from a slab on, with the queues before the slabs as far as they are
    /// known.
    fn all_passes(
        &mut self,
        tracer: &Tracer,
        first: usize,
        mut queue: Queue,
        mut queues: Vec<Queue>,
    ) -> (Landed, Vec<Queue>) {
        let count = tracer.slabs.len();
        for pass in first..=count {
            if self.settings.update == Update::Changed {
                queues.push(queue.clone());
            }
            self.pass(tracer, pass, &mut queue);
        }
        // What went back goes through slabs again.
        while !queue.is_empty() && !self.progress.is_stopped() {
            for slab in 0..count {
                if !queue.waiting[slab].is_empty() {
                    self.pass(tracer, slab, &mut queue);
                }
            }
            self.pass(tracer, count, &mut queue);
        }
        ((queue.passed.landed, queue.passed.tally), queues)
    }

    /// Some passes of a sweep; what is left of it, if that was not the last.
    fn some_passes(
        &mut self,
        tracer: &Tracer,
        passes: Range<usize>,
        mut queue: Queue,
        frames: &mut Frames,
    ) -> Option<Queue> {
        let is_last = passes.end > tracer.slabs.len();
        for pass in passes {
            self.pass(tracer, pass, &mut queue);
        }
        if is_last {
            frames.shown = Some((queue.passed.landed, queue.passed.tally));
            return None;
        }
        Some(queue)
    }

    /// Stage `splat`: what the sensor has of photons that landed.
    fn drawn(&mut self, lattices: &[Lattice], landed: &[Landing]) -> Vec<Rgb> {
        let settings = self.settings;
        self.timed((self.passes.len() - 1, Step::Splat), |this, work| {
            // Half the diagonal of a texel: each splat has the middle of one.
            let least = 0.5 * std::f64::consts::SQRT_2 * this.film.texel_length(this.scene);
            let cuboid = &this.volume.cuboid;
            let discs = if settings.splat == Splat::Ellipses {
                ellipses(lattices, cuboid, settings, landed, least)
            } else {
                discs(cuboid, settings, landed, least)
            };
            work.splats += discs.len() as u64;
            draw(this.scene, this.film, &discs, work)
        })
    }

    /// Stage `splat`, exact.
    fn beams(&mut self, tracer: &Tracer, lattices: &[Lattice]) -> Result<Vec<Rgb>, Error> {
        let (scene, volume) = (self.scene, self.volume);
        let receivers = Receivers::new(scene);
        let bounds = Bounds::from_points(volume.cuboid.corners());
        let bound = |source| flux_bound(source, &bounds);
        let total: f64 = volume.sources.iter().map(bound).sum();
        let largest = total * self.film.largest_factor(scene);
        let film = ExactFilm::new(self.film.size(), largest)?;
        let screen = self.film.screen();
        let count = tracer.slabs.len();
        for lattice in lattices {
            let beams = Beams {
                progress: self.progress,
                tracer,
                lattice,
                screen: &screen,
                receivers: &receivers,
                film: &film,
            };
            let dealt = self.timed((count, Step::Splat), |_, _| beams.deal());
            self.add_work(count, &dealt.work);
            self.flow.tally += dealt.tally;
        }
        let sums = film.finish()?;
        let texels = sums.into_iter().enumerate();
        let average = |(texel, sum): (usize, Rgb)| match self.film.measure(texel) {
            measure if measure > 0.0 => sum / measure,
            _ => Rgb::BLACK,
        };
        Ok(texels.map(average).collect())
    }

    /// Values, work and flux of the frame.
    fn frame(mut self, values: Vec<Rgb>, is_seen: bool) -> Frame {
        let is_dark = values.iter().all(|value| value.is_black());
        let reason = if self.progress.is_stopped() {
            Some("stopped before all passes were made: light is missing".to_owned())
        } else {
            is_dark.then(|| darkness::reason(&self.flow, self.film, is_seen))
        };
        if let Some(reason) = reason {
            self.warnings.insert(0, reason);
        }
        let mut sum = Work::default();
        for done in self.passes.iter().flatten() {
            sum += done.work;
        }
        let photons: u64 = self.passes.iter().map(|pass| pass[0].work.photons).sum();
        Frame {
            values,
            work: work_list(&self.passes),
            counters: Counters::of([
                ("photons", photons),
                ("passes", sum.passes),
                ("texels", sum.texels),
                ("triangles", sum.triangles),
                ("steps", sum.steps),
                ("fetches", sum.fetches),
                ("copied", sum.copied),
                ("splats", sum.splats),
                ("fragments", sum.fragments),
                ("rays", sum.rays),
                ("bytes", sum.bytes),
            ]),
            flux: if self.film.shape().is_some() {
                self.flow.entries()
            } else {
                Vec::new()
            },
            warnings: self.warnings,
        }
    }
}

/// Work stage by stage, and pass by pass: those of slabs in their order, then the projectors'.
fn work_list(passes: &[BySteps<Done<Work>>]) -> Vec<StageWork> {
    let mut list = Vec::new();
    for (step, stage) in STAGES.iter().enumerate() {
        let has_any = |done: &Done<Work>| done.work != Work::default() || done.seconds > 0.0;
        let all = passes.iter().map(|pass| &pass[step]).enumerate();
        let done: Vec<(usize, &Done<Work>)> = all.filter(|(_, done)| has_any(done)).collect();
        if done.is_empty() {
            list.push(StageWork::new(stage.name));
        }
        for (index, one) in &done {
            let pass = match *index {
                _ if done.len() == 1 => String::new(),
                index if index + 1 == passes.len() => "projectors".to_owned(),
                index => format!("slab {}", index + 1),
            };
            list.push(StageWork {
                pass,
                work: one.work.counters(),
                seconds: one.seconds,
                ..StageWork::new(stage.name)
            });
        }
    }
    list
}
