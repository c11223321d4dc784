//! What the tasks of a batch did, which may be done on several machines.

use std::sync::Arc;

use super::film::BeamFilm;
use super::refine::Balance;
use crate::geometry::TraversalCounters;
use crate::numeric::FixedPoint;

/// What tasks of a batch did.
#[derive(Clone, Debug)]
pub enum BatchSums {
    /// Of a scene without colours.
    Grey(ChannelSums<1>),
    /// Of a scene with colours.
    Colours(ChannelSums<3>),
    /// More than a limit of work allows: nothing of it is of use.
    Beyond {
        /// The work until then, as the limit counts it \[rays\].
        work: u64,
    },
}

/// Sums of a batch, in `N` channels.
#[derive(Clone, Debug)]
pub struct ChannelSums<const N: usize> {
    /// A film for each signature, in the order of their events.
    pub films: Vec<Arc<BeamFilm<N>>>,
    /// In the order of the tasks.
    pub done: Vec<TaskDone<N>>,
    /// Work, as a limit counts it \[rays\].
    pub work: u64,
}

/// What a task did.
#[derive(Clone, Debug, PartialEq)]
pub struct TaskDone<const N: usize> {
    /// Its number in the batch.
    pub number: usize,
    /// Of each of its signatures.
    pub signatures: Vec<SignatureDone<N>>,
}

/// What a task did for one of the signatures.
#[derive(Clone, Debug, PartialEq)]
pub struct SignatureDone<const N: usize> {
    /// Its number in the order of events.
    pub signature: usize,
    /// The light of its cells.
    pub balance: Balance<N>,
    /// The work that they took.
    pub counters: TraversalCounters,
}

/// Sums that are not of the same tasks' kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unlike;

impl<const N: usize> SignatureDone<N> {
    /// Adds what was done for more light of the same signature.
    pub fn add(&mut self, more: &Self) {
        self.balance += more.balance;
        self.counters += more.counters;
    }
}

impl BatchSums {
    /// Work, as a limit counts it \[rays\].
    pub fn work(&self) -> u64 {
        match self {
            Self::Grey(sums) => sums.work,
            Self::Colours(sums) => sums.work,
            Self::Beyond { work } => *work,
        }
    }

    /// Tells the work that it took.
    pub(super) fn set_work(&mut self, all: u64) {
        match self {
            Self::Grey(sums) => sums.work = all,
            Self::Colours(sums) => sums.work = all,
            Self::Beyond { work } => *work = all,
        }
    }

    /// True if a texel's flux was not representable: then nothing here is valid.
    pub(super) fn overflowed(&self) -> bool {
        match self {
            Self::Grey(sums) => sums.films.iter().any(|film| film.overflowed()),
            Self::Colours(sums) => sums.films.iter().any(|film| film.overflowed()),
            Self::Beyond { .. } => false,
        }
    }

    /// Adds what other tasks of the same batch did.
    ///
    /// # Errors
    ///
    /// If they are of another batch, or a sum overflows: then nothing here is valid.
    pub fn merge(&mut self, other: Self) -> Result<(), Unlike> {
        let work = self.work().saturating_add(other.work());
        match (&mut *self, other) {
            (Self::Grey(sums), Self::Grey(others)) => sums.merge(others)?,
            (Self::Colours(sums), Self::Colours(others)) => sums.merge(others)?,
            (Self::Beyond { .. }, _) => {}
            (_, Self::Beyond { .. }) => *self = Self::Beyond { work },
            _ => return Err(Unlike),
        }
        self.set_work(work);
        Ok(())
    }

    /// True if it is all that such tasks did for so many signatures.
    pub fn is_whole(&self, tasks: usize, signatures: usize) -> bool {
        match self {
            Self::Grey(sums) => sums.is_whole(tasks, signatures),
            Self::Colours(sums) => sums.is_whole(tasks, signatures),
            Self::Beyond { .. } => false,
        }
    }
}

impl<const N: usize> ChannelSums<N> {
    fn merge(&mut self, other: Self) -> Result<(), Unlike> {
        if self.films.len() != other.films.len() {
            return Err(Unlike);
        }
        for (film, other) in self.films.iter_mut().zip(&other.films) {
            let film = Arc::get_mut(film).ok_or(Unlike)?;
            film.merge(other).ok_or(Unlike)?;
        }
        self.done.extend(other.done);
        self.done.sort_by_key(|task| task.number);
        Ok(())
    }

    /// True if all films have the scale.
    pub(super) fn have_scale(&self, scale: FixedPoint) -> bool {
        self.films.iter().all(|film| film.scale() == scale)
    }

    fn is_whole(&self, tasks: usize, signatures: usize) -> bool {
        let numbers = self.done.iter().map(|task| task.number);
        let of_batch = |done: &SignatureDone<N>| done.signature < signatures;
        self.films.len() == signatures
            && numbers.eq(0..tasks)
            && self
                .done
                .iter()
                .flat_map(|task| &task.signatures)
                .all(of_batch)
    }
}
