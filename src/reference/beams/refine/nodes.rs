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
    /// source and the surface, `with_legs` if the clearance is likely to need the path's
    /// [trail](Self::trail).
    #[inline]
    pub fn node(
        &mut self,
        store: &mut PathStore<N>,
        chart: &SurfaceChart,
        at: DVec2,
        in_sight: bool,
        with_legs: bool,
    ) -> BeamNode<N> {
        self.found(chart, at, |follower, chart, at| {
            store.path(follower, chart, at, in_sight, with_legs)
        })
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
        self.found(chart, at, |follower, chart, at| {
            store.trail(follower, chart, at, in_sight, trail)
        });
    }

    /// The node at coordinates of a chart, by `follow`. That is asked for the path of the face that owns the
    /// place. If the chart's own face parts from that, it is asked again, for the chart's own path.
    #[inline]
    fn found(
        &mut self,
        chart: &SurfaceChart,
        at: DVec2,
        mut follow: impl FnMut(&mut PathFollower<'a, N>, &SurfaceChart, DVec2) -> PathEnd<N>,
    ) -> BeamNode<N> {
        let (owner, place) = self.shared.owner(self.follower.source(), chart, at);
        let mut path = follow(&mut self.follower, &owner, place);
        if owner.face() != chart.face() {
            // The light that sets out is for a unit of the chart's own area.
            match self.follower.emitted_alike(chart, at, &path) {
                Some(emitted) => path.emitted = emitted,
                None => path = follow(&mut self.follower, chart, at),
            }
        }
        BeamNode {
            at,
            landing: match path.end {
                End::Landed(landing) => Some(landing),
                _ => None,
            },
            turned_back: path.end == End::TurnedBack,
            weight: path.throughput * path.emitted,
            emitted: path.emitted * self.strength,
            topology: path.topology,
            faces: path.faces,
        }
    }
}
