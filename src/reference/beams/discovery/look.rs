//! The paths of one place.

use super::places::StartPlace;
use crate::transport::fixed_signature::PathFollower;
use crate::transport::path_end::End;
use crate::transport::signature::Signature;

/// Flux below this part of what set out is not followed any further.
pub(super) const LEAST_THROUGHPUT: f64 = 1e-7;

/// A path that landed.
pub(super) struct LandedPath {
    pub signature: Signature,
    /// What it brings for its part of the patch \[W\].
    pub flux: f64,
    /// What it delivers of what sets out.
    pub delivered: f64,
    /// Not beside the film, on the surface's extension.
    pub on_film: bool,
}

/// The paths from one place that land: all branches of the first events, up to a split depth, and from there on
/// one branch of each, that [`follow_some`](PathFollower::follow_some) takes by `choice`, up to a depth.
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
                    on_film: screen.is_on_film(at),
                });
            }
        },
    );
    found
}
