//! Paths in parts of some rows of the image.

use std::time::Instant;

use super::divided::{Divided, RunInParts};
use super::identity::{About, RunIdentity};
use super::sums::Sums;
use crate::reference::path::PathReport;
use crate::reference::path::bands::Bands;
use crate::reference::path::run::{Run, Setup};
use crate::reference::path::sums::RoundSums;
use crate::reference::rounds::Schedule;
use crate::reference::shard::{Round, Shard};
use crate::run::{Budget, Error, Estimate};

impl Divided for Setup<'_> {
    type Run<'r>
        = Run<'r, 'r>
    where
        Self: 'r;
    type Found = (Estimate, PathReport);

    fn identity(&self, sensor: &str, round: Round) -> RunIdentity {
        let about = About {
            method: "path",
            scene: self.scene,
            sensor,
            filter: Some(self.camera.filter()),
            settings: serde_json::to_string(&self.settings).unwrap_or_default(),
            size: [self.camera.width(), self.camera.height()],
            layers: Vec::new(),
        };
        RunIdentity::new(about, round)
    }

    fn begin<'r>(&'r self, budget: &'r Budget) -> (Schedule<'r>, Run<'r, 'r>) {
        self.begun(budget, Instant::now())
    }

    fn extent(&self, round: Round) -> (u64, u32) {
        let pixels = (self.camera.width() * self.camera.height()) as u64;
        (
            round.work().saturating_mul(pixels),
            Bands::most(self.camera.height()),
        )
    }

    fn trace(&self, round: Round, shard: Shard) -> Result<Option<Sums>, Error> {
        let bands = Bands::of(shard, self.camera.height());
        let sums = self.round(round, bands, None)?;
        let is_whole = sums.replicates == round.replicates;
        Ok(is_whole.then(|| Sums::Path(vec![(shard, sums)])))
    }

    fn found(&self, run: Run<'_, '_>, incomplete: bool) -> Self::Found {
        run.estimate(incomplete)
    }
}

impl RunInParts for Run<'_, '_> {
    fn replicates(&self) -> u32 {
        self.replicates
    }

    fn add_round(&mut self, round: Round, sums: &Sums) -> bool {
        let Sums::Path(parts) = sums else {
            return false;
        };
        let camera = &self.setup.camera;
        let image = RoundSums::of_parts(camera.width(), camera.height(), parts);
        self.add(&image, round.each)
    }
}
