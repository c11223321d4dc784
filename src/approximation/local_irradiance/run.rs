//! The stages one after the other: tables for the lights of a frame, and the frame that reads them.

use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use super::demands::{self, are_kept};
use super::lamp::SeenLight;
use super::layout::{Layout, cells_needed, kind};
use super::ledger;
use super::object::SpecularObject;
use super::prepare::{adapted_radii, even_radii};
use super::scenery::{Kept, Reading, Scenery, part};
use super::settings::Settings;
use super::shelf::Shelf;
use super::size::{Size, parts};
use super::variants::{BySteps, Radii, Region, STAGES, Step, Tree};
use super::work::Work;
use crate::approximation::clock::{Clocked, Done, stage_work};
use crate::approximation::{Frame, SensorFilm, SensorPoint};
use crate::radiometry::Rgb;
use crate::run::{Context, Counters, Error, Refusal, StageWork};
use crate::scene::{Scene, Sensor};

/// Work and time of a run, with its place.
pub struct Run<'a> {
    pub(super) settings: &'a Settings,
    pub(super) context: &'a Context,
    pub(super) scene: &'a Scene,
    pub(super) film: SensorFilm,
    pub(super) shelf: Shelf,
    /// Tables that a frame holds at once.
    pub(super) together: u64,
    /// Bytes that a frame takes, its tables included.
    pub(super) needed: u64,
    pub(super) done: BySteps<Done<Work>>,
}

impl Clocked for Run<'_> {
    type Step = Step;
    type Work = Work;

    fn done(&mut self, step: Step) -> &mut Done<Work> {
        &mut self.done[step as usize]
    }
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
        let size = Size::new(scene, sensor, settings);
        Ok(Self {
            settings,
            context,
            scene,
            film: SensorFilm::new(scene, sensor)?,
            shelf: Shelf::new(settings, context),
            together: size.samples.max(1),
            needed: size.bytes(),
            done: Default::default(),
        })
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
        let forms: Vec<Arc<str>> = objects.iter().map(|object| object.form(settings)).collect();
        for (object, form) in objects.into_iter().zip(&forms) {
            let layout = self.layout(kept, &object, form)?;
            scenery.objects.push((object, layout));
        }
        let mut lights = Vec::new();
        for index in 0..scenery.objects.len() {
            for source in &sources {
                let object = &scenery.objects[index];
                if let Some(light) = SeenLight::new(source, object.0.center, settings) {
                    let part = part(&samples, index, object, light, settings.interpolation);
                    scenery.parts.push(part);
                    lights.push(source);
                }
            }
        }
        if are_kept(settings) {
            self.read_kept(kept, &mut scenery, &samples, &forms)?;
        } else {
            self.light_up(&mut scenery, &lights)?;
        }
        kept.account.unwritten += self.shelf.unwritten();
        scenery.warnings.extend(self.shelf.warnings());
        kept.last = Some(scenery);
        Ok(())
    }

    /// The cells around an object: stages `space` and `region`.
    fn layout(
        &mut self,
        kept: &mut Kept,
        object: &SpecularObject,
        form: &Arc<str>,
    ) -> Result<Layout, Error> {
        let settings = self.settings;
        let radii = if kind(settings) != Some(Tree::Shells) {
            Vec::new()
        } else if settings.radii == Radii::Uniform {
            even_radii(settings.shells, settings.reach * object.radius)
        } else if let Some(radii) = kept.radii.get(form) {
            radii.clone()
        } else {
            let region = settings.reach * object.radius;
            let found = self.shelf.radii(form, settings.shells, region);
            let radii = if let Some(radii) = found {
                radii
            } else {
                let made =
                    self.timed(Step::Space, |_, work| adapted_radii(settings, object, work))?;
                self.shelf.keep_radii(form, &made);
                made
            };
            kept.radii.insert(Arc::clone(form), radii.clone());
            radii
        };
        if settings.region != Region::Exact {
            return Ok(Layout::new(settings, object.radius, &radii, 0.0));
        }
        // How many cells there are is known only now.
        let farthest = self.farthest(object.center);
        let cells =
            cells_needed(settings, object.radius, &radii, farthest) * parts(settings) as f64;
        let most = self.most_numbers();
        if cells > most {
            return Err(Refusal::new(format!(
                "region=exact: the sensor sees surfaces up to {farthest:.3} m from an object whose own region has a \
                 radius of {:.3} m: {cells:.2e} cells are more than fit into the memory ({most:.2e}); allowed are \
                 region=clamp and fade, larger cells, and sensors that see less",
                settings.reach * object.radius
            ))
            .into());
        }
        Ok(Layout::new(settings, object.radius, &radii, farthest))
    }

    /// The most numbers of a table whose sums fit into the memory with the frame's other tables, and that
    /// have numbers at all.
    pub(super) fn most_numbers(&self) -> f64 {
        /// Bytes of a number: its sum on a thread; its value, copied once; how it is found again.
        const SUM: f64 = 24.0;
        const VALUE: f64 = 120.0;
        let each = VALUE * self.together as f64 + SUM * rayon::current_num_threads() as f64;
        let free = self.context.available_bytes();
        let fitting = free.map_or(f64::INFINITY, |bytes| bytes as f64 / each);
        fitting.min(f64::from(u32::MAX))
    }

    /// The points that a frame asks for, in batches of texels.
    pub(super) fn batches(&self) -> impl IndexedParallelIterator<Item = Vec<SensorPoint>> + '_ {
        let batches = self.film.batches(self.scene, self.settings.samples);
        batches.map(|(found, _)| found.points)
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

    /// Reads the tables at all places of the sensor.
    pub(super) fn read(&self, scenery: &Scenery) -> (Vec<Rgb>, Work) {
        let settings = self.settings;
        let read = |point: &SensorPoint, reading: &mut Reading| {
            let mut sum = Rgb::BLACK;
            for part in &scenery.parts {
                let (object, layout) = &scenery.objects[part.object];
                sum += part.read(settings, object, layout, point, reading);
            }
            sum
        };
        let (values, reading, rays) = self.film.evaluate(self.scene, settings.samples, read);
        let mut work = reading.work;
        work.add_rays(rays);
        (values, work)
    }

    /// The frame of what was made.
    pub fn frame(&mut self, kept: &Kept) -> Frame {
        let Some(scenery) = &kept.last else {
            return Frame::default();
        };
        let values = self.timed(Step::Space, |this, work| {
            if let Some(image) = &scenery.image {
                return image.clone();
            }
            let (values, done) = this.read(scenery);
            *work += done;
            work.resident += kept.resident(scenery);
            values
        });
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
        Frame {
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
        }
    }
}
