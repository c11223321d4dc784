//! Light along a given chain of facets.

use glam::DVec2;

use super::table::{Facet, Facets};
use crate::geometry::Ray;
use crate::scene::Scene;
use crate::transport::first_surface::Source;
use crate::transport::fixed_signature::leave;
use crate::transport::flux::Flux;
use crate::transport::scatter::ShadingNormals;
use crate::transport::signature::{Event, MAX_EVENTS, Signature};

/// Light on one leg of its path.
#[derive(Clone, Copy, Debug)]
pub struct FacetLight<const N: usize> {
    /// Its coordinates on the first facet.
    pub at: DVec2,
    /// The leg: from the emitter to the first facet, or from the facet it left last.
    pub ray: Ray,
    /// The fraction (0..=1) of its flux that is left.
    pub throughput: Flux<N>,
    /// Flux \[W\] that set out for a unit of coordinate area, in units of the source's strength.
    pub emitted: f64,
    /// History of the path: equal numbers for light of one smooth topology.
    ///
    /// The least bit is 1 while the light is on its way. Above it is one bit an event, the last event lowest.
    /// It is 1 if all light took the way of the event, 0 if a part did.
    pub state: u128,
}

// The longest path needs one bit an event, and the least bit.
const _: () = assert!(MAX_EVENTS < u128::BITS as usize);

impl<const N: usize> FacetLight<N> {
    /// The [state](Self::state) in 64 bits: unchanged for paths of up to 63 events, mixed for longer ones.
    #[inline]
    pub fn topology(&self) -> u64 {
        let [low, high] = [0, 64].map(|shift| (self.state >> shift) as u64);
        low ^ high.wrapping_mul(0x9e37_79b9_7f4a_7c15)
    }

    /// True if the light did not end before this leg.
    #[inline]
    pub fn is_on_its_way(&self) -> bool {
        self.state & 1 == 1
    }

    fn stop(mut self) -> Self {
        self.state &= !1;
        self.throughput = Flux::BLACK;
        self
    }
}

/// The facets that light met, and the events that it had there.
#[derive(Clone, Debug)]
pub struct FacetChain {
    /// The first one from the start on, before the light gets there.
    facets: Vec<u32>,
    events: Signature,
}

impl FacetChain {
    /// That of light on its way from the emitter to its first facet.
    pub fn to(facet: u32) -> Self {
        Self {
            facets: vec![facet],
            events: Signature::DIRECT,
        }
    }

    /// The first facet.
    #[inline]
    pub fn first(&self) -> u32 {
        self.facets[0]
    }

    /// Number of events so far.
    #[inline]
    pub fn events(&self) -> usize {
        self.events.len()
    }

    /// The facet that the light left last; `None` if it comes from the emitter.
    #[inline]
    pub fn left(&self) -> Option<u32> {
        Some(self.facets[self.events().checked_sub(1)?])
    }

    /// Adds an event. The first one is on the first facet.
    pub fn push(&mut self, facet: u32, event: Event) {
        if self.events() > 0 {
            self.facets.push(facet);
        }
        self.events = self.events.then(event);
    }
}

/// Follower of light of one source along chains of facets.
#[derive(Debug)]
pub struct FacetPaths<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The light's source.
    pub source: &'a Source,
    /// The facets of the scene.
    pub facets: &'a Facets,
    /// Effect of interpolated normals on flux.
    pub shading_normals: ShadingNormals,
}

impl FacetPaths<'_> {
    /// The light that falls onto the first facet at `at`, on the leg after a chain's events.
    #[inline]
    pub fn follow<const N: usize>(&self, chain: &FacetChain, at: DVec2) -> FacetLight<N> {
        let mut light = self.arrive(chain.first(), at);
        let events = chain.events.events().zip(&chain.facets);
        for (number, (event, &facet)) in events.enumerate() {
            light = self.after(&light, number == 0, facet, event);
        }
        light
    }

    /// The light that arrives at the first facet at `at`.
    #[inline]
    fn arrive<const N: usize>(&self, facet: u32, at: DVec2) -> FacetLight<N> {
        let facet = self.facets.get(facet);
        let point = facet.point(at);
        let arrival = self.source.arrive(point.position);
        let mut light = FacetLight {
            at,
            ray: Ray {
                origin: point.position,
                direction: -point.geometric_normal,
            },
            throughput: Flux::WHITE,
            emitted: 0.0,
            state: 1,
        };
        let Some(arrival) = arrival else {
            return light.stop();
        };
        light.ray = arrival.ray;
        let facing = arrival.ray.direction.dot(point.geometric_normal).abs();
        light.emitted = arrival.density * facing * facet.unit_area();
        light
    }

    /// The light of a chain after one event more, on a facet that its leg meets.
    #[inline]
    pub fn onward<const N: usize>(
        &self,
        light: &FacetLight<N>,
        chain: &FacetChain,
        facet: u32,
        event: Event,
    ) -> FacetLight<N> {
        self.after(light, chain.events() == 0, facet, event)
    }

    #[inline]
    fn after<const N: usize>(
        &self,
        light: &FacetLight<N>,
        is_first: bool,
        facet: u32,
        event: Event,
    ) -> FacetLight<N> {
        if !light.is_on_its_way() {
            return *light;
        }
        let facet: &Facet = self.facets.get(facet);
        let met = if is_first {
            Some(facet.point(light.at))
        } else {
            facet.meet(&light.ray)
        };
        let Some(point) = met else {
            return light.stop();
        };
        let Some((share, branch)) = leave(
            self.scene,
            facet.shape(),
            &point,
            light.ray.direction,
            event,
            self.shading_normals,
        ) else {
            return light.stop();
        };
        FacetLight {
            at: light.at,
            ray: Ray {
                origin: point.position,
                direction: branch.direction,
            },
            throughput: light.throughput * branch.tint * share,
            emitted: light.emitted,
            // All of the light goes on, or a part does: a kink is between them.
            state: (light.state >> 1) << 2 | u128::from(share == 1.0) << 1 | 1,
        }
    }

    /// The light's leg as a ray to search with: it starts off the facet that it leaves.
    #[inline]
    pub fn search_ray<const N: usize>(&self, light: &FacetLight<N>, chain: &FacetChain) -> Ray {
        let Some(left) = chain.left() else {
            return light.ray;
        };
        let facet = self.facets.get(left);
        // Put back onto the facet: the bound on its position's error is for such points.
        facet
            .point(facet.coordinates(light.ray.origin))
            .spawn(light.ray.direction)
    }
}
