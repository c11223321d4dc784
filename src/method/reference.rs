//! The interface of a reference, as the table of methods sees it.

use crate::reference::parts::{Divided, GatherError, Gathered, Next, Part, Shards, Step};
use crate::reference::shard::Shard;
use crate::run::{Budget, Context, Cost, Error, Refusal, Rendering};
use crate::scene::{Scene, Sensor};
use crate::setting::{Setting, Values};

/// Facts of a reference that no scene changes.
pub(super) struct About {
    /// The name, as on the command line.
    pub name: &'static str,
    /// One line: the light that it measures, and how.
    pub meaning: &'static str,
    /// The limits of a run, the error and the time first if it has them.
    pub limits: &'static [Setting],
    /// The key of the limit on work; `None` for methods whose work is fixed.
    pub work_key: Option<&'static str>,
    /// All other settings.
    pub settings: &'static [Setting],
    /// True if it fills cameras only.
    pub is_of_cameras: bool,
}

/// A reference: one of the methods that compute the truth.
pub(super) trait Reference: Sync {
    /// Facts that no scene changes.
    fn about(&self) -> &'static About;

    /// True if it traces light of one wavelength where an index depends on it.
    fn follows_dispersion(&self) -> bool {
        false
    }

    /// Refuses scenes and sensors that it cannot work on, without running it.
    fn supports(&self, scene: &Scene, sensor: &Sensor, values: &Values) -> Result<(), Refusal>;

    /// Memory and counted work of a run.
    fn cost(&self, scene: &Scene, sensor: &Sensor, values: &Values) -> Cost;

    /// Memory \[bytes\] of a run whose light is that which a pilot finds: at most that of the
    /// [`cost`](Self::cost), and nearer to what it takes.
    ///
    /// # Errors
    ///
    /// As of a run.
    fn pilot(&self, scene: &Scene, sensor: &Sensor, values: &Values) -> Result<u64, Error> {
        Ok(self.cost(scene, sensor, values).bytes)
    }

    /// Fills a sensor.
    fn run(&self, job: &Job) -> Result<Rendering, Error>;

    /// The same in parts; `None` if its runs are made in one piece.
    fn in_parts(&self) -> Option<&dyn InParts> {
        None
    }
}

/// A reference whose runs can be divided.
pub(super) trait Divisible: Sync {
    /// A run, set up.
    type Setup<'a>: Divided;

    /// Sets a run up.
    fn setup<'a>(&self, job: &Job<'a>) -> Result<Self::Setup<'a>, Error>;

    /// The result of a run, made in one piece or put together of parts.
    fn rendering<'a>(
        &self,
        job: &Job<'a>,
        setup: &Self::Setup<'a>,
        found: <Self::Setup<'a> as Divided>::Found,
    ) -> Rendering;
}

/// Runs in parts, whatever the reference.
pub(super) trait InParts: Sync {
    /// Refuses shards, if no part of a run is known beforehand.
    fn check_shards(&self) -> Result<(), Refusal> {
        Ok(())
    }

    /// The file of one part of each round; `None` if it was stopped before its end.
    fn run_shard(&self, job: &Job, shard: Shard) -> Result<Option<Vec<u8>>, GatherError>;

    /// One part of one round, or of a piece of beams; `None` if it was stopped before its end.
    fn run_part(&self, job: &Job, step: &Step, shard: Shard) -> Result<Option<Part>, Error>;

    /// All parts of all rounds, put together.
    fn merge(&self, job: &Job, shards: &mut Shards) -> Result<Rendering, GatherError>;

    /// The round that is needed next, or the result.
    fn next(&self, job: &Job, gathered: &Gathered) -> Result<Next<Rendering>, GatherError>;
}

impl<T: Divisible> InParts for T {
    fn run_shard(&self, job: &Job, shard: Shard) -> Result<Option<Vec<u8>>, GatherError> {
        let setup = self.setup(job)?;
        setup.run_shard(&job.sensor.id, job.budget, shard)
    }

    fn run_part(&self, job: &Job, step: &Step, shard: Shard) -> Result<Option<Part>, Error> {
        let Step::Round(round) = step else {
            return Err(other_step());
        };
        self.setup(job)?.run_part(&job.sensor.id, *round, shard)
    }

    fn merge(&self, job: &Job, shards: &mut Shards) -> Result<Rendering, GatherError> {
        let setup = self.setup(job)?;
        let found = setup.merge(&job.sensor.id, shards)?;
        Ok(self.rendering(job, &setup, found))
    }

    fn next(&self, job: &Job, gathered: &Gathered) -> Result<Next<Rendering>, GatherError> {
        let setup = self.setup(job)?;
        Ok(match setup.next(&job.sensor.id, job.budget, gathered)? {
            Next::Step(wanted) => Next::Step(wanted),
            Next::Done(found) => Next::Done(Box::new(self.rendering(job, &setup, *found))),
        })
    }
}

/// The error of a step of another method.
pub(super) fn other_step() -> Error {
    let reason = "the step is of another method: rounds are of photons and paths, pieces of beams";
    Refusal::new(reason).into()
}

/// A run that is asked for.
#[derive(Clone, Copy)]
pub(super) struct Job<'a> {
    pub scene: &'a Scene,
    pub sensor: &'a Sensor,
    pub values: &'a Values,
    pub budget: &'a Budget,
    pub context: &'a Context,
}
