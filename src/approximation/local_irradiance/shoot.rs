//! Photons of one light sample, and the legs on which they travel (section 4.2).

use std::ops::Range;
use std::sync::Mutex;

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::lamp::Lamp;
use super::leg::Leg;
use super::work::Work;
use crate::geometry::{Hit, Ray, SurfacePoint, TraversalCounters};
use crate::numeric::{Stream, morton_code};
use crate::scene::{Material, Scene};
use crate::transport::chain::{Arrival, ChainSettings, ChainSink, ChainTracer, Emitted};
use crate::transport::flux::Flux;
use crate::transport::ledger::Fate;
use crate::transport::signature::Signature;

/// Photons of a task.
pub const TASK: u64 = 16_384;

/// Photons of one light sample.
pub struct Shot<'a> {
    /// What they are traced in.
    pub scene: &'a Scene,
    /// The object's centre there.
    pub center: DVec3,
    /// The radius of the ball around it \[m\].
    pub radius: f64,
    /// The rotation from the scene's axes to the object's own.
    pub to_own: DMat3,
    /// The object's shapes, if there are others: photons belong to the object whose surface they meet first.
    pub own: Option<&'a [u32]>,
    /// Their light, along the scene's axes.
    pub lamp: Lamp,
    /// Settings of their chains.
    pub chains: ChainSettings,
    /// Their random numbers.
    pub stream: Stream,
    /// Their numbers.
    pub photons: Range<u64>,
    /// The number that stands for all light.
    pub total: u64,
    /// Tells when to give up.
    pub stop: &'a (dyn Fn() -> bool + Sync),
}

/// What legs are added to. Sums do not depend on the order.
pub trait Deposits<const N: usize>: Send {
    /// Adds the light of a leg.
    fn add(&mut self, leg: &TracedLeg<N>, work: &mut Work);
}

/// A leg after a first event, along the object's own axes about its centre.
#[derive(Clone, Copy, Debug)]
pub struct TracedLeg<const N: usize> {
    /// Its place.
    pub leg: Leg,
    /// Its flux \[W\].
    pub flux: Flux<N>,
    /// True if it is inside of glass.
    pub is_inside: bool,
    /// True if light ends at its end.
    pub is_stopped: bool,
}

/// The flux of photons \[W\] by their ends.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Tally {
    /// Photons that set out.
    pub photons: u64,
    /// What set out.
    pub set_out: [f64; 3],
    /// What met nothing of the object.
    pub missed: [f64; 3],
    /// What interfaces took.
    pub absorbed: [f64; 3],
    /// What ended after too many events.
    pub cut_off: [f64; 3],
    /// What left the object.
    pub left: [f64; 3],
}

impl Tally {
    /// True if all of its flux is a number, as it is but in a foreign file.
    pub fn is_finite(&self) -> bool {
        let flux = [
            self.set_out,
            self.missed,
            self.absorbed,
            self.cut_off,
            self.left,
        ];
        flux.as_flattened().iter().all(|it| it.is_finite())
    }

    /// The photons of another, and its flux times a factor.
    pub fn add_scaled(&mut self, other: &Self, factor: f64) {
        self.add_coloured(other, [factor; 3]);
    }

    /// The photons of another, and its flux times a factor by colour.
    pub fn add_coloured(&mut self, other: &Self, factors: [f64; 3]) {
        self.photons += other.photons;
        let pairs = [
            (&mut self.set_out, other.set_out),
            (&mut self.missed, other.missed),
            (&mut self.absorbed, other.absorbed),
            (&mut self.cut_off, other.cut_off),
            (&mut self.left, other.left),
        ];
        for (sum, one) in pairs {
            for c in 0..3 {
                sum[c] += one[c] * factors[c];
            }
        }
    }
}

