//! Following light along specular chains.
//!
//! One photon may become many: at an interface light goes on along every branch (the Fresnel
//! tree) for the first few events, and then along one branch, chosen with the probability of
//! its share. Both keep the expected flux of every branch; choosing one keeps the flux itself,
//! too, so the [ledger](super::ledger) closes for every photon and not only on average.

use super::ledger::Fate;
use super::receiver::Receiver;
use super::scatter::{ShadingNormals, scatter};
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
    /// `flux` \[W\] fell into `texel` after the events of `signature`.
    fn received(&mut self, signature: Signature, texel: usize, flux: Rgb);
    /// `flux` \[W\] ended otherwise.
    fn ended(&mut self, signature: Signature, fate: Fate, flux: Rgb);
    /// Adjoint shading normals added `flux` \[W\].
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

    /// Follows `flux` \[W\] along `ray` until all of it has ended.
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
    #[inline]
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
        let mut measured = false;
        let point = if hit.shape == self.receiver.shape() {
            let point = world.surface_point(&ray, &hit);
            if let Some(texel) = self.receiver.texel(&point, ray.direction) {
                measured = true;
                if !signature.is_empty() {
                    sink.received(signature, texel, flux);
                }
            }
            point
        } else {
            world.bounce_point(&ray, &hit)
        };
        let follows = self.follow(signature, passes, sink);
        let mut went_on = Gone::default();
        let adjoint = self.settings.shading_normals == ShadingNormals::Adjoint;
        let pending = &mut self.pending;
        scatter(
            self.scene,
            self.scene.material_of(hit.shape),
            &point,
            ray.direction,
            self.settings.shading_normals,
            &mut |branch| {
                went_on.branches += 1;
                let arriving = match follows {
                    Follow::All => flux * branch.share,
                    // Passing is no event: it needs no depth.
                    Follow::Passes if branch.event.is_none() => flux * branch.share,
                    Follow::One(choice) => {
                        let chosen =
                            choice >= went_on.shares && choice < went_on.shares + branch.share;
                        went_on.shares += branch.share;
                        if !chosen {
                            return;
                        }
                        flux
                    }
                    Follow::Passes | Follow::None => return,
                };
                let leaving = arriving * branch.tint;
                // A tint above one can only come from adjoint shading normals.
                if adjoint && leaving != arriving {
                    went_on.gain += leaving - arriving;
                    went_on.flux += arriving;
                } else {
                    went_on.flux += leaving;
                }
                if !leaving.is_black() {
                    pending.push(Flight {
                        ray: point.spawn(branch.direction),
                        flux: leaving,
                        signature: branch
                            .event
                            .map_or(signature, |event| signature.then(event)),
                        passes: passes + u32::from(branch.event.is_none()),
                    });
                }
            },
        );
        if !went_on.gain.is_black() {
            sink.gained(went_on.gain);
        }
        let fate = match (follows, went_on.branches) {
            (_, 0) if measured && signature.is_empty() => Fate::Direct,
            (_, 0) if measured => Fate::Received,
            (Follow::Passes | Follow::None, 1..) => Fate::CutOff,
            _ => Fate::Absorbed,
        };
        let rest = flux - went_on.flux;
        // Shares sum to one but for rounding, which is no absorption.
        if rest.map(f64::abs).max_channel() > 4.0 * f64::EPSILON * flux.max_channel() {
            sink.ended(signature, fate, rest);
        }
    }

    /// Which branches to follow after the events of `signature`.
    #[inline]
    fn follow(&self, signature: Signature, passes: u32, sink: &mut impl ChainSink) -> Follow {
        if passes >= MAX_PASSES {
            Follow::None
        } else if signature.len() >= self.settings.max_depth as usize {
            Follow::Passes
        } else if signature.len() < self.settings.split_depth as usize {
            Follow::All
        } else {
            Follow::One(sink.choice(signature, passes))
        }
    }
}

/// Which branches are followed.
#[derive(Clone, Copy)]
enum Follow {
    /// All of them.
    All,
    /// One, chosen by a uniform number; what no branch carries is one of the choices.
    One(f64),
    /// Those that are no event.
    Passes,
    /// None.
    None,
}

/// What went on from a surface.
#[derive(Default)]
struct Gone {
    branches: u32,
    /// Sum of the shares of the branches so far.
    shares: f64,
    /// Taken from the flux that arrived.
    flux: Rgb,
    /// Added to it.
    gain: Rgb,
}
