//! `nephroid render`.

use std::path::PathBuf;

use super::parse::{parse_bytes, parse_define, parse_shard};
use super::{CacheArgs, SceneArgs, SettingArgs};
use crate::reference::shard::Shard;
use crate::scene::{ReconstructionFilter, Sensor};

/// `nephroid render`.
#[derive(Debug, clap::Args)]
pub struct RenderArgs {
    /// The scene
    #[command(flatten)]
    pub scene: SceneArgs,

    /// The EXR to write; the picture goes beside it [default: out/SCENE.exr]
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,

    /// The sensor to fill, by id [default: the first irradiancemeter; for methods of cameras, and in scenes
    /// without one, the first camera]
    #[arg(long, value_name = "ID")]
    pub sensor: Option<String>,

    /// The film's filter
    #[command(flatten)]
    pub filter: FilterArg,

    /// The method, one of those that `nephroid methods` lists [default: beams if they can follow all light,
    /// else photons; of scenes that have cameras alone full if it can, else path]
    #[arg(long, value_name = "NAME")]
    pub method: Option<String>,

    /// Settings of methods
    #[command(flatten)]
    pub settings: SettingArgs,

    /// Change any setting of the method, e.g. splat=fixed; `nephroid methods NAME` lists all
    #[arg(long, value_name = "KEY=VALUE", value_parser = parse_define)]
    pub set: Vec<(String, String)>,

    /// The folder of tables
    #[command(flatten)]
    pub cache: CacheArgs,

    /// Memory that the program may take; a run that would take more is refused before it starts [default:
    /// what is free]
    #[arg(long, value_name = "SIZE", value_parser = parse_bytes)]
    pub memory: Option<u64>,

    /// Threads [default: all cores]; results do not depend on it
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,

    /// Trace only part K of N of a run of photons, photon maps or paths and write its sums, for
    /// `nephroid merge` [method by default: photons]
    #[arg(long, value_name = "K/N", value_parser = parse_shard)]
    pub shard: Option<Shard>,

    /// Make an image for each frame of an animation: parameters of the scene, as `poses` of study.toml have
    /// them, e.g. "lift = { from = 0, to = 1, count = 30 }"; given again, more frames follow
    #[arg(long, value_name = "PARAMETERS", conflicts_with = "shard")]
    pub frames: Vec<String>,

    /// Print the summary as JSON
    #[arg(long)]
    pub json: bool,
}

/// A filter that is asked for.
#[derive(Debug, clap::Args)]
pub struct FilterArg {
    /// Another filter of the film than the scene's: box makes pixels plain averages, as beams and the
    /// real-time techniques need them
    #[arg(long, value_name = "NAME", value_parser = ["box"])]
    pub filter: Option<String>,
}

impl FilterArg {
    /// The sensor with the filter that is asked for.
    pub fn filtered(&self, sensor: &Sensor) -> Sensor {
        let mut sensor = sensor.clone();
        if let Some(filter) = self.wanted() {
            sensor.film.filter = filter;
        }
        sensor
    }

    /// The filter that is asked for; `None` if the scene's stays.
    pub fn wanted(&self) -> Option<ReconstructionFilter> {
        self.filter.is_some().then_some(ReconstructionFilter::Box)
    }
}
