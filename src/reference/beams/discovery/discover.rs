//! The discovery of a scene.

use rayon::prelude::*;

use super::aim::aim;
use super::found::{Discovery, SignatureLight};
use super::inputs::{DiscoveryInputs, PLACES};
use super::look::{LandedPath, look_at};
use super::places::StartPlace;
use super::rare::look_for_rare;
use crate::transport::signature::Signature;

/// Number of halvings of the way between two places.
const LEVELS_BETWEEN: u32 = 10;

/// Finds the signatures that bring light to the sensor.
///
/// It follows all branches of some thousand paths spread over all first surfaces, and of some more between
/// neighbours that saw different things. Then it follows single branches of as many more as it takes to see
/// rare light.
pub fn discover(inputs: &DiscoveryInputs) -> Discovery {
    let max_depth = inputs.max_depth;
    let most_between = PLACES.div_ceil(inputs.lights.len().max(1));
    let mut all = Discovery::default();
    for light in 0..inputs.lights.len() {
        let look = |place: &StartPlace| {
            let mut follower = inputs.follower(light, Signature::DIRECT);
            look_at(&mut follower, place, [max_depth; 2], |_| 0.0)
        };
        let seen: Vec<PlaceSights> = inputs
            .places(light, PLACES)
            .into_par_iter()
            .map(|place| PlaceSights::new(place, look))
            .collect();
        let between = look_between(&seen, most_between, look);
        for sight in seen.iter().chain(&between).flat_map(|seen| &seen.sights) {
            all.add(sight);
        }
    }
    let (rare, is_enough) = look_for_rare(inputs);
    all.looked.clone_from(&rare.looked);
    all.landed = rare.signatures.values().map(|found| found.flux).sum();
    if !is_enough && rare.is_mostly_beside() {
        // Only light on the film counts. Single paths tell how much that is: places between others stand for
        // less than they may bring.
        let on_film = |(signature, found): (&Signature, &SignatureLight)| {
            let flux = found.on_film;
            let found = SignatureLight {
                flux,
                ..found.clone()
            };
            (flux > 0.0).then_some((*signature, found))
        };
        let seen = std::mem::take(&mut all.signatures);
        all.signatures = rare.signatures.iter().filter_map(on_film).collect();
        let led = aim(inputs, &all);
        all.learn(led.signatures);
        all.learn(seen.iter().filter_map(on_film).collect());
    } else {
        all.learn(rare.signatures);
        if !is_enough {
            let led = aim(inputs, &all);
            all.learn(led.signatures);
        }
    }
    all
}

/// A place, and all paths from there that landed, in the order of their signatures.
struct PlaceSights {
    place: StartPlace,
    sights: Vec<LandedPath>,
}

impl PlaceSights {
    fn new(place: StartPlace, look: impl Fn(&StartPlace) -> Vec<LandedPath>) -> Self {
        let mut sights = look(&place);
        sights.sort_by_key(|sight| sight.signature);
        Self { place, sights }
    }

    /// True if another place sent light to the sensor by the same signatures.
    fn agrees(&self, other: &Self) -> bool {
        let theirs = other.sights.iter().map(|sight| sight.signature);
        self.sights.iter().map(|sight| sight.signature).eq(theirs)
    }
}

/// Places between others, and their paths, for signatures that set out from a sliver of light space only.
///
/// If two neighbouring places saw different signatures, a third is tried between them, and so on, to some
/// thousandths of their distance; `most` in all.
fn look_between(
    seen: &[PlaceSights],
    most: usize,
    look: impl Fn(&StartPlace) -> Vec<LandedPath> + Sync,
) -> Vec<PlaceSights> {
    let mut found: Vec<PlaceSights> = Vec::new();
    // Indices count through both, one after the other.
    let mut pairs: Vec<[usize; 2]> = (1..seen.len()).map(|index| [index - 1, index]).collect();
    for _ in 0..LEVELS_BETWEEN {
        pairs.retain(|[a, b]| {
            let (a, b) = (at(*a, seen, &found), at(*b, seen, &found));
            a.place.chart.is_that_of(&b.place.chart) && !a.agrees(b)
        });
        let left = most.saturating_sub(found.len());
        if pairs.is_empty() || left == 0 {
            break;
        }
        // If there are too many, every n-th will do.
        let stride = pairs.len().div_ceil(left);
        let pairs_now: Vec<[usize; 2]> = pairs.iter().copied().step_by(stride).collect();
        let middles: Vec<PlaceSights> = pairs_now
            .par_iter()
            .map(|[a, b]| {
                PlaceSights::new(
                    at(*a, seen, &found)
                        .place
                        .halfway(&at(*b, seen, &found).place),
                    &look,
                )
            })
            .collect();
        pairs.clear();
        for ([a, b], middle) in pairs_now.into_iter().zip(middles) {
            let index = seen.len() + found.len();
            found.push(middle);
            pairs.extend([[a, index], [index, b]]);
        }
    }
    found
}

/// The element of two slices, counted through both.
fn at<'a>(index: usize, first: &'a [PlaceSights], second: &'a [PlaceSights]) -> &'a PlaceSights {
    first
        .get(index)
        .unwrap_or_else(|| &second[index - first.len()])
}
