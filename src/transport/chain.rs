//! Chains of mirrors and glass, and the light that follows them.
//!
//! One photon may become many. For the first few events light goes on along every branch of an interface (the
//! Fresnel tree). After that it goes on along one branch, chosen with the probability of its share. Both keep
//! the expected flux of every branch. Choosing one also keeps the flux itself, so the [ledger](super::ledger)
//! closes for every photon and not only on average. At a rough interface one of its many branches is chosen,
//! too ([`glossy`]). The settings tell from which surfaces chains go on ([`Followed`]).
//!
//! A chain knows nothing of sensors. It tells its [`ChainSink`] of every surface at which light arrives, and
//! a sensor, or a photon map, uses that as it likes.

use super::flux::Flux;
use super::followed::Followed;
use super::glossy;
use super::ledger::Fate;
use super::scatter::{Branch, Interaction, ShadingNormals, Way};
use super::signature::{Event, MAX_EVENTS, Signature};
use crate::geometry::{Hit, Ray, Segment, SurfacePoint, TraversalCounters};
use crate::numeric::Extras;
use crate::radiometry::Rgb;
use crate::scene::{Color, Material, MediumId, Scene, TexturePoint};

/// Depth to which chains are followed, and to which they are split.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct ChainSettings {
    /// Number of events after which flux is cut off, at most [`MAX_EVENTS`].
    pub max_depth: u32,
    /// Number of specular events up to which every branch is followed; later ones follow one at random.
    pub split_depth: u32,
    /// Effect of interpolated normals on flux.
    pub shading_normals: ShadingNormals,
    /// The surfaces that they go on from; at others they end. It is the method's to say.
    #[serde(skip)]
    pub followed: Followed,
}

