//! Shares of the time.
//!
//! Each method has the time left, divided by the number of those that wait for it, itself included. Paths
//! come last and matter most: without two replicates of them nothing is known of any pixel. So time is set
//! aside for a first round of them, a sample a pixel of each replicate: for all of it, but at most half of
//! the whole time, or for two replicates if these take more than that.

use std::time::{Duration, Instant};

/// The largest part of the time that is set aside for paths, if that has room for two replicates.
const MOST_OF_PATHS: f64 = 0.5;

/// A replicate may take so much longer than a few of its tiles foretell.
const MARGIN: f64 = 1.1;

/// The time of a run.
pub(super) struct Shares {
    start: Instant,
    /// All of it; `None` if it is not limited.
    time: Option<Duration>,
    /// Set aside for paths.
    of_paths: Duration,
}

impl Shares {
    /// Shares of a run that began at `start`, of so many `replicates` of paths. `replicate` tells how long
    /// one of a sample a pixel takes; `None` if that is more than the time that it is given.
    pub fn new(
        start: Instant,
        time: Option<Duration>,
        replicates: u32,
        replicate: impl FnOnce(Duration) -> Option<Duration>,
    ) -> Self {
        // Fewest that say something of their error, if there are as many.
        let least = f64::from(replicates.min(2));
        let of_paths = time.map(|time| {
            let most = time.mul_f64(MOST_OF_PATHS);
            // If not even these fit, nothing is known of the image whatever is set aside.
            let replicate = replicate(time.div_f64(MARGIN * least));
            replicate.map_or(most, |replicate| {
                let replicate = replicate.mul_f64(MARGIN);
                let first_round = replicate.saturating_mul(replicates);
                first_round.min(most.max(replicate.mul_f64(least)))
            })
        });
        Self {
            start,
            time,
            of_paths: of_paths.unwrap_or_default(),
        }
    }

    fn left(&self) -> Option<Duration> {
        Some(self.time?.saturating_sub(self.start.elapsed()))
    }

    /// The share of a method that follows light, the first of so many that wait for it.
    pub fn of_light(&self, waiting: u32) -> Option<Duration> {
        let left = self.left()?;
        let beside_paths = left.saturating_sub(self.of_paths) / waiting;
        Some(beside_paths.min(left / (waiting + 1)))
    }

    /// The share of paths: all that is left, and what was set aside even if others took longer than theirs.
    pub fn of_paths(&self) -> Option<Duration> {
        Some(self.left()?.max(self.of_paths))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MINUTE: Duration = Duration::from_secs(60);

    /// Shares of a minute, of ten replicates of paths that take so many seconds each.
    fn shares(start: Instant, replicate: f64) -> Shares {
        Shares::new(start, Some(MINUTE), 10, |most| {
            Some(Duration::from_secs_f64(replicate)).filter(|it| *it <= most)
        })
    }

    /// Asserts a share in seconds; the test itself takes less than one.
    fn assert_share(share: Option<Duration>, seconds: f64) {
        let share = share.unwrap().as_secs_f64();
        assert!(
            share <= seconds && seconds - share < 1.0,
            "{share} of {seconds}"
        );
    }

    #[test]
    fn methods_share_the_time_left_alike() {
        let shares = shares(Instant::now(), 0.1);
        assert_share(shares.of_light(2), 20.0);
        assert_share(shares.of_light(1), 30.0);
        assert_share(shares.of_paths(), 60.0);
    }

    #[test]
    fn half_the_time_at_most_is_set_aside_for_a_first_round_of_paths() {
        let now = Instant::now();
        // 24 s and a tenth.
        assert_share(shares(now, 2.4).of_light(2), 16.8);
        // Of the last not even two replicates fit.
        for endless in [3.0, 13.0, 100.0] {
            assert_share(shares(now, endless).of_light(2), 15.0);
        }
    }

    #[test]
    fn two_replicates_of_paths_go_before_all_else() {
        assert_share(shares(Instant::now(), 25.0).of_light(1), 5.0);
    }

    #[test]
    fn paths_have_what_was_set_aside_even_if_nothing_is_left() {
        let Some(long_ago) = Instant::now().checked_sub(MINUTE) else {
            return;
        };
        let shares = shares(long_ago, 0.7);
        assert_share(shares.of_light(1), 0.0);
        assert_share(shares.of_paths(), 7.7);
    }

    #[test]
    fn without_a_limit_there_are_no_shares_and_no_round_is_timed() {
        let shares = Shares::new(Instant::now(), None, 10, |_| panic!("timed"));
        assert!(shares.of_light(2).is_none() && shares.of_paths().is_none());
    }
}
