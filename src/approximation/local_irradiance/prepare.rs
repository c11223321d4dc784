//! Photons of samples into sums: by cell, by what the sensor reads, or by texel.

use std::ops::Range;
use std::sync::Arc;

use glam::{DMat3, DVec3};

use super::cells::Cells;
use super::crossing::OnSensor;
use super::deposit::{AllCells, CellVectors, ReadCells, Rule, Sums};
use super::directions::Blended;
use super::grid::Grid;
use super::lamp::{Lamp, least_rotation};
use super::layout::Layout;
use super::object::SpecularObject;
use super::reads::Reads;
use super::settings::Settings;
use super::shoot::{Deposits, Shot, Tally};
use super::variants::{Deposit, Light, Normal, Region, Space, Surroundings};
use super::work::Work;
use crate::approximation::SensorFilm;
use crate::geometry::Geodesic;
use crate::numeric::math;
use crate::numeric::{Stream, StreamKind};
use crate::run::Error;
use crate::scene::{Scene, is_achromatic};
use crate::transport::chain::ChainSettings;
use crate::transport::first_surface::Source;
use crate::transport::followed::Followed;
use crate::transport::scatter::ShadingNormals;

/// Events up to which photons follow every way.
const SPLIT_DEPTH: u32 = 2;

/// An object in a light, about to be lit.
pub struct Lit<'a> {
    /// The settings.
    pub settings: &'a Settings,
    /// The scene.
    pub scene: &'a Scene,
    /// The object.
    pub object: &'a SpecularObject,
    /// The light, and the direction to it along the object's own axes; only exact light needs it.
    pub light: Option<(&'a Source, DVec3)>,
    /// Tells when to give up.
    pub stop: &'a (dyn Fn() -> bool + Sync),
}

/// Where the light of photons goes.
#[derive(Clone, Copy)]
pub enum Goal<'a> {
    /// To all cells: for surfaces that face the centre, or vectors.
    Cells(&'a Layout),
    /// To what the sensor reads.
    Reads(&'a Layout, &'a Arc<Reads>),
    /// To the sensor itself.
    Sensor(&'a Layout, &'a SensorFilm),
}

/// Sums of photons with what became of them.
#[derive(Clone, Debug)]
pub struct Shed {
    /// Sums of irradiance by cell or by number, or of vectors, three a cell; of a sensor its own, by texel.
    pub values: Vec<[f64; 3]>,
    /// What became of photons.
    pub tally: Tally,
    /// Their work.
    pub work: Work,
}

