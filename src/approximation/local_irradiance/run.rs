//! The stages one after the other: tables for the lights of a frame, and the frame that reads them.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::sync::Arc;
use std::time::Instant;

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::crossing::faded;
use super::demands::{self, are_kept};
use super::directions::{Blended, Samples};
use super::lamp::SeenLight;
use super::layout::{Layout, kind};
use super::ledger;
use super::object::SpecularObject;
use super::prepare::{Goal, Lit, Shed, adapted_radii, even_radii, stream};
use super::reads::{Read, Reads, average_leaves, needed, read_table, reads_at};
use super::settings::Settings;
use super::shoot::Tally;
use super::storage::Stored;
use super::table::{Form, Table};
use super::variants::{
    BySteps, Directions, Noise, Normal, Radii, Region, STAGES, Space, Step, Storage, Tables, Tree,
};
use super::work::Work;
use crate::approximation::clock::{Done, stage_work};
use crate::approximation::{Frame, SensorFilm, SensorPoint};
use crate::geometry::TraversalCounters;
use crate::numeric::spherical_harmonics;
use crate::radiometry::Rgb;
use crate::run::{Context, Counters, Error, StageWork};
use crate::scene::{Scene, Sensor};
use crate::transport::first_surface::Source;

/// Photons of a sample at which `noise=exact` gives up.
const MOST_PHOTONS: u64 = 1 << 27;

/// What outlives a frame.
#[derive(Default)]
pub struct Kept {
    /// The last scene, with what was made for it.
    last: Option<Scenery>,
    /// Tables of forms that were seen, by form and sample.
    tables: HashMap<(String, usize), Arc<Table>>,
    /// Borders of shells, by form.
    radii: HashMap<String, Vec<f64>>,
}

/// A scene's objects in its lights, with all that a frame reads.
struct Scenery {
    /// The scene and the sensor.
    key: [String; 2],
    parts: Vec<Part>,
    objects: Vec<(SpecularObject, Layout)>,
    /// The sensor's values, if space is exact.
    image: Option<Vec<Rgb>>,
    warnings: Vec<String>,
}

/// An object in a light.
struct Part {
    object: usize,
    light: SeenLight,
    /// The direction to the light along the object's own axes.
    towards: DVec3,
    /// The samples that are read, with the maps from the world to their own axes.
    blended: Vec<(Blended, DMat3)>,
    /// Their tables: none if space is exact.
    tables: Vec<Arc<Table>>,
    /// Harmonics of the light's direction, if a table has those.
    row: Vec<f64>,
    /// What became of photons, by the light's own irradiance.
    tally: Tally,
}

/// Work and time of a run, with its place.
pub struct Run<'a> {
    settings: &'a Settings,
    context: &'a Context,
    scene: &'a Scene,
    film: SensorFilm,
    done: BySteps<Done<Work>>,
}

impl<'a> Run<'a> {
    /// A run that fills a sensor.
    ///
    /// # Errors
    ///
    /// As [`SensorFilm::new`].
    pub fn new(
        settings: &'a Settings,
        context: &'a Context,
        scene: &'a Scene,
        sensor: &Sensor,
    ) -> Result<Self, Error> {
        Ok(Self {
            settings,
            context,
            scene,
            film: SensorFilm::new(scene, sensor)?,
            done: Default::default(),
        })
    }

    fn timed<T>(
        &mut self,
        step: Step,
        part: impl FnOnce(&mut Self, &mut Work) -> Result<T, Error>,
    ) -> Result<T, Error> {
        let start = Instant::now();
        let mut work = Work::default();
        let result = part(self, &mut work);
        let done = &mut self.done[step as usize];
        done.work += work;
        done.seconds += start.elapsed().as_secs_f64();
        result
    }

    /// The work so far, by stage.
    pub fn work(&self) -> Vec<StageWork> {
        stage_work(&STAGES, &self.done, Work::counters)
    }

