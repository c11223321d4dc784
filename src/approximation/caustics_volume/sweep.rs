//! Stage `sweep` (Algorithm 1): photons through the slabs, and on to the projectors.

use rayon::prelude::*;

use super::buffers::{Pictures, Slab};
use super::cuboid::Face;
use super::demands::Volume;
use super::ledger::Fate;
use super::meeting::Optics;
use super::photon::Photon;
use super::projector::Projectors;
use super::settings::Settings;
use super::slab::{Passed, SlabTracer};
use super::variants::{BySteps, Step, Sweep};
use super::work::Work;
use crate::scene::Scene;

/// A volume ready for photons.
#[derive(Clone, Copy, Debug)]
pub struct Tracer<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The settings.
    pub settings: &'a Settings,
    /// The volume.
    pub volume: &'a Volume,
    /// Its slabs, from the entry on.
    pub slabs: &'a [Slab<'a>],
    /// Their pictures.
    pub pictures: &'a [Pictures],
    /// The projectors' pictures.
    pub projectors: &'a Projectors,
}

/// Where a photon goes on.
enum Next {
    /// Into a slab.
    Slab(usize, Photon),
    /// Outside the volume.
    Outside(Photon),
}

/// Photons of a chunk: chunks are added up in their order, so that sums are the same bits on any threads.
const CHUNK: usize = 256;

/// Runs `each` for all photons, in chunks at the same time.
pub fn in_chunks<T: Sync>(all: &[T], each: impl Fn(&T, &mut Passed) + Sync) -> Passed {
    let chunks: Vec<Passed> = all
        .par_chunks(CHUNK)
        .map(|chunk| {
            let mut passed = Passed::default();
            passed.out.reserve_exact(chunk.len());
            for one in chunk {
                each(one, &mut passed);
            }
            passed
        })
        .collect();
    let mut all = Passed::default();
    let count = |of: fn(&Passed) -> usize| chunks.iter().map(of).sum();
    all.out.reserve_exact(count(|one| one.out.len()));
    all.landed.reserve_exact(count(|one| one.landed.len()));
    for one in chunks {
        all.append(one);
    }
    all
}

impl Tracer<'_> {
    fn optics(&self) -> Optics<'_> {
        Optics {
            scene: self.scene,
            settings: self.settings,
        }
    }

    /// The slab in which a photon on a face, or just inside, begins.
    pub fn slab_of(&self, photon: &Photon) -> usize {
        let cuboid = &self.volume.cuboid;
        let depth = cuboid.to_local(photon.ray.origin).z;
        cuboid.slab_at(depth, self.slabs.len())
    }

    /// Takes a photon through a slab.
    pub fn cross(&self, slab: usize, photon: &Photon, into: &mut Passed) {
        let optics = self.optics();
        let tracer = SlabTracer {
            slab: &self.slabs[slab],
            pictures: &self.pictures[slab],
            settings: self.settings,
            optics: &optics,
        };
        tracer.cross(photon, into);
    }

    /// Where a photon goes that leaves a slab by a face of that slab.
    fn next(&self, slab: usize, face: Face, photon: Photon, into: &mut Passed) -> Option<Next> {
        let last = self.slabs.len() - 1;
        let any = self.settings.sweep == Sweep::Exact;
        match face {
            Face::Far if slab < last => Some(Next::Slab(slab + 1, photon)),
            Face::Entry if slab > 0 && any => Some(Next::Slab(slab - 1, photon)),
            Face::Entry if slab > 0 => {
                into.end(Step::Sweep, Fate::Backward, &photon);
                None
            }
            face if self.volume.culls[face as usize] && !any => {
                into.end(Step::Sweep, Fate::Culled, &photon);
                None
            }
            _ => Some(Next::Outside(photon)),
        }
    }

    /// A photon leaves the volume: it goes on to the projectors, left in `into.out`, if it is contributive.
    /// Nothing that mirrors or refracts is outside, so that none comes back.
    fn leave(photon: Photon, into: &mut Passed) {
        if photon.is_contributive() {
            into.out.push((Face::Far, photon));
        } else {
            into.end(Step::Sweep, Fate::Straight, &photon);
        }
    }

    /// Stage `projector`: a photon outside lands, or does not.
    pub fn project(&self, photon: &Photon, into: &mut Passed) {
        let landing = self.projectors.land(
            self.scene,
            &self.volume.cuboid,
            self.settings,
            photon,
            into.work(Step::Projector),
        );
        match landing {
            Ok(landing) => into.land(landing),
            Err(fate) => into.end(Step::Projector, fate, photon),
        }
    }

    /// Follows one photon to the end, by itself: a beam's corner. What goes on to the projectors is left in
    /// `into.out`.
    pub fn follow(&self, photon: &Photon, into: &mut Passed) {
        let mut waiting = vec![(self.slab_of(photon), *photon)];
        let mut outside = Vec::new();
        while let Some((slab, photon)) = waiting.pop() {
            self.cross(slab, &photon, into);
            let left = std::mem::take(&mut into.out);
            for (face, photon) in left {
                match self.next(slab, face, photon, into) {
                    Some(Next::Slab(next, photon)) => waiting.push((next, photon)),
                    Some(Next::Outside(photon)) => Self::leave(photon, into),
                    None => {}
                }
            }
            outside.append(&mut into.out);
        }
        into.out = outside;
    }
}

/// The photons at the entries of slabs, and what became of others before: what a later frame begins with.
#[derive(Clone, Debug, Default)]
pub struct Queue {
    /// By slab.
    pub waiting: Vec<Vec<Photon>>,
    /// Outside of the volume.
    pub outside: Vec<Photon>,
    /// In the volume.
    pub passed: Passed,
}

impl Queue {
    /// Photons before all slabs.
    pub fn new(photons: &[Photon], tracer: &Tracer) -> Self {
        let mut waiting = vec![Vec::new(); tracer.slabs.len()];
        for photon in photons {
            waiting[tracer.slab_of(photon)].push(*photon);
        }
        Self {
            waiting,
            ..Self::default()
        }
    }

    /// The pass of a slab: its work.
    pub fn pass(&mut self, slab: usize, tracer: &Tracer) -> BySteps<Work> {
        let photons = std::mem::take(&mut self.waiting[slab]);
        let mut passed = in_chunks(&photons, |photon, into| tracer.cross(slab, photon, into));
        let out = std::mem::take(&mut passed.out);
        let mut copied = 0;
        for (face, photon) in out {
            match tracer.next(slab, face, photon, &mut passed) {
                Some(Next::Slab(next, photon)) => self.waiting[next].push(photon),
                Some(Next::Outside(photon)) => self.outside.push(photon),
                None => continue,
            }
            copied += 1;
        }
        let work = passed.work(Step::Sweep);
        work.copied += copied;
        work.passes += 1;
        let work = std::mem::take(&mut passed.work);
        self.passed.append(passed);
        work
    }

    /// The pass of the projectors: what is outside lands, or ends. Returns its work.
    pub fn project(&mut self, tracer: &Tracer) -> BySteps<Work> {
        let photons = std::mem::take(&mut self.outside);
        let mut passed = in_chunks(&photons, |photon, into| {
            Tracer::leave(*photon, into);
            for (_, photon) in std::mem::take(&mut into.out) {
                tracer.project(&photon, into);
            }
        });
        passed.work(Step::Sweep).passes += 1;
        let work = std::mem::take(&mut passed.work);
        self.passed.append(passed);
        work
    }

    /// True if no slab has photons before it.
    pub fn is_empty(&self) -> bool {
        self.waiting.iter().all(Vec::is_empty)
    }
}
