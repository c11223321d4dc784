//! A scene's objects in its lights, and how a frame reads their tables.

use std::cell::Cell;
use std::collections::HashMap;
use std::ops::AddAssign;
use std::sync::Arc;

use glam::{DMat3, DVec3};

use super::cells::Cells;
use super::chunk::Key;
use super::crossing::faded;
use super::directions::{Blended, Samples};
use super::lamp::SeenLight;
use super::layout::Layout;
use super::object::SpecularObject;
use super::settings::Settings;
use super::shells::Shells;
use super::shoot::Tally;
use super::table::Table;
use super::variants::{Interpolation, Normal, Region};
use super::work::Work;
use crate::approximation::{SensorPoint, TableAccount};
use crate::radiometry::Rgb;

/// What outlives a frame.
#[derive(Default)]
pub struct Kept {
    /// The last scene, with what was made for it.
    pub last: Option<Scenery>,
    /// Tables of forms that were seen.
    pub tables: HashMap<Key, Arc<Table>>,
    /// Borders of shells, by form.
    pub radii: HashMap<Arc<str>, Vec<f64>>,
    /// What became of the tables that were asked for.
    pub account: TableAccount,
}

/// A scene's objects in its lights, with all that a frame reads.
pub struct Scenery {
    /// The scene and the sensor.
    pub key: [String; 2],
    pub parts: Vec<Part>,
    pub objects: Vec<(SpecularObject, Layout)>,
    /// The sensor's values, if space is exact.
    pub image: Option<Vec<Rgb>>,
    pub warnings: Vec<String>,
}

/// An object in a light.
pub struct Part {
    pub object: usize,
    pub light: SeenLight,
    /// The direction to the light along the object's own axes.
    pub towards: DVec3,
    /// The samples that are read, with the maps from the world to their own axes.
    pub blended: Vec<(Blended, DMat3)>,
    /// Their tables: none if space is exact.
    pub tables: Vec<Arc<Table>>,
    /// By sample: how places are found on shells, if values are between those of cells.
    pub turned: Vec<Turned>,
    /// Harmonics of the light's direction, if a table has those.
    pub row: Vec<f64>,
    /// What became of photons, by the light's own irradiance.
    pub tally: Tally,
}

impl Scenery {
    /// What became of all photons, by flux \[W\].
    pub fn tally(&self) -> Tally {
        let mut all = Tally::default();
        for part in &self.parts {
            all.add_coloured(&part.tally, part.light.irradiance.0);
        }
        all
    }
}

impl Kept {
    /// Bytes of all tables that are kept, and of those of a frame alone.
    pub fn resident(&self, scenery: &Scenery) -> u64 {
        if self.tables.is_empty() {
            let tables = scenery.parts.iter().flat_map(|part| &part.tables);
            return tables.map(|table| table.bytes()).sum();
        }
        self.tables.values().map(|table| table.bytes()).sum()
    }
}

impl Part {
    /// Counts what became of the photons of each sample.
    pub fn count<'a>(&mut self, tallies: impl Iterator<Item = &'a Tally>) {
        for ((blended, _), tally) in self.blended.iter().zip(tallies) {
            self.tally.add_scaled(tally, blended.weight);
        }
    }

    /// Irradiance [W/m²] at a point of the sensor.
    #[inline]
    pub fn read(
        &self,
        settings: &Settings,
        object: &SpecularObject,
        layout: &Layout,
        point: &SensorPoint,
        Reading { work, faces }: &mut Reading,
    ) -> Rgb {
        let away = point.point.position - object.center;
        let distance = away.length();
        let mut factor = match settings.normal {
            Normal::Exact | Normal::Vector => 1.0,
            Normal::Fixed => (-point.normal.dot(away) / distance).max(0.0),
        };
        if settings.region == Region::Fade {
            factor *= faded(distance / layout.radius);
        }
        if factor <= 0.0 || distance == 0.0 {
            return Rgb::BLACK;
        }
        work.queries += 1;
        let mut sum = Rgb::BLACK;
        let away = held(layout, away);
        let shells = match &layout.cells {
            Some(Cells::Shells(shells)) if !self.turned.is_empty() => {
                Some((shells, shells.between(distance.min(layout.radius))))
            }
            _ => None,
        };
        let samples = self.blended.iter().zip(&self.tables).enumerate();
        for (number, ((blended, map), table)) in samples {
            let place = *map * away;
            let normal = match settings.normal {
                Normal::Exact | Normal::Vector => *map * point.normal,
                Normal::Fixed => DVec3::ZERO,
            };
            let at = [place, normal];
            let value = if let Some((shells, layers)) = shells {
                let face = &faces[number % Reading::FACES];
                let three = || self.turned[number].three(shells, map, away, face);
                let ([inner, outer], _) = layers;
                let six = || shells.six(three(), layers);
                let value = (inner != outer).then(|| layout.read_six(table, six, work));
                value.flatten().unwrap_or_else(|| {
                    let stencil = || shells.stencil(three(), layers);
                    layout.read_at(settings, table, at, &stencil, &self.row, work)
                })
            } else {
                layout.read(settings, table, at, &self.row, work)
            };
            sum += value * blended.weight;
        }
        sum * self.light.irradiance * factor
    }
}

/// What a thread has read so far.
#[derive(Default)]
pub struct Reading {
    /// Its work.
    pub work: Work,
    /// By sample: the face of the icosahedron on which the last place was, most often that of the next one.
    /// Results do not depend on it. Threads that shared it would wait for one another.
    faces: [Cell<u32>; Self::FACES],
}

impl Reading {
    const FACES: usize = 4;
}

impl AddAssign for Reading {
    fn add_assign(&mut self, other: Self) {
        self.work += other.work;
    }
}

/// How places of the world are found on the shells of a sample.
pub struct Turned {
    /// Weights by the corners of each face, of directions in the world.
    weights: Box<[DMat3; 20]>,
}

impl Turned {
    fn new(shells: &Shells, map: DMat3) -> Self {
        Self {
            weights: Box::new(shells.dual().turned(map)),
        }
    }

    /// The triangles around a place that the map takes to the sample's own axes, with their shares.
    #[inline]
    fn three(
        &self,
        shells: &Shells,
        map: &DMat3,
        place: DVec3,
        last: &Cell<u32>,
    ) -> [(u32, f64); 3] {
        let mut face = last.get();
        let turn = (map, &*self.weights);
        let three = shells.dual().between_turned(turn, place, &mut face);
        last.set(face);
        three
    }
}

/// A place, or that at the region's border in front of it.
#[inline]
pub fn held(layout: &Layout, place: DVec3) -> DVec3 {
    let distance = place.length();
    if distance > layout.radius {
        place * (layout.radius / distance)
    } else {
        place
    }
}

pub fn part(
    samples: &Samples,
    index: usize,
    (object, layout): &(SpecularObject, Layout),
    light: SeenLight,
    interpolation: Interpolation,
) -> Part {
    let towards = object.to_own(light.towards).normalize();
    let back = object.turn.transpose();
    let blended = samples.blend(towards).into_iter();
    let blended: Vec<(Blended, DMat3)> = blended.map(|one| (one, one.turn * back)).collect();
    let turned = match (&layout.cells, interpolation) {
        (Some(Cells::Shells(shells)), Interpolation::Linear) => {
            let maps = blended.iter();
            maps.map(|(_, map)| Turned::new(shells, *map)).collect()
        }
        _ => Vec::new(),
    };
    Part {
        object: index,
        light,
        towards,
        blended,
        tables: Vec::new(),
        turned,
        row: Vec::new(),
        tally: Tally::default(),
    }
}
