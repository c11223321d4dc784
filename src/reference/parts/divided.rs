//! What a method says of itself to be made in parts, and its schedule, followed with parts.
//!
//! A run to an error has rounds. Which round it needs next is known once those before are whole: the run's
//! own schedule is followed again each time, with rounds that are there instead of traced.

use std::time::Instant;

use super::gather::{Gathered, RoundsElsewhere, Step, Wanted};
use super::identity::{RunIdentity, ShardError};
use super::part::Part;
use super::shards::Shards;
use super::sums::Sums;
use crate::reference::rounds::{Rounds, Schedule};
use crate::reference::shard::{Round, Shard};
use crate::run::{Budget, Error, Refusal};

/// A run, set up, that can be made in parts.
pub trait Divided: Sized {
    /// A run under way.
    type Run<'r>: RunInParts
    where
        Self: 'r;

    /// What a run finds.
    type Found;

    /// What all parts of a round have in common.
    fn identity(&self, sensor: &str, round: Round) -> RunIdentity;

    /// A run that begins, and the schedule by which it spends its budget.
    fn begin<'r>(&'r self, budget: &'r Budget) -> (Schedule<'r>, Self::Run<'r>);

    /// The work of a budget that a unit of a round's work is.
    fn unit(&self) -> u64 {
        1
    }

    /// Work of a round in all, in photons or paths; and the most parts of which each has something to do.
    fn extent(&self, round: Round) -> (u64, u32);

    /// Traces the shard's part of a round. `None` if it was stopped before its end.
    ///
    /// # Errors
    ///
    /// If contributions are not representable.
    fn trace(&self, round: Round, shard: Shard) -> Result<Option<Sums>, Error>;

    /// What a run has found that ended before its budget was used, if it is `incomplete`.
    fn found(&self, run: Self::Run<'_>, incomplete: bool) -> Self::Found;

    /// Traces the shard's part of a round. `None` if it was stopped before its end.
    ///
    /// # Errors
    ///
    /// If contributions are not representable.
    fn run_part(&self, sensor: &str, round: Round, shard: Shard) -> Result<Option<Part>, Error> {
        let sums = self.trace(round, shard)?;
        Ok(sums.map(|sums| Part {
            run: self.identity(sensor, round),
            shard,
            whole: None,
            sums,
        }))
    }

    /// Traces the shard's part of each round of a run, and returns the contents of its file. `None` if it was
    /// stopped before its end, since part of a shard is of no use.
    ///
    /// # Errors
    ///
    /// If the budget limits anything but work, or contributions are not representable.
    fn run_shard(
        &self,
        sensor: &str,
        budget: &Budget,
        shard: Shard,
    ) -> Result<Option<Vec<u8>>, GatherError> {
        check_budget(budget).map_err(Error::from)?;
        let (schedule, run) = self.begin(budget);
        let mut traced = Traced {
            setup: self,
            sensor,
            shard,
            run,
            whole: schedule.most,
            done: 0,
            file: Ok(Some(Vec::new())),
        };
        schedule.spend(&mut traced)?;
        Ok(traced.file?)
    }

    /// Puts the shards of a run together. The result is that of the run in one piece, bit for bit.
    ///
    /// # Errors
    ///
    /// If a shard is of another run, missing or doubled.
    fn merge(&self, sensor: &str, shards: &mut Shards) -> Result<Self::Found, GatherError> {
        // As much as the shards say: whoever merges them need not know.
        let work = shards.work()?.saturating_mul(self.unit());
        match replay(self, sensor, &Budget::work(work), shards)? {
            Next::Done(found) => {
                shards.check_end()?;
                Ok(*found)
            }
            Next::Step(wanted) => Err(ShardError::NoRound(wanted.run.round.number).into()),
        }
    }

    /// The round that a run needs next, or its result: that of the run in one piece, bit for bit.
    ///
    /// # Errors
    ///
    /// If the budget limits time, or parts are of another run, or missing.
    fn next(
        &self,
        sensor: &str,
        budget: &Budget,
        mut gathered: &Gathered,
    ) -> Result<Next<Self::Found>, GatherError> {
        check_gathered(budget).map_err(Error::from)?;
        replay(self, sensor, budget, &mut gathered)
    }
}

/// Follows the schedule of a run with rounds from elsewhere.
fn replay<S: Divided>(
    setup: &S,
    sensor: &str,
    budget: &Budget,
    source: &mut dyn RoundsElsewhere,
) -> Result<Next<S::Found>, GatherError> {
    let (schedule, run) = setup.begin(budget);
    let mut replay = Replay {
        setup,
        run,
        sensor,
        source,
        needed: None,
        problem: None,
    };
    let incomplete = schedule.spend(&mut replay)?;
    if let Some(problem) = replay.problem {
        return Err(problem.into());
    }
    if let Some((round, run)) = replay.needed {
        let (work, most_parts) = setup.extent(round);
        let done = round.before.saturating_add(round.each);
        let each = schedule.most.saturating_sub(done);
        return Ok(Next::Step(Box::new(Wanted {
            step: Step::Round(round),
            key: run.key(),
            work,
            most_parts,
            left: setup.extent(Round { each, ..round }).0,
            run,
        })));
    }
    Ok(Next::Done(Box::new(setup.found(replay.run, incomplete))))
}

/// A run under way whose rounds may come from elsewhere.
pub trait RunInParts: Rounds {
    /// Number of replicates.
    fn replicates(&self) -> u32;

