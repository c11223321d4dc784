//! Chains of mirrors and glass, and the light that follows them.
//!
//! One photon may become many. For the first few events light goes on along every branch of an interface (the
//! Fresnel tree). After that it goes on along one branch, chosen with the probability of its share. Both keep
//! the expected flux of every branch. Choosing one also keeps the flux itself, so the [ledger](super::ledger)
//! closes for every photon and not only on average. At a rough interface one of its many branches is chosen,
//! too, if the settings let chains go on from there ([`glossy`]).
//!
//! A chain knows nothing of sensors. It tells its [`ChainSink`] of every surface at which light arrives, and
//! a sensor, or a photon map, uses that as it likes.

use super::flux::Flux;
use super::glossy;
use super::ledger::Fate;
use super::scatter::{Branch, Interaction, ShadingNormals, Way};
use super::signature::{Event, MAX_EVENTS, Signature};
use crate::geometry::{Hit, Ray, SurfacePoint, TraversalCounters};
use crate::scene::{Material, Scene};

/// Depth to which chains are followed, and to which they are split.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct ChainSettings {
    /// Number of events after which flux is cut off, at most [`MAX_EVENTS`].
    pub max_depth: u32,
    /// Number of specular events up to which every branch is followed; later ones follow one at random.
    pub split_depth: u32,
    /// Effect of interpolated normals on flux.
    pub shading_normals: ShadingNormals,
    /// True if chains go on from rough interfaces, false if they end there. It is the method's to say.
    #[serde(skip)]
    pub follows_rough: bool,
}

impl Default for ChainSettings {
    /// Settings of 16 events, with all branches for the first two, also from rough interfaces.
    fn default() -> Self {
        Self {
            max_depth: 16,
            split_depth: 2,
            shading_normals: ShadingNormals::Flux,
            follows_rough: true,
        }
    }
}

/// Light that arrives at a surface.
#[derive(Clone, Copy, Debug)]
pub struct Arrival<'a, const N: usize> {
    /// The leg that ends here.
    pub ray: &'a Ray,
    /// The hit at the end of the leg.
    pub hit: &'a Hit,
    /// [`World::bounce_point`](crate::geometry::World::bounce_point) of the hit: `uv` is unspecified on round
    /// shapes.
    pub point: &'a SurfacePoint,
    /// The events so far.
    pub signature: Signature,
    /// Flux that arrives \[W\].
    pub flux: Flux<N>,
}

/// A receiver of the reports on a followed chain.
pub trait ChainSink<const N: usize> {
    /// `flux` \[W\] travels along a leg: to a surface, or, without an arrival, out of the scene.
    #[inline]
    fn travels(
        &mut self,
        ray: &Ray,
        end: Option<(&Hit, &SurfacePoint)>,
        signature: Signature,
        flux: Flux<N>,
    ) {
        let _ = (ray, end, signature, flux);
    }
    /// Light arrives at a surface, and may end there or go on. Returns the fate of the light that ends.
    ///
    /// `counters` is for rays that the sink traces itself.
    fn arrived(&mut self, arrival: &Arrival<N>, counters: &mut TraversalCounters) -> Fate;
    /// `flux` \[W\] ended after the events of `signature`.
    fn ended(&mut self, signature: Signature, fate: Fate, flux: Flux<N>);
    /// Adjoint shading normals added `flux` \[W\].
    fn gained(&mut self, flux: Flux<N>);
    /// A uniform number in [0, 1) for the choice after `signature` and `passes` surfaces passed through. It
    /// is always the same for the same arguments.
    fn choice(&mut self, signature: Signature, passes: u32) -> f64;
}

/// Light on its way, one leg of a chain.
#[derive(Clone, Copy, Debug)]
struct Flight<const N: usize> {
    ray: Ray,
    flux: Flux<N>,
    signature: Signature,
    passes: u32,
}

/// Largest number of surfaces that change nothing (null, open masks) before a chain is cut off. A ray meets
/// each surface once, so only a pathological scene reaches it.
pub const MAX_PASSES: u32 = 4096;

/// A tracer of chains through one scene. Each thread needs its own, since it keeps its stack.
pub struct ChainTracer<'a, const N: usize> {
    scene: &'a Scene,
    settings: ChainSettings,
    /// Branches that wait while another is followed.
    pending: Vec<Flight<N>>,
    /// Work done so far.
    pub counters: TraversalCounters,
}

