//! Which path signatures bring light to the sensor.

mod aim;
mod faces;
mod places;
mod rare;

use std::collections::BTreeMap;

use rayon::prelude::*;

use self::aim::aim;
use self::rare::look_for_rare;
use super::pass::Light;
use crate::radiometry::Rgb;
use crate::scene::Scene;
use crate::transport::fixed_signature::{End, PathFollower};
use crate::transport::scatter::ShadingNormals;
use crate::transport::screen::Screen;
use crate::transport::signature::Signature;
use places::{Place, places_of};

/// About how many places of the first surfaces are looked at.
const PLACES: usize = 1 << 12;

/// ... and on each shape, all lights together: a small thing beside a large mesh has its own.
const LEAST_PLACES: usize = 1 << 7;

/// How often the way between two places is halved.
const LEVELS_BETWEEN: u32 = 10;

/// Where less than this part of the light that lands is on the film, the rest is not what errors are measured by.
const MOSTLY_BESIDE: f64 = 1.0 / 16.0;

/// Flux below this part of what set out is not followed any further.
const LEAST_THROUGHPUT: f64 = 1e-7;

/// What a discovery saw of one signature.
#[derive(Clone, Copy, Debug, Default)]
pub struct Found {
    /// About how much flux it brings \[W\], mean of channels.
    pub flux: f64,
    /// The most that a path delivers of what sets out.
    pub peak: f64,
    /// What of it falls on the film, not beside it \[W\].
    pub on_film: f64,
}

/// What a discovery saw.
#[derive(Clone, Debug, Default)]
pub struct Discovery {
    /// What each signature brings to the sensor's surface.
    pub signatures: BTreeMap<Signature, Found>,
    /// About the flux that lands on the film and beside it \[W\].
    pub landed: f64,
    /// How closely single paths were followed from each light to each shape, by their indices.
    pub looked: BTreeMap<(usize, u32), Looked>,
}

/// How closely a shape was looked at.
#[derive(Clone, Copy, Debug, Default)]
pub struct Looked {
    /// About the flux that sets out to it \[W\].
    pub set_out: Rgb,
    /// How many places on it.
    pub places: u64,
}

/// Follows all branches of some thousand paths spread over all first surfaces, of some more
/// between neighbours of them that saw different things, and single branches of as many more as it takes to
/// see rare light.
pub fn discover(
    scene: &Scene,
    lights: &[Light],
    screen: &Screen,
    max_depth: u32,
    shading_normals: ShadingNormals,
) -> Discovery {
    let places = PLACES.div_ceil(lights.len().max(1));
    let mut all = Discovery::default();
    for light in lights {
        let source = &light.source;
        let look = |place: &Place| {
            let mut follower =
                PathFollower::<3>::new(scene, source, screen, Signature::DIRECT, shading_normals);
            look_at(&mut follower, place, [max_depth; 2], |_| 0.0)
        };
        let least = LEAST_PLACES / lights.len();
        let seen: Vec<Seen> = places_of(scene, light, places, least)
            .into_par_iter()
            .map(|place| Seen::new(place, look))
            .collect();
        let between = look_between(&seen, places, look);
        for sight in seen.iter().chain(&between).flat_map(|seen| &seen.sights) {
            all.add(sight);
        }
    }
    let (rare, is_enough) = look_for_rare(scene, lights, screen, max_depth, shading_normals);
    all.looked.clone_from(&rare.looked);
    all.landed = rare.signatures.values().map(|found| found.flux).sum();
    if !is_enough && rare.is_mostly_beside() {
        // Only what falls on the film counts. Single paths tell how much that is: places between others stand for less
        // than they may bring.
        let on_film = |(signature, found): (&Signature, &Found)| {
            let flux = found.on_film;
            (flux > 0.0).then_some((*signature, Found { flux, ..*found }))
        };
        let seen = std::mem::take(&mut all.signatures);
        all.signatures = rare.signatures.iter().filter_map(on_film).collect();
        let led = aim(scene, lights, screen, max_depth, shading_normals, &all);
        all.learn(led.signatures);
        all.learn(seen.iter().filter_map(on_film).collect());
    } else {
        all.learn(rare.signatures);
        if !is_enough {
            let led = aim(scene, lights, screen, max_depth, shading_normals, &all);
            all.learn(led.signatures);
        }
    }
    all
}

