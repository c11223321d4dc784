//! Parts of a run, traced apart and put together to the bits of the run in one piece.

use super::Method;
use super::references::photons;
use super::warnings;
use crate::reference::photons::gather::{GatherError, Gathered, Next, Wanted, check_gathered};
use crate::reference::photons::run::Setup;
use crate::reference::photons::shard::{Part, Round, ShardError, check_budget};
use crate::reference::photons::{PhotonSettings, Shard};
use crate::run::{Budget, Context, Error, Refusal, Rendering};
use crate::scene::{Scene, Sensor};

impl Method {
    /// Traces one part of a run. `None` if it was stopped before its end: part of a shard is of no use.
    ///
    /// # Errors
    ///
    /// If the method is not photons, its settings limit time or error, or as [`Method::run`].
    #[doc(hidden)]
    pub fn run_shard(
        &self,
        scene: &Scene,
        sensor: &Sensor,
        shard: Shard,
        context: &Context,
    ) -> Result<Option<Part>, Error> {
        self.check_memory(scene, sensor, context)?;
        let settings = self.divided(check_budget)?;
        context.install(|| {
            let setup = Setup::new(scene, sensor, settings, &context.progress)?;
            setup.run_shard(&sensor.id, &self.budget(), shard)
        })
    }

    /// Puts the parts of a run together: the bits of the run in one piece.
    ///
    /// # Errors
    ///
    /// If a part is of another run, missing or doubled, or as [`Method::run_shard`].
    #[doc(hidden)]
    pub fn merge(
        &self,
        scene: &Scene,
        sensor: &Sensor,
        parts: Vec<Part>,
        context: &Context,
    ) -> Result<Rendering, MergeError> {
        self.check_memory(scene, sensor, context)
            .map_err(Error::from)?;
        let settings = self.divided(check_budget).map_err(Error::from)?;
        // Direct light is measured here, on the threads asked for.
        context
            .install(|| {
                let setup = Setup::new(scene, sensor, settings, &context.progress)?;
                let warnings = warnings::of_photons(scene, setup.light().is_empty());
                Ok(setup
                    .merge(&sensor.id, parts)
                    .map(|estimate| photons::rendering(scene, &settings, estimate, warnings))
                    .map(|rendering| self.described(rendering, sensor)))
            })?
            .map_err(MergeError::from)
    }

    /// Traces one part of a round. `None` if it was stopped before its end.
    ///
    /// # Errors
    ///
    /// As [`Method::next`].
    #[doc(hidden)]
    pub fn run_part(
        &self,
        scene: &Scene,
        sensor: &Sensor,
        round: Round,
        shard: Shard,
        context: &Context,
    ) -> Result<Option<Part>, Error> {
        self.check_memory(scene, sensor, context)?;
        let settings = self.divided(check_gathered)?;
        context.install(|| {
            let setup = Setup::new(scene, sensor, settings, &context.progress)?;
            setup.run_part(&sensor.id, round, shard)
        })
    }

    /// The round that a run in parts needs next, or its result: the bits of the run in one piece.
    ///
    /// # Errors
    ///
    /// If the method is not photons, its settings limit time, parts do not fit, or as [`Method::run`].
    #[doc(hidden)]
    pub fn next(
        &self,
        scene: &Scene,
        sensor: &Sensor,
        gathered: &Gathered,
        context: &Context,
    ) -> Result<NextPart, MergeError> {
        self.check_memory(scene, sensor, context)
            .map_err(Error::from)?;
        let settings = self.divided(check_gathered).map_err(Error::from)?;
        context
            .install(|| {
                let setup = Setup::new(scene, sensor, settings, &context.progress)?;
                let next = setup.next(&sensor.id, &self.budget(), gathered);
                Ok(next.map(|next| match next {
                    Next::Round(wanted) => NextPart::Round(wanted),
                    Next::Done(estimate) => {
                        let warnings = warnings::of_photons(scene, setup.light().is_empty());
                        let rendering = photons::rendering(scene, &settings, *estimate, warnings);
                        NextPart::Done(Box::new(self.described(rendering, sensor)))
                    }
                }))
            })?
            .map_err(MergeError::from)
    }

    /// The settings of a run that can be divided, if its limits pass `check`.
    fn divided(
        &self,
        check: impl Fn(&Budget) -> Result<(), Refusal>,
    ) -> Result<PhotonSettings, Refusal> {
        if self.name() != "photons" {
            return Err(Refusal::new(format!(
                "shards are for --method photons: a run of {} is made in one piece",
                self.name()
            )));
        }
        check(&self.budget())?;
        Ok(photons::settings(&self.values, PhotonSettings::default()))
    }
}

/// What becomes of a run in parts.
#[derive(Debug)]
pub enum NextPart {
    /// It needs the parts of a round.
    Round(Wanted),
    /// It is done.
    Done(Box<Rendering>),
}

/// An error that ends a merge.
#[derive(Debug, thiserror::Error)]
pub enum MergeError {
    /// The run cannot be set up.
    #[error(transparent)]
    Run(#[from] Error),
    /// The parts do not fit together.
    #[error(transparent)]
    Shard(#[from] ShardError),
}

impl From<GatherError> for MergeError {
    fn from(error: GatherError) -> Self {
        match error {
            GatherError::Run(error) => Self::Run(error),
            GatherError::Shard(error) => Self::Shard(error),
        }
    }
}