impl<'a, const N: usize> ChainTracer<'a, N> {
    /// A tracer without any work done.
    ///
    /// # Panics
    ///
    /// If `settings.max_depth` is above [`MAX_EVENTS`].
    pub fn new(scene: &'a Scene, settings: ChainSettings) -> Self {
        assert!(settings.max_depth as usize <= MAX_EVENTS);
        Self {
            scene,
            settings,
            pending: Vec::new(),
            counters: TraversalCounters::default(),
        }
    }

    /// Follows `flux` \[W\] along `ray` until all of it has ended.
    #[inline]
    pub fn trace(&mut self, ray: Ray, flux: Flux<N>, sink: &mut impl ChainSink<N>) {
        self.trace_among(self.scene.materials(), ray, flux, sink);
    }

    /// Follows the same among other materials than the scene's own: as light of one wavelength meets them.
    ///
    /// Rough interfaces stay those of the scene.
    #[inline]
    pub fn trace_among(
        &mut self,
        materials: &[Material],
        ray: Ray,
        flux: Flux<N>,
        sink: &mut impl ChainSink<N>,
    ) {
        let mut flight = Flight {
            ray,
            flux,
            signature: Signature::DIRECT,
            passes: 0,
        };
        while let Some(next) = self
            .step(materials, &flight, sink)
            .or_else(|| self.pending.pop())
        {
            flight = next;
        }
    }

    /// Goes to the next surface, and on along one of its branches; others are left pending.
    #[inline]
    fn step(
        &mut self,
        materials: &[Material],
        flight: &Flight<N>,
        sink: &mut impl ChainSink<N>,
    ) -> Option<Flight<N>> {
        if flight.flux.is_black() {
            return None;
        }
        let world = self.scene.world();
        let ray = &flight.ray;
        let Some(hit) = world.closest_hit(ray, f64::INFINITY, &mut self.counters) else {
            sink.travels(ray, None, flight.signature, flight.flux);
            sink.ended(flight.signature, Fate::Escaped, flight.flux);
            return None;
        };
        let point = world.bounce_point(ray, &hit);
        let end = Some((&hit, &point));
        sink.travels(ray, end, flight.signature, flight.flux);
        let arrival = Arrival {
            ray,
            hit: &hit,
            point: &point,
            signature: flight.signature,
            flux: flight.flux,
        };
        let fate = sink.arrived(&arrival, &mut self.counters);
        let material = self.scene.objects()[hit.shape as usize].material;
        let interaction = Interaction::among(
            (self.scene, materials),
            &materials[material.0 as usize],
            &point,
            ray.direction,
            self.settings.shading_normals,
        );
        let is_rough = self.settings.follows_rough && interaction.rough_share() > 0.0;
        if interaction.is_end() && !is_rough {
            sink.ended(flight.signature, fate, flight.flux);
            return None;
        }
        let events = flight.signature.len();
        if flight.passes >= MAX_PASSES {
            sink.ended(flight.signature, Fate::CutOff, flight.flux);
            None
        } else if events >= self.settings.max_depth as usize {
            self.pass(flight, &interaction, &point, sink)
        } else if is_rough {
            self.scatter(flight, &hit, &point, sink)
        } else if events < self.settings.split_depth as usize {
            self.follow_all(flight, &interaction, &point, sink)
        } else {
            self.follow_one(flight, &interaction, &point, sink)
        }
    }

    /// Follows one way, chosen with the probability of its share: it carries all the flux.
    #[inline]
    fn follow_one(
        &self,
        flight: &Flight<N>,
        interaction: &Interaction,
        point: &SurfacePoint,
        sink: &mut impl ChainSink<N>,
    ) -> Option<Flight<N>> {
        let choice = sink.choice(flight.signature, flight.passes);
        let next = interaction
            .choose(choice)
            .and_then(|way| self.along(flight, flight.flux, way, interaction, point, sink));
        if next.is_none() {
            sink.ended(flight.signature, Fate::Absorbed, flight.flux);
        }
        next
    }

