//! One slab of Algorithm 1: a photon from where it enters to where it leaves, or ends.

use glam::DVec3;

use super::buffers::{Met, Pictures, Slab};
use super::cuboid::Face;
use super::ledger::{Fate, Tally};
use super::march::{Against, Marcher};
use super::meeting::{Meeting, Optics};
use super::photon::{Landing, Photon};
use super::settings::Settings;
use super::variants::{BySteps, Layers, Step};
use super::work::Work;
use crate::geometry::{Hit, SurfacePoint, TraversalCounters};

/// What became of some photons in one pass.
#[derive(Clone, Debug, Default)]
pub struct Passed {
    /// Those that go on, with the face by which they leave: of a slab the entry or the far face is its own.
    pub out: Vec<(Face, Photon)>,
    /// Those that land.
    pub landed: Vec<Landing>,
    /// Their flux.
    pub tally: Tally,
    /// Work by stage.
    pub work: BySteps<Work>,
}

impl Passed {
    /// The work of a stage.
    pub fn work(&mut self, step: Step) -> &mut Work {
        &mut self.work[step as usize]
    }

    /// What became of more photons, after these.
    pub fn append(&mut self, other: Self) {
        // The first of several is not copied.
        if self.landed.capacity() == 0 {
            self.landed = other.landed;
        } else {
            self.landed.extend(other.landed);
        }
        self.out.extend(other.out);
        self.tally += other.tally;
        for (sum, one) in self.work.iter_mut().zip(other.work) {
            *sum += one;
        }
    }

    /// A photon ends.
    pub fn end(&mut self, step: Step, fate: Fate, photon: &Photon) {
        self.tally.add(fate, photon.flux);
        self.work(step).dropped += 1;
    }

    /// A photon is on a surface that neither mirrors nor refracts.
    pub fn land(&mut self, landing: Landing) {
        let flux = landing.photon.flux;
        if landing.photon.is_contributive() {
            self.tally.add(Fate::Landed, flux);
            self.landed.push(landing);
        } else {
            self.end(Step::Sweep, Fate::Straight, &landing.photon);
        }
    }
}

/// A slab as photons cross it.
#[derive(Clone, Copy, Debug)]
pub struct SlabTracer<'a> {
    /// The slab.
    pub slab: &'a Slab<'a>,
    /// Its pictures.
    pub pictures: &'a Pictures,
    /// The settings.
    pub settings: &'a Settings,
    /// The surfaces' optics.
    pub optics: &'a Optics<'a>,
}

impl SlabTracer<'_> {
    /// Takes a photon through the slab.
    pub fn cross(&self, photon: &Photon, into: &mut Passed) {
        match self.settings.layers {
            Layers::NearFar => self.near_then_far(photon, into),
            Layers::Peel => self.peeled(photon, into),
            Layers::Exact => self.traced(photon, into),
        }
    }

    /// A photon leaves the slab along its way.
    fn leave(&self, photon: &Photon, into: &mut Passed) {
        let (distance, face) = self.slab.cuboid.leaves(&photon.ray, self.slab.depths);
        into.out.push((face, photon.moved(distance)));
    }

    /// The first surface against some pictures.
    fn first(&self, photon: &Photon, against: Against, into: &mut Passed) -> Option<Met> {
        let marcher = Marcher {
            slab: self.slab,
            pictures: self.pictures,
            settings: self.settings,
            optics: self.optics,
        };
        marcher.first(photon, against, into.work(Step::March))
    }

    /// The ways on from a surface; none if the photon lands or ends there.
    fn meet(&self, photon: &Photon, met: &Met, into: &mut Passed) -> [Option<Photon>; 3] {
        into.work(Step::Interface).photons += 1;
        match self
            .optics
            .meet(photon, &met.hit, &met.point, &mut into.tally)
        {
            Meeting::Goes(ways) => return ways,
            Meeting::Ends => into.work(Step::Interface).dropped += 1,
            Meeting::Lands => {
                let is_traced = self.settings.layers == Layers::Exact;
                into.land(landing(photon, met, is_traced));
            }
        }
        [None; 3]
    }

    /// Algorithm 1: an event on the near picture, then one on the far picture.
    fn near_then_far(&self, photon: &Photon, into: &mut Passed) {
        let Some(near) = self.first(photon, Against::Near, into) else {
            self.leave(photon, into);
            return;
        };
        for photon in self.meet(photon, &near, into).iter().flatten() {
            let Some(far) = self.first(photon, Against::Far, into) else {
                self.leave(photon, into);
                continue;
            };
            for photon in self.meet(photon, &far, into).iter().flatten() {
                self.leave(photon, into);
            }
        }
    }

    /// Any number of events on peeled layers.
    fn peeled(&self, photon: &Photon, into: &mut Passed) {
        let mut waiting = vec![*photon];
        while let Some(photon) = waiting.pop() {
            match self.first(&photon, Against::All, into) {
                None => self.leave(&photon, into),
                Some(met) => {
                    waiting.extend(self.meet(&photon, &met, into).iter().rev().flatten());
                }
            }
        }
    }

    /// Any number of events on the slab's surfaces, by rays.
    fn traced(&self, photon: &Photon, into: &mut Passed) {
        let mut waiting = vec![*photon];
        while let Some(photon) = waiting.pop() {
            into.work(Step::Layers).photons += 1;
            let mut counters = TraversalCounters::default();
            let found = first_by_rays(self.slab, self.optics, &photon, &mut counters);
            into.work(Step::Layers).add_rays(counters);
            match found {
                None => self.leave(&photon, into),
                Some(met) => {
                    waiting.extend(self.meet(&photon, &met, into).iter().rev().flatten());
                }
            }
        }
    }
}

/// The first surface of a slab on a photon's way, by rays.
pub fn first_by_rays(
    slab: &Slab,
    optics: &Optics,
    photon: &Photon,
    counters: &mut TraversalCounters,
) -> Option<Met> {
    let scene = slab.scene;
    let (end, _) = slab.cuboid.leaves(&photon.ray, slab.depths);
    let (mut ray, mut done) = (photon.ray, 0.0);
    while let Some(hit) = scene.world().closest_hit(&ray, end - done, counters) {
        let point = scene.world().bounce_point(&ray, &hit);
        if !scene.material_of(hit.shape).is_passed(scene.materials())
            && optics.accepts(photon, hit.shape, point.geometric_normal, true)
        {
            let distance = done + hit.distance;
            let hit = Hit { distance, ..hit };
            let depth = slab_depth(slab, &point);
            return Some(Met { depth, hit, point });
        }
        ray = point.spawn(ray.direction);
        done = (ray.origin - photon.ray.origin).dot(photon.ray.direction);
    }
    None
}

/// A photon on a surface that it met.
fn landing(photon: &Photon, met: &Met, is_traced: bool) -> Landing {
    Landing {
        photon: *photon,
        position: met.point.position,
        normal: facing(met.point.geometric_normal, photon.ray.direction),
        hit: is_traced.then_some(met.hit),
    }
}

/// The depth of a point from a slab's entry \[m\].
fn slab_depth(slab: &Slab, point: &SurfacePoint) -> f64 {
    slab.place(slab.cuboid.to_local(point.position)).z
}

/// A normal on the side that light comes from.
pub fn facing(normal: DVec3, direction: DVec3) -> DVec3 {
    if normal.dot(direction) > 0.0 {
        -normal
    } else {
        normal
    }
}
