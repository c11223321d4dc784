//! Photon maps in parts of some replicates.

use std::time::Instant;

use super::divided::{Divided, RunInParts};
use super::identity::{About, RunIdentity, filter_of};
use super::sums::Sums;
use crate::reference::photon_map::PhotonMapReport;
use crate::reference::photon_map::run::Run;
use crate::reference::photon_map::settings::MOST_MAPS;
use crate::reference::photon_map::setup::Setup;
use crate::reference::rounds::Schedule;
use crate::reference::shard::{Round, Shard};
use crate::run::{Budget, Error, Estimate, Refusal};

impl Divided for Setup<'_> {
    type Run<'r>
        = Run<'r>
    where
        Self: 'r;
    type Found = (Estimate, PhotonMapReport);

    fn identity(&self, sensor: &str, round: Round) -> RunIdentity {
        let layers = self.layer_names().into_iter();
        let about = About {
            method: "photon-map",
            scene: self.scene,
            sensor,
            filter: filter_of(&self.target),
            settings: serde_json::to_string(&self.settings).unwrap_or_default(),
            size: self.target.size(),
            layers: layers.map(|name| name.to_string()).collect(),
        };
        RunIdentity::new(about, round)
    }

    fn begin<'r>(&'r self, budget: &'r Budget) -> (Schedule<'r>, Run<'r>) {
        self.begun(budget, Instant::now())
    }

    fn unit(&self) -> u64 {
        self.settings.map_photons
    }

    fn extent(&self, round: Round) -> (u64, u32) {
        // Each map is looked up from each pixel, too.
        let paths = self
            .settings
            .map_photons
            .saturating_add(self.target.texels() as u64);
        (round.work().saturating_mul(paths), round.replicates)
    }

    fn trace(&self, round: Round, shard: Shard) -> Result<Option<Sums>, Error> {
        let maps = round.before.saturating_add(round.each);
        if maps > MOST_MAPS {
            return Err(Refusal::new(format!(
                "a run in parts has up to {MOST_MAPS} maps a replicate, and this has {maps}: larger maps need fewer"
            ))
            .into());
        }
        let mine = shard.replicates(round.replicates);
        let photons = round.work_of(mine).saturating_mul(self.unit());
        self.progress.expect_more(photons);
        let sums = self.round(round.before, round.each, shard, None)?;
        Ok((sums.replicates() == mine).then_some(Sums::PhotonMap(sums)))
    }

    fn found(&self, run: Run<'_>, _: bool) -> Self::Found {
        run.estimate()
    }
}

impl RunInParts for Run<'_> {
    fn replicates(&self) -> u32 {
        self.setup.settings.photons.replicates
    }

    fn add_round(&mut self, _: Round, sums: &Sums) -> bool {
        matches!(sums, Sums::PhotonMap(sums) if self.add(sums))
    }
}
