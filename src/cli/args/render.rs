//! `nephroid render`.

use std::path::PathBuf;
use std::time::Duration;

use clap::ValueEnum;

use super::method::{PathArgs, PhotonArgs, PhotonMapArgs, SharedArgs};
use super::parse::{parse_define, parse_duration, parse_fraction, parse_shard};
use super::{MAX_COUNT, SceneArgs};
use crate::approximation::CausticMap;
use crate::reference::beams::{BeamBudget, BeamSettings};
use crate::reference::full::{FullBudget, FullSettings};
use crate::reference::path::{PathBudget, PathSettings};
use crate::reference::photon_map::PhotonMapSettings;
use crate::reference::photons::{Budget, PhotonSettings, Shard};
use crate::scene::Integrator;

/// `nephroid render`.
#[derive(Debug, clap::Args)]
pub struct RenderArgs {
    /// The scene
    #[command(flatten)]
    pub scene: SceneArgs,

    /// The EXR to write; the picture goes beside it [default: out/SCENE.exr]
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,

    /// The sensor to fill, by id [default: the first irradiancemeter; of path and full the first camera]
    #[arg(long, value_name = "ID")]
    pub sensor: Option<String>,

    /// How to compute [default: beams where they can follow all light and none is from an area
    /// light; else photons]
    #[arg(long, value_enum)]
    pub method: Option<Method>,

    /// Stop after this many photons (of photons) [default: 16777216 where no other limit is given]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=MAX_COUNT))]
    pub photons: Option<u64>,

    /// Stop after this many rays (of beams)
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=MAX_COUNT))]
    pub rays: Option<u64>,

    /// Stop after this time, e.g. 30s, 2m (of full: shared among its methods)
    #[arg(long, value_name = "TIME", value_parser = parse_duration)]
    pub time: Option<Duration>,

    /// Stop at this error over lit texels, e.g. 1%: the standard error of photons and paths,
    /// the likely error of beams (root mean square over mean) [default: 0.1% of beams without any limit,
    /// 1% of those in full]
    #[arg(long, value_name = "ERROR", value_parser = parse_fraction)]
    pub error: Option<f64>,

    /// Settings of all methods
    #[command(flatten)]
    pub shared: SharedArgs,

    /// Settings of photons
    #[command(flatten)]
    pub photon: PhotonArgs,

    /// Settings of paths
    #[command(flatten)]
    pub path: PathArgs,
    /// Settings of photon maps
    #[command(flatten)]
    pub photon_map: PhotonMapArgs,

    /// Change a setting of an approximation, e.g. splat=fixed, photons=1024; a wrong one lists all
    #[arg(long, value_name = "KEY=VALUE", value_parser = parse_define)]
    pub set: Vec<(String, String)>,

    /// Threads [default: all cores]; results do not depend on it
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,

    /// Trace only part K of N and write its sums, for `nephroid merge`
    #[arg(long, value_name = "K/N", value_parser = parse_shard, conflicts_with_all = ["time", "error"])]
    pub shard: Option<Shard>,

    /// Print the summary as JSON
    #[arg(long)]
    pub json: bool,
}

/// How to compute.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Method {
    /// Adaptive beams with lower and upper bounds: deterministic, but for places on area lights
    Beams,
    /// Photons binned into texels, or connected to a camera: unbiased, on any scene
    Photons,
    /// Paths from a camera: all that it sees, but caustics of small lamps slowly, of point lights never
    Path,
    /// Photon maps: caustics that a camera sees by way of mirrors or glass, with their bias
    PhotonMap,
    /// All that a camera sees: caustics by beams, photons and photon maps, the rest by paths
    Full,
    /// Caustic mapping (Wyman and Davis 2006): a real-time approximation, with its errors; see --set
    CausticMap,
}