impl Lit<'_> {
    /// The photons of a range in the light of a sample, of which `total` are all light.
    ///
    /// # Errors
    ///
    /// If a sum does not fit.
    pub fn shed(
        &self,
        blended: &Blended,
        stream: Stream,
        photons: Range<u64>,
        goal: Goal,
    ) -> Result<Shed, Error> {
        let shot = self.shot(blended, stream, photons);
        // A camera shows the colours of what it sees, too.
        let is_camera = matches!(goal, Goal::Sensor(_, SensorFilm::Camera(_)));
        if is_achromatic(shot.scene) && !is_camera {
            self.shed_by::<1>(&shot, blended, goal)
        } else {
            self.shed_by::<3>(&shot, blended, goal)
        }
    }

    fn shot(&self, blended: &Blended, stream: Stream, photons: Range<u64>) -> Shot<'_> {
        let (settings, object) = (self.settings, self.object);
        let is_alone = settings.scene == Surroundings::Alone;
        // From the object's own axes to those that photons are traced along.
        let (scene, center, axes) = if is_alone {
            (&object.alone, object.own_center, DMat3::IDENTITY)
        } else {
            (self.scene, object.center, object.turn)
        };
        let towards = axes * blended.towards;
        let bounds = scene.world().bounds();
        let beyond_all =
            1.01 * (bounds.radius() + bounds.center().distance(center) + object.radius);
        // What is behind a lamp is not in its way.
        let ahead = match self.light {
            Some((Source::Point { origin, .. }, _)) => {
                beyond_all.min(origin.distance(object.center))
            }
            _ => beyond_all,
        };
        let lamp = match (settings.light, self.light) {
            (
                Light::Exact,
                Some((
                    Source::Point {
                        origin, falloff, ..
                    },
                    own,
                )),
            ) => {
                // The light's own direction, along the world's axes: by the way back of places, if these are
                // turned.
                let turned = least_rotation(blended.towards, blended.turn * own);
                let back = blended.turn.transpose() * turned;
                Lamp::Point {
                    towards,
                    distance: origin.distance(object.center),
                    falloff: *falloff,
                    unturned: object.turn * back * axes.transpose(),
                }
            }
            _ => Lamp::Parallel { towards, ahead },
        };
        Shot {
            scene,
            center,
            radius: object.radius,
            to_own: axes.transpose(),
            own: (!is_alone).then_some(&object.shapes),
            lamp,
            chains: ChainSettings {
                max_depth: settings.max_depth,
                split_depth: SPLIT_DEPTH,
                shading_normals: ShadingNormals::Flux,
                followed: Followed::Smooth,
            },
            stream,
            total: photons.end - photons.start,
            photons,
            stop: self.stop,
        }
    }

    fn shed_by<const N: usize>(
        &self,
        shot: &Shot,
        blended: &Blended,
        goal: Goal,
    ) -> Result<Shed, Error> {
        /// Where a leg counts more than its flux: it comes in grazing, or as seen by a camera.
        const HEADROOM: f64 = 4096.0;
        let settings = self.settings;
        let flux = shot.lamp.flux_bound(shot.radius);
        match goal {
            Goal::Cells(layout) => {
                let Some(rule) = rule(settings, layout) else {
                    return Ok(empty(0));
                };
                if settings.normal == Normal::Vector {
                    let count = 3 * rule.cells.count();
                    let new = || CellVectors {
                        rule: &rule,
                        sums: Sums::<N>::new(count, rule.bound(flux)),
                    };
                    return traced(shot, count, new, |one| one.sums);
                }
                let new = || AllCells {
                    rule: &rule,
                    sums: Sums::<N>::new(rule.cells.count(), rule.bound(flux)),
                };
                let mut shed = traced(shot, layout.count(), new, |one| one.sums)?;
                rule.factors(&mut shed.values);
                Ok(shed)
            }
            Goal::Reads(layout, reads) => {
                let Some(rule) = rule(settings, layout) else {
                    return Ok(empty(reads.count()));
                };
                let new = || ReadCells {
                    rule: &rule,
                    reads,
                    sums: Sums::<N>::new(reads.count(), rule.bound(flux)),
                };
                traced(shot, reads.count(), new, |one| one.sums)
            }
            Goal::Sensor(layout, film) => {
                let [width, height] = film.size();
                let largest = HEADROOM * flux * film.largest_factor(self.scene);
                // Legs of samples that are turned may end before the surface that their own light ends on.
                let beyond = if blended.turn == DMat3::IDENTITY {
                    0.0
                } else {
                    beyond(&Cells::Grid(Grid::new(settings.cells, layout.radius)))
                };
                let new = || OnSensor {
                    settings,
                    scene: self.scene,
                    screen: film.screen(),
                    center: self.object.center,
                    to_world: self.object.turn * blended.turn.transpose(),
                    radius: layout.radius,
                    beyond,
                    sums: Sums::<N>::new(width * height, largest),
                };
                traced(shot, width * height, new, |one| one.sums)
            }
        }
    }
}

fn empty(len: usize) -> Shed {
    Shed {
        values: vec![[0.0; 3]; len],
        tally: Tally::default(),
        work: Work::default(),
    }
}

/// The rule of deposits in a layout's cells.
fn rule<'a>(settings: &Settings, layout: &'a Layout) -> Option<Rule<'a>> {
    let cells = layout.cells.as_ref()?;
    Some(Rule {
        cells,
        deposit: settings.deposit,
        beyond: beyond(cells),
    })
}

/// By how much \[m\] legs go on after surfaces that stop them, or the cells that a receiver cuts would be
/// half dark.
fn beyond(cells: &Cells) -> f64 {
    2.0 * cells.diagonal()
}

/// Traces photons, and adds up what all threads have. Of a run that was stopped, those that were traced stand
/// for all.
fn traced<const N: usize, D: Deposits<N>>(
    shot: &Shot,
    len: usize,
    new: impl Fn() -> D + Sync,
    sums: impl Fn(D) -> Sums<N>,
) -> Result<Shed, Error> {
    let (parts, mut tally, mut work) = shot.trace(new);
    let parts: Vec<Sums<N>> = parts.into_iter().map(sums).collect();
    let mut values = Sums::total(parts, len)?;
    if tally.photons > 0 && tally.photons < shot.total {
        let share = shot.total as f64 / tally.photons as f64;
        for value in values.iter_mut().flatten() {
            *value *= share;
        }
        let traced = std::mem::take(&mut tally);
        tally.add_scaled(&traced, share);
    }
    work.samples += 1;
    Ok(Shed {
        values,
        tally,
        work,
    })
}

