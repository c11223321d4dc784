//! The paths of one place.

use glam::DVec2;

use super::places::StartPlace;
use crate::transport::fixed_signature::PathFollower;
use crate::transport::path_end::End;
use crate::transport::signature::Signature;

/// Part of the light that set out below which flux is not followed any further.
pub(super) const LEAST_THROUGHPUT: f64 = 1e-7;

/// A path that landed.
pub(super) struct LandedPath {
    pub signature: Signature,
    /// Flux \[W\] that it brings for its part of the patch.
    pub flux: f64,
    /// Part of the light that set out which it delivers.
    pub delivered: f64,
    /// Film coordinates of its end, in texels.
    pub at: DVec2,
    /// True if it is on the film, not beside it on the surface's extension.
    pub on_film: bool,
}

/// The paths from one place that land. All branches of the first events are followed, up to a split depth.
/// From there on, up to a depth, [`follow_some`](PathFollower::follow_some) takes one branch of each by
/// `choice`.
pub(super) fn look_at(
    follower: &mut PathFollower<3>,
    place: &StartPlace,
    depths: [u32; 2],
    mut choice: impl FnMut(Signature) -> f64,
) -> Vec<LandedPath> {
    let strength = follower.source().strength().mean();
    let screen = follower.screen();
    let mut found = Vec::new();
    follower.follow_some(
        &place.chart,
        place.at,
        depths,
        LEAST_THROUGHPUT,
        &mut choice,
        &mut |signature, _, path, probability| {
            if let End::Landed(at) = path.end {
                let throughput = path.throughput.rgb().mean();
                found.push(LandedPath {
                    signature,
                    flux: throughput * path.emitted * place.area / probability,
                    delivered: throughput / strength,
                    at,
                    on_film: screen.is_on_film(at),
                });
            }
        },
    );
    found
}