impl RenderArgs {
    /// An option given that beams do not have at all.
    pub fn of_photons_only(&self) -> Option<&'static str> {
        let PhotonArgs {
            samples,
            split_depth,
            direct_samples,
        } = &self.photon;
        given([
            ("--photons", self.photons.is_some()),
            ("--shard", self.shard.is_some()),
            ("--samples", samples.is_some()),
            ("--split-depth", split_depth.is_some()),
            ("--direct-samples", direct_samples.is_some()),
        ])
    }

    /// An option given that only paths have.
    pub fn of_paths_only(&self) -> Option<&'static str> {
        let PathArgs {
            spp,
            rr_depth,
            hide_emitters,
            light_sampling,
            without_caustics,
        } = &self.path;
        given([
            ("--spp", spp.is_some()),
            ("--rr-depth", rr_depth.is_some()),
            ("--hide-emitters", hide_emitters.is_some()),
            ("--light-sampling", light_sampling.is_some()),
            ("--without-caustics", *without_caustics),
        ])
    }

    /// An option given that says how to draw by lot.
    pub fn of_chance(&self) -> Option<&'static str> {
        given([
            ("--seed", self.shared.seed.is_some()),
            ("--replicates", self.shared.replicates.is_some()),
        ])
    }

    /// What the flags mean to beams.
    ///
    /// # Errors
    ///
    /// For options that only photons have.
    pub fn beams(&self) -> anyhow::Result<(BeamSettings, BeamBudget)> {
        self.refuse_options_of_photon_maps()?;
        if let Some(name) = self.of_photons_only() {
            anyhow::bail!(
                "{name} is for --method photons; beams are limited by --error, --time and --rays"
            );
        }
        self.refuse_paths_options()?;
        let budget = BeamBudget {
            relative_error: self.error,
            time: self.time,
            rays: self.rays,
        };
        Ok((self.shared.beams(), budget))
    }

    /// What the flags mean to photons.
    ///
    /// # Errors
    ///
    /// For options that only beams have, and where the run could never know the error it is to stop at.
    pub fn photons(&self) -> anyhow::Result<(PhotonSettings, Budget)> {
        self.refuse_paths_options()?;
        self.refuse_options_of_photon_maps()?;
        let settings = self.shared.photons(&self.photon);
        Ok((settings, self.budget(settings.replicates)?))
    }

    /// What the flags mean to photon maps.
    ///
    /// # Errors
    ///
    /// As [`Self::photons`], and for shards.
    pub fn photon_maps(&self) -> anyhow::Result<(PhotonMapSettings, Budget)> {
        self.refuse_paths_options()?;
        let settings = self.shared.photon_maps(&self.photon, &self.photon_map);
        anyhow::ensure!(
            self.shard.is_none(),
            "--shard is for --method photons: photon maps are made in one piece"
        );
        let budget = self.budget(settings.photons.replicates)?;
        Ok((settings, budget))
    }

    fn refuse_options_of_photon_maps(&self) -> anyhow::Result<()> {
        match self.photon_map.given() {
            Some(name) => anyhow::bail!("{name} is for --method photon-map"),
            None => Ok(()),
        }
    }

    fn budget(&self, replicates: u32) -> anyhow::Result<Budget> {
        anyhow::ensure!(
            self.rays.is_none(),
            "--rays is for --method beams; photons are limited by --photons, --error and --time"
        );
        self.ensure_error_bar(replicates)?;
        Ok(Budget {
            photons: self.photons,
            time: self.time,
            relative_error: self.error,
        })
    }

    /// What the flags mean to paths, in a scene whose file has this integrator.
    ///
    /// # Errors
    ///
    /// For options that only other methods have, and where the run could never know the error it is to stop at.
    pub fn path(
        &self,
        integrator: Option<&Integrator>,
    ) -> anyhow::Result<(PathSettings, PathBudget)> {
        self.refuse_options_of_photon_maps()?;
        let of_others = given([
            ("--photons", self.photons.is_some()),
            ("--rays", self.rays.is_some()),
            ("--shard", self.shard.is_some()),
            ("--split-depth", self.photon.split_depth.is_some()),
            ("--direct-samples", self.photon.direct_samples.is_some()),
        ]);
        if let Some(name) = of_others {
            anyhow::bail!(
                "{name} is not for --method path; paths are limited by --spp, --time and --error"
            );
        }
        let settings = self
            .shared
            .path(self.photon.samples, &self.path, integrator);
        self.ensure_error_bar(settings.replicates)?;
        let budget = PathBudget {
            samples: self.path.spp,
            time: self.time,
            relative_error: self.error,
        };
        Ok((settings, budget))
    }

    /// What the flags mean to all methods together, in a scene whose file has this integrator.
    ///
    /// # Errors
    ///
    /// For options that contradict it, and where the run could never know the error it is to stop at.
    pub fn full(
        &self,
        integrator: Option<&Integrator>,
    ) -> anyhow::Result<(FullSettings, FullBudget)> {
        let contradicting = given([
            ("--rays", self.rays.is_some()),
            ("--shard", self.shard.is_some()),
            ("--seen", self.photon_map.seen.is_some()),
            ("--without-caustics", self.path.without_caustics),
        ]);
        if let Some(name) = contradicting {
            anyhow::bail!(
                "{name} is not for --method full, which is limited by --spp, --photons, --time and --error"
            );
        }
        let path = self
            .shared
            .path(self.photon.samples, &self.path, integrator);
        let photon_map = self.shared.photon_maps(&self.photon, &self.photon_map);
        let settings = FullSettings {
            path,
            photons: self.shared.photons(&self.photon),
            photon_map,
            beams: self.shared.beams(),
        };
        let fewest = path.replicates.min(photon_map.photons.replicates);
        self.ensure_error_bar(fewest)?;
        let budget = FullBudget {
            samples: self.path.spp,
            photons: self.photons,
            time: self.time,
            relative_error: self.error,
        };
        Ok((settings.agreeing(), budget))
    }

    /// What the flags mean to caustic maps.
    ///
    /// # Errors
    ///
    /// For options that only references have, and for settings that there are not.
    pub fn caustic_map(&self) -> anyhow::Result<CausticMap> {
        self.refuse_paths_options()?;
        self.refuse_options_of_photon_maps()?;
        let of_others = given([
            ("--photons", self.photons.is_some()),
            ("--rays", self.rays.is_some()),
            ("--time", self.time.is_some()),
            ("--error", self.error.is_some()),
            ("--shard", self.shard.is_some()),
        ]);
        if let Some(name) = of_others {
            anyhow::bail!(
                "{name} is not for --method caustic-map, which takes its settings by --set, as --set photons=512"
            );
        }
        super::caustic_map(&self.set)
    }

    fn refuse_paths_options(&self) -> anyhow::Result<()> {
        match self.of_paths_only() {
            Some(name) => anyhow::bail!("{name} is for --method path"),
            None => Ok(()),
        }
    }

    fn ensure_error_bar(&self, replicates: u32) -> anyhow::Result<()> {
        anyhow::ensure!(
            self.error.is_none() || replicates >= 2,
            "--error needs an error bar, which takes at least 2 replicates, not --replicates {replicates}"
        );
        Ok(())
    }
}

/// The first option that is given.
pub(super) fn given<const N: usize>(options: [(&'static str, bool); N]) -> Option<&'static str> {
    options
        .into_iter()
        .find_map(|(name, is_given)| is_given.then_some(name))
}