    /// Makes all tables that a frame reads, as far as they are not kept.
    ///
    /// # Errors
    ///
    /// As [`demands::of_scene`], and if sums of light are not representable.
    pub fn make(&mut self, kept: &mut Kept, sensor: &Sensor) -> Result<(), Error> {
        let key = [self.scene.content_hash().to_owned(), sensor.id.clone()];
        let is_same = |last: &Scenery| last.key == key && !key[0].is_empty();
        if kept.last.as_ref().is_some_and(is_same) {
            return Ok(());
        }
        let settings = self.settings;
        let (objects, sources) = demands::of_scene(self.scene, &self.film, settings)?;
        let samples = demands::samples(settings)?;
        let mut scenery = Scenery {
            key,
            warnings: demands::warnings(self.scene, &objects, &sources, settings),
            parts: Vec::new(),
            objects: Vec::new(),
            image: None,
        };
        let forms: Vec<String> = objects.iter().map(|object| object.form(settings)).collect();
        for (object, form) in objects.into_iter().zip(&forms) {
            let layout = self.layout(kept, &object, form)?;
            scenery.objects.push((object, layout));
        }
        let mut lights = Vec::new();
        for index in 0..scenery.objects.len() {
            for source in &sources {
                let object = &scenery.objects[index].0;
                if let Some(light) = SeenLight::new(source, object.center, settings) {
                    scenery.parts.push(part(&samples, index, object, light));
                    lights.push(source);
                }
            }
        }
        if are_kept(settings) {
            self.read_kept(kept, &mut scenery, &samples, &forms)?;
        } else {
            self.light_up(&mut scenery, &lights)?;
        }
        kept.last = Some(scenery);
        Ok(())
    }

    /// The cells around an object: stages `space` and `region`.
    fn layout(
        &mut self,
        kept: &mut Kept,
        object: &SpecularObject,
        form: &str,
    ) -> Result<Layout, Error> {
        let settings = self.settings;
        let radii = if kind(settings) != Some(Tree::Shells) {
            Vec::new()
        } else if settings.radii == Radii::Uniform {
            even_radii(settings.shells, settings.reach * object.radius)
        } else if let Some(radii) = kept.radii.get(form) {
            radii.clone()
        } else {
            let radii = self.timed(Step::Space, |_, work| adapted_radii(settings, object, work))?;
            kept.radii.insert(form.to_owned(), radii.clone());
            radii
        };
        let farthest = if settings.region == Region::Exact {
            self.farthest(object.center)
        } else {
            0.0
        };
        Ok(Layout::new(settings, object.radius, &radii, farthest))
    }

