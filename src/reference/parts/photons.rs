//! Photons in parts of some replicates.

use std::time::Instant;

use super::divided::{Divided, RunInParts};
use super::identity::{About, RunIdentity, filter_of};
use super::sums::Sums;
use crate::reference::photons::run::{Run, Setup};
use crate::reference::rounds::Schedule;
use crate::reference::shard::{Round, Shard};
use crate::run::{Budget, Error, Estimate};

impl Divided for Setup<'_> {
    type Run<'r>
        = Run<'r, 'r>
    where
        Self: 'r;
    type Found = Estimate;

    fn identity(&self, sensor: &str, round: Round) -> RunIdentity {
        let layers = self.map.signatures().iter().map(ToString::to_string);
        let about = About {
            method: "photons",
            scene: self.scene,
            sensor,
            filter: filter_of(&self.target),
            settings: serde_json::to_string(&self.settings).unwrap_or_default(),
            size: self.target.size(),
            layers: layers.collect(),
        };
        RunIdentity::new(about, round)
    }

    fn begin<'r>(&'r self, budget: &'r Budget) -> (Schedule<'r>, Run<'r, 'r>) {
        self.begun(budget, Instant::now())
    }

    fn extent(&self, round: Round) -> (u64, u32) {
        (round.work(), round.replicates)
    }

    fn trace(&self, round: Round, shard: Shard) -> Result<Option<Sums>, Error> {
        let Round {
            number,
            replicates,
            each,
            ..
        } = round;
        let mine = shard.replicates(replicates);
        self.progress.expect_more(round.work_of(mine));
        let sums = self.round(number, each, replicates, shard, None)?;
        Ok((sums.replicates() == mine).then_some(Sums::Photons(sums)))
    }

    fn found(&self, run: Run<'_, '_>, incomplete: bool) -> Estimate {
        run.estimate(self.direct(None).as_ref(), incomplete)
    }
}

impl RunInParts for Run<'_, '_> {
    fn replicates(&self) -> u32 {
        self.replicates
    }

    fn add_round(&mut self, _: Round, sums: &Sums) -> bool {
        matches!(sums, Sums::Photons(sums) if self.add(sums))
    }
}
