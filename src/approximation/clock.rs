//! Work and time by stage.

use std::ops::AddAssign;
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
    /// Its work.
    type Work: Default + AddAssign;

    /// The work and time of a stage so far.
    fn done(&mut self, step: Self::Step) -> &mut Done<Self::Work>;

    /// Runs a part of a stage on the clock, and counts its work.
    fn timed<T>(
        &mut self,
        step: Self::Step,
        part: impl FnOnce(&mut Self, &mut Self::Work) -> T,
    ) -> T {
        let start = Instant::now();
        let mut work = Self::Work::default();
        let result = part(self, &mut work);
        let done = self.done(step);
        done.work += work;
        done.seconds += start.elapsed().as_secs_f64();
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
