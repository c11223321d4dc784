//! The attributions of a study: from the store, or made, in parts that are kept until all are there.

use std::cell::OnceCell;

use super::StudyError;
use super::attribution::{
    self, Attribution, AttributionError, Beginning, KnownFigures, ReducedSensor, RunProgress,
    StageRuns, film::truth_of_film,
};
use super::plan::{SensorPlan, StudyRun};
use super::session::Session;
use super::store::{StoredRun, Value};
use crate::film::exr;
use crate::radiometry::Rgb;
use crate::run::{Context, Light};
use crate::scene::Sensor;

/// An attribution that is done, and whether it was found in the store.
#[derive(Clone, Debug, PartialEq)]
pub struct Attributed {
    /// The attribution, or the reason why there is none.
    pub found: Result<Attribution, String>,
    /// Whether nothing had to be computed.
    pub was_kept: bool,
}

/// A part of an attribution, which is made by itself, on any machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The first run. It needs the truth's film.
    First,
    /// Some of the others, by their number from 0. They need the truth's film and the first part.
    Others(usize),
}

/// An approximation of a study whose error is attributed to its stages.
pub struct Stages<'a> {
    session: &'a Session,
    plan: &'a SensorPlan,
    run: &'a StudyRun,
    sensor: &'a Sensor,
}

impl<'a> Stages<'a> {
    /// Those of a run on a plan's sensor.
    ///
    /// # Errors
    ///
    /// If the scene does not have the sensor.
    pub fn new(
        session: &'a Session,
        plan: &'a SensorPlan,
        run: &'a StudyRun,
    ) -> Result<Self, StudyError> {
        let sensor = session.sensor(plan)?;
        Ok(Self {
            session,
            plan,
            run,
            sensor,
        })
    }

    /// The attribution, or the reason why there is none, if it is in the store.
    pub fn kept(&self) -> Option<Result<Attribution, String>> {
        self.session.store.value(&self.whole())
    }

    /// All its parts.
    pub fn parts(&self) -> Vec<Part> {
        let others = 0..attribution::parts(&self.run.method);
        [Part::First]
            .into_iter()
            .chain(others.map(Part::Others))
            .collect()
    }

    /// The place of a part in the store.
    pub fn place(&self, part: Part) -> Value {
        self.value(&match part {
            Part::First => "-begun".to_owned(),
            Part::Others(number) => {
                let all = attribution::parts(&self.run.method);
                format!("-{}-of-{all}", number + 1)
            }
        })
    }

    /// True if a part is in the store, or is not needed any more.
    pub fn is_kept(&self, part: Part) -> bool {
        self.session.store.has(&self.whole()) || self.session.store.has(&self.place(part))
    }

    /// The attribution against the film of a truth: from the store, or made, as far as its parts are not
    /// kept. `None` if it was stopped.
    ///
    /// # Errors
    ///
    /// If the approximation cannot work on the scene, or a file not be read or written.
    pub fn attribute(
        &self,
        truth: &StoredRun,
        context: &Context,
        progressing: RunProgress,
    ) -> Result<Option<Attributed>, StudyError> {
        if let Some(found) = self.kept() {
            self.forget_parts();
            let was_kept = true;
            return Ok(Some(Attributed { found, was_kept }));
        }
        let reduced = self.reduced();
        let making = self.making(&reduced, truth, context)?;
        let found = match making.beginning()? {
            None => return Ok(None),
            Some(Err(reason)) => Err(reason),
            Some(Ok(beginning)) => {
                let (known, missing) = self.kept_others();
                let make = |beginning: &Beginning, number, heard: &mut dyn FnMut()| {
                    making.others(beginning, number, heard)
                };
                let found = (making.runs).complete(beginning, known, missing, progressing, make)?;
                let Some(found) = found else {
                    return Ok(None);
                };
                Ok(found)
            }
        };
        self.session.store.keep_value(&self.whole(), &found)?;
        self.forget_parts();
        let was_kept = false;
        Ok(Some(Attributed { found, was_kept }))
    }

    /// Makes a part that is not kept, with all that it needs. False if it was stopped.
    ///
    /// # Errors
    ///
    /// As [`attribute`](Self::attribute).
    pub fn make(
        &self,
        part: Part,
        truth: &StoredRun,
        context: &Context,
    ) -> Result<bool, StudyError> {
        if self.is_kept(part) {
            return Ok(true);
        }
        let reduced = self.reduced();
        let making = self.making(&reduced, truth, context)?;
        Ok(match (making.beginning()?, part) {
            (None, _) => false,
            (Some(Ok(beginning)), Part::Others(number)) => {
                making.others(&beginning, number, || ())?.is_some()
            }
            (Some(_), _) => true,
        })
    }

    /// The figures of the other parts that are in the store, and the numbers of those that are not.
    fn kept_others(&self) -> (KnownFigures, Vec<usize>) {
        let (mut known, mut missing) = (KnownFigures::new(), Vec::new());
        for number in 0..attribution::parts(&self.run.method) {
            let place = self.place(Part::Others(number));
            match self.session.store.value::<KnownFigures>(&place) {
                Some(kept) => known.extend(kept),
                None => missing.push(number),
            }
        }
        (known, missing)
    }