    /// Adds a round. True if it has all replicates.
    fn add_round(&mut self, round: Round, sums: &Sums) -> bool;
}

/// What becomes of a run.
#[derive(Debug)]
pub enum Next<T> {
    /// It needs the parts of a step.
    Step(Box<Wanted>),
    /// It is done.
    Done(Box<T>),
}

/// An error that ends a run in parts.
#[derive(Debug, thiserror::Error)]
pub enum GatherError {
    /// The run cannot go on.
    #[error(transparent)]
    Run(#[from] Error),
    /// The parts do not fit together.
    #[error(transparent)]
    Shard(#[from] ShardError),
}

/// Refuses budgets whose work is not known beforehand.
///
/// # Errors
///
/// If time or error is limited.
pub fn check_budget(budget: &Budget) -> Result<(), Refusal> {
    if budget.is_work_only() {
        return Ok(());
    }
    let reason = "a shard needs a fixed number of photons or samples: give --photons or --spp, and neither --time nor \
                  --error";
    Err(Refusal::new(reason))
}

/// Refuses budgets that a clock ends.
///
/// # Errors
///
/// If time is limited.
pub fn check_gathered(budget: &Budget) -> Result<(), Refusal> {
    if budget.time.is_none() {
        return Ok(());
    }
    let reason = "a run that is divided among machines needs photons, samples or error for a limit, not time: what it \
                  finds by then would depend on the machines";
    Err(Refusal::new(reason))
}

/// The number of a round, and what is in it.
fn round_of(run: &impl RunInParts, number: u64, each: u64, before: u64) -> Round {
    Round {
        number,
        replicates: run.replicates(),
        each,
        before,
    }
}

/// A run of which one part is traced.
struct Traced<'a, S: Divided + 'a> {
    setup: &'a S,
    sensor: &'a str,
    shard: Shard,
    /// The run before any round: none is added, since one part has no error.
    run: S::Run<'a>,
    /// Work of each replicate in all rounds.
    whole: u64,
    done: u64,
    /// The parts of its rounds, as they are written; none after it was stopped.
    file: Result<Option<Vec<u8>>, ShardError>,
}

impl<S: Divided> Rounds for Traced<'_, S> {
    fn trace(&mut self, number: u64, each: u64, _: Option<Instant>) -> Result<bool, Error> {
        let round = round_of(&self.run, number, each, self.done);
        let part = self.setup.run_part(self.sensor, round, self.shard)?;
        self.done += each;
        if let (Ok(Some(file)), Some(part)) = (&mut self.file, part) {
            let part = Part {
                whole: Some(self.whole),
                ..part
            };
            match part.write_to(file) {
                Ok(()) => return Ok(true),
                Err(error) => self.file = Err(error),
            }
        } else {
            self.file = Ok(None);
        }
        Ok(false)
    }

    fn done(&self) -> u64 {
        self.done
    }

    fn relative_error(&self) -> Option<f64> {
        None
    }

    fn is_dark(&self) -> bool {
        self.run.is_dark()
    }
}

/// A run whose rounds are there already, up to the one that is needed.
struct Replay<'a, 'b, S: Divided + 'a> {
    setup: &'a S,
    run: S::Run<'a>,
    sensor: &'a str,
    source: &'b mut dyn RoundsElsewhere,
    needed: Option<(Round, RunIdentity)>,
    problem: Option<ShardError>,
}

impl<S: Divided> Rounds for Replay<'_, '_, S> {
    fn trace(&mut self, number: u64, each: u64, _: Option<Instant>) -> Result<bool, Error> {
        let round = round_of(&self.run, number, each, self.run.done());
        let run = self.setup.identity(self.sensor, round);
        let mut add = |sums: &Sums| self.run.add_round(round, sums);
        match self.source.round(&run, &mut add) {
            Ok(Some(is_complete)) => return Ok(is_complete),
            Ok(None) => self.needed = Some((round, run)),
            Err(problem) => self.problem = Some(problem),
        }
        Ok(false)
    }

    fn done(&self) -> u64 {
        self.run.done()
    }

    fn relative_error(&self) -> Option<f64> {
        self.run.relative_error()
    }

    fn is_dark(&self) -> bool {
        self.run.is_dark()
    }
}
