//! Tables that outlive a frame: those of an object alone in parallel light.

use std::collections::hash_map::Entry;
use std::sync::Arc;

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::cells::Cells;
use super::directions::{Blended, Samples};
use super::layout::Layout;
use super::object::SpecularObject;
use super::prepare::{Goal, Lit, Shed, stream};
use super::run::Run;
use super::scenery::{Kept, Scenery};
use super::shoot::Tally;
use super::storage::Stored;
use super::table::{Form, Table};
use super::variants::{Directions, Space, Step, Tables};
use crate::numeric::spherical_harmonics;
use crate::run::Error;

impl Run<'_> {
    /// Tables that outlive the frame: those that are there, and those that are not yet.
    pub(super) fn read_kept(
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

fn empty_table() -> Table {
    Table {
        tally: Tally::default(),
        saturated: 0,
        form: Form::Cells(Stored::F64(Vec::new())),
    }
}