    /// Follows one of the many directions of a rough interface, or passes the mask over it.
    ///
    /// Out of line: scenes without rough interfaces are not to pay for it.
    #[cold]
    #[inline(never)]
    fn scatter(
        &self,
        flight: &Flight<N>,
        hit: &Hit,
        point: &SurfacePoint,
        sink: &mut impl ChainSink<N>,
    ) -> Option<Flight<N>> {
        // No flight has passed so many surfaces: nothing else is chosen by these numbers.
        let numbers =
            [0, 1, 2].map(|k| sink.choice(flight.signature, flight.passes + k * (MAX_PASSES + 1)));
        let drawn = glossy::draw(
            self.scene,
            hit,
            point,
            flight.ray.direction,
            self.settings.shading_normals,
            numbers,
        );
        let Some((branch, event)) = drawn else {
            sink.ended(flight.signature, Fate::Absorbed, flight.flux);
            return None;
        };
        Some(self.leave(flight, flight.flux, &branch, event, point, sink))
    }

    /// Follows every way that light goes.
    #[inline]
    fn follow_all(
        &mut self,
        flight: &Flight<N>,
        interaction: &Interaction,
        point: &SurfacePoint,
        sink: &mut impl ChainSink<N>,
    ) -> Option<Flight<N>> {
        let mut last = None;
        let mut rest = flight.flux;
        for way in Way::ALL {
            let share = interaction.share_of(way);
            if share > 0.0 {
                let flux = flight.flux * share;
                if let Some(next) = self.along(flight, flux, way, interaction, point, sink) {
                    rest = rest - flux;
                    self.pending.extend(last.replace(next));
                }
            }
        }
        // Shares sum to one but for rounding, which does not count as absorption.
        if rest.max_magnitude() > 4.0 * f64::EPSILON * flight.flux.max_magnitude() {
            sink.ended(flight.signature, Fate::Absorbed, rest);
        }
        last
    }

    /// Past the deepest level: light that passes without an event goes on, the rest is cut off.
    fn pass(
        &self,
        flight: &Flight<N>,
        interaction: &Interaction,
        point: &SurfacePoint,
        sink: &mut impl ChainSink<N>,
    ) -> Option<Flight<N>> {
        let passed = interaction.share_of(Way::Passed);
        if passed < 1.0 {
            let mut events =
                interaction.share_of(Way::Reflected) + interaction.share_of(Way::Transmitted);
            if self.settings.follows_rough {
                events += interaction.rough_share();
            }
            let fate = if events > 0.0 {
                Fate::CutOff
            } else {
                Fate::Absorbed
            };
            sink.ended(flight.signature, fate, flight.flux * (1.0 - passed));
        }
        if passed > 0.0 {
            let flux = flight.flux * passed;
            self.along(flight, flux, Way::Passed, interaction, point, sink)
        } else {
            None
        }
    }

    /// `flux` of a flight on one of the ways from its place; `None` if there is no way after all.
    #[inline]
    fn along(
        &self,
        flight: &Flight<N>,
        flux: Flux<N>,
        way: Way,
        interaction: &Interaction,
        point: &SurfacePoint,
        sink: &mut impl ChainSink<N>,
    ) -> Option<Flight<N>> {
        let branch = interaction.branch(way)?;
        Some(self.leave(flight, flux, &branch, way.event(), point, sink))
    }

    /// `flux` of a flight on one branch from its place.
    ///
    /// Flux that a tint takes is absorbed. Flux that a tint adds is a gain by adjoint shading normals.
    #[inline]
    fn leave(
        &self,
        flight: &Flight<N>,
        flux: Flux<N>,
        branch: &Branch<N>,
        event: Option<Event>,
        point: &SurfacePoint,
        sink: &mut impl ChainSink<N>,
    ) -> Flight<N> {
        let leaving = flux * branch.tint;
        if leaving != flux {
            if self.settings.shading_normals == ShadingNormals::Adjoint {
                sink.gained(leaving - flux);
            } else {
                sink.ended(flight.signature, Fate::Absorbed, flux - leaving);
            }
        }
        Flight {
            ray: point.spawn(branch.direction),
            flux: leaving,
            signature: event.map_or(flight.signature, |event| flight.signature.then(event)),
            passes: flight.passes + u32::from(event.is_none()),
        }
    }
}
