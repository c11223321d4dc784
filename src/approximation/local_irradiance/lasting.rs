//! Tables that outlive a frame: those of an object alone in parallel light.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::cells::Cells;
use super::directions::{Blended, Samples};
use super::file::{Expected, HARMONICS, Key};
use super::layout::Layout;
use super::object::SpecularObject;
use super::prepare::{Goal, Lit, Shed, stream};
use super::run::Run;
use super::scenery::{Kept, Scenery};
use super::settings::Settings;
use super::shoot::Tally;
use super::storage::Stored;
use super::table::{Form, Table};
use super::variants::{Directions, Space, Step, Tables};
use crate::numeric::spherical_harmonics;
use crate::run::Error;

/// A form and a sample, by which a table is found again; of harmonics of the light's direction the sample is
/// [`FITTED`].
type Name = (String, usize);

pub const FITTED: usize = usize::MAX;

/// A table that is asked for.
struct Wanted {
    object: usize,
    name: Name,
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
        forms: &[String],
    ) -> Result<(), Error> {
        let settings = self.settings;
        let is_fitted = is_fitted(settings);
        let wanted = wanted(settings, scenery, samples, forms);
        let missing = self.load(kept, scenery, wanted)?;
        let torn = self.make_missing(kept, scenery, samples, missing)?;
        let found = |name: &Name| Arc::clone(torn.get(name).unwrap_or_else(|| &kept.tables[name]));
        for part in &mut scenery.parts {
            let form = &forms[part.object];
            if is_fitted {
                let table = found(&(form.clone(), FITTED));
                part.row = spherical_harmonics(part.towards, settings.order as usize);
                part.tally = table.tally;
                part.tables = vec![table];
                part.blended.truncate(1);
                part.blended[0].0.weight = 1.0;
                continue;
            }
            for (blended, _) in &part.blended {
                let table = found(&(form.clone(), blended.sample));
                part.tally.add_scaled(&table.tally, blended.weight);
                part.tally.photons += table.tally.photons;
                part.tables.push(table);
            }
        }
        Ok(())
    }

    /// Reads files of tables that are not in memory; those that have none are left.
    fn load(
        &mut self,
        kept: &mut Kept,
        scenery: &Scenery,
        wanted: Vec<Wanted>,
    ) -> Result<Vec<Wanted>, Error> {
        let settings = self.settings;
        self.timed(Step::Storage, |this, work| {
            let mut missing = Vec::new();
            for one in wanted {
                if kept.tables.contains_key(&one.name) {
                    continue;
                }
                let expected = Expected::new(settings, &scenery.objects[one.object].1);
                if let Some(table) = this.shelf.table(key(&one.name), &expected) {
                    work.loaded += 1;
                    kept.account.add_read(table.bytes());
                    kept.tables.insert(one.name, Arc::new(table));
                } else {
                    missing.push(one);
                }
            }
            Ok(missing)
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
    ) -> Result<HashMap<Name, Arc<Table>>, Error> {
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
            let sample = one.name.1;
            let table = if sample == FITTED {
                self.harmonics(object, layout, samples)?
            } else {
                self.table(object, layout, samples.all()[sample], sample)?
            };
            if table.tally.photons == photons {
                self.timed(Step::Storage, |this, _| {
                    this.shelf.keep(key(&one.name), &table);
                    Ok(())
                })?;
                kept.account.add_made(table.bytes());
                kept.tables.insert(one.name, Arc::new(table));
            } else {
                kept.account.missing += 1;
                torn.insert(one.name, Arc::new(table));
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
        let cells = layout.cells.as_ref().map_or(0, Cells::count);
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
}

/// The tables that a frame reads, and then all others if they are asked for; none twice.
fn wanted(
    settings: &Settings,
    scenery: &Scenery,
    samples: &Samples,
    forms: &[String],
) -> Vec<Wanted> {
    let mut known = HashSet::new();
    let mut wanted = Vec::new();
    let mut add = |object: usize, sample: usize, is_read: bool| {
        let sample = if is_fitted(settings) { FITTED } else { sample };
        let name = (forms[object].clone(), sample);
        if known.insert(name.clone()) {
            wanted.push(Wanted {
                object,
                name,
                is_read,
            });
        }
    };
    for part in &scenery.parts {
        for (blended, _) in &part.blended {
            add(part.object, blended.sample, true);
        }
    }
    if settings.tables == Tables::All {
        for object in 0..scenery.objects.len() {
            (0..samples.all().len()).for_each(|sample| add(object, sample, false));
        }
    }
    wanted
}

/// True if an object has one table for all light directions: harmonics of these in each cell.
pub fn is_fitted(settings: &Settings) -> bool {
    let is_cellwise = matches!(settings.space, Space::Grid | Space::Shells);
    settings.directions == Directions::Harmonics && is_cellwise
}

fn key(name: &Name) -> Key<'_> {
    Key {
        form: &name.0,
        sample: if name.1 == FITTED {
            HARMONICS
        } else {
            name.1 as u64
        },
    }
}

fn empty_table() -> Table {
    Table {
        tally: Tally::default(),
        saturated: 0,
        form: Form::Cells(Stored::F64(Vec::new())),
    }
}
