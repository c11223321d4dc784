//! Limits that end a pass before it is done.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use crate::run::{Budget, Progress};

/// Limits of time and rays, and a request from outside to stop. All threads ask now and then, in the middle
/// of their work.
///
/// The limit of rays does not depend on threads. The number of rays that a pass needs is fixed, and an excess
/// is noticed at the latest when the pass is done.
pub struct Limit<'a> {
    progress: &'a Progress,
    /// The end of the time; `None` if there is none, or if it is too far away to be represented.
    deadline: Option<Instant>,
    most_rays: Option<u64>,
    rays: AtomicU64,
}

impl<'a> Limit<'a> {
    /// The limits of a run that began at `start`.
    pub fn new(budget: &Budget, progress: &'a Progress, start: Instant) -> Self {
        Self {
            progress,
            deadline: budget.deadline(start),
            most_rays: budget.work,
            rays: AtomicU64::new(0),
        }
    }

    /// True if time or rays are limited.
    pub fn is_set(&self) -> bool {
        self.deadline.is_some() || self.most_rays.is_some()
    }

    /// True if work must stop.
    pub fn is_reached(&self) -> bool {
        self.progress.is_stopped()
            || self
                .deadline
                .is_some_and(|deadline| Instant::now() > deadline)
            || self.is_beyond_rays()
    }

    /// True if more rays were searched for than asked for: the same on any threads.
    pub fn is_beyond_rays(&self) -> bool {
        self.most_rays.is_some_and(|most| self.rays() > most)
    }

    /// Adds rays to the work done.
    pub fn spend(&self, rays: u64) {
        self.rays.fetch_add(rays, Ordering::Relaxed);
    }

    /// Number of rays so far.
    pub fn rays(&self) -> u64 {
        self.rays.load(Ordering::Relaxed)
    }

    /// Factor by which the rest of the budget exceeds a piece of work that took `time` and `rays`.
    pub fn affordable(&self, time: Duration, rays: u64) -> f64 {
        let in_time = self.deadline.map_or(f64::INFINITY, |deadline| {
            let left = deadline.saturating_duration_since(Instant::now());
            left.as_secs_f64() / time.as_secs_f64()
        });
        let in_rays = self.most_rays.map_or(f64::INFINITY, |most| {
            most.saturating_sub(self.rays()) as f64 / rays as f64
        });
        // 0 / 0 if there was no work: no limit then.
        f64::min(in_time, in_rays)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_beyond_the_end_of_time_is_none() {
        let progress = Progress::default();
        let budget = Budget {
            time: Some(Duration::MAX),
            ..Budget::default()
        };
        let limit = Limit::new(&budget, &progress, Instant::now());
        assert!(!limit.is_reached());
        assert_eq!(limit.affordable(Duration::from_secs(1), 1), f64::INFINITY);
    }

    #[test]
    fn rays_are_a_limit() {
        let progress = Progress::default();
        let budget = Budget {
            work: Some(100),
            ..Budget::default()
        };
        let limit = Limit::new(&budget, &progress, Instant::now());
        limit.spend(20);
        assert_eq!(limit.affordable(Duration::ZERO, 20), 4.0);
        limit.spend(80);
        assert!(!limit.is_reached());
        limit.spend(1);
        assert!(limit.is_reached());
    }
}
