//! The source of cells' nodes: paths that are followed or remembered.

use glam::DVec2;

use crate::reference::beams::cell::BeamNode;
use crate::reference::beams::store::PathStore;
use crate::transport::clearance::Trail;
use crate::transport::first_surface::{SharedPlaces, SurfaceChart};
use crate::transport::fixed_signature::{PathEnd, PathFollower};
use crate::transport::path_end::End;

/// Finder of nodes: it follows paths of one source and one signature, or remembers them.
pub struct NodeFinder<'a, const N: usize> {
    /// The follower of the paths.
    pub follower: PathFollower<'a, N>,
    shared: &'a SharedPlaces<'a>,
    /// Strength of the source, mean of channels.
    strength: f64,
}

impl<'a, const N: usize> NodeFinder<'a, N> {
    /// A finder that has found nothing yet.
    pub fn new(follower: PathFollower<'a, N>, shared: &'a SharedPlaces<'a>) -> Self {
        Self {
            strength: follower.source().strength().mean(),
            follower,
            shared,
        }
    }

    /// The node at coordinates of a chart. `in_sight` is true if it is known that nothing is between the
    /// source and the surface.
    #[inline]
    pub fn node(
        &mut self,
        store: &mut PathStore<N>,
        chart: &SurfaceChart,
        at: DVec2,
        in_sight: bool,
    ) -> BeamNode<N> {
        let (owner, place) = self.owner(chart, at);
        let path = store.path(&mut self.follower, &owner, place, in_sight);
        self.seen_on(chart, at, &owner, path)
    }

    /// The same for a cell whose [trails](Self::trail) the clearance is likely to need.
    #[inline]
    pub fn node_with_trail(
        &mut self,
        store: &mut PathStore<N>,
        chart: &SurfaceChart,
        at: DVec2,
        in_sight: bool,
    ) -> BeamNode<N> {
        let (owner, place) = self.owner(chart, at);
        let path = store.path_with_legs(&mut self.follower, &owner, place, in_sight);
        self.seen_on(chart, at, &owner, path)
    }

    /// Writes the trail of the path at coordinates of a chart.
    pub fn trail(
        &mut self,
        store: &mut PathStore<N>,
        chart: &SurfaceChart,
        at: DVec2,
        in_sight: bool,
        trail: &mut Trail,
    ) {
        let (owner, place) = self.owner(chart, at);
        store.trail(&mut self.follower, &owner, place, in_sight, trail);
    }

    #[inline]
    fn owner(&self, chart: &SurfaceChart, at: DVec2) -> (SurfaceChart, DVec2) {
        self.shared.owner(self.follower.source(), chart, at)
    }

    /// A path as a node of a chart: the light that sets out is for a unit of the chart's own area.
    #[inline]
    fn seen_on(
        &self,
        chart: &SurfaceChart,
        at: DVec2,
        owner: &SurfaceChart,
        path: PathEnd<N>,
    ) -> BeamNode<N> {
        let emitted = if owner.face() == chart.face() {
            path.emitted
        } else {
            self.follower.emitted(chart, at)
        };
        BeamNode {
            at,
            landing: match path.end {
                End::Landed(landing) => Some(landing),
                _ => None,
            },
            turned_back: path.end == End::TurnedBack,
            weight: path.throughput * emitted,
            emitted: emitted * self.strength,
            topology: path.topology,
        }
    }
}
