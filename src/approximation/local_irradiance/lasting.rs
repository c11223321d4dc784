//! Tables that outlive a frame: those of an object alone in parallel light.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::chunk::{Content, Key, is_fitted};
use super::directions::{Blended, Samples};
use super::file::Expected;
use super::layout::Layout;
use super::object::SpecularObject;
use super::prepare::{Goal, Lit, Shed, stream};
use super::run::Run;
use super::scenery::{Kept, Scenery};
use super::settings::Settings;
use super::shoot::Tally;
use super::storage::Stored;
use super::table::{Form, Table};
use super::variants::{Step, Tables};
use crate::approximation::clock::Clocked as _;
use crate::numeric::spherical_harmonics;
use crate::run::Error;

/// A table that is asked for.
struct Wanted {
    object: usize,
    key: Key,
    /// True if the frame reads it.
    is_read: bool,
}

impl Run<'_> {
    /// Tables that outlive the frame: those that are there, those that have files, and the others by photons.
    pub(super) fn read_kept(
        &mut self,
        kept: &mut Kept,
        scenery: &mut Scenery,
        samples: &Samples,
        forms: &[Arc<str>],
    ) -> Result<(), Error> {
        let settings = self.settings;
        if is_fitted(settings) {
            for part in &mut scenery.parts {
                part.row = spherical_harmonics(part.towards, settings.order as usize);
                part.blended.truncate(1);
                part.blended[0].0.weight = 1.0;
            }
        }
        let wanted = wanted(settings, scenery, samples, forms);
        self.make_room(kept, &wanted);
        let missing = self.load(kept, scenery, wanted);
        let torn = self.make_missing(kept, scenery, samples, missing)?;
        for part in &mut scenery.parts {
            let form = &forms[part.object];
            let table = |blended: &Blended| {
                let key = Key::new(form, read_by(settings, blended));
                Arc::clone(torn.get(&key).unwrap_or_else(|| &kept.tables[&key]))
            };
            part.tables = part.blended.iter().map(|(one, _)| table(one)).collect();
            let tables = part.tables.clone();
            part.count(tables.iter().map(|table| &table.tally));
        }
        Ok(())
    }

    /// Lets go of tables of earlier frames if they do not fit into the memory beside this frame. They come
    /// back from files, or are made again.
    fn make_room(&self, kept: &mut Kept, wanted: &[Wanted]) {
        let held: u64 = kept.tables.values().map(|table| table.bytes()).sum();
        let free = self.context.available_bytes();
        if free.is_some_and(|free| held.saturating_add(self.needed) > free) {
            let wanted: HashSet<&Key> = wanted.iter().map(|one| &one.key).collect();
            kept.tables.retain(|key, _| wanted.contains(key));
        }
    }

    /// Reads files of tables that are not in memory; those that have none are left.
    fn load(&mut self, kept: &mut Kept, scenery: &Scenery, wanted: Vec<Wanted>) -> Vec<Wanted> {
        let settings = self.settings;
        self.timed(Step::Storage, |this, work| {
            let mut missing = Vec::new();
            for one in wanted {
                if kept.tables.contains_key(&one.key) {
                    continue;
                }
                let expected = Expected::new(settings, &scenery.objects[one.object].1);
                if let Some(table) = this.shelf.table(&one.key, &expected) {
                    work.loaded += 1;
                    kept.account.add_read(table.bytes());
                    kept.tables.insert(one.key, Arc::new(table));
                } else {
                    missing.push(one);
                }
            }
            missing
        })
    }

    /// Makes tables, and writes their files. Tables of a run that was stopped lack photons: they serve its
    /// own frame alone.
    fn make_missing(
        &mut self,
        kept: &mut Kept,
        scenery: &Scenery,
        samples: &Samples,
        missing: Vec<Wanted>,
    ) -> Result<HashMap<Key, Arc<Table>>, Error> {
        let (settings, context) = (self.settings, self.context);
        let progress = &context.progress;
        let photons = if is_fitted(settings) {
            settings.photons * samples.all().len() as u64
        } else {
            settings.photons
        };
        if !missing.is_empty() {
            progress.expect(progress.done() + photons * missing.len() as u64);
        }
        let mut torn = HashMap::new();
        for one in missing {
            if progress.is_stopped() && !one.is_read {
                kept.account.missing += 1;
                continue;
            }
            let (object, layout) = &scenery.objects[one.object];
            let table = match one.key.content {
                Content::Sample(sample) => {
                    self.table(object, layout, samples.all()[sample], sample)?
                }
                Content::Harmonics | Content::Shells => self.harmonics(object, layout, samples)?,
            };
            if table.tally.photons == photons {
                self.timed(Step::Storage, |this, _| this.shelf.keep(&one.key, &table));
                kept.account.add_made(table.bytes());
                kept.tables.insert(one.key, Arc::new(table));
            } else {
                kept.account.missing += 1;
                torn.insert(one.key, Arc::new(table));
            }
        }
        Ok(torn)
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
            context.progress.add(shed.tally.photons);
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
        Ok(self.timed(Step::Storage, |_, work| {
            let table = layout.table(settings, shed.values, shed.tally);
            work.saturated += table.saturated;
            table
        }))
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
        let cells = layout.count();
        let mut sums = vec![[0.0f64; 3]; cells * number];
        let mut tally = Tally::default();
        for (sample, towards) in samples.all().iter().enumerate() {
            let shed = self.sample(object, layout, *towards, sample)?;
            tally.add_scaled(&shed.tally, 1.0 / samples.all().len() as f64);
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
            });
        }
        let (stored, saturated) = Stored::new(sums, settings.storage, settings.range);
        Ok(Table {
            tally,
            saturated,
            form: Form::Harmonics(stored),
        })
    }
}

/// The tables that a frame reads, and then all others if they are asked for; none twice.
fn wanted(
    settings: &Settings,
    scenery: &Scenery,
    samples: &Samples,
    forms: &[Arc<str>],
) -> Vec<Wanted> {
    let mut known = HashSet::new();
    let mut wanted = Vec::new();
    let mut add = |object: usize, content: Content, is_read: bool| {
        let key = Key::new(&forms[object], content);
        if known.insert(key.clone()) {
            wanted.push(Wanted {
                object,
                key,
                is_read,
            });
        }
    };
    for part in &scenery.parts {
        for (blended, _) in &part.blended {
            add(part.object, read_by(settings, blended), true);
        }
    }
    if settings.tables == Tables::All {
        for object in 0..scenery.objects.len() {
            for content in Content::tables(settings, samples) {
                add(object, content, false);
            }
        }
    }
    wanted
}

/// The table that a blended sample is read from.
fn read_by(settings: &Settings, blended: &Blended) -> Content {
    if is_fitted(settings) {
        Content::Harmonics
    } else {
        Content::Sample(blended.sample)
    }
}

fn empty_table() -> Table {
    Table {
        tally: Tally::default(),
        saturated: 0,
        form: Form::Cells(Stored::F64(Vec::new())),
    }
}
