//! Signatures that bring little light.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::places::{Place, places_of};
use super::{Found, LEAST_PLACES, LEAST_THROUGHPUT, PLACES};
use crate::numeric::{Stream, StreamKind};
use crate::reference::beams::pass::Light;
use crate::scene::Scene;
use crate::transport::prescribed::{End, PathFollower};
use crate::transport::scatter::ShadingNormals;
use crate::transport::screen::Screen;
use crate::transport::signature::Signature;

/// Enough light has landed once so many places sent some: of a signature that one in a thousand of these
/// landings has, eight are expected; none is seen with a probability of about e⁻⁸.
const LANDINGS: usize = 1 << 13;

/// Rounds at most: of about 2¹³, 2¹⁴ and 2¹⁵ places. All branches from 2¹² were followed before.
const ROUNDS: u32 = 3;

/// Events up to which every branch is followed.
const SPLIT_DEPTH: u32 = 2;

/// Of which stream choices of branches are.
const SEED: u64 = 0x5352_5645_5900;

/// What single paths from ever more places show.
///
/// Each round spreads its places over all first surfaces anew, twice as many as the round before. The last that saw a signature
/// tells its flux: of what only an earlier one saw, that is too much rather than too little.
pub(super) fn look_for_rare(
    scene: &Scene,
    lights: &[Light],
    screen: &Screen,
    max_depth: u32,
    shading_normals: ShadingNormals,
) -> BTreeMap<Signature, Found> {
    let mut all = BTreeMap::new();
    let mut landed = 0;
    for count in (1..=ROUNDS).map(|round| PLACES << round) {
        if landed >= LANDINGS {
            break;
        }
        let mut round: BTreeMap<Signature, Found> = BTreeMap::new();
        for (index, light) in lights.iter().enumerate() {
            let stream = Stream::new(StreamKind::Random, SEED)
                .split(count as u64)
                .split(index as u64);
            let each = count.div_ceil(lights.len());
            let least = LEAST_PLACES / lights.len();
            let places = places_of(scene, light, each, least);
            let look = |(index, place): (usize, &Place)| {
                let source = &light.source;
                let mut follower = PathFollower::<3>::new(
                    scene,
                    source,
                    screen,
                    Signature::DIRECT,
                    shading_normals,
                );
                look_at(&mut follower, place, max_depth, |signature| {
                    stream.extra(index as u64, signature.len() as u32)
                })
            };
            let seen: Vec<Vec<(Signature, Found)>> =
                places.par_iter().enumerate().map(look).collect();
            let strength = light.source.strength().mean();
            landed += seen.iter().filter(|sights| !sights.is_empty()).count();
            // In the order of places: the same sums on any threads.
            for (signature, found) in seen.into_iter().flatten() {
                let one = round.entry(signature).or_default();
                one.flux += found.flux;
                one.peak = one.peak.max(found.peak / strength);
            }
        }
        all.extend(round);
    }
    all
}

/// What one path from a place, or some that share their first events, brings to the sensor.
fn look_at(
    follower: &mut PathFollower<3>,
    place: &Place,
    max_depth: u32,
    mut choice: impl FnMut(Signature) -> f64,
) -> Vec<(Signature, Found)> {
    let mut found = Vec::new();
    follower.follow_some(
        &place.chart,
        place.at,
        [SPLIT_DEPTH, max_depth],
        LEAST_THROUGHPUT,
        &mut choice,
        &mut |signature, path, probability| {
            if matches!(path.end, End::Landed(_)) {
                let throughput = path.throughput.rgb().mean();
                let flux = throughput * path.emitted * place.area / probability;
                let peak = throughput;
                found.push((signature, Found { flux, peak }));
            }
        },
    );
    found
}
