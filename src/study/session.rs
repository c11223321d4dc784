//! Obtaining the runs of a plan: from the store, or by making them.

use std::sync::Arc;
use std::time::Instant;

use super::StudyError;
use super::attribution::{self, Attribution, AttributionError, ReducedSensor, film::truth_of_film};
use super::facts::Product;
use super::plan::{SensorPlan, StudyPlan, StudyRun};
use super::store::{Store, StoredRun, Time, value_key};
use crate::film::exr;
use crate::mitsuba;
use crate::run::{Budget, Context, Light};
use crate::scene::{Scene, Sensor};

/// A study under way.
pub struct Session {
    /// The scene.
    pub scene: Arc<Scene>,
    /// What is to be done.
    pub plan: StudyPlan,
    /// Where films are kept.
    pub store: Store,
}

/// A run that is done, and whether it was found in the store.
#[derive(Clone, Debug, PartialEq)]
pub struct Obtained {
    /// The run.
    pub stored: StoredRun,
    /// Whether nothing had to be computed.
    pub was_kept: bool,
}

/// An attribution that is done, and whether it was found in the store.
#[derive(Clone, Debug, PartialEq)]
pub struct Attributed {
    /// The attribution, or the reason why there is none.
    pub found: Result<Attribution, String>,
    /// Whether nothing had to be computed.
    pub was_kept: bool,
}

impl Session {
    /// Reads the scene of a study and plans its runs; films are kept in `store`.
    ///
    /// # Errors
    ///
    /// Where the scene cannot be read or the study not be planned.
    pub fn new(file: &super::StudyFile, store: Store) -> Result<Self, StudyError> {
        let scene = mitsuba::load(&file.scene, &file.define)?;
        Self::of_scene(Arc::new(scene), file, store)
    }

    /// Plans the runs of a study whose scene is read already.
    ///
    /// # Errors
    ///
    /// Where the study cannot be planned.
    pub fn of_scene(
        scene: Arc<Scene>,
        file: &super::StudyFile,
        store: Store,
    ) -> Result<Self, StudyError> {
        let plan = StudyPlan::new(file, &scene)?;
        Ok(Self { scene, plan, store })
    }

    /// The sensor of a plan.
    ///
    /// # Errors
    ///
    /// Where the scene does not have it.
    pub fn sensor(&self, plan: &SensorPlan) -> Result<&Sensor, StudyError> {
        let mut sensors = self.scene.sensors().iter();
        sensors
            .find(|sensor| sensor.id == plan.sensor)
            .ok_or_else(|| StudyError::NoSensor(plan.sensor.clone()))
    }

    /// A run on a sensor, made where it is not in the store, and as often as its seconds are to be repeated.
    /// `None` where it was stopped: part of a run is not kept.
    ///
    /// # Errors
    ///
    /// Where the method cannot work on the scene, or its film not be kept.
    pub fn obtain(
        &self,
        sensor: &Sensor,
        run: &StudyRun,
        context: &Context,
    ) -> Result<Option<Obtained>, StudyError> {
        let repeats = self.plan.repeats as usize;
        let mut stored = self.store.find(&self.scene, sensor, run);
        let was_kept = stored.as_ref().is_some_and(|it| self.is_timed(it));
        while stored
            .as_ref()
            .is_none_or(|it| it.time.seconds.len() < repeats)
        {
            context.progress.begin_part();
            let start = Instant::now();
            let rendering = run
                .method
                .run(&self.scene, sensor, &Budget::default(), context);
            let rendering = rendering.map_err(|cause| StudyError::Method {
                run: format!("{} on sensor \"{}\"", run.label(), sensor.id),
                cause: Box::new(cause),
            })?;
            if context.progress.is_stopped() {
                return Ok(None);
            }
            let product = Product::of(&rendering);
            let seconds = product.seconds.unwrap_or(start.elapsed().as_secs_f64());
            stored = Some(self.keep(sensor, run, stored, product, seconds)?);
        }
        Ok(stored.map(|stored| Obtained { stored, was_kept }))
    }

