//! Rounds: a budget of work, time or error, spent by a method that repeats itself.
//!
//! A method with replicates works in rounds, each of all replicates. If only work is limited there is one
//! round. Otherwise there are several, each with twice the work of the one before, or with what is missing to
//! the error asked for, until the next would not fit.

use std::time::{Duration, Instant};

use crate::run::{Budget, Error, Progress};

/// A method that works in rounds. Its unit of work is counted for each replicate.
pub trait Rounds {
    /// Traces round `number`, with so much work `each`, and adds it to the rounds before. Returns false if it
    /// was ended before all replicates were through.
    ///
    /// # Errors
    ///
    /// If numbers cannot be summed.
    fn trace(&mut self, number: u64, each: u64, deadline: Option<Instant>) -> Result<bool, Error>;

    /// Work that each replicate has done.
    fn done(&self) -> u64;

    /// Relative standard error of the rounds so far; `None` while nothing is lit, or without an error bar.
    fn relative_error(&self) -> Option<f64>;

    /// True if no photon or path can find light: more rounds would change nothing.
    fn is_dark(&self) -> bool;
}

/// The schedule of rounds for a budget.
pub struct Schedule<'a> {
    /// The limits.
    pub budget: &'a Budget,
    /// Told of the error so far, and asked whether to stop.
    pub progress: &'a Progress,
    /// The start of the run.
    pub start: Instant,
    /// Work of each replicate in the first of several rounds, and the least that a later round is worth.
    pub first: u64,
    /// The most work of each replicate.
    pub most: u64,
    /// Work of each replicate after which a run without any light has no error to reach.
    pub hopeless: u64,
    /// True if a run that has nothing but its work for a limit is one round, of which whoever stops it keeps
    /// the replicates that are done.
    pub is_in_one: bool,
}

impl Schedule<'_> {
    /// Spends the budget. Returns true if the run ended before its budget was used.
    ///
    /// # Errors
    ///
    /// As [`Rounds::trace`].
    pub fn spend(&self, rounds: &mut impl Rounds) -> Result<bool, Error> {
        if self.is_in_one && self.budget.is_work_only() {
            return Ok(!rounds.trace(0, self.most, None)?);
        }
        let deadline = self.budget.deadline(self.start);
        let mut each = self.first.min(self.most);
        for number in 0.. {
            let complete = rounds.trace(number, each, deadline)?;
            let error = rounds.relative_error();
            self.progress.set_relative_error(error);
            let goal = self.budget.relative_error;
            let is_good = matches!((error, goal), (Some(error), Some(goal)) if error <= goal);
            if !complete || is_good || rounds.is_dark() {
                break;
            }
            let is_hopeless = error.is_none() && rounds.done() >= self.hopeless;
            if is_hopeless && goal.is_some() && self.budget.time.is_none() {
                return Ok(true);
            }
            let Some(next) = self.next(rounds.done(), each, error) else {
                break;
            };
            each = next;
        }
        Ok(self.progress.is_stopped())
    }

    /// Work of each replicate in the next round, after one of `each`; `None` if the budget is used up.
    fn next(&self, done: u64, each: u64, error: Option<f64>) -> Option<u64> {
        let mut next = (2 * each).min(self.most.saturating_sub(done));
        if let (Some(error), Some(goal)) = (error, self.budget.relative_error) {
            next = next.min(self.missing(done, error / goal));
        }
        if let Some(time) = self.budget.time {
            let fits = self.fitting(done, time);
            if fits < next {
                // A power of two suits Sobol' points.
                next = fits.checked_ilog2().map_or(0, |log| 1 << log);
            }
        }
        (next > 0 && next >= self.first.min(each)).then_some(next)
    }

    /// Work of each replicate that an error some `times` too large is likely to need, as a power of two.
    fn missing(&self, done: u64, times: f64) -> u64 {
        /// The error of a few replicates is known to a tenth, about.
        const CAUTION: f64 = 1.2;
        let missing = done as f64 * (CAUTION * times * times - 1.0);
        // A number too large is the largest.
        (missing as u64)
            .max(self.first)
            .checked_next_power_of_two()
            .unwrap_or(u64::MAX)
    }

    /// Work of each replicate that the time left has room for, at the rate so far.
    fn fitting(&self, done: u64, time: Duration) -> u64 {
        /// A round that ends early is of little use.
        const CAUTION: f64 = 0.9;
        let elapsed = self.start.elapsed();
        let rate = done as f64 / elapsed.as_secs_f64();
        let left = time.saturating_sub(elapsed).as_secs_f64();
        (CAUTION * rate * left) as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A method whose error is 1 / √work, of four replicates.
    #[derive(Default)]
    struct Falling {
        rounds: Vec<u64>,
    }

    impl Rounds for Falling {
        fn trace(&mut self, number: u64, each: u64, _: Option<Instant>) -> Result<bool, Error> {
            assert_eq!(number, self.rounds.len() as u64);
            self.rounds.push(each);
            Ok(true)
        }

        fn done(&self) -> u64 {
            self.rounds.iter().sum()
        }

        fn relative_error(&self) -> Option<f64> {
            Some(1.0 / (self.done() as f64).sqrt())
        }

        fn is_dark(&self) -> bool {
            false
        }
    }

    fn spent(budget: Budget, most: u64) -> (Vec<u64>, bool) {
        spent_in(true, budget, most)
    }

    fn spent_in(is_in_one: bool, budget: Budget, most: u64) -> (Vec<u64>, bool) {
        let mut method = Falling::default();
        let progress = Progress::default();
        let schedule = Schedule {
            budget: &budget,
            progress: &progress,
            start: Instant::now(),
            first: 4,
            most,
            hopeless: 1000,
            is_in_one,
        };
        let incomplete = schedule.spend(&mut method).unwrap();
        (method.rounds, incomplete)
    }

    #[test]
    fn work_alone_is_one_round() {
        assert_eq!(spent(Budget::work(70), 70), (vec![70], false));
        // Or several, of all the same.
        assert_eq!(
            spent_in(false, Budget::work(70), 70),
            (vec![4, 8, 16, 32, 10], false)
        );
    }

    #[test]
    fn rounds_double_until_little_is_missing_to_the_error() {
        // 4 + 8 + 16 + 32 = 60 of work: an error of 0.129.
        assert_eq!(
            spent(Budget::error(0.13), u64::MAX),
            (vec![4, 8, 16, 32], false)
        );
        // 1 / √60 is 0.1291: a fifth of 60 more, to be sure, is 12, and the next power of two 16.
        assert_eq!(
            spent(Budget::error(0.129), u64::MAX),
            (vec![4, 8, 16, 32, 16], false)
        );
    }

    #[test]
    fn the_last_round_is_what_work_is_left_if_that_is_worth_one() {
        assert_eq!(spent(Budget::error(1e-9), 33), (vec![4, 8, 16, 5], false));
        assert_eq!(spent(Budget::error(1e-9), 30), (vec![4, 8, 16], false));
    }
}