    /// The points that a frame asks for, in batches of texels.
    fn batches(&self) -> impl IndexedParallelIterator<Item = Vec<SensorPoint>> + '_ {
        const BATCH: usize = 1024;
        let [width, height] = self.film.size();
        let texels = width * height;
        (0..texels.div_ceil(BATCH))
            .into_par_iter()
            .map(move |batch| {
                let range = batch * BATCH..((batch + 1) * BATCH).min(texels);
                let mut counters = TraversalCounters::default();
                self.film
                    .points(self.scene, range, self.settings.samples, &mut counters)
                    .points
            })
    }

    /// The largest distance \[m\] from a place at which the sensor sees a surface.
    fn farthest(&self, center: DVec3) -> f64 {
        let farthest = |points: Vec<SensorPoint>| {
            let distances = points
                .iter()
                .map(|point| point.point.position.distance(center));
            distances.fold(0.0, f64::max)
        };
        self.batches().map(farthest).reduce(|| 0.0, f64::max)
    }

    /// Tables that outlive the frame: those that are there, and those that are not yet.
    fn read_kept(
        &mut self,
        kept: &mut Kept,
        scenery: &mut Scenery,
        samples: &Samples,
        forms: &[String],
    ) -> Result<(), Error> {
        let settings = self.settings;
        let is_cellwise = matches!(settings.space, Space::Grid | Space::Shells);
        for part in &mut scenery.parts {
            let form = &forms[part.object];
            let (object, layout) = &scenery.objects[part.object];
            if settings.directions == Directions::Harmonics && is_cellwise {
                let key = (form.clone(), usize::MAX);
                let known = kept.tables.get(&key).cloned();
                let table = match known {
                    Some(table) => table,
                    None => Arc::new(self.harmonics(object, layout, samples)?),
                };
                kept.tables.insert(key, Arc::clone(&table));
                part.row = spherical_harmonics(part.towards, settings.order as usize);
                part.tally = table.tally;
                part.tables = vec![table];
                part.blended.truncate(1);
                part.blended[0].0.weight = 1.0;
                continue;
            }
            let all = 0..samples.all().len();
            let needed: Vec<usize> = match settings.tables {
                Tables::All => all.collect(),
                Tables::Needed => part.blended.iter().map(|(it, _)| it.sample).collect(),
            };
            for sample in needed {
                let key = (form.clone(), sample);
                if let Entry::Vacant(place) = kept.tables.entry(key) {
                    let table = self.table(object, layout, samples.all()[sample], sample)?;
                    place.insert(Arc::new(table));
                }
            }
            for (blended, _) in &part.blended {
                let table = &kept.tables[&(form.clone(), blended.sample)];
                part.tally.add_scaled(&table.tally, blended.weight);
                part.tally.photons += table.tally.photons;
                part.tables.push(Arc::clone(table));
            }
        }
        Ok(())
    }

    /// The values of a sample's cells, by photons.
    fn sample(
        &mut self,
        object: &SpecularObject,
        layout: &Layout,
        towards: DVec3,
        sample: usize,
    ) -> Result<Shed, Error> {
        let (settings, context, scene) = (self.settings, self.context, self.scene);
        let stop = || context.progress.is_stopped();
        self.timed(Step::Deposit, |_, work| {
            let lit = Lit {
                settings,
                scene,
                object,
                light: None,
                stop: &stop,
            };
            let blended = Blended {
                sample,
                towards,
                weight: 1.0,
                turn: DMat3::IDENTITY,
            };
            let random = stream(settings, sample, 0);
            let goal = Goal::Cells(layout);
            let shed = lit.shed(&blended, random, 0..settings.photons, goal)?;
            *work += shed.work;
            Ok(shed)
        })
    }

    fn table(
        &mut self,
        object: &SpecularObject,
        layout: &Layout,
        towards: DVec3,
        sample: usize,
    ) -> Result<Table, Error> {
        let settings = self.settings;
        let shed = self.sample(object, layout, towards, sample)?;
        self.timed(Step::Storage, |_, work| {
            let table = layout.table(settings, shed.values, shed.tally);
            work.saturated += table.saturated;
            Ok(table)
        })
    }

    /// Harmonics of the light's direction in each cell, fitted to all samples one after the other.
    fn harmonics(
        &mut self,
        object: &SpecularObject,
        layout: &Layout,
        samples: &Samples,
    ) -> Result<Table, Error> {
        let settings = self.settings;
        let Some((fit, order)) = samples.fit() else {
            return Ok(empty_table());
        };
        let number = order * order;
        let cells = layout.cells.as_ref().map_or(0, super::cells::Cells::count);
        let mut sums = vec![[0.0f64; 3]; cells * number];
        let mut tally = Tally::default();
        for (sample, towards) in samples.all().iter().enumerate() {
            let shed = self.sample(object, layout, *towards, sample)?;
            tally.add_scaled(&shed.tally, 1.0 / samples.all().len() as f64);
            tally.photons += shed.tally.photons;
            self.timed(Step::Directions, |_, _| {
                let column: Vec<f64> = fit.iter().map(|row| row[sample]).collect();
                sums.par_chunks_exact_mut(number)
                    .zip(&shed.values)
                    .filter(|(_, value)| **value != [0.0; 3])
                    .for_each(|(sums, value)| {
                        for (sum, weight) in sums.iter_mut().zip(&column) {
                            for c in 0..3 {
                                sum[c] += weight * value[c];
                            }
                        }
                    });
                Ok(())
            })?;
        }
        let (stored, saturated) = Stored::new(sums, settings.storage, settings.range);
        Ok(Table {
            tally,
            saturated,
            form: Form::Harmonics(stored),
        })
    }

    /// Tables, or the image itself, of this scene, light and sensor alone.
    fn light_up(&mut self, scenery: &mut Scenery, lights: &[&Source]) -> Result<(), Error> {
        let settings = self.settings;
        let reads = self.reads(scenery)?;
        let mut photons = settings.photons;
        let mut round = 0;
        let mut sheds = self.round(scenery, lights, &reads, round, photons)?;
        loop {
            let exact = self.content(scenery, &reads, &sheds, settings.noise == Noise::Exact)?;
            if settings.noise == Noise::Photons {
                scenery.image = exact;
                break;
            }
            // As many photons once more: the difference of the two halves tells their error.
            round += 1;
            let others = self.round(scenery, lights, &reads, round, photons)?;
            let first = self.image_or_read(scenery, exact);
            let second = self.content(scenery, &reads, &others, true)?;
            let second = self.image_or_read(scenery, second);
            let error = halves_error(&first, &second);
            for (shed, other) in sheds.iter_mut().flatten().zip(others.into_iter().flatten()) {
                merge(shed, other);
            }
            photons *= 2;
            let is_late = photons >= MOST_PHOTONS || self.context.progress.is_stopped();
            if error <= settings.noise_error || is_late {
                if error > settings.noise_error {
                    scenery.warnings.push(format!(
                        "noise=exact ended at {photons} photons a sample with an error of {:.2} %: noise-error asks \
                         for {:.2} %",
                        100.0 * error,
                        100.0 * settings.noise_error
                    ));
                }
                scenery.image = self.content(scenery, &reads, &sheds, false)?;
                break;
            }
        }
        for (part, sheds) in scenery.parts.iter_mut().zip(&sheds) {
            for ((blended, _), shed) in part.blended.iter().zip(sheds) {
                part.tally.add_scaled(&shed.tally, blended.weight);
                part.tally.photons += shed.tally.photons;
            }
        }
        Ok(())
    }

    /// What the sensor reads of each part's samples, if its own normals count.
    fn reads(&mut self, scenery: &Scenery) -> Result<Vec<Vec<Arc<Reads>>>, Error> {
        let settings = self.settings;
        if settings.normal == Normal::Fixed || settings.space == Space::Exact {
            return Ok(Vec::new());
        }
        self.timed(Step::Normal, |this, _| {
            let parts = scenery.parts.iter();
            Ok(parts
                .map(|part| {
                    let (object, layout) = &scenery.objects[part.object];
                    let blended = part.blended.iter();
                    blended
                        .map(|(_, map)| Arc::new(this.reads_of(object, layout, map)))
                        .collect()
                })
                .collect())
        })
    }

    fn reads_of(&self, object: &SpecularObject, layout: &Layout, map: &DMat3) -> Reads {
        let of_batch = |points: Vec<SensorPoint>| {
            let places = points.iter().map(|point| {
                let away = *map * (point.point.position - object.center);
                [held(layout, away), *map * point.normal]
            });
            reads_at(layout, self.settings, places)
        };
        let batches: Vec<Vec<Read>> = self.batches().map(of_batch).collect();
        needed(layout, self.settings, batches.concat())
    }

    /// Photons of all parts' samples.
    fn round(
        &mut self,
        scenery: &Scenery,
        lights: &[&Source],
        reads: &[Vec<Arc<Reads>>],
        round: u64,
        photons: u64,
    ) -> Result<Vec<Vec<Shed>>, Error> {
        let (settings, context, scene) = (self.settings, self.context, self.scene);
        let stop = || context.progress.is_stopped();
        self.timed(Step::Deposit, |this, work| {
            let mut all = Vec::new();
            for (index, (part, source)) in scenery.parts.iter().zip(lights).enumerate() {
                let (object, layout) = &scenery.objects[part.object];
                let lit = Lit {
                    settings,
                    scene,
                    object,
                    light: Some((*source, part.towards)),
                    stop: &stop,
                };
                let mut sheds = Vec::new();
                for (number, (blended, _)) in part.blended.iter().enumerate() {
                    let goal = match (settings.space, reads.get(index)) {
                        (Space::Exact, _) => Goal::Sensor(layout, &this.film),
                        (_, Some(reads)) => Goal::Reads(layout, &reads[number]),
                        (_, None) => Goal::Cells(layout),
                    };
                    let random = stream(settings, blended.sample, round);
                    let mut shed = lit.shed(blended, random, 0..photons, goal)?;
                    if let (Some(reads), Space::MultiResolution) =
                        (reads.get(index), settings.space)
                    {
                        // The trees are those of surfaces that face the centre.
                        let cells = lit.shed(blended, random, 0..photons, Goal::Cells(layout))?;
                        shed.work += cells.work;
                        let (trees, _) = layout.merged(settings, &cells.values);
                        average_leaves(layout, &trees, &reads[number], &mut shed.values);
                    }
                    *work += shed.work;
                    sheds.push(shed);
                }
                all.push(sheds);
            }
            Ok(all)
        })
    }

    /// The tables of some sums, set in the scenery's parts; or, if space is exact, the image that they are.
    fn content(
        &mut self,
        scenery: &mut Scenery,
        reads: &[Vec<Arc<Reads>>],
        sheds: &[Vec<Shed>],
        is_unrounded: bool,
    ) -> Result<Option<Vec<Rgb>>, Error> {
        let mut settings = self.settings.clone();
        if is_unrounded {
            settings.storage = Storage::Exact;
        }
        if settings.space == Space::Exact {
            return Ok(Some(self.texels(scenery, sheds, &settings)));
        }
        self.timed(Step::Storage, |_, work| {
            for (index, part) in scenery.parts.iter_mut().enumerate() {
                let layout = &scenery.objects[part.object].1;
                part.tables.clear();
                for (number, shed) in sheds[index].iter().enumerate() {
                    let values = shed.values.clone();
                    let table = match reads.get(index) {
                        None => layout.table(&settings, values, shed.tally),
                        Some(reads) => {
                            read_table(layout, &settings, &reads[number], values, shed.tally)
                        }
                    };
                    work.saturated += table.saturated;
                    part.tables.push(Arc::new(table));
                }
            }
            Ok(None)
        })
    }

    /// The sensor's values of sums by texel: weighted samples, rounded as tables are.
    fn texels(&self, scenery: &Scenery, sheds: &[Vec<Shed>], settings: &Settings) -> Vec<Rgb> {
        let [width, height] = self.film.size();
        let mut values = vec![Rgb::BLACK; width * height];
        for (part, sheds) in scenery.parts.iter().zip(sheds) {
            let mut sums = vec![[0.0; 3]; values.len()];
            for ((blended, _), shed) in part.blended.iter().zip(sheds) {
                for (texel, value) in shed.values.iter().enumerate() {
                    let measure = self.film.measure(texel);
                    if measure > 0.0 {
                        for c in 0..3 {
                            sums[texel][c] += blended.weight * value[c] / measure;
                        }
                    }
                }
            }
            let (stored, _) = Stored::new(sums, settings.storage, settings.range);
            for (texel, value) in values.iter_mut().enumerate() {
                *value += stored.get(texel) * part.light.irradiance;
            }
        }
        values
    }

    fn image_or_read(&self, scenery: &Scenery, image: Option<Vec<Rgb>>) -> Vec<Rgb> {
        image.unwrap_or_else(|| self.read(scenery).0)
    }

    /// Reads the tables at all places of the sensor.
    fn read(&self, scenery: &Scenery) -> (Vec<Rgb>, Work) {
        let settings = self.settings;
        let read = |point: &SensorPoint, work: &mut Work| {
            let mut sum = Rgb::BLACK;
            for part in &scenery.parts {
                let (object, layout) = &scenery.objects[part.object];
                sum += part.read(settings, object, layout, point, work);
            }
            sum
        };
        let (values, mut work, rays) = self.film.evaluate(self.scene, settings.samples, read);
        work.add_rays(rays);
        (values, work)
    }

    /// The frame of what was made.
    ///
    /// # Errors
    ///
    /// None of its own.
    pub fn frame(&mut self, kept: &Kept) -> Result<Frame, Error> {
        let Some(scenery) = &kept.last else {
            return Ok(Frame::default());
        };
        let values = self.timed(Step::Space, |this, work| {
            if let Some(image) = &scenery.image {
                return Ok(image.clone());
            }
            let (values, done) = this.read(scenery);
            *work += done;
            work.resident += kept.resident(scenery);
            Ok(values)
        })?;
        let mut sum = Work::default();
        for done in &self.done {
            sum += done.work;
        }
        let mut warnings = scenery.warnings.clone();
        let tally = scenery.tally();
        if values.iter().all(|value| value.is_black()) {
            warnings.insert(0, ledger::darkness(&tally, &self.film));
        }
        if self.context.progress.is_stopped() {
            warnings.push("stopped: some photons of the tables are missing".to_owned());
        }
        let saturated: u64 = scenery
            .parts
            .iter()
            .flat_map(|part| part.tables.iter().map(|table| table.saturated))
            .sum();
        Ok(Frame {
            flux: if self.film.shape().is_some() {
                let image = values.iter().enumerate();
                let drawn = image
                    .map(|(texel, value)| *value * self.film.measure(texel))
                    .sum();
                ledger::entries(&tally, drawn)
            } else {
                Vec::new()
            },
            values,
            work: self.work(),
            counters: Counters::of([
                ("queries", sum.queries),
                ("fetches", sum.fetches),
                ("bytes", sum.bytes),
                ("nodes", sum.nodes),
                ("resident", sum.resident),
                ("saturated", saturated),
                ("photons", sum.photons),
                ("rays", sum.rays),
                ("deposits", sum.deposits),
                ("samples", sum.samples),
            ]),
            warnings,
        })
    }
}

