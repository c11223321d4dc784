//! Advice on slabs and faces (beyond the paper), from a few photons whose ways are traced.
//!
//! Algorithm 1 meets two surfaces of a slab: first the one nearest to the entry, then the farthest. So light
//! is lost to S slabs if on its true way
//!
//! - its first event in a slab is not on the nearest surface of its column, or the second not on the farthest,
//! - it has a third event in a slab,
//! - or it goes back into an earlier slab (but for `sweep=exact`).
//!
//! What else goes wrong is not counted: an event that pictures have and the true way has not, and the texels
//! of pictures. So the share is what S slabs lose at least.

use glam::DVec3;
use rayon::prelude::*;

use super::buffers::Slab;
use super::cuboid::Face;
use super::demands::Volume;
use super::emission::lattices;
use super::ledger::Tally;
use super::meeting::{Meeting, Optics};
use super::photon::Photon;
use super::settings::Settings;
use super::slab::first_by_rays;
use super::variants::{Layers, Splat, Sweep};
use super::work::Work;
use crate::geometry::TraversalCounters;
use crate::scene::Scene;

/// Photons of the pilot at most: shares of 1 % have a standard deviation of 0.3 %.
pub const PHOTONS: u32 = 1024;

/// Slabs that are tried.
pub const SLABS: usize = 8;

/// The share of light from which on a loss is worth a word.
const WORTH: f64 = 0.01;

/// The true way of a photon through the volume.
#[derive(Clone, Debug)]
struct Path {
    /// Where it begins, and its events: local points.
    start: DVec3,
    events: Vec<DVec3>,
    /// \[W\], the mean of channels.
    flux: f64,
    /// Where it leaves, and by which face; `None` if it lands inside.
    left: Option<(DVec3, Face)>,
}

/// Photons whose true ways through a volume are known.
#[derive(Debug)]
pub struct Pilot<'a> {
    scene: &'a Scene,
    settings: &'a Settings,
    volume: &'a Volume,
    /// How many set out.
    photons: u64,
    /// Of light that meets something that mirrors or refracts.
    paths: Vec<Path>,
}

impl<'a> Pilot<'a> {
    /// Traces photons of a volume, as its stages `emission` and `interface` make them.
    pub fn new(scene: &'a Scene, settings: &'a Settings, volume: &'a Volume) -> Self {
        let own = Settings {
            photons: settings.photons.min(PHOTONS),
            // Beams follow all ways; photons one by lot, after some events.
            splat: Splat::Quads,
            ..settings.clone()
        };
        let optics = Optics {
            scene,
            settings: &own,
        };
        let whole = slab(scene, volume, &own, [0.0, volume.cuboid.size().z]);
        let mut photons = Vec::new();
        for lattice in lattices(scene, &own, volume) {
            let mut work = Work::default();
            photons.extend((0..lattice.cells()).filter_map(|cell| lattice.cell(cell, &mut work)));
        }
        // In the order of photons: sums are the same bits on any threads.
        let paths: Vec<Vec<Path>> = photons
            .par_iter()
            .map(|photon| ways(&optics, &whole, photon))
            .collect();
        Self {
            scene,
            settings,
            volume,
            photons: photons.len() as u64,
            paths: paths.into_iter().flatten().collect(),
        }
    }

    /// Photons that were traced.
    pub fn photons(&self) -> u64 {
        self.photons
    }

    /// The share of light that paths have of which something is true.
    fn share(&self, is_so: impl Fn(&Path) -> bool + Sync) -> f64 {
        let flux = |path: &Path| if is_so(path) { path.flux } else { 0.0 };
        let some: Vec<f64> = self.paths.par_iter().map(flux).collect();
        let all: f64 = self.paths.iter().map(|path| path.flux).sum();
        if all > 0.0 {
            some.iter().sum::<f64>() / all
        } else {
            0.0
        }
    }

    /// The share of light that a number of slabs loses at least, by two surfaces a slab.
    pub fn lost(&self, slabs: usize) -> f64 {
        let cuboid = &self.volume.cuboid;
        let all: Vec<Slab> = (0..slabs)
            .map(|index| {
                let depths = cuboid.slab(index, slabs);
                slab(self.scene, self.volume, self.settings, depths)
            })
            .collect();
        self.share(|path| !self.is_held(path, &all))
    }