    /// True if nothing of a run is to be computed.
    pub fn is_kept(&self, sensor: &Sensor, run: &StudyRun) -> bool {
        let kept = self.store.find(&self.scene, sensor, run);
        kept.is_some_and(|it| self.is_timed(&it))
    }

    /// True if a run has been made as often as its seconds are to be repeated.
    fn is_timed(&self, stored: &StoredRun) -> bool {
        stored.time.seconds.len() >= self.plan.repeats as usize
    }

    /// The error of an approximation, stage by stage, against the film of a truth: from the store, or by
    /// running it. `None` if it was stopped.
    ///
    /// # Errors
    ///
    /// If the approximation cannot work on the scene, or the truth's film not be read.
    pub fn attribution(
        &self,
        plan: &SensorPlan,
        run: &StudyRun,
        truth: &StoredRun,
        context: &Context,
        progressing: attribution::RunProgress,
    ) -> Result<Option<Attributed>, StudyError> {
        let sensor = self.sensor(plan)?;
        if let Some(found) = self.kept_attribution(plan, run)? {
            let was_kept = true;
            return Ok(Some(Attributed { found, was_kept }));
        }
        let film = exr::read(&self.store.path(&truth.exr))?;
        let reduced = ReducedSensor::new(&self.scene, sensor, attribution::SIDE);
        let reference = |light: Light| truth_of_film(&film, truth, &reduced, light);
        let found = attribution::attribute(
            &run.method,
            &self.scene,
            &reduced.sensor,
            context,
            progressing,
            reference,
        );
        // Light that the truth does not have, or not by itself, is no error of the study.
        let found = match found {
            Ok(found) => found.map(Ok),
            Err(cause @ (AttributionError::Dark(_) | AttributionError::Truth(_))) => {
                Some(Err(cause.to_string()))
            }
            Err(cause) => {
                return Err(StudyError::Attribution {
                    run: format!("{} on sensor \"{}\"", run.label(), sensor.id),
                    cause: Box::new(cause),
                });
            }
        };
        if let Some(found) = &found {
            let [name, key] = self.attribution_place(plan, run, sensor);
            self.store.keep_value(&name, &key, found)?;
        }
        let was_kept = false;
        Ok(found.map(|found| Attributed { found, was_kept }))
    }

    /// An attribution that is in the store.
    ///
    /// # Errors
    ///
    /// If the scene does not have the sensor.
    pub fn kept_attribution(
        &self,
        plan: &SensorPlan,
        run: &StudyRun,
    ) -> Result<Option<Result<Attribution, String>>, StudyError> {
        let [name, key] = self.attribution_place(plan, run, self.sensor(plan)?);
        Ok(self.store.find_value(&name, &key))
    }

    /// Name and key of an attribution.
    fn attribution_place(&self, plan: &SensorPlan, run: &StudyRun, sensor: &Sensor) -> [String; 2] {
        let name = format!("{}-{}-stages", sensor.id, run.label());
        let side = attribution::SIDE.to_string();
        let key = value_key(&self.scene, sensor, [run, &plan.truth], &side);
        [name, key]
    }

    fn keep(
        &self,
        sensor: &Sensor,
        run: &StudyRun,
        earlier: Option<StoredRun>,
        product: Product,
        seconds: f64,
    ) -> Result<StoredRun, StudyError> {
        let time = Time::of_this_machine(seconds);
        let Some(mut stored) = earlier else {
            return Ok(self.store.keep(&self.scene, sensor, run, product, time)?);
        };
        // The same run again has the same bits, or the program is wrong.
        if product.facts != stored.facts {
            return Err(StudyError::NotRepeated(run.label()));
        }
        stored.time.repeat(time);
        self.store.keep_time(&stored.exr, &stored.time)?;
        Ok(stored)
    }
}
