//! Stage `splat`, exact: beams between the photons of a lattice, dealt out to the sensor's texels by area.
//!
//! Where the four corners of a cell have light that went the same way, their landings span two triangles
//! (either way, and both are taken, by half), over which the cell's flux is dealt out. For light that not all
//! corners have, the cell is quartered, `border-levels` times. Of what is left then, each corner puts a
//! quarter into its texel.

use glam::DVec2;
use rayon::prelude::*;

use super::emission::Lattice;
use super::ledger::{Fate, Tally};
use super::photon::{Landing, Photon};
use super::slab::Passed;
use super::sweep::Tracer;
use super::variants::{BySteps, Projector, Step};
use super::work::Work;
use crate::approximation::{ExactFilm, Receivers};
use crate::geometry::{Hit, Ray, TraversalCounters};
use crate::radiometry::Rgb;
use crate::run::Progress;
use crate::transport::path_end::{End, next_hit};
use crate::transport::screen::Screen;

/// Where beams come from, and where they land.
#[derive(Clone, Copy)]
pub struct Beams<'a> {
    /// The wish to stop: lines that have not begun then are left out.
    pub progress: &'a Progress,
    /// The volume.
    pub tracer: &'a Tracer<'a>,
    /// The lattice.
    pub lattice: &'a Lattice<'a>,
    /// The sensor.
    pub screen: &'a Screen<'a>,
    /// What light may land on.
    pub receivers: &'a Receivers,
    /// Sums of flux by texel.
    pub film: &'a ExactFilm,
}

/// What became of beams.
#[derive(Clone, Copy, Debug, Default)]
pub struct Dealt {
    /// Work by stage.
    pub work: BySteps<Work>,
    /// Flux, by a quarter of a cell a corner.
    pub tally: Tally,
}

impl Dealt {
    fn add(mut self, other: &Self) -> Self {
        for (sum, one) in self.work.iter_mut().zip(other.work) {
            *sum += one;
        }
        self.tally += other.tally;
        self
    }
}

/// The light of a corner that went one way.
#[derive(Clone, Copy)]
struct Landed {
    path: u64,
    /// In texels; may lie beside the film.
    at: DVec2,
    /// What the flux of a cell is multiplied by on the way, and on the film.
    factor: Rgb,
    /// Only on the way.
    left: f64,
}

/// A corner's light.
#[derive(Clone, Default)]
struct Corner {
    /// By path, ascending.
    landed: Vec<Landed>,
    /// By what a cell carries.
    tally: Tally,
}

impl Corner {
    fn of(&self, path: u64) -> Option<&Landed> {
        let found = self.landed.binary_search_by_key(&path, |one| one.path);
        found.ok().map(|index| &self.landed[index])
    }
}

/// The share of a cell's light from which on its border is worth more rays.
const LEAST_SPLIT: f64 = 1e-2;

/// Rows of cells that share their lines of corners, as one task.
const ROWS: usize = 8;

