//! Advice on slabs and faces (beyond the paper), from a few photons.
//!
//! The pilot's photons are traced to where they leave the volume, or land in it. Then they are led through S
//! slabs by Algorithm 1: by the nearest and the farthest surface of each slab's columns, as they are, without
//! texels. Two ways are the same if they have the same events and end at the same place, in the same
//! direction. Light of traced ways that are not among those of the slabs is lost; light of the slabs' ways
//! that are not among the traced ones is false. A way that leads elsewhere is both.

use glam::DVec3;
use rayon::prelude::*;

use super::buffers::{Pictures, Slab};
use super::cuboid::Face;
use super::demands::Volume;
use super::emission::lattices;
use super::photon::Photon;
use super::projector::Projectors;
use super::settings::Settings;
use super::slab::Passed;
use super::sweep::Tracer;
use super::variants::{Buffers, Layers, March, Projector, Splat, Sweep};
use super::work::Work;
use crate::scene::Scene;
use crate::transport::signature::Signature;

/// Photons of the pilot at most: shares of 1 % have a standard deviation of 0.3 %.
pub const PHOTONS: u32 = 1024;

/// Slabs that are tried.
pub const SLABS: usize = 8;

/// The share of light from which on a loss is worth a word.
const WORTH: f64 = 0.01;

/// Texels a row, and rows, of what spares the pilot rays: they change no way.
const SIDE: u32 = 64;

/// The end of a photon's way in the volume.
#[derive(Clone, Copy, Debug)]
struct End {
    photon: u64,
    signature: Signature,
    position: DVec3,
    direction: DVec3,
    /// \[W\], the mean of channels.
    flux: f64,
    /// The face by which it leaves; `None` if it lands inside.
    face: Option<Face>,
}

/// What a number of slabs makes of the light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shares {
    /// Light that it lacks, by all.
    pub lost: f64,
    /// Light that it has and that is not there, by all.
    pub false_light: f64,
}

impl Shares {
    fn sum(self) -> f64 {
        self.lost + self.false_light
    }
}

/// Photons whose true ways through a volume are known.
#[derive(Debug)]
pub struct Pilot<'a> {
    scene: &'a Scene,
    settings: &'a Settings,
    volume: &'a Volume,
    photons: Vec<Photon>,
    /// Of light that meets something that mirrors or refracts.
    traced: Vec<End>,
}

impl<'a> Pilot<'a> {
    /// Traces photons of a volume, as its stages `emission` and `interface` make them.
    pub fn new(scene: &'a Scene, settings: &'a Settings, volume: &'a Volume) -> Self {
        let few = Settings {
            photons: settings.photons.min(PHOTONS),
            ..settings.clone()
        };
        let mut photons = Vec::new();
        for lattice in lattices(scene, &few, volume) {
            let mut work = Work::default();
            photons.extend((0..lattice.cells()).filter_map(|cell| lattice.cell(cell, &mut work)));
        }
        let mut pilot = Self {
            scene,
            settings,
            volume,
            photons,
            traced: Vec::new(),
        };
        pilot.traced = pilot.ends(Layers::Exact, Sweep::Exact, 1);
        pilot
    }

    /// Photons that were traced.
    pub fn photons(&self) -> u64 {
        self.photons.len() as u64
    }

    /// The ends of all ways through some slabs, by photon and events.
    fn ends(&self, layers: Layers, sweep: Sweep, slabs: usize) -> Vec<End> {
        let settings = Settings {
            g_buffer: self.settings.g_buffer.min(SIDE),
            buffers: Buffers::Exact,
            march: March::Exact,
            layers,
            sweep,
            projector: Projector::Exact,
            // Beams follow all ways; photons one by lot, after some events.
            splat: Splat::Quads,
            ..self.settings.clone()
        };
        let cuboid = &self.volume.cuboid;
        let parts: Vec<Slab> = (0..slabs)
            .map(|slab| Slab {
                scene: self.scene,
                cuboid,
                depths: cuboid.slab(slab, slabs),
                side: settings.g_buffer as usize,
            })
            .collect();
        let mut work = Work::default();
        let pictures = parts.iter();
        let pictures: Vec<Pictures> = pictures
            .map(|slab| Pictures::new(slab, &settings, &mut work))
            .collect();
        let tracer = Tracer {
            scene: self.scene,
            settings: &settings,
            volume: self.volume,
            slabs: &parts,
            pictures: &pictures,
            projectors: &Projectors::default(),
        };
        let size = cuboid.size();
        let half = DVec3::new(size.x, size.y, 0.5 * size.z);
        let ends = |photon: &Photon| -> Vec<End> {
            let mut passed = Passed::default();
            tracer.follow(photon, &mut passed);
            let end = |photon: &Photon, position: DVec3, face: Option<Face>| End {
                photon: photon.index,
                signature: photon.signature,
                position,
                direction: photon.ray.direction,
                flux: photon.flux.mean(),
                face,
            };
            let left = passed.out.iter().map(|(_, photon)| {
                let place = cuboid.to_local(photon.ray.origin) - DVec3::Z * half.z;
                end(photon, photon.ray.origin, Some(Face::along(place / half)))
            });
            let landed = passed.landed.iter();
            left.chain(landed.map(|it| end(&it.photon, it.position, None)))
                .collect()
        };
        // In the order of photons: sums are the same bits on any threads.
        let ends: Vec<Vec<End>> = self.photons.par_iter().map(ends).collect();
        let mut ends: Vec<End> = ends.into_iter().flatten().collect();
        ends.sort_by_key(|end| (end.photon, end.signature));
        ends
    }

