//! Following light along specular chains.
//!
//! One photon may become many: at an interface light goes on along every branch (the Fresnel
//! tree) for the first few events, and then along one branch, chosen with the probability of
//! its share. Both keep the expected flux of every branch; choosing one keeps the flux itself,
//! too, so the [ledger](super::ledger) closes for every photon and not only on average.

use super::ledger::Fate;
use super::receiver::Receiver;
use super::scatter::{Branch, ShadingNormals, scatter};
use super::signature::{MAX_EVENTS, Signature};
use crate::geometry::{Ray, TraversalCounters};
use crate::radiometry::Rgb;
use crate::scene::Scene;

/// How far and how finely chains are followed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct ChainSettings {
    /// Specular events after which flux is cut off, at most [`MAX_EVENTS`].
    pub max_depth: u32,
    /// Specular events up to which every branch is followed; later ones follow one at random.
    pub split_depth: u32,
    /// What interpolated normals do to flux.
    pub shading_normals: ShadingNormals,
}

impl Default for ChainSettings {
    /// 16 events, all branches for the first two.
    fn default() -> Self {
        Self {
            max_depth: 16,
            split_depth: 2,
            shading_normals: ShadingNormals::Flux,
        }
    }
}

/// What a followed chain reports.
pub trait ChainSink {
    /// `flux` [W] fell into `texel` after the events of `signature`.
    fn received(&mut self, signature: Signature, texel: usize, flux: Rgb);
    /// `flux` [W] ended otherwise.
    fn ended(&mut self, signature: Signature, fate: Fate, flux: Rgb);
    /// Adjoint shading normals added `flux` [W].
    fn gained(&mut self, flux: Rgb);
    /// A uniform number in [0, 1) for the choice at the end of `signature`, `passes` surfaces
    /// passed through: always the same for the same arguments.
    fn choice(&mut self, signature: Signature, passes: u32) -> f64;
}

/// Light on its way.
#[derive(Clone, Copy, Debug)]
struct Flight {
    ray: Ray,
    flux: Rgb,
    signature: Signature,
    passes: u32,
}

/// Surfaces that change nothing (null, open masks) a chain may pass before it is cut off.
/// A ray meets each surface once, so only a pathological scene gets here.
const MAX_PASSES: u32 = 4096;

/// Follows chains through one scene to one receiver. Make one a thread: it keeps its stack.
pub struct ChainTracer<'a> {
    scene: &'a Scene,
    receiver: &'a Receiver,
    settings: ChainSettings,
    pending: Vec<Flight>,
    /// Work done so far.
    pub counters: TraversalCounters,
}

impl<'a> ChainTracer<'a> {
    /// A tracer that ends chains at `receiver`.
    ///
    /// # Panics
    ///
    /// Where `settings.max_depth` is above [`MAX_EVENTS`].
    pub fn new(scene: &'a Scene, receiver: &'a Receiver, settings: ChainSettings) -> Self {
        assert!(settings.max_depth as usize <= MAX_EVENTS);
        Self {
            scene,
            receiver,
            settings,
            pending: Vec::new(),
            counters: TraversalCounters::default(),
        }
    }

    /// Follows `flux` [W] along `ray` until all of it has ended.
    #[inline]
    pub fn trace(&mut self, ray: Ray, flux: Rgb, sink: &mut impl ChainSink) {
        self.pending.push(Flight {
            ray,
            flux,
            signature: Signature::DIRECT,
            passes: 0,
        });
        while let Some(flight) = self.pending.pop() {
            self.step(&flight, sink);
        }
    }

    /// To the next surface, and into the branches there.
    fn step(&mut self, flight: &Flight, sink: &mut impl ChainSink) {
        let Flight {
            ray,
            flux,
            signature,
            passes,
        } = *flight;
        let world = self.scene.world();
        let Some(hit) = world.closest_hit(&ray, f64::INFINITY, &mut self.counters) else {
            sink.ended(signature, Fate::Escaped, flux);
            return;
        };
        let point = world.surface_point(&ray, &hit);
        let mut measured = false;
        if hit.shape == self.receiver.shape()
            && let Some(texel) = self.receiver.texel(&point, ray.direction)
        {
            measured = true;
            if !signature.is_empty() {
                sink.received(signature, texel, flux);
            }
        }
        let branches = scatter(
            self.scene,
            self.scene.material_of(hit.shape),
            &point,
            ray.direction,
            self.settings.shading_normals,
        );
        if branches.is_empty() {
            let fate = match (measured, signature.is_empty()) {
                (true, false) => Fate::Received,
                (true, true) => Fate::Direct,
                (false, _) => Fate::Absorbed,
            };
            sink.ended(signature, fate, flux);
            return;
        }
        if signature.len() >= self.settings.max_depth as usize || passes >= MAX_PASSES {
            let mut rest = flux;
            for branch in branches.iter().filter(|_| passes < MAX_PASSES) {
                // Passing is no event: it needs no depth.
                if branch.event.is_none() {
                    let flux = flux * branch.share;
                    rest = rest - flux;
                    self.go(&point, branch, flux, flight);
                }
            }
            sink.ended(signature, Fate::CutOff, rest);
            return;
        }
        let mut rest = flux;
        if branches.len() == 1 || signature.len() < self.settings.split_depth as usize {
            for branch in branches.iter() {
                let arriving = flux * branch.share;
                rest = rest - self.take(&point, branch, arriving, flight, sink);
            }
        } else {
            // What no branch carries is one of the choices: the flux is absorbed whole then.
            let mut left = sink.choice(signature, passes);
            for branch in branches.iter() {
                if left < branch.share {
                    rest = rest - self.take(&point, branch, flux, flight, sink);
                    break;
                }
                left -= branch.share;
            }
        }
        if !rest.is_black() {
            sink.ended(signature, Fate::Absorbed, rest);
        }
    }

    /// Sends `arriving` flux along a branch. Returns what it took from the flux at the surface.
    #[inline]
    fn take(
        &mut self,
        point: &crate::geometry::SurfacePoint,
        branch: &Branch,
        arriving: Rgb,
        flight: &Flight,
        sink: &mut impl ChainSink,
    ) -> Rgb {
        let leaving = arriving * branch.tint;
        if !leaving.is_black() {
            self.go(point, branch, leaving, flight);
        }
        // A tint above one can only come from adjoint shading normals.
        let gain = leaving - arriving;
        if self.settings.shading_normals == ShadingNormals::Adjoint && gain.max_channel() > 0.0 {
            sink.gained(gain);
            return arriving;
        }
        leaving
    }

    #[inline]
    fn go(
        &mut self,
        point: &crate::geometry::SurfacePoint,
        branch: &Branch,
        flux: Rgb,
        flight: &Flight,
    ) {
        let (signature, passes) = match branch.event {
            Some(event) => (flight.signature.then(event), flight.passes),
            None => (flight.signature, flight.passes + 1),
        };
        self.pending.push(Flight {
            ray: point.spawn(branch.direction),
            flux,
            signature,
            passes,
        });
    }
}
