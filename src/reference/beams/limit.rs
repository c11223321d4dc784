//! Limits that end a pass before it is done.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use crate::run::{Budget, Progress};

/// Rays that take as long as a polygon of flat facets, about. A cell takes one or two, and is seldom without
/// its own rays.
pub const RAYS_A_PLACE: u64 = 8;

/// Limits of time and rays, and a request from outside to stop. All threads ask now and then, in the middle
/// of their work.
///
/// The limit of rays does not depend on threads. The number of rays that a pass needs is fixed, and an excess
/// is noticed at the latest when the pass is done.
pub struct Limit<'a> {
    progress: &'a Progress,
    start: Instant,
    /// The end of the time; `None` if there is none, or if it is too far away to be represented.
    deadline: Option<Instant>,
    /// An earlier end, until the limit is extended.
    early: Option<Instant>,
    is_extended: AtomicBool,
    most_rays: Option<u64>,
    /// Work after which passes end \[rays\]: a forecast was far too low.
    most_work: Option<u64>,
    rays: AtomicU64,
}

impl<'a> Limit<'a> {
    /// The limits of a run that began at `start`.
    pub fn new(budget: &Budget, progress: &'a Progress, start: Instant) -> Self {
        Self {
            progress,
            start,
            deadline: budget.deadline(start),
            early: None,
            is_extended: AtomicBool::new(false),
            most_rays: budget.work,
            most_work: None,
            rays: AtomicU64::new(0),
        }
    }

    /// The same with a limit of work from here on, if any, in rays: a cell or polygon counts for some, too.
    /// Passes do not spare for it: it is a guard, and holds until the limit is [extended](Self::extend).
    #[must_use]
    pub fn guarded(mut self, most_work: Option<u64>) -> Self {
        self.most_work = most_work.map(|most| most.saturating_add(self.rays()));
        self
    }

    /// Work so far, by numbers of rays and of cells and polygons.
    pub fn work(&self, rays: u64, places: u64) -> u64 {
        rays + self.most_work.map_or(0, |_| RAYS_A_PLACE * places)
    }

    /// The same with an earlier end, after some `time`, if any: it holds until the limit is
    /// [extended](Self::extend).
    #[must_use]
    pub fn early(mut self, time: Option<Duration>) -> Self {
        self.early = time.and_then(|time| self.start.checked_add(time));
        self
    }

    /// Takes the earlier end and the guard back, as something is known of all light.
    pub fn extend(&self) {
        self.is_extended.store(true, Ordering::Relaxed);
    }

    fn is_extended(&self) -> bool {
        self.is_extended.load(Ordering::Relaxed)
    }

    fn deadline(&self) -> Option<Instant> {
        let early = self.early.filter(|_| !self.is_extended());
        early.or(self.deadline)
    }

    /// True if time or rays are limited.
    pub fn is_set(&self) -> bool {
        self.deadline.is_some() || self.most_rays.is_some()
    }

    /// True if work must stop.
    pub fn is_reached(&self) -> bool {
        self.progress.is_over(self.deadline()) || self.is_beyond_rays()
    }

    /// True if more rays were searched for than asked for, or more work was done: the same on any threads.
    pub fn is_beyond_rays(&self) -> bool {
        self.is_beyond_guard() || self.most_rays.is_some_and(|most| self.rays() > most)
    }

    /// True if more work was done than the guard allows: a forecast was far too low.
    pub fn is_beyond_guard(&self) -> bool {
        let guard = self.most_work.filter(|_| !self.is_extended());
        guard.is_some_and(|most| self.rays() > most)
    }

    /// Work that the guard allows until it ends passes \[rays\], without an end once it is taken back; `None`
    /// if there is no guard.
    pub fn left_of_guard(&self) -> Option<u64> {
        let most = self.most_work?;
        Some(if self.is_extended() {
            u64::MAX
        } else {
            most.saturating_sub(self.rays())
        })
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
        let in_time = self.deadline().map_or(f64::INFINITY, |deadline| {
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
    fn an_earlier_end_and_a_guard_hold_until_they_are_taken_back() {
        let progress = Progress::default();
        let budget = Budget::time(Duration::from_secs(1000));
        let over = Limit::new(&budget, &progress, Instant::now()).early(Some(Duration::ZERO));
        std::thread::sleep(Duration::from_millis(2));
        assert!(over.is_reached());
        over.extend();
        assert!(!over.is_reached() && over.is_set());
        let guarded = Limit::new(&Budget::default(), &progress, Instant::now()).guarded(Some(100));
        // Twelve polygons are as much work as 96 rays.
        guarded.spend(guarded.work(5, 12));
        assert!(guarded.is_reached() && !guarded.is_set());
        guarded.extend();
        assert!(!guarded.is_reached());
        // Work that was done before counts for nothing.
        let later = Limit::new(&Budget::default(), &progress, Instant::now());
        later.spend(50);
        let later = later.guarded(Some(100));
        later.spend(100);
        assert!(!later.is_beyond_guard());
        later.spend(1);
        assert!(later.is_beyond_guard());
    }

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
