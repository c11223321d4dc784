//! Work and time by stage.

use std::time::Instant;

use super::Stage;
use crate::run::{Counters, StageWork};

/// Work and time of a stage.
#[derive(Clone, Copy, Debug, Default)]
pub struct Done<W> {
    /// Work.
    pub work: W,
    /// Time \[s\].
    pub seconds: f64,
}

/// A pipeline that has a clock for each stage.
pub trait Clocked: Sized {
    /// A stage.
    type Step;

    /// The time of a stage so far \[s\].
    fn seconds(&mut self, step: Self::Step) -> &mut f64;

    /// Runs a part of a stage on the clock.
    fn timed<T>(&mut self, step: Self::Step, part: impl FnOnce(&mut Self) -> T) -> T {
        let start = Instant::now();
        let result = part(self);
        *self.seconds(step) += start.elapsed().as_secs_f64();
        result
    }
}

/// Work and time of stages, in their order, as a frame has them; `counters` has the work by name.
pub fn stage_work<W>(
    stages: &[Stage],
    done: &[Done<W>],
    counters: impl Fn(&W) -> Counters,
) -> Vec<StageWork> {
    let pairs = stages.iter().zip(done);
    pairs
        .map(|(stage, done)| StageWork {
            work: counters(&done.work),
            seconds: done.seconds,
            ..StageWork::new(stage.name)
        })
        .collect()
}