impl Shot<'_> {
    /// Traces the photons into deposits: one on each thread at a time, of which all are returned.
    ///
    /// Tallies are added up in the order of photons. After `stop` asked for an end, the tasks not yet started
    /// are missing: [`Tally::photons`] has those that were traced.
    pub fn trace<const N: usize, D: Deposits<N>>(
        &self,
        new: impl Fn() -> D + Sync,
    ) -> (Vec<D>, Tally, Work) {
        let pool: Mutex<Vec<D>> = Mutex::new(Vec::new());
        let count = self.photons.end - self.photons.start;
        let done: Vec<(Tally, Work)> = (0..count.div_ceil(TASK))
            .into_par_iter()
            .map(|task| {
                if (self.stop)() {
                    return Default::default();
                }
                let mut deposits = pool
                    .lock()
                    .ok()
                    .and_then(|mut pool| pool.pop())
                    .unwrap_or_else(&new);
                let first = self.photons.start + task * TASK;
                let range = first..(first + TASK).min(self.photons.end);
                let done = self.trace_some(range, &mut deposits);
                if let Ok(mut pool) = pool.lock() {
                    pool.push(deposits);
                }
                done
            })
            .collect();
        let (mut tally, mut work) = (Tally::default(), Work::default());
        for (one, counted) in &done {
            tally.add_scaled(one, 1.0);
            work += *counted;
        }
        (pool.into_inner().unwrap_or_default(), tally, work)
    }

    /// Photons with their points of the unit square, along the Morton curve: one after another meets the same
    /// triangles and cells, which are then still in a core's cache.
    fn nearest_first(&self, photons: Range<u64>) -> impl Iterator<Item = (u64, [f64; 2])> {
        let mut ordered: Vec<(u64, u64, [f64; 2])> = photons
            .map(|index| {
                let [u, v] = self.stream.point2(index);
                (morton_code(DVec3::new(u, v, 0.0)), index, [u, v])
            })
            .collect();
        ordered.sort_unstable_by_key(|(code, index, _)| (*code, *index));
        ordered.into_iter().map(|(_, index, point)| (index, point))
    }

    fn trace_some<const N: usize, D: Deposits<N>>(
        &self,
        photons: Range<u64>,
        deposits: &mut D,
    ) -> (Tally, Work) {
        let mut tracer = ChainTracer::new(self.scene, self.chains);
        let (mut tally, mut work) = (Tally::default(), Work::default());
        for (index, point) in self.nearest_first(photons) {
            let (ray, flux) = self.lamp.photon(self.radius, point);
            let flux = Flux::<N>::WHITE * (flux / self.total as f64);
            let mut sink = Sink {
                shot: self,
                deposits: &mut *deposits,
                tally: &mut tally,
                work: &mut work,
                is_own: self.own.is_none(),
            };
            let light = Emitted {
                ray: Ray::new(self.center + ray.origin, ray.direction),
                flux,
                choices: self.stream.extras(index),
            };
            tracer.trace(&light, &mut sink);
            tally.photons += 1;
        }
        work.photons += tally.photons;
        work.add_rays(tracer.counters);
        (tally, work)
    }
}

fn add<const N: usize>(sum: &mut [f64; 3], flux: Flux<N>) {
    for (sum, one) in sum.iter_mut().zip(flux.rgb().0) {
        *sum += one;
    }
}

struct Sink<'a, const N: usize, D> {
    shot: &'a Shot<'a>,
    deposits: &'a mut D,
    tally: &'a mut Tally,
    work: &'a mut Work,
    /// True if the photon's first event was on the object. Chains follow all that comes of one first event
    /// before the next.
    is_own: bool,
}

impl<const N: usize, D: Deposits<N>> ChainSink<N> for Sink<'_, N, D> {
    #[inline]
    fn emitted(&mut self, flux: Flux<N>) {
        add(&mut self.tally.set_out, flux);
    }

    #[inline]
    fn travels(
        &mut self,
        ray: &Ray,
        end: Option<(&Hit, &SurfacePoint)>,
        signature: Signature,
        flux: Flux<N>,
    ) {
        if signature.is_empty() || !self.is_own {
            return;
        }
        let shot = self.shot;
        let (mut is_inside, mut is_stopped) = (false, false);
        if let Some((hit, point)) = end {
            let material = shot.scene.material_of(hit.shape);
            is_inside =
                encloses(shot.scene, material) && ray.direction.dot(point.geometric_normal) > 0.0;
            is_stopped = !material.is_specular(shot.scene.materials())
                && !material.is_passed(shot.scene.materials());
        }
        self.work.legs += 1;
        let leg = Leg {
            from: shot.to_own * (ray.origin - shot.center),
            direction: shot.to_own * ray.direction,
            length: end.map_or(f64::INFINITY, |(hit, _)| hit.distance),
        };
        let traced = TracedLeg {
            leg,
            flux,
            is_inside,
            is_stopped,
        };
        self.deposits.add(&traced, self.work);
    }

    #[inline]
    fn arrived(&mut self, arrival: &Arrival<N>, _: &mut TraversalCounters) -> Fate {
        let scene = self.shot.scene;
        if let Some(own) = self.shot.own
            && arrival.signature.is_empty()
        {
            self.is_own = own.contains(&arrival.hit.shape);
        }
        let material = scene.material_of(arrival.hit.shape);
        if material.is_specular(scene.materials()) {
            // The back of a mirror, or normals that contradict each other.
            Fate::Absorbed
        } else {
            Fate::Received
        }
    }

    #[inline]
    fn ended(&mut self, signature: Signature, fate: Fate, flux: Flux<N>) {
        let sum = match fate {
            _ if signature.is_empty() && fate != Fate::Absorbed => &mut self.tally.missed,
            _ if !self.is_own => &mut self.tally.missed,
            Fate::Absorbed => &mut self.tally.absorbed,
            Fate::CutOff => &mut self.tally.cut_off,
            Fate::Escaped | Fate::Received | Fate::Direct => &mut self.tally.left,
        };
        add(sum, flux);
    }

    fn gained(&mut self, _: Flux<N>) {}
}

/// True if a material is the border of glass: behind it is the inside.
fn encloses(scene: &Scene, material: &Material) -> bool {
    match material {
        Material::Dielectric { .. } => true,
        Material::Mask { .. } => material
            .nested()
            .any(|id| encloses(scene, scene.material(id))),
        _ => false,
    }
}