impl Beams<'_> {
    /// Deals out the light of the lattice.
    pub fn deal(&self) -> Dealt {
        let [columns, rows] = self.lattice.size().map(|side| side as usize);
        let line = |row: usize, done: &mut Dealt| -> Vec<Corner> {
            (0..=columns)
                .map(|column| self.corner(DVec2::new(column as f64, row as f64), done))
                .collect()
        };
        let tasks: Vec<Dealt> = (0..rows.div_ceil(ROWS))
            .into_par_iter()
            .map(|task| {
                let mut done = Dealt::default();
                if self.progress.is_stopped() {
                    return done;
                }
                let first = task * ROWS;
                let mut above = line(first, &mut done);
                for row in first..(first + ROWS).min(rows) {
                    let below = line(row + 1, &mut done);
                    for column in 0..columns {
                        let low = DVec2::new(column as f64, row as f64);
                        let corners = [
                            &above[column],
                            &above[column + 1],
                            &below[column],
                            &below[column + 1],
                        ];
                        let levels = self.tracer.settings.border_levels;
                        self.cell(low, 1.0, corners, levels, &mut Vec::new(), &mut done);
                    }
                    above = below;
                }
                done
            })
            .collect();
        // In the order of rows: sums of flux are the same bits on any threads.
        tasks.iter().fold(Dealt::default(), Dealt::add)
    }

    fn corner(&self, at: DVec2, done: &mut Dealt) -> Corner {
        let emitted = &mut done.work[Step::Emission as usize];
        let Some(photon) = self.lattice.photon(at, 0, emitted) else {
            return Corner::default();
        };
        let mut passed = Passed::default();
        passed.tally.add(Fate::SetsOut, photon.flux);
        self.tracer.follow(&photon, &mut passed);
        let mut landed = Vec::new();
        if self.tracer.settings.projector == Projector::Exact {
            for (_, photon) in std::mem::take(&mut passed.out) {
                landed.extend(self.traced(&photon, &mut passed));
            }
        } else {
            for (_, photon) in std::mem::take(&mut passed.out) {
                self.tracer.project(&photon, &mut passed);
            }
        }
        for landing in std::mem::take(&mut passed.landed) {
            landed.extend(self.looked_up(&landing, &mut passed));
        }
        landed.sort_by_key(|one| one.path);
        for (sum, one) in done.work.iter_mut().zip(passed.work) {
            *sum += one;
        }
        Corner {
            landed,
            tally: passed.tally,
        }
    }

    /// A photon outside that is traced to the sensor. On a plane it also knows what would land beyond its
    /// border.
    fn traced(&self, photon: &Photon, passed: &mut Passed) -> Option<Landed> {
        let scene = self.tracer.scene;
        let mut counters = TraversalCounters::default();
        let found = next_hit(scene, photon.ray, &mut counters);
        let (ray, hit) = found.map_or((photon.ray, None), |(ray, hit)| (ray, Some(hit)));
        let is_specular = |hit: &Hit| scene.material_of(hit.shape).is_specular(scene.materials());
        let fate = match hit {
            Some(hit) if is_specular(&hit) => Fate::Specular,
            Some(_) => Fate::Landed,
            None => Fate::NoReceiver,
        };
        passed.tally.add(fate, photon.flux);
        let landed = self.on_film(photon, &ray, hit.as_ref(), &mut counters);
        let work = passed.work(Step::Projector);
        work.photons += 1;
        work.dropped += u64::from(fate != Fate::Landed);
        work.add_rays(counters);
        landed
    }

    /// A photon that is known to be on a surface: by its hit, or a ray along the normal from before it.
    fn looked_up(&self, landing: &Landing, passed: &mut Passed) -> Option<Landed> {
        /// The distance before the surface, by the volume's diagonal: pictures' depths are off.
        const BEFORE: f64 = 0.02;
        let mut counters = TraversalCounters::default();
        if landing.hit.is_some() {
            let ray = &landing.photon.ray;
            return self.on_film(&landing.photon, ray, landing.hit.as_ref(), &mut counters);
        }
        let before = BEFORE * self.tracer.volume.cuboid.diagonal();
        let ray = Ray::new(landing.position + landing.normal * before, -landing.normal);
        let hit = self
            .receivers
            .first(&ray, &mut counters)
            .map(|(hit, _)| hit);
        let landed = self.on_film(&landing.photon, &ray, hit.as_ref(), &mut counters);
        passed.work(Step::Splat).add_rays(counters);
        landed
    }

    fn on_film(
        &self,
        photon: &Photon,
        ray: &Ray,
        hit: Option<&Hit>,
        counters: &mut TraversalCounters,
    ) -> Option<Landed> {
        let (end, weight, surface) = self.screen.end(self.tracer.scene, ray, hit, counters);
        let End::Landed(at) = end else {
            return None;
        };
        Some(Landed {
            path: photon.path ^ surface.rotate_left(17),
            at,
            factor: photon.flux * weight,
            left: photon.flux.max_channel(),
        })
    }

    /// Deals out what a square of the lattice with its lower corner at `low` carries, but for the light that
    /// went by `done_paths`.
    fn cell(
        &self,
        low: DVec2,
        size: f64,
        corners: [&Corner; 4],
        levels: u32,
        done_paths: &mut Vec<u64>,
        done: &mut Dealt,
    ) {
        let known = done_paths.len();
        let carried = self.lattice.strength() * self.lattice.carried(low, low + size);
        let [a, b, c, d] = corners;
        let mut is_split = false;
        for corner in corners {
            for one in &corner.landed {
                if done_paths.contains(&one.path) {
                    continue;
                }
                let all = [a, b, c, d].map(|corner| corner.of(one.path));
                if let [Some(a), Some(b), Some(c), Some(d)] = all {
                    done_paths.push(one.path);
                    for triangle in [[a, b, d], [a, d, c], [a, b, c], [b, d, c]] {
                        let places = triangle.map(|it| it.at);
                        let flux = triangle.map(|it| carried * it.factor * 0.25);
                        let work = &mut done.work[Step::Splat as usize];
                        work.fragments += self.film.deal(places, flux);
                        work.splats += 1;
                    }
                } else {
                    is_split |= one.left >= LEAST_SPLIT;
                }
            }
        }
        if !is_split || levels == 0 {
            for corner in corners {
                done.tally.add_scaled(&corner.tally, carried * 0.25);
                for one in &corner.landed {
                    if !done_paths.contains(&one.path) {
                        self.film.deposit_at(one.at, carried * one.factor * 0.25);
                        let work = &mut done.work[Step::Splat as usize];
                        work.splats += 1;
                        work.fragments += 1;
                    }
                }
            }
        } else {
            let half = 0.5 * size;
            let mut at = |x: f64, y: f64| self.corner(low + DVec2::new(x, y), done);
            let (top, left, middle) = (at(half, 0.0), at(0.0, half), at(half, half));
            let (right, bottom) = (at(size, half), at(half, size));
            let quarters = [
                (DVec2::ZERO, [a, &top, &left, &middle]),
                (DVec2::new(half, 0.0), [&top, b, &middle, &right]),
                (DVec2::new(0.0, half), [&left, &middle, c, &bottom]),
                (DVec2::splat(half), [&middle, &right, &bottom, d]),
            ];
            for (offset, corners) in quarters {
                self.cell(low + offset, half, corners, levels - 1, done_paths, done);
            }
        }
        done_paths.truncate(known);
    }
}
