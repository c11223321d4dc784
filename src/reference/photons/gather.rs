//! The parts of a run, put together as they come, in any order.
//!
//! A run to an error has rounds. Which round it needs next is known once those before are whole: the run's
//! own schedule is followed again each time, with rounds that are there instead of traced.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::time::Instant;

use super::run::{Run, Setup};
use super::shard::{Part, Round, ShardError, compare};
use crate::reference::rounds::Rounds;
use crate::run::{Budget, Error, Estimate, Refusal};

/// The parts that have come, round by round.
#[derive(Debug, Default)]
pub struct Gathered {
    rounds: BTreeMap<u64, Whole>,
}

/// The sum of a round's parts.
#[derive(Debug)]
struct Whole {
    sum: Part,
    /// Those that are in it, counted from 1.
    given: Vec<u32>,
}

/// What becomes of a run.
#[derive(Debug)]
pub enum Next {
    /// It needs the parts of a round, whose key names their contents.
    Round(Round, String),
    /// It is done.
    Done(Box<Estimate>),
}

impl Gathered {
    /// Adds a part.
    ///
    /// # Errors
    ///
    /// If it is of another run, is there already, or a sum overflows.
    pub fn add(&mut self, part: Part) -> Result<(), ShardError> {
        let (number, index, count) = (part.run.round().number, part.shard.index, part.shard.count);
        let whole = match self.rounds.entry(number) {
            Entry::Vacant(place) => {
                let given = vec![index + 1];
                place.insert(Whole { sum: part, given });
                return Ok(());
            }
            Entry::Occupied(place) => place.into_mut(),
        };
        compare(&whole.sum.run, &part.run)?;
        let there = whole.sum.shard.count;
        if there != count {
            return Err(ShardError::OtherRun {
                field: "the number of shards",
                left: there.to_string(),
                right: count.to_string(),
            });
        }
        let place = whole.given.binary_search(&(index + 1));
        let Err(place) = place else {
            let mut given = whole.given.clone();
            given.push(index + 1);
            return Err(ShardError::Incomplete { count, given });
        };
        whole.sum.sums.merge(&part.sums)?;
        whole.given.insert(place, index + 1);
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
            return Ok(Next::Round(round, self.identity(sensor, round).key()));
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
    fn add(&mut self, whole: &Whole, round: Round) -> Result<bool, ShardError> {
        let setup = self.run.setup;
        compare(&setup.identity(self.sensor, round), &whole.sum.run)?;
        let count = whole.sum.shard.count;
        if whole.given.len() != count as usize {
            let given = whole.given.clone();
            return Err(ShardError::Incomplete { count, given });
        }
        Ok(self.run.add(&whole.sum.sums))
    }
}

impl Rounds for Replay<'_, '_> {
    fn trace(&mut self, number: u64, each: u64, _: Option<Instant>) -> Result<bool, Error> {
        let round = Round {
            number,
            replicates: self.run.replicates,
            photons_each: each,
        };
        let Some(whole) = self.gathered.rounds.get(&number) else {
            self.needed = Some(round);
            return Ok(false);
        };
        match self.add(whole, round) {
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
