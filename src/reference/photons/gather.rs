//! The parts of a run, put together as they come, in any order.
//!
//! A run to an error has rounds. Which round it needs next is known once those before are whole: the run's
//! own schedule is followed again each time, with rounds that are there instead of traced.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::time::Instant;

use super::run::{Run, Setup};
use super::settings::Shard;
use super::shard::{Part, Round, RunIdentity, ShardError, compare};
use crate::reference::rounds::Rounds;
use crate::run::{Budget, Error, Estimate, Refusal};

/// The parts that have come, round by round.
#[derive(Debug, Default)]
pub struct Gathered {
    rounds: BTreeMap<u64, RoundSum>,
}

/// The sum of those of a round's parts that have come.
#[derive(Debug)]
struct RoundSum {
    sum: Part,
    /// Those that are in it, counted from 1.
    given: Vec<u32>,
}

/// What becomes of a run.
#[derive(Debug)]
pub enum Next {
    /// It needs the parts of a round.
    Round(Wanted),
    /// It is done.
    Done(Box<Estimate>),
}

/// A round that a run needs.
#[derive(Clone, Debug)]
pub struct Wanted {
    /// Which one.
    pub round: Round,
    /// A hash of what its parts are made from: it names their contents.
    pub key: String,
    run: RunIdentity,
}

impl Gathered {
    /// Adds a part of a round that is wanted.
    ///
    /// # Errors
    ///
    /// If it is another part than `shard`, or of another run; is there already; or a sum overflows: then all
    /// of its round is dropped.
    pub fn add(&mut self, wanted: &Wanted, shard: Shard, part: Part) -> Result<(), ShardError> {
        compare(&wanted.run, &part.run)?;
        let differs = |field, left: u32, right: u32| ShardError::OtherRun {
            field,
            left: left.to_string(),
            right: right.to_string(),
        };
        if part.shard.count != shard.count {
            let count = part.shard.count;
            return Err(differs("the number of shards", shard.count, count));
        }
        if part.shard.index != shard.index {
            let index = part.shard.index;
            return Err(differs("the shard", shard.index + 1, index + 1));
        }
        let (number, index, count) = (wanted.round.number, shard.index, shard.count);
        let mut place = match self.rounds.entry(number) {
            Entry::Vacant(place) => {
                let given = vec![index + 1];
                place.insert(RoundSum { sum: part, given });
                return Ok(());
            }
            Entry::Occupied(place) => place,
        };
        let there = place.get_mut();
        compare(&there.sum.run, &part.run)?;
        if there.sum.shard.count != count {
            let before = there.sum.shard.count;
            return Err(differs("the number of shards", before, count));
        }
        let Err(at) = there.given.binary_search(&(index + 1)) else {
            let mut given = there.given.clone();
            given.push(index + 1);
            return Err(ShardError::Incomplete { count, given });
        };
        if let Err(error) = there.sum.sums.merge(&part.sums) {
            // Some of it is added, and some is not.
            place.remove();
            return Err(error.into());
        }
        there.given.insert(at, index + 1);
        Ok(())
    }
}

impl Setup<'_> {
    /// The round that a run needs next, or its result: that of the run in one piece, bit for bit.
    ///
    /// # Errors
    ///
    /// If the budget limits time, or parts are of another run, or missing.
    pub fn next(
        &self,
        sensor: &str,
        budget: &Budget,
        gathered: &Gathered,
    ) -> Result<Next, GatherError> {
        check_gathered(budget).map_err(Error::from)?;
        let (schedule, run) = self.begun(budget, Instant::now());
        let mut replay = Replay {
            run,
            sensor,
            gathered,
            needed: None,
            problem: None,
        };
        let incomplete = schedule.spend(&mut replay)?;
        if let Some(problem) = replay.problem {
            return Err(problem.into());
        }
        if let Some(round) = replay.needed {
            let run = self.identity(sensor, round);
            let key = run.key();
            return Ok(Next::Round(Wanted { round, key, run }));
        }
        let direct = self.direct(None);
        let estimate = replay.run.estimate(direct.as_ref(), incomplete);
        Ok(Next::Done(Box::new(estimate)))
    }
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
    let reason = "a run that is divided among machines needs photons or error for a limit, not time: what it finds by \
                  then would depend on the machines";
    Err(Refusal::new(reason))
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

/// A run whose rounds are there already, up to the one that is needed.
struct Replay<'a, 's> {
    run: Run<'a, 's>,
    sensor: &'a str,
    gathered: &'a Gathered,
    needed: Option<Round>,
    problem: Option<ShardError>,
}

impl Replay<'_, '_> {
    /// Adds a round that is there, if it is the one meant and has all of its parts.
    fn add(&mut self, there: &RoundSum, round: Round) -> Result<bool, ShardError> {
        let setup = self.run.setup;
        compare(&setup.identity(self.sensor, round), &there.sum.run)?;
        let count = there.sum.shard.count;
        if there.given.len() != count as usize {
            let given = there.given.clone();
            return Err(ShardError::Incomplete { count, given });
        }
        Ok(self.run.add(&there.sum.sums))
    }
}

impl Rounds for Replay<'_, '_> {
    fn trace(&mut self, number: u64, each: u64, _: Option<Instant>) -> Result<bool, Error> {
        let round = Round {
            number,
            replicates: self.run.replicates,
            photons_each: each,
        };
        let Some(there) = self.gathered.rounds.get(&number) else {
            self.needed = Some(round);
            return Ok(false);
        };
        match self.add(there, round) {
            Ok(is_complete) => Ok(is_complete),
            Err(problem) => {
                self.problem = Some(problem);
                Ok(false)
            }
        }
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