impl Default for ChainSettings {
    /// Settings of 16 events, with all branches for the first two, from all surfaces that photons know.
    fn default() -> Self {
        Self {
            max_depth: 16,
            split_depth: 2,
            shading_normals: ShadingNormals::Flux,
            followed: Followed::All,
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
    /// A photon starts with `flux` \[W\].
    #[inline]
    fn emitted(&mut self, flux: Flux<N>) {
        let _ = flux;
    }
    /// `flux` \[W\] sets out along a leg: to a surface, or, without an arrival, out of the scene. A medium
    /// may absorb part of it on the way.
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
}

/// Light at its start.
#[derive(Clone, Copy, Debug)]
pub struct Emitted<const N: usize> {
    /// The first leg.
    pub ray: Ray,
    /// Flux along it \[W\].
    pub flux: Flux<N>,
    /// The photon's own random numbers, from which branches are chosen.
    pub choices: Extras,
}

/// Light on its way, one leg of a chain.
#[derive(Clone, Copy, Debug)]
struct Flight<const N: usize> {
    ray: Ray,
    flux: Flux<N>,
    signature: Signature,
    passes: u32,
    /// The medium that the leg is in.
    medium: MediumId,
    choices: Extras,
}

impl<const N: usize> Flight<N> {
    #[inline]
    fn starts(light: &Emitted<N>) -> Self {
        Self {
            ray: light.ray,
            flux: light.flux,
            signature: Signature::DIRECT,
            passes: 0,
            medium: MediumId::CLEAR,
            choices: light.choices,
        }
    }

    /// A uniform number in [0, 1) for the choice at a place that the light reaches after `passes` surfaces
    /// that it passed through. It is always the same for the same path.
    #[inline]
    fn choice(&self, passes: u32) -> f64 {
        // The events and passes of a path name it: there is one dimension for each choice along it.
        let dimension = self.signature.key() ^ passes.wrapping_mul(0x9e37_79b9);
        self.choices.at(dimension)
    }
}

/// The place at the end of a leg.
#[derive(Clone, Copy)]
struct Place<'p> {
    hit: &'p Hit,
    point: &'p SurfacePoint,
    /// The fate of light that does not go on from there.
    lost: Fate,
}

/// Legs searched for at a time: shapes are then tried one after the other for all of them. 16 to 128 take
/// the same time.
const WAVE: usize = 64;

/// Largest number of surfaces that change nothing (null, open masks) before a chain is cut off. A ray meets
/// each surface once, so only a pathological scene reaches it.
pub const MAX_PASSES: u32 = 4096;

/// A tracer of chains through one scene. Each thread needs its own, since it keeps its stack.
pub struct ChainTracer<'a, const N: usize> {
    scene: &'a Scene,
    settings: ChainSettings,
    /// True if no medium absorbs.
    is_clear: bool,
    /// Branches that wait while another is followed.
    pending: Vec<Flight<N>>,
    /// Legs that are searched for together, and what they hit: kept for their memory.
    wave: Vec<Flight<N>>,
    segments: Vec<Segment>,
    hits: Vec<Option<Hit>>,
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
            is_clear: scene.is_clear(),
            pending: Vec::new(),
            wave: Vec::new(),
            segments: Vec::new(),
            hits: Vec::new(),
            counters: TraversalCounters::default(),
        }
    }

    /// Follows light until all of it has ended.
    #[inline]
    pub fn trace(&mut self, light: &Emitted<N>, sink: &mut impl ChainSink<N>) {
        self.trace_among(self.scene.materials(), light, sink);
    }

    /// Follows the same among other materials than the scene's own: as light of one wavelength meets them.
    ///
    /// Rough interfaces stay those of the scene.
    #[inline]
    pub fn trace_among(
        &mut self,
        materials: &[Material],
        light: &Emitted<N>,
        sink: &mut impl ChainSink<N>,
    ) {
        let world = self.scene.world();
        sink.emitted(light.flux);
        let mut next = Some(Flight::starts(light));
        while let Some(flight) = next.take().or_else(|| self.pending.pop()) {
            if !flight.flux.is_black() {
                let hit = world.closest_hit(&flight.ray, f64::INFINITY, &mut self.counters);
                next = self.step(materials, &flight, hit, sink);
            }
        }
    }

    /// Follows many photons at a time: as [`Self::trace`] for each, in another order.
    ///
    /// Their rays are searched for together, some legs of some photons after some of others. So a sink is
    /// to take reports in any order.
    pub fn trace_all(
        &mut self,
        mut photons: impl Iterator<Item = Emitted<N>>,
        sink: &mut impl ChainSink<N>,
    ) {
        let world = self.scene.world();
        let materials = self.scene.materials();
        let mut wave = std::mem::take(&mut self.wave);
        let mut segments = std::mem::take(&mut self.segments);
        let mut hits = std::mem::take(&mut self.hits);
        loop {
            if self.pending.is_empty() {
                let started = photons.by_ref().take(WAVE).map(|light| {
                    sink.emitted(light.flux);
                    Flight::starts(&light)
                });
                self.pending.extend(started);
                if self.pending.is_empty() {
                    break;
                }
            }
            // The latest first, so that few wait; in their order, so that neighbours had the same events.
            let latest = self.pending.len().saturating_sub(WAVE);
            let lit = |flight: &Flight<N>| !flight.flux.is_black();
            wave.extend(self.pending.drain(latest..).filter(lit));
            segments.extend(wave.iter().map(|flight| Segment {
                ray: flight.ray,
                length: f64::INFINITY,
            }));
            world.closest_hits(&segments, &mut hits, &mut self.counters);
            for (flight, &hit) in wave.iter().zip(&hits) {
                let next = self.step(materials, flight, hit, sink);
                self.pending.extend(next);
            }
            wave.clear();
            segments.clear();
        }
        (self.wave, self.segments, self.hits) = (wave, segments, hits);
    }

    /// Arrives at the next surface, and goes on along one of its branches; others are left pending.
    #[inline]
    fn step(
        &mut self,
        materials: &[Material],
        flight: &Flight<N>,
        hit: Option<Hit>,
        sink: &mut impl ChainSink<N>,
    ) -> Option<Flight<N>> {
        let world = self.scene.world();
        let ray = &flight.ray;
        let absorbed;
        let Some(hit) = hit else {
            sink.travels(ray, None, flight.signature, flight.flux);
            absorbed = self.absorbed(flight, f64::INFINITY, sink);
            let flight = absorbed.as_ref().unwrap_or(flight);
            sink.ended(flight.signature, Fate::Escaped, flight.flux);
            return None;
        };
        let point = world.bounce_point(ray, &hit);
        sink.travels(ray, Some((&hit, &point)), flight.signature, flight.flux);
        absorbed = self.absorbed(flight, hit.distance, sink);
        let flight = absorbed.as_ref().unwrap_or(flight);
        let arrival = Arrival {
            ray,
            hit: &hit,
            point: &point,
            signature: flight.signature,
            flux: flight.flux,
        };
        let fate = sink.arrived(&arrival, &mut self.counters);
        let material = self.scene.objects()[hit.shape as usize].material;
        let mut interaction = Interaction::among(
            (self.scene, materials),
            &materials[material.0 as usize],
            &point,
            ray.direction,
            self.settings.shading_normals,
        );
        interaction.follow(self.settings.followed);
        let is_rough = interaction.rough_share() > 0.0;
        if interaction.is_end() && !is_rough {
            sink.ended(flight.signature, fate, flight.flux);
            return None;
        }
        let events = flight.signature.len();
        let lost = if interaction.is_coated() {
            fate
        } else {
            Fate::Absorbed
        };
        let place = Place {
            hit: &hit,
            point: &point,
            lost,
        };
        if flight.passes >= MAX_PASSES {
            sink.ended(flight.signature, Fate::CutOff, flight.flux);
            None
        } else if events >= self.settings.max_depth as usize {
            self.pass(flight, &interaction, place, sink)
        } else if is_rough {
            self.scatter(flight, &interaction, place, sink)
        } else if events < self.settings.split_depth as usize {
            self.follow_all(flight, &interaction, place, sink)
        } else {
            self.follow_one(flight, &interaction, place, sink)
        }
    }

    /// The flight at the end of a leg of some `length` within a medium; `None` in the clear.
    #[inline]
    fn absorbed(
        &self,
        flight: &Flight<N>,
        length: f64,
        sink: &mut impl ChainSink<N>,
    ) -> Option<Flight<N>> {
        (flight.medium != MediumId::CLEAR).then(|| self.absorb(flight, length, sink))
    }

    ///
    /// Out of line: scenes without media are not to pay for it.
    #[cold]
    #[inline(never)]
    fn absorb(&self, flight: &Flight<N>, length: f64, sink: &mut impl ChainSink<N>) -> Flight<N> {
        let flux = flight.flux * Flux::of(self.scene.transmittance(flight.medium, length));
        sink.ended(flight.signature, Fate::Absorbed, flight.flux - flux);
        Flight { flux, ..*flight }
    }

    /// Follows one way, chosen with the probability of its share: it carries all the flux.
    #[inline]
    fn follow_one(
        &self,
        flight: &Flight<N>,
        interaction: &Interaction,
        place: Place,
        sink: &mut impl ChainSink<N>,
    ) -> Option<Flight<N>> {
        let choice = flight.choice(flight.passes);
        let next = interaction
            .choose(choice)
            .and_then(|way| self.along(flight, flight.flux, way, interaction, place, sink));
        if next.is_none() {
            sink.ended(flight.signature, place.lost, flight.flux);
        }
        next
    }

    /// Follows one of the many directions of a rough interface, or passes the mask over it.
    ///
    /// What a coat reflects is some percent. While chains split, these go on. Later the chain goes on as
    /// often as that, with all of its flux.
    ///
    /// Out of line: scenes without rough interfaces are not to pay for it.
    #[cold]
    #[inline(never)]
    fn scatter(
        &self,
        flight: &Flight<N>,
        interaction: &Interaction,
        place: Place,
        sink: &mut impl ChainSink<N>,
    ) -> Option<Flight<N>> {
        // No flight has passed so many surfaces: nothing else is chosen by these numbers.
        let number = |k: u32| flight.choice(flight.passes + k * (MAX_PASSES + 1));
        let drawn = glossy::draw(
            self.scene,
            (place.hit, place.point),
            flight.ray.direction,
            self.settings.shading_normals,
            [0, 1, 2].map(number),
        );
        let Some((mut branch, event)) = drawn else {
            sink.ended(flight.signature, place.lost, flight.flux);
            return None;
        };
        let mut flux = flight.flux;
        let share = branch.tint.max_magnitude();
        if event.is_some() && interaction.is_coated() && share < 1.0 {
            branch.tint = branch.tint * (1.0 / share);
            if flight.signature.len() < self.settings.split_depth as usize {
                sink.ended(flight.signature, place.lost, flux * (1.0 - share));
                flux = flux * share;
            } else if number(3) >= share {
                sink.ended(flight.signature, place.lost, flux);
                return None;
            }
        }
        Some(self.leave(flight, flux, &branch, event, place, sink))
    }

    /// Follows every way that light goes.
    #[inline]
    fn follow_all(
        &mut self,
        flight: &Flight<N>,
        interaction: &Interaction,
        place: Place,
        sink: &mut impl ChainSink<N>,
    ) -> Option<Flight<N>> {
        let mut last = None;
        let mut rest = flight.flux;
        for way in Way::ALL {
            let share = interaction.share_of(way);
            if share > 0.0 {
                let flux = flight.flux * share;
                if let Some(next) = self.along(flight, flux, way, interaction, place, sink) {
                    rest = rest - flux;
                    self.pending.extend(last.replace(next));
                }
            }
        }
        // Shares sum to one but for rounding, which does not count as absorption.
        if rest.max_magnitude() > 4.0 * f64::EPSILON * flight.flux.max_magnitude() {
            sink.ended(flight.signature, place.lost, rest);
        }
        last
    }

    /// Past the deepest level: light that passes without an event goes on, the rest is cut off.
    fn pass(
        &self,
        flight: &Flight<N>,
        interaction: &Interaction,
        place: Place,
        sink: &mut impl ChainSink<N>,
    ) -> Option<Flight<N>> {
        let passed = interaction.share_of(Way::Passed);
        if passed < 1.0 {
            let events = interaction.share_of(Way::Reflected)
                + interaction.share_of(Way::Transmitted)
                + interaction.rough_share();
            let (cut, fate) = if interaction.is_coated() {
                // What a rough one would send on is not known: some percent.
                (interaction.share_of(Way::Reflected), place.lost)
            } else if events > 0.0 {
                (1.0 - passed, Fate::CutOff)
            } else {
                (0.0, Fate::Absorbed)
            };
            for (share, fate) in [(cut, Fate::CutOff), (1.0 - passed - cut, fate)] {
                if share > 0.0 {
                    sink.ended(flight.signature, fate, flight.flux * share);
                }
            }
        }
        if passed > 0.0 {
            let flux = flight.flux * passed;
            self.along(flight, flux, Way::Passed, interaction, place, sink)
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
        place: Place,
        sink: &mut impl ChainSink<N>,
    ) -> Option<Flight<N>> {
        let value_of = |color: &Color| match color {
            Color::Constant(value) => *value,
            _ => self.looked_up(*color, place),
        };
        let branch = interaction.branch_tinted(way, value_of)?;
        Some(self.leave(flight, flux, &branch, way.event(), place, sink))
    }

    /// A factor that varies over its surface.
    ///
    /// Out of line: scenes without textured interfaces are not to pay for it.
    #[cold]
    #[inline(never)]
    fn looked_up(&self, color: Color, place: Place) -> Rgb {
        let point = self.scene.world().with_uv(*place.point, place.hit);
        self.scene
            .color(color, &TexturePoint::new(self.scene, place.hit, &point))
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
        place: Place,
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
            ray: place.point.spawn(branch.direction),
            flux: leaving,
            signature: event.map_or(flight.signature, |event| flight.signature.then(event)),
            passes: flight.passes + u32::from(event.is_none()),
            medium: if self.is_clear {
                MediumId::CLEAR
            } else {
                let n = place.point.geometric_normal;
                self.scene
                    .medium_beyond(place.hit.shape, n, branch.direction, flight.medium)
            },
            choices: flight.choices,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::{Stream, StreamKind};
    use glam::DVec3;

    /// All reports, with the bits of their numbers.
    #[derive(Default)]
    struct Reports(Vec<(&'static str, Signature, Vec<u64>)>);

    impl Reports {
        fn add(&mut self, kind: &'static str, signature: Signature, flux: Flux<1>, place: DVec3) {
            let numbers = [flux.0[0], place.x, place.y, place.z].map(f64::to_bits);
            self.0.push((kind, signature, numbers.to_vec()));
        }

        fn in_order(mut self) -> Vec<(&'static str, Signature, Vec<u64>)> {
            self.0.sort();
            self.0
        }
    }

    impl ChainSink<1> for Reports {
        fn emitted(&mut self, flux: Flux<1>) {
            self.add("emitted", Signature::DIRECT, flux, DVec3::ZERO);
        }

        fn arrived(&mut self, arrival: &Arrival<1>, _: &mut TraversalCounters) -> Fate {
            let place = arrival.point.position;
            self.add("arrived", arrival.signature, arrival.flux, place);
            Fate::Received
        }

        fn ended(&mut self, signature: Signature, _: Fate, flux: Flux<1>) {
            self.add("ended", signature, flux, DVec3::ZERO);
        }

        fn gained(&mut self, flux: Flux<1>) {
            self.add("gained", Signature::DIRECT, flux, DVec3::ZERO);
        }
    }

    #[test]
    fn photons_followed_together_bring_what_each_brings_alone() {
        // Those in a narrow cone through faces go down the tree in packets.
        together_and_alone("glass-ball", 1.0, 0.0);
        together_and_alone("glass-ball-mesh", 0.02, 0.1);
    }

    /// Of a shipped scene, with photons in a cone so much as wide as its ball and tilted.
    fn together_and_alone(name: &str, wide: f64, tilt: f64) {
        let file = std::path::PathBuf::from(format!("scenes/{name}.xml"));
        let scene = crate::mitsuba::load(&file, &[]).expect("a shipped scene loads");
        let lamp = DVec3::new(0.0, 0.0, 4.0);
        let stream = Stream::new(StreamKind::Sobol, 1);
        // Some have no flux: they are not followed.
        let photons: Vec<Emitted<1>> = (0..500)
            .map(|index| {
                let [x, y] = stream.point2(index);
                // Within the ball's outline and a little beyond.
                let [across, along] = [x, y].map(|share| 0.9 * wide * (share - 0.5));
                let direction = DVec3::new(across + tilt, along + tilt, -1.0);
                let ray = Ray::new(lamp, direction.normalize());
                let flux = Flux([if index % 7 == 0 { 0.0 } else { 1.0 + x }]);
                let choices = stream.extras(index);
                Emitted { ray, flux, choices }
            })
            .collect();
        for split_depth in [0, 2, 16] {
            let settings = ChainSettings {
                split_depth,
                ..ChainSettings::default()
            };
            let (mut together, mut alone) = (Reports::default(), Reports::default());
            let mut tracer = ChainTracer::new(&scene, settings);
            tracer.trace_all(photons.iter().copied(), &mut together);
            let counters = std::mem::take(&mut tracer.counters);
            for light in &photons {
                tracer.trace(light, &mut alone);
            }
            let [rays, expected] = [counters, tracer.counters].map(|it| it.rays);
            assert_eq!(rays, expected, "{name}, split depth {split_depth}");
            // Only in packets are nodes visited together.
            let [few, many] = [counters, tracer.counters].map(|it| it.node_visits);
            assert_eq!(few < many, wide < 1.0, "{name}: {few} visits, {many} alone");
            let events = alone.0.iter().filter(|it| it.1.len() >= 2).count();
            assert!(events > 400, "only {events} reports from behind the glass");
            assert_eq!(together.in_order(), alone.in_order());
        }
    }
}
