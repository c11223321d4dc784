//! Obtaining the runs of a plan: from the store, or by making them.

use std::sync::Arc;
use std::time::Instant;

use super::StudyError;
use super::facts::Product;
use super::plan::{SensorPlan, StudyPlan, StudyRun};
use super::store::{Store, StoredRun, Time};
use crate::mitsuba;
use crate::run::{Budget, Context};
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