    /// True if slabs have all events of a path, in their order.
    fn is_held(&self, path: &Path, slabs: &[Slab]) -> bool {
        /// What depths of the same surface differ by at most, by the volume's diagonal.
        const SAME: f64 = 1e-6;
        let cuboid = &self.volume.cuboid;
        let same = SAME * cuboid.diagonal();
        let is_once = self.settings.sweep == Sweep::Once;
        let mut at = cuboid.slab_at(path.start.z, slabs.len());
        let mut events = 0;
        let is_met = path.events.iter().all(|event| {
            let next = cuboid.slab_at(event.z, slabs.len());
            if next < at && is_once {
                return false;
            }
            if next != at {
                (at, events) = (next, 0);
            }
            events += 1;
            if events > 2 {
                return false;
            }
            let place = slabs[at].place(*event);
            let mut work = Work::default();
            let met = slabs[at].asked(place.truncate(), events == 2, &mut work);
            met.is_some_and(|met| (met.depth - place.z).abs() < same)
        });
        let goes_back = |place: DVec3| is_once && cuboid.slab_at(place.z, slabs.len()) < at;
        is_met && !path.left.is_some_and(|(place, _)| goes_back(place))
    }

    /// The share of light that leaves by each face; what is left of 1 lands inside.
    pub fn faces(&self) -> [f64; 6] {
        Face::ALL.map(|face| self.share(|path| path.left.is_some_and(|it| it.1 == face)))
    }

    /// What the settings lose more than 1 % of the light by, in a sentence each, with what would lose less.
    pub fn advice(&self) -> Vec<String> {
        let mut said = Vec::new();
        let slabs = self.settings.slabs as usize;
        if self.settings.layers == Layers::NearFar {
            let lost = self.lost(slabs);
            if lost > WORTH {
                said.push(self.on_slabs(slabs, lost));
            }
        }
        let culls = |face: &Face| self.volume.culls[*face as usize];
        let culled: Vec<Face> = Face::ALL.into_iter().filter(culls).collect();
        let by_culled = self.share(|path| path.left.is_some_and(|it| culled.contains(&it.1)));
        if by_culled > WORTH && self.settings.sweep == Sweep::Once {
            let names: Vec<&str> = culled
                .iter()
                .map(|it| self.volume.cuboid.name(*it))
                .collect();
            said.push(format!(
                "{:.1} % of the light leaves by faces that cull ({}): sweep=exact lets it out",
                100.0 * by_culled,
                names.join(", ")
            ));
        }
        said
    }

    /// A sentence on a loss by slabs.
    fn on_slabs(&self, slabs: usize, lost: f64) -> String {
        let of = |count: usize| {
            if count == 1 {
                "1 slab".to_owned()
            } else {
                format!("{count} slabs")
            }
        };
        let tried: Vec<f64> = (1..=SLABS).map(|count| self.lost(count)).collect();
        let best = tried.iter().copied().fold(f64::INFINITY, f64::min);
        let begin = format!(
            "two surfaces a slab, in the order of {}, lose at least {:.1} % of the light",
            of(slabs),
            100.0 * lost
        );
        if best > lost - WORTH {
            return format!(
                "{begin}, and other numbers up to {SLABS} hardly less: with layers=exact and sweep=exact none is lost"
            );
        }
        // The fewest slabs that are about as good as the best ones.
        let few = tried
            .iter()
            .position(|it| *it <= best + 0.1 * WORTH)
            .unwrap_or(0);
        format!(
            "{begin}: {} would lose {:.1} % (slabs={})",
            of(few + 1),
            100.0 * tried[few],
            few + 1
        )
    }
}

/// A part of a volume between two depths.
fn slab<'a>(
    scene: &'a Scene,
    volume: &'a Volume,
    settings: &Settings,
    depths: [f64; 2],
) -> Slab<'a> {
    Slab {
        scene,
        cuboid: &volume.cuboid,
        depths,
        side: settings.g_buffer as usize,
    }
}

/// The true ways of a photon that meet something that mirrors or refracts, up to where they leave the volume
/// or land.
fn ways(optics: &Optics, whole: &Slab, photon: &Photon) -> Vec<Path> {
    let cuboid = whole.cuboid;
    let start = cuboid.to_local(photon.ray.origin);
    let mut found = Vec::new();
    let mut waiting = vec![(*photon, Vec::new())];
    while let Some((photon, mut events)) = waiting.pop() {
        let path = |events, left| Path {
            start,
            events,
            flux: photon.flux.mean(),
            left,
        };
        let mut counters = TraversalCounters::default();
        let Some(met) = first_by_rays(whole, optics, &photon, &mut counters) else {
            if photon.is_contributive() {
                let (distance, face) = cuboid.leaves(&photon.ray, whole.depths);
                let place = cuboid.to_local(photon.ray.at(distance));
                found.push(path(events, Some((place, face))));
            }
            continue;
        };
        events.push(cuboid.to_local(met.point.position));
        match optics.meet(&photon, &met.hit, &met.point, &mut Tally::default()) {
            Meeting::Goes(next) => {
                let next = next.into_iter().flatten();
                waiting.extend(next.map(|photon| (photon, events.clone())));
            }
            Meeting::Lands if photon.is_contributive() => found.push(path(events, None)),
            Meeting::Lands | Meeting::Ends => {}
        }
    }
    found
}