/// The stream of a sample's photons: `round` of those that are drawn for less noise.
pub fn stream(settings: &Settings, sample: usize, round: u64) -> Stream {
    Stream::new(StreamKind::Sobol, settings.seed)
        .split(sample as u64)
        .split(round)
}

/// The borders of shells \[m\], from 0 to the region's radius: closer where a pilot's caustic changes.
///
/// The pilot lights the object from the twelve corners of an icosahedron. Each shell then has the same share
/// of the change of irradiance from one pilot shell to the next, and of a fifth of it that is everywhere.
///
/// # Errors
///
/// If a sum does not fit.
pub fn adapted_radii(
    settings: &Settings,
    object: &SpecularObject,
    work: &mut Work,
) -> Result<Vec<f64>, Error> {
    /// Pilot shells for each shell.
    const FINER: u32 = 8;
    /// Their level.
    const LEVEL: u32 = 2;
    const PHOTONS: u64 = 16_384;
    /// Share of the pilot's shells that have as much as all others.
    const EVEN: f64 = 0.2;
    let radius = settings.reach * object.radius;
    let count = settings.shells * FINER;
    let radii = even_radii(count, radius);
    let pilot = Settings {
        scene: Surroundings::Alone,
        light: Light::Directional,
        deposit: Deposit::Exact,
        shell_level: LEVEL,
        space: Space::Shells,
        region: Region::Clamp,
        normal: Normal::Fixed,
        ..settings.clone()
    };
    let layout = Layout::new(&pilot, object.radius, &radii, 0.0);
    let lit = Lit {
        settings: &pilot,
        scene: &object.alone,
        object,
        light: None,
        stop: &|| false,
    };
    let mut changes = vec![0.0; count as usize];
    let triangles = 20 << (2 * LEVEL);
    for (sample, towards) in Geodesic::new(1).vertices().iter().enumerate() {
        let blended = Blended {
            sample,
            towards: *towards,
            weight: 1.0,
            turn: DMat3::IDENTITY,
        };
        let random = stream(settings, sample, u64::MAX);
        let shed = lit.shed(&blended, random, 0..PHOTONS, Goal::Cells(&layout))?;
        *work += shed.work;
        for (layer, change) in changes.iter_mut().enumerate().skip(1) {
            let shell = |layer: usize| &shed.values[layer * triangles..(layer + 1) * triangles];
            let pairs = shell(layer - 1).iter().zip(shell(layer));
            // Weighted by the area that a triangle has there.
            let area = math::powi(layer as f64, 2);
            let change_of = |(a, b): (&[f64; 3], &[f64; 3])| -> f64 {
                (0..3).map(|c| (a[c] - b[c]).abs()).sum()
            };
            *change += area * pairs.map(change_of).sum::<f64>();
        }
    }
    let total: f64 = changes.iter().sum();
    let even = if total > 0.0 {
        EVEN * total / f64::from(count)
    } else {
        1.0
    };
    let mut cumulative = vec![0.0];
    for change in &changes {
        cumulative.push(cumulative[cumulative.len() - 1] + change + even);
    }
    let whole = cumulative[count as usize];
    let mut borders = vec![0.0];
    for shell in 1..settings.shells {
        let share = whole * f64::from(shell) / f64::from(settings.shells);
        let place = cumulative.partition_point(|sum| *sum < share).max(1);
        let (low, high) = (cumulative[place - 1], cumulative[place]);
        let part = (share - low) / (high - low);
        borders.push(radius * (place as f64 - 1.0 + part) / f64::from(count));
    }
    borders.push(radius);
    Ok(borders)
}

/// Borders of shells \[m\] equally far apart, from 0 to a radius.
pub fn even_radii(shells: u32, radius: f64) -> Vec<f64> {
    let inner = 0..shells;
    inner
        .map(|shell| radius * f64::from(shell) / f64::from(shells))
        .chain([radius])
        .collect()
}