impl Discovery {
    /// The flux \[W\] that the discovery may have missed with a probability of `risk` a shape, where it saw none.
    ///
    /// Half of a shape's places are spread by light: a part p of what sets out to it is missed by n of them with a probability of
    /// (1 − p/2)ⁿ at most, as far as a first surface's corners say how much light falls on it.
    pub fn unseen(&self, risk: f64) -> Rgb {
        let missed = self.looked.values().map(|one| {
            let part = 2.0 * (1.0 - risk.powf(1.0 / one.places.max(1) as f64));
            one.set_out * part.min(1.0)
        });
        missed.sum()
    }

    /// Whether nearly all light falls beside the film.
    fn is_mostly_beside(&self) -> bool {
        let sum = |of: fn(&Found) -> f64| self.signatures.values().map(of).sum::<f64>();
        sum(|found| found.on_film) <= MOSTLY_BESIDE * sum(|found| found.flux)
    }

    /// Takes over what was not known yet.
    fn learn(&mut self, signatures: BTreeMap<Signature, Found>) {
        for (signature, found) in signatures {
            let known = self.signatures.entry(signature).or_insert(found);
            known.peak = known.peak.max(found.peak);
            known.on_film = known.on_film.max(found.on_film);
        }
    }

    /// Floats are summed: always in the order of places, the same on any threads.
    fn add(&mut self, sight: &Sight) {
        let one = self.signatures.entry(sight.signature).or_default();
        one.flux += sight.flux;
        one.peak = one.peak.max(sight.delivered);
        one.on_film += if sight.on_film { sight.flux } else { 0.0 };
    }
}

/// A path that landed.
struct Sight {
    signature: Signature,
    /// What it brings for its part of the patch \[W\].
    flux: f64,
    /// What it delivers of what sets out.
    delivered: f64,
    /// Not beside the film, on the surface's extension.
    on_film: bool,
}

/// A place, and all paths from there that landed, in the order of their signatures.
struct Seen {
    place: Place,
    sights: Vec<Sight>,
}

impl Seen {
    fn new(place: Place, look: impl Fn(&Place) -> Vec<Sight>) -> Self {
        let mut sights = look(&place);
        sights.sort_by_key(|sight| sight.signature);
        Self { place, sights }
    }

    /// Whether another place sent light to the sensor by the same events.
    fn agrees(&self, other: &Self) -> bool {
        let theirs = other.sights.iter().map(|sight| sight.signature);
        self.sights.iter().map(|sight| sight.signature).eq(theirs)
    }
}

/// Paths by a signature may set out from a sliver of light space only, between others: where two
/// neighbouring places saw different things, a third is looked at between them, and so on, to some
/// thousandths of their distance; `most` in all.
fn look_between(
    seen: &[Seen],
    most: usize,
    look: impl Fn(&Place) -> Vec<Sight> + Sync,
) -> Vec<Seen> {
    let mut found: Vec<Seen> = Vec::new();
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
        // Where there are too many, every so many-th will do.
        let stride = pairs.len().div_ceil(left);
        let pairs_now: Vec<[usize; 2]> = pairs.iter().copied().step_by(stride).collect();
        let middles: Vec<Seen> = pairs_now
            .par_iter()
            .map(|[a, b]| {
                Seen::new(
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
fn at<'a>(index: usize, first: &'a [Seen], second: &'a [Seen]) -> &'a Seen {
    first
        .get(index)
        .unwrap_or_else(|| &second[index - first.len()])
}

/// The paths from one place that land: all branches of the first events, up to a split depth, and from there on
/// one branch of each, that [`follow_some`](PathFollower::follow_some) takes by `choice`, up to a depth.
fn look_at(
    follower: &mut PathFollower<3>,
    place: &Place,
    depths: [u32; 2],
    mut choice: impl FnMut(Signature) -> f64,
) -> Vec<Sight> {
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
                found.push(Sight {
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
