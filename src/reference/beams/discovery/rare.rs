//! Signatures that bring little light.

use rayon::prelude::*;

use super::found::Discovery;
use super::inputs::{DiscoveryInputs, PLACES};
use super::look::{LandedPath, look_at};
use super::places::StartPlace;
use crate::numeric::{Stream, StreamKind};
use crate::radiometry::Rgb;
use crate::transport::signature::Signature;

/// Number of places that must send light to the film. If one in a thousand of these landings is of a
/// signature, eight are expected; the signature is missed with a probability of about e⁻⁸.
const LANDINGS: usize = 1 << 13;

/// Most rounds: of about 2¹³, 2¹⁴ and 2¹⁵ places. All branches from 2¹² were followed before.
const ROUNDS: u32 = 3;

/// Events up to which every branch is followed.
const SPLIT_DEPTH: u32 = 2;

/// Key of the stream of the branches' choices.
const SEED: u64 = 0x5352_5645_5900;

/// The signatures that single paths from ever more places show, and true if enough of them landed on the
/// film.
///
/// Each round spreads its places over all first surfaces anew, twice as many as the round before. The last
/// round that saw a signature tells its flux. If only an earlier one saw it, that is too much rather than too
/// little.
pub(super) fn look_for_rare(inputs: &DiscoveryInputs) -> (Discovery, bool) {
    let mut all = Discovery::default();
    let mut landed = 0;
    for count in (1..=ROUNDS).map(|round| PLACES << round) {
        if landed >= LANDINGS {
            break;
        }
        let mut round = Discovery::default();
        for index in 0..inputs.lights.len() {
            let stream = Stream::new(StreamKind::Random, SEED)
                .split(count as u64)
                .split(index as u64);
            let places = inputs.places(index, count);
            let shapes = places.chunk_by(|a, b| a.chart.shape() == b.chart.shape());
            for places in shapes {
                let shape = (index, places[0].chart.shape());
                let known = all.looked.entry(shape).or_default();
                known.set_out = set_out(inputs, index, places);
                known.places += places.len() as u64;
            }
            let look = |(number, place): (usize, &StartPlace)| {
                let mut follower = inputs.follower(index, Signature::DIRECT);
                let depths = [SPLIT_DEPTH, inputs.max_depth];
                look_at(&mut follower, place, depths, |signature| {
                    stream.extra(number as u64, signature.key())
                })
            };
            let seen: Vec<Vec<LandedPath>> = places.par_iter().enumerate().map(look).collect();
            let lands = |sights: &&Vec<LandedPath>| sights.iter().any(|sight| sight.on_film);
            landed += seen.iter().filter(lands).count();
            for sight in seen.iter().flatten() {
                round.add(sight);
            }
        }
        for (signature, mut found) in round.signatures {
            // A later round may have seen it fall beside the film only.
            if let Some(before) = all.signatures.get(&signature) {
                found.peak = found.peak.max(before.peak);
                if found.on_film == 0.0 {
                    (found.on_film, found.landings) = (before.on_film, before.landings.clone());
                }
            }
            all.signatures.insert(signature, found);
        }
    }
    (all, landed >= LANDINGS)
}

/// Flux \[W\] that sets out to the first surfaces that places stand for.
fn set_out(inputs: &DiscoveryInputs, light: usize, places: &[StartPlace]) -> Rgb {
    let (world, source) = (inputs.scene.world(), &inputs.lights[light].source);
    let emitted =
        |place: &StartPlace| Some(place.chart.emitted(world, source, place.at)? * place.area);
    let by_strength: f64 = places.iter().filter_map(emitted).sum();
    source.strength() * by_strength
}
