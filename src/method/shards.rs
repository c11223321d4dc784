//! Parts of a run, traced apart and put together to the bits of the run in one piece.

use super::Method;
use super::entry::Entry;
use super::reference::{InParts, Job};
use crate::reference::parts::divided::{check_budget, check_gathered};
use crate::reference::parts::{GatherError, Gathered, Next, Part, Shards, Step};
use crate::reference::shard::Shard;
use crate::run::{Budget, Context, Error, Refusal, Rendering};
use crate::scene::{Scene, Sensor};

impl Method {
    /// Traces one part of a run: a part of each of its rounds. Returns the contents of a shard's file; `None`
    /// if it was stopped before its end: part of a shard is of no use.
    ///
    /// # Errors
    ///
    /// If the method's runs are made in one piece, its settings limit time or error, or as [`Method::run`].
    #[doc(hidden)]
    pub fn run_shard(
        &self,
        scene: &Scene,
        sensor: &Sensor,
        shard: Shard,
        context: &Context,
    ) -> Result<Option<Vec<u8>>, GatherError> {
        self.check_shards()?;
        self.in_parts(scene, sensor, context, check_budget, |method, job| {
            method.run_shard(job, shard)
        })
    }

    /// Puts the shards of a run together: the bits of the run in one piece.
    ///
    /// # Errors
    ///
    /// If a shard is of another run, missing or doubled, or as [`Method::run_shard`].
    #[doc(hidden)]
    pub fn merge(
        &self,
        scene: &Scene,
        sensor: &Sensor,
        shards: &mut Shards,
        context: &Context,
    ) -> Result<Rendering, GatherError> {
        self.check_shards()?;
        let merge = |method: &dyn InParts, job: &Job| method.merge(job, shards);
        let rendering = self.in_parts(scene, sensor, context, check_budget, merge)?;
        Ok(self.described(rendering, sensor))
    }

    /// Traces one part of a step of a run. `None` if it was stopped before its end.
    ///
    /// # Errors
    ///
    /// As [`Method::next`].
    #[doc(hidden)]
    pub fn run_part(
        &self,
        scene: &Scene,
        sensor: &Sensor,
        step: &Step,
        shard: Shard,
        context: &Context,
    ) -> Result<Option<Part>, Error> {
        self.in_parts(scene, sensor, context, check_gathered, |method, job| {
            method.run_part(job, step, shard)
        })
    }

    /// The step that a run in parts needs next, or its result: the bits of the run in one piece.
    ///
    /// # Errors
    ///
    /// If the method's runs are made in one piece, its settings limit time, parts do not fit, or as
    /// [`Method::run`].
    #[doc(hidden)]
    pub fn next(
        &self,
        scene: &Scene,
        sensor: &Sensor,
        gathered: &Gathered,
        context: &Context,
    ) -> Result<Next<Rendering>, GatherError> {
        let next = |method: &dyn InParts, job: &Job| method.next(job, gathered);
        Ok(
            match self.in_parts(scene, sensor, context, check_gathered, next)? {
                Next::Step(wanted) => Next::Step(wanted),
                Next::Done(rendering) => Next::Done(Box::new(self.described(*rendering, sensor))),
            },
        )
    }

    /// Does part of a run on the threads asked for, if its limits pass `check`.
    fn in_parts<T: Send, E: Send + From<Error>>(
        &self,
        scene: &Scene,
        sensor: &Sensor,
        context: &Context,
        check: impl Fn(&Budget) -> Result<(), Refusal>,
        work: impl FnOnce(&dyn InParts, &Job) -> Result<T, E> + Send,
    ) -> Result<T, E> {
        self.check_memory(scene, sensor, context)
            .map_err(Error::from)?;
        let method = self.divisible().map_err(Error::from)?;
        // As a run in one piece.
        if self.is_of_cameras() && !sensor.is_camera() {
            self.supports(scene, sensor).map_err(Error::from)?;
        }
        self.entry.check_dispersion(scene).map_err(Error::from)?;
        let budget = self.budget();
        check(&budget).map_err(Error::from)?;
        let job = Job {
            scene,
            sensor,
            values: &self.values,
            budget: &budget,
            context,
        };
        context.install(|| Ok(work(method, &job)))?
    }

    /// Refuses methods that have no shards.
    fn check_shards(&self) -> Result<(), Error> {
        let method = self.in_parts_or_else(|method| {
            let names = names(|one| one.check_shards().is_ok());
            format!("shards are for --method {names}: a run of {method} is made in one piece")
        });
        Ok(method?.check_shards()?)
    }

    /// The method, if its runs can be divided.
    fn divisible(&self) -> Result<&dyn InParts, Refusal> {
        self.in_parts_or_else(|method| {
            let names = names(|_| true);
            format!("runs of {names} can be divided: a run of {method} is made in one piece")
        })
    }

    fn in_parts_or_else(&self, reason: impl Fn(&str) -> String) -> Result<&dyn InParts, Refusal> {
        let method = match &self.entry {
            Entry::Reference(one) => one.in_parts(),
            Entry::Technique(_) => None,
        };
        method.ok_or_else(|| Refusal::new(reason(self.name())))
    }
}

/// The names of those methods that can be divided, as far as `is_meant`.
fn names(is_meant: impl Fn(&dyn InParts) -> bool) -> String {
    let names = Entry::references().filter(|one| one.in_parts().is_some_and(&is_meant));
    let names: Vec<&str> = names.map(|one| one.about().name).collect();
    names.join(", ")
}