impl Scenery {
    /// What became of all photons, by flux \[W\].
    fn tally(&self) -> Tally {
        let mut all = Tally::default();
        for part in &self.parts {
            let one = part.tally;
            all.photons += one.photons;
            all.add_coloured(&one, part.light.irradiance.0);
        }
        all
    }
}

impl Kept {
    /// Bytes of all tables that are kept, and of those of a frame alone.
    fn resident(&self, scenery: &Scenery) -> u64 {
        if self.tables.is_empty() {
            let tables = scenery.parts.iter().flat_map(|part| &part.tables);
            return tables.map(|table| table.bytes()).sum();
        }
        self.tables.values().map(|table| table.bytes()).sum()
    }
}

impl Part {
    /// Irradiance [W/m²] at a point of the sensor.
    #[inline]
    fn read(
        &self,
        settings: &Settings,
        object: &SpecularObject,
        layout: &Layout,
        point: &SensorPoint,
        work: &mut Work,
    ) -> Rgb {
        let away = point.point.position - object.center;
        let distance = away.length();
        let mut factor = match settings.normal {
            Normal::Exact => 1.0,
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
        for ((blended, map), table) in self.blended.iter().zip(&self.tables) {
            let place = held(layout, *map * away);
            let normal = match settings.normal {
                Normal::Exact => *map * point.normal,
                Normal::Fixed => DVec3::ZERO,
            };
            sum += layout.read(settings, table, [place, normal], &self.row, work) * blended.weight;
        }
        sum * self.light.irradiance * factor
    }
}

/// A place, or that at the region's border in front of it.
#[inline]
fn held(layout: &Layout, place: DVec3) -> DVec3 {
    let distance = place.length();
    if distance > layout.radius {
        place * (layout.radius / distance)
    } else {
        place
    }
}

fn part(samples: &Samples, index: usize, object: &SpecularObject, light: SeenLight) -> Part {
    let towards = object.to_own(light.towards).normalize();
    let back = object.turn.transpose();
    let blended = samples.blend(towards).into_iter();
    Part {
        object: index,
        light,
        towards,
        blended: blended.map(|one| (one, one.turn * back)).collect(),
        tables: Vec::new(),
        row: Vec::new(),
        tally: Tally::default(),
    }
}

fn empty_table() -> Table {
    Table {
        tally: Tally::default(),
        saturated: 0,
        form: Form::Cells(Stored::F64(Vec::new())),
    }
}

/// The relative standard error of the mean of two halves: half their distance by its length.
fn halves_error(first: &[Rgb], second: &[Rgb]) -> f64 {
    let (mut apart, mut whole) = (0.0, 0.0);
    for (a, b) in first.iter().zip(second) {
        for c in 0..3 {
            apart += (a.0[c] - b.0[c]).powi(2);
            whole += (a.0[c] + b.0[c]).powi(2);
        }
    }
    if whole > 0.0 {
        (apart / whole).sqrt()
    } else {
        0.0
    }
}

/// The mean of sums of as many photons.
fn merge(shed: &mut Shed, other: Shed) {
    for (value, other) in shed.values.iter_mut().zip(other.values) {
        for c in 0..3 {
            value[c] = f64::midpoint(value[c], other[c]);
        }
    }
    let photons = shed.tally.photons + other.tally.photons;
    let mut tally = Tally::default();
    tally.add_scaled(&shed.tally, 0.5);
    tally.add_scaled(&other.tally, 0.5);
    tally.photons = photons;
    shed.tally = tally;
}
