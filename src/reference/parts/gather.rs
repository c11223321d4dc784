//! The parts of a run, put together as they come, in any order.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use serde::{Deserialize, Serialize};

use super::identity::{RunIdentity, ShardError};
use super::part::Part;
use super::sums::Sums;
use crate::reference::beams::piece::Piece;
use crate::reference::shard::{Round, Shard};

/// The parts that have come, step by step, by the number of their round or piece.
#[derive(Debug, Default)]
pub struct Gathered {
    steps: BTreeMap<u64, StepSum>,
}

/// The sum of those of a step's parts that have come.
#[derive(Debug)]
struct StepSum {
    sum: Part,
    /// Those that are in it, counted from 1.
    given: Vec<u32>,
}

/// A step of a run, which is made in parts before the next is known.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Step {
    /// A round of replicates.
    Round(Round),
    /// Some batches of a pass of beams.
    Piece(Piece),
}

/// A step that a run needs.
#[derive(Clone, Debug)]
pub struct Wanted {
    /// Which one.
    pub step: Step,
    /// A hash of what its parts are made from: it names their contents.
    pub key: String,
    /// Its work in all, in photons or paths; of beams about, in rays.
    pub work: u64,
    /// The most parts of which each has something to do.
    pub most_parts: u32,
    /// The most work that there may be after it.
    pub left: u64,
    pub(super) run: RunIdentity,
}

impl Gathered {
    /// Adds a part of a round that is wanted.
    ///
    /// # Errors
    ///
    /// If it is another part than `shard`, or of another run; is there already; or a sum overflows: then all
    /// of its round is dropped.
    pub fn add(&mut self, wanted: &Wanted, shard: Shard, part: Part) -> Result<(), ShardError> {
        wanted.run.compare(&part.run)?;
        let there = part.shard;
        if there.count != shard.count {
            let field = "the number of shards";
            return Err(ShardError::differs(field, &shard.count, &there.count));
        }
        if there.index != shard.index {
            let [here, there] = [shard.index, there.index].map(|index| index + 1);
            return Err(ShardError::differs("the shard", &here, &there));
        }
        self.put(part)
    }

    /// Adds a part of any round.
    pub(super) fn put(&mut self, part: Part) -> Result<(), ShardError> {
        let Shard { index, count } = part.shard;
        let mut place = match self.steps.entry(part.run.round.number) {
            Entry::Vacant(place) => {
                let given = vec![index + 1];
                place.insert(StepSum { sum: part, given });
                return Ok(());
            }
            Entry::Occupied(place) => place,
        };
        let there = place.get_mut();
        there.sum.run.compare(&part.run)?;
        let before = there.sum.shard.count;
        if before != count {
            let field = "the number of shards";
            return Err(ShardError::differs(field, &before, &count));
        }
        let Err(at) = there.given.binary_search(&(index + 1)) else {
            let mut given = there.given.clone();
            given.push(index + 1);
            given.sort_unstable();
            return Err(ShardError::Incomplete { count, given });
        };
        if let Err(error) = there.sum.sums.merge(part.sums) {
            // Some of it is added, and some is not.
            place.remove();
            return Err(error);
        }
        there.given.insert(at, index + 1);
        Ok(())
    }

    /// Calls `add` with the sums of a round; `None` if none of its parts is there.
    ///
    /// # Errors
    ///
    /// If they are of another run than `run`, or some are missing.
    pub(super) fn round(
        &self,
        run: &RunIdentity,
        add: &mut dyn FnMut(&Sums) -> bool,
    ) -> Result<Option<bool>, ShardError> {
        let Some(there) = self.steps.get(&run.round.number) else {
            return Ok(None);
        };
        run.compare(&there.sum.run)?;
        let count = there.sum.shard.count;
        if there.given.len() != count as usize {
            let given = there.given.clone();
            return Err(ShardError::Incomplete { count, given });
        }
        Ok(Some(add(&there.sum.sums)))
    }
}

/// Where rounds come from that are not traced here.
pub(super) trait RoundsElsewhere {
    /// Calls `add` with the sums of a round; `None` if none of its parts is there.
    ///
    /// # Errors
    ///
    /// If they are of another run than `run`, damaged, or some are missing.
    fn round(
        &mut self,
        run: &RunIdentity,
        add: &mut dyn FnMut(&Sums) -> bool,
    ) -> Result<Option<bool>, ShardError>;
}

impl RoundsElsewhere for &Gathered {
    fn round(
        &mut self,
        run: &RunIdentity,
        add: &mut dyn FnMut(&Sums) -> bool,
    ) -> Result<Option<bool>, ShardError> {
        Gathered::round(self, run, add)
    }
}