    /// Flux of ways \[W\] of which something is true.
    fn flux(ends: &[End], is_so: impl Fn(&End) -> bool) -> f64 {
        let some = ends.iter().filter(|end| is_so(end));
        // From 0 on: the sum of none is -0.
        some.fold(0.0, |sum, end| sum + end.flux)
    }

    /// A flux by that of all traced ways.
    fn share(&self, flux: f64) -> f64 {
        let all = Self::flux(&self.traced, |_| true);
        if all > 0.0 { flux / all } else { 0.0 }
    }

    /// True if light leaves by a face that culls, whatever slabs there are.
    fn is_culled(&self, end: &End) -> bool {
        let is_once = self.settings.sweep == Sweep::Once;
        is_once
            && end
                .face
                .is_some_and(|face| self.volume.culls[face as usize])
    }

    /// What a number of slabs makes of the light, by two surfaces a slab; without light that faces cull.
    pub fn slabs(&self, slabs: usize) -> Shares {
        /// What places of the same way differ by at most, by the volume's diagonal; and directions.
        const SAME: f64 = 1e-6;
        let same = SAME * self.volume.cuboid.diagonal();
        let marched = self.ends(Layers::NearFar, self.settings.sweep, slabs);
        let has = |ends: &[End], one: &End| {
            let key = |end: &End| (end.photon, end.signature);
            let first = ends.partition_point(|it| key(it) < key(one));
            let alike = ends[first..].iter().take_while(|it| key(it) == key(one));
            let is_same = |it: &End| {
                it.position.distance(one.position) < same
                    && it.direction.distance(one.direction) < SAME
            };
            alike.into_iter().any(is_same)
        };
        let is_lost = |end: &End| !self.is_culled(end) && !has(&marched, end);
        Shares {
            lost: self.share(Self::flux(&self.traced, is_lost)),
            false_light: self.share(Self::flux(&marched, |end| !has(&self.traced, end))),
        }
    }

    /// The share of light that leaves by each face; what is left of 1 lands inside.
    pub fn faces(&self) -> [f64; 6] {
        Face::ALL.map(|face| self.share(Self::flux(&self.traced, |end| end.face == Some(face))))
    }

    /// All that the pilot knows: lost and false light by numbers of slabs, faces by which light leaves.
    pub fn account(&self) -> Vec<String> {
        let percent = |share: f64| format!("{:.2} %", 100.0 * share);
        let all = Self::flux(&self.traced, |_| true);
        if all <= 0.0 {
            return vec![format!(
                "none of {} photons of the pilot meets what mirrors or refracts",
                self.photons()
            )];
        }
        let mut said = vec![format!(
            "by {} photons of the pilot; shares are of the light that meets what mirrors or refracts",
            self.photons()
        )];
        // With all surfaces nothing hangs on their number.
        if self.settings.layers != Layers::Exact {
            said.extend((1..=SLABS).map(|slabs| {
                let shares = self.slabs(slabs);
                format!(
                    "slabs={slabs}: two surfaces a slab lose {} and make {} that is not there",
                    percent(shares.lost),
                    percent(shares.false_light)
                )
            }));
        }
        let faces = self.faces();
        let mut parts: Vec<String> = Face::ALL
            .into_iter()
            .zip(faces)
            .map(|(face, share)| {
                let role = if face == Face::Entry { " (entry)" } else { "" };
                format!("{}{role} {}", self.volume.cuboid.name(face), percent(share))
            })
            .collect();
        // Rounding alone makes it negative.
        let inside = (1.0 - faces.iter().sum::<f64>()).max(0.0);
        parts.push(format!("lands inside {}", percent(inside)));
        said.push(format!("light leaves by {}", parts.join(", ")));
        said
    }

    /// What the settings have wrong by more than 1 % of the light, in a sentence each, with what would do
    /// better.
    pub fn advice(&self) -> Vec<String> {
        let mut said = Vec::new();
        let slabs = self.settings.slabs as usize;
        if self.settings.layers == Layers::NearFar {
            let shares = self.slabs(slabs);
            if shares.sum() > WORTH {
                said.push(self.on_slabs(slabs, shares));
            }
        }
        let culled = self.share(Self::flux(&self.traced, |end| self.is_culled(end)));
        if culled > WORTH {
            let faces = Face::ALL.into_iter();
            let names: Vec<&str> = faces
                .filter(|face| self.volume.culls[*face as usize])
                .map(|face| self.volume.cuboid.name(face))
                .collect();
            said.push(format!(
                "{:.1} % of the light leaves by faces that cull ({}): sweep=exact lets it out",
                100.0 * culled,
                names.join(", ")
            ));
        }
        said
    }

    /// A sentence on what a number of slabs makes of the light.
    fn on_slabs(&self, slabs: usize, shares: Shares) -> String {
        let made = |shares: Shares| {
            let [lost, more] = [shares.lost, shares.false_light].map(|it| 100.0 * it);
            format!("{lost:.1} % of the light and make {more:.1} % that is not there")
        };
        let begin = format!("two surfaces a slab lose {}", made(shares));
        let tried: Vec<Shares> = (1..=SLABS).map(|count| self.slabs(count)).collect();
        let best = tried.iter().map(|it| it.sum());
        let best = best.fold(f64::INFINITY, f64::min);
        if best > shares.sum() - WORTH {
            return format!(
                "{begin} (slabs={slabs}), and other numbers up to {SLABS} are hardly better: layers=exact has all \
                 surfaces, and sweep=exact all directions"
            );
        }
        // The fewest slabs that are about as good as the best ones.
        let few = tried.iter().position(|it| it.sum() <= best + 0.1 * WORTH);
        let few = few.unwrap_or(0);
        format!(
            "{begin} (slabs={slabs}): slabs={} would lose {}",
            few + 1,
            made(tried[few])
        )
    }
}