    /// Removes parts, which the whole has in it.
    fn forget_parts(&self) {
        for part in self.parts() {
            self.session.store.forget(&self.place(part));
        }
    }

    fn reduced(&self) -> ReducedSensor {
        ReducedSensor::new(&self.session.scene, self.sensor, attribution::SIDE)
    }

    fn making<'m>(
        &'m self,
        reduced: &'m ReducedSensor,
        truth: &'m StoredRun,
        context: &'m Context,
    ) -> Result<Making<'m>, StudyError> {
        let (technique, scene) = (&self.run.method, &*self.session.scene);
        let runs = StageRuns::new(technique, scene, &reduced.sensor, context);
        Ok(Making {
            of: self,
            truth,
            reduced,
            runs: runs.map_err(|error| self.error(error))?,
            light: OnceCell::new(),
        })
    }

    fn whole(&self) -> Value {
        self.value("")
    }

    fn value(&self, end: &str) -> Value {
        let Self { session, run, .. } = self;
        let name = format!("{}-{}-stages{end}", self.sensor.id, run.label());
        let of = [*run, &self.plan.truth];
        let side = attribution::SIDE;
        Value::new(
            name,
            &session.scene,
            self.sensor,
            of,
            &format!("{side}{end}"),
        )
    }

    fn error(&self, cause: AttributionError) -> StudyError {
        StudyError::Attribution {
            run: format!("{} on sensor \"{}\"", self.run.label(), self.sensor.id),
            cause: Box::new(cause),
        }
    }
}

/// An attribution under way.
struct Making<'a> {
    of: &'a Stages<'a>,
    truth: &'a StoredRun,
    reduced: &'a ReducedSensor,
    runs: StageRuns<'a>,
    /// The truth of the light that the approximation models, once its film is read.
    light: OnceCell<Vec<Rgb>>,
}

impl Making<'_> {
    /// The beginning, or the reason why there is no attribution; `None` if it was stopped.
    fn beginning(&self) -> Result<Option<Result<Beginning, String>>, StudyError> {
        let (store, place) = (&self.of.session.store, self.of.place(Part::First));
        if let Some(kept) = store.value(&place) {
            return Ok(Some(kept));
        }
        let film = exr::read(&store.path(&self.truth.exr))?;
        let truth = |light: Light| truth_of_film(&film, self.truth, self.reduced, light);
        let found = match self.runs.begin(truth) {
            Ok(None) => return Ok(None),
            Ok(Some((beginning, light))) => {
                self.light.get_or_init(|| light);
                Ok(beginning)
            }
            // Light that the truth does not have, or not by itself, is no error of the study.
            Err(cause @ (AttributionError::Dark(_) | AttributionError::Truth(_))) => {
                Err(cause.to_string())
            }
            Err(cause) => return Err(self.of.error(cause)),
        };
        store.keep_value(&place, &found)?;
        Ok(Some(found))
    }

    /// Makes one of the other parts, and keeps it; `None` if it was stopped.
    fn others(
        &self,
        beginning: &Beginning,
        number: usize,
        heard: impl FnMut(),
    ) -> Result<Option<KnownFigures>, StudyError> {
        let light = if let Some(light) = self.light.get() {
            light
        } else {
            let light = self.read(beginning.light)?;
            self.light.get_or_init(|| light)
        };
        let found = self.runs.others(beginning, light, number, heard);
        let found = found.map_err(|error| self.of.error(error))?;
        if let Some(found) = &found {
            let place = self.of.place(Part::Others(number));
            self.of.session.store.keep_value(&place, found)?;
        }
        Ok(found)
    }

    fn read(&self, light: Light) -> Result<Vec<Rgb>, StudyError> {
        let film = exr::read(&self.of.session.store.path(&self.truth.exr))?;
        let truth = truth_of_film(&film, self.truth, self.reduced, light);
        let truth = truth.map_err(|error| self.of.error(AttributionError::Truth(error)))?;
        Ok(truth.modelled)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;
    use crate::study::file::StudyWishes;
    use crate::study::{Store, StudyFile};

    /// Names of files are cut off, and what tells parts apart is at a name's end.
    #[test]
    fn parts_have_files_of_their_own_whatever_the_runs_name() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("s.toml");
        let scene = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/glass-ball.xml");
        let name = "a-caustic-map-".repeat(9);
        let text = format!(
            "scene = \"{}\"\n[[method]]\nname = \"{name}\"\nmethod = \"caustic-map\"\n",
            scene.display()
        );
        std::fs::write(&file, text).unwrap();
        let file = StudyFile::wanted(&file, &StudyWishes::default()).unwrap();
        let session = Session::new(&file, Store::open(folder.path()).unwrap()).unwrap();
        let plan = &session.plan.sensors[0];
        let stages = Stages::new(&session, plan, &plan.attributed[0]).unwrap();
        let parts = stages.parts();
        assert!(parts.len() > 5, "{}", parts.len());
        let mut values: Vec<Value> = parts.iter().map(|part| stages.place(*part)).collect();
        values.push(stages.whole());
        let files: HashSet<String> = values.iter().map(Value::file).collect();
        assert_eq!(files.len(), values.len(), "{files:#?}");
        assert!(files.iter().all(|file| file.len() < 120), "{files:#?}");
    }
}
