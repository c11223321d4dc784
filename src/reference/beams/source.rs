//! Where the sums of a pass come from.

use super::light::BeamLight;
use super::pass::Passes;
use super::refine::Asked;
use super::traced::BatchSums;
use crate::reference::shard::Shard;
use crate::run::Error;

/// A source of sums, batch by batch.
pub(in crate::reference) trait PassSource {
    /// Told of each pass before it begins: the batches that it has.
    fn begin_pass(&mut self, batches: &[Vec<Asked>]);

    /// What all tasks of the pass's next batch did; `None` if work was stopped, or the source has no more.
    ///
    /// # Errors
    ///
    /// If a texel's flux is not representable.
    fn batch(
        &mut self,
        passes: &Passes,
        lights: &[BeamLight],
        asked: &[Asked],
    ) -> Result<Option<BatchSums>, Error>;
}

/// Sums that are made here.
pub(super) struct Here;

impl PassSource for Here {
    fn begin_pass(&mut self, _: &[Vec<Asked>]) {}

    fn batch(
        &mut self,
        passes: &Passes,
        lights: &[BeamLight],
        asked: &[Asked],
    ) -> Result<Option<BatchSums>, Error> {
        passes.trace(lights, asked, Shard::WHOLE)
    }
}
