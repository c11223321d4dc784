//! What can be typed.

use std::path::PathBuf;
use std::time::Duration;

use clap::{Parser, Subcommand, ValueEnum};
use glam::DVec2;

use super::compare::CompareArgs;
use crate::numeric::StreamKind;
use crate::reference::beams::{self, BeamBudget, BeamSettings};
use crate::reference::photons::{Budget, PhotonSettings, Shard};
use crate::reference::probe::ProbeSettings;
use crate::scene::{Scene, Sensor, SensorKind};
use crate::transport::chain::ChainSettings;
use crate::transport::scatter::ShadingNormals;

/// Ground truth for caustics: how much light do reflection and refraction put on this surface?
#[derive(Debug, Parser)]
#[command(version, max_term_width = 100)]
pub struct Args {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Measure the light on a sensor of a Mitsuba 3 scene; write EXR and PNG
    Render(RenderArgs),
    /// Show what a scene holds, what it requires modelled and why, and what is odd about it
    Inspect(InspectArgs),
    /// Find every specular path from the scene's lights to one point of a sensor
    Probe(ProbeArgs),
    /// Put the shards of a run together, to the same bits as the run in one piece
    Merge(MergeArgs),
    /// Say how far two images are apart, and whether their error bars explain it
    Compare(CompareArgs),
    /// Write the shipped scenes, their meshes at any fineness
    Generate(GenerateArgs),
}

/// The largest number of photons that can be asked for: a year's work at ten million a second.
const MAX_PHOTONS: u64 = 1 << 48;

/// Which scene.
#[derive(Debug, clap::Args)]
pub struct SceneArgs {
    /// The scene file, Mitsuba 3 XML
    pub scene: PathBuf,

    /// Set a parameter of the scene file (its `$NAME`)
    #[arg(short = 'D', value_name = "NAME=VALUE", value_parser = parse_define)]
    pub define: Vec<(String, String)>,
}

/// `nephroid render`.
#[derive(Debug, clap::Args)]
pub struct RenderArgs {
    /// The scene
    #[command(flatten)]
    pub scene: SceneArgs,

    /// The EXR to write; the picture goes beside it [default: out/SCENE.exr]
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,

    /// The sensor to fill, by id [default: the first irradiancemeter]
    #[arg(long, value_name = "ID")]
    pub sensor: Option<String>,

    /// How to compute [default: beams where they can follow all light and none is from an area
    /// light, and for cameras; else photons]
    #[arg(long, value_enum)]
    pub method: Option<Method>,

    /// Stop after this many photons (of photons) [default: 16777216 where no other limit is given]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=MAX_PHOTONS))]
    pub photons: Option<u64>,

    /// Stop after this many rays (of beams)
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=MAX_PHOTONS))]
    pub rays: Option<u64>,

    /// Stop after this time, e.g. 30s, 2m
    #[arg(long, value_name = "TIME", value_parser = parse_duration)]
    pub time: Option<Duration>,

    /// Stop at this error over lit texels, e.g. 1%: the standard error of photons, the likely
    /// error of beams (root mean square over mean) [default: 0.1% of beams without any limit]
    #[arg(long, value_name = "ERROR", value_parser = parse_fraction)]
    pub error: Option<f64>,

    /// Settings of the method
    #[command(flatten)]
    pub photon: PhotonArgs,

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

/// Settings of a photon run.
#[derive(Debug, clap::Args)]
pub struct PhotonArgs {
    /// Seed of all random choices (of photons, and of places on area lights) [default: 0]
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,

    /// How sample points are laid out (of photons) [default: sobol]
    #[arg(long, value_enum)]
    pub samples: Option<Samples>,

    /// Independent randomisations; their scatter is the error bar [default: 32 of photons, 16 of
    /// beams from area lights]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=255))]
    pub replicates: Option<u32>,

    /// Specular events after which flux is cut off
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(0..=31))]
    pub max_depth: u32,

    /// Specular events up to which photons follow every branch, later one at random [default: 2]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=31))]
    pub split_depth: Option<u32>,

    /// What interpolated normals do to flux
    #[arg(long, value_enum, default_value_t = ShadingNormalsArg::Flux)]
    pub shading_normals: ShadingNormalsArg,

    /// Path signatures with a layer of their own: the brightest
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u32).range(0..=1024))]
    pub layers: u32,
}

/// `nephroid inspect`.
#[derive(Debug, clap::Args)]
pub struct InspectArgs {
    /// The scene
    #[command(flatten)]
    pub scene: SceneArgs,

    /// Print as JSON
    #[arg(long)]
    pub json: bool,
}

/// `nephroid probe`.
#[derive(Debug, clap::Args)]
pub struct ProbeArgs {
    /// The scene
    #[command(flatten)]
    pub scene: SceneArgs,

    /// The point, by the surface parameters of the sensor's shape, each in 0..=1
    #[arg(long, value_name = "U,V", value_parser = parse_uv, allow_hyphen_values = true)]
    pub at: DVec2,

    /// The sensor whose shape holds the point [default: the first irradiancemeter]
    #[arg(long, value_name = "ID")]
    pub sensor: Option<String>,

    /// Specular events after which light is cut off
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(0..=31))]
    pub max_depth: u32,

    /// What interpolated normals do to flux
    #[arg(long, value_enum, default_value_t = ShadingNormalsArg::Flux)]
    pub shading_normals: ShadingNormalsArg,

    /// Look for small features: divide all of light N times more before the search; 4 times the work each
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=6))]
    pub refine: u32,

    /// Print as JSON
    #[arg(long)]
    pub json: bool,
}

/// `nephroid merge`.
#[derive(Debug, clap::Args)]
pub struct MergeArgs {
    /// The scene
    #[command(flatten)]
    pub scene: SceneArgs,

    /// The shards, all of them
    #[arg(required = true, value_name = "SHARD")]
    pub shards: Vec<PathBuf>,

    /// The EXR to write; the picture goes beside it [default: out/SCENE.exr]
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,

    /// The sensor the shards were made for [default: the first irradiancemeter]
    #[arg(long, value_name = "ID")]
    pub sensor: Option<String>,

    /// The settings the shards were made with
    #[command(flatten)]
    pub photon: PhotonArgs,

    /// Print the summary as JSON
    #[arg(long)]
    pub json: bool,
}

/// `nephroid generate`.
#[derive(Debug, clap::Args)]
pub struct GenerateArgs {
    /// The scenes to write [default: all]
    #[arg(value_name = "NAME")]
    pub names: Vec<String>,

    /// The folder to write them into; made where missing
    #[arg(short, long, value_name = "DIR", default_value = "out/scenes")]
    pub output: PathBuf,

    /// A factor on the number of cuts of curved meshes: N² times the triangles
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub detail: u32,
}

/// How to compute.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Method {
    /// Adaptive beams with lower and upper bounds: deterministic, but for places on area lights
    Beams,
    /// Photons binned into texels: unbiased, on any scene
    Photons,
}

/// How sample points are laid out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Samples {
    /// Owen-scrambled Sobol' points
    Sobol,
    /// Independent random points
    Random,
}

/// What interpolated normals do to flux.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ShadingNormalsArg {
    /// Nothing: the ledger closes
    Flux,
    /// Veach's factor, as Mitsuba's ptracer
    Adjoint,
}

impl From<ShadingNormalsArg> for ShadingNormals {
    fn from(typed: ShadingNormalsArg) -> Self {
        match typed {
            ShadingNormalsArg::Flux => Self::Flux,
            ShadingNormalsArg::Adjoint => Self::Adjoint,
        }
    }
}

impl ProbeArgs {
    /// What the flags mean.
    pub fn settings(&self) -> ProbeSettings {
        ProbeSettings {
            max_depth: self.max_depth,
            shading_normals: self.shading_normals.into(),
            first_level: self.refine,
            ..ProbeSettings::default()
        }
    }
}

impl PhotonArgs {
    /// What the flags mean.
    pub fn settings(&self) -> PhotonSettings {
        let default = PhotonSettings::default();
        PhotonSettings {
            stream: match self.samples {
                None => default.stream,
                Some(Samples::Sobol) => StreamKind::Sobol,
                Some(Samples::Random) => StreamKind::Random,
            },
            seed: self.seed.unwrap_or(default.seed),
            replicates: self.replicates.unwrap_or(default.replicates),
            chains: ChainSettings {
                max_depth: self.max_depth,
                split_depth: self.split_depth.unwrap_or(default.chains.split_depth),
                shading_normals: self.shading_normals.into(),
            },
            max_layers: self.layers as usize,
        }
    }
}

impl RenderArgs {
    /// The method asked for, or the best that a scene allows: beams, unless light has to be drawn
    /// by lot or an option that only photons have is given.
    pub fn method(&self, scene: &Scene, sensor: &Sensor) -> Method {
        let of_photons = self.of_photons().is_some();
        self.method.unwrap_or_else(|| {
            let beams_can = beams::run::supports(scene).is_ok();
            // Photons do not fill cameras.
            let is_deterministic = beams::run::is_deterministic(scene) || is_camera(sensor);
            if !of_photons && beams_can && is_deterministic {
                Method::Beams
            } else {
                Method::Photons
            }
        })
    }

    /// An option given that only photons have.
    fn of_photons(&self) -> Option<&'static str> {
        let PhotonArgs {
            seed,
            samples,
            replicates,
            split_depth,
            ..
        } = &self.photon;
        [
            ("--photons", self.photons.is_some()),
            ("--shard", self.shard.is_some()),
            ("--samples", samples.is_some()),
            ("--split-depth", split_depth.is_some()),
            ("--seed", seed.is_some()),
            ("--replicates", replicates.is_some()),
        ]
        .into_iter()
        .find_map(|(name, given)| given.then_some(name))
    }

    /// What the flags mean to beams.
    ///
    /// # Errors
    ///
    /// For options that only photons have.
    pub fn beams(&self) -> anyhow::Result<(BeamSettings, BeamBudget)> {
        // The others are for area lights, too.
        let shared = ["--seed", "--replicates"];
        if let Some(name) = self.of_photons().filter(|name| !shared.contains(name)) {
            anyhow::bail!(
                "{name} is for --method photons; beams are limited by --error, --time and --rays"
            );
        }
        let chains = self.photon.settings().chains;
        let default = BeamSettings::default();
        Ok((
            BeamSettings {
                max_depth: chains.max_depth,
                shading_normals: chains.shading_normals,
                max_layers: self.photon.layers as usize,
                replicates: self.photon.replicates.unwrap_or(default.replicates),
                seed: self.photon.seed.unwrap_or(default.seed),
            },
            BeamBudget {
                relative_error: self.error,
                time: self.time,
                rays: self.rays,
            },
        ))
    }

    /// What the limits mean to photons.
    ///
    /// # Errors
    ///
    /// Where the run could never know the error it is to stop at.
    pub fn budget(&self) -> anyhow::Result<Budget> {
        anyhow::ensure!(
            self.rays.is_none(),
            "--rays is for --method beams; photons are limited by --photons, --error and --time"
        );
        anyhow::ensure!(
            self.error.is_none() || self.photon.settings().replicates >= 2,
            "--error needs an error bar, which takes at least 2 replicates, not --replicates {}",
            self.photon.settings().replicates
        );
        Ok(Budget {
            photons: self.photons,
            time: self.time,
            relative_error: self.error,
        })
    }
}

fn is_camera(sensor: &Sensor) -> bool {
    !matches!(sensor.kind, SensorKind::IrradianceMeter { .. })
}

/// The sensor with this id, or the first irradiance meter.
///
/// # Errors
///
/// Where there is none; the message lists those there are.
pub fn choose_sensor<'a>(scene: &'a Scene, id: Option<&str>) -> anyhow::Result<&'a Sensor> {
    let found = match id {
        Some(id) => scene.sensors().iter().find(|sensor| sensor.id == id),
        None => scene
            .sensors()
            .iter()
            .find(|sensor| matches!(sensor.kind, SensorKind::IrradianceMeter { .. })),
    };
    found.ok_or_else(|| {
        let wanted = id.map_or_else(
            || "no sensor of plugin irradiancemeter".to_owned(),
            |id| format!("no sensor with id \"{id}\""),
        );
        let there: Vec<String> = scene
            .sensors()
            .iter()
            .map(|sensor| format!("\"{}\" ({})", sensor.id, sensor.plugin()))
            .collect();
        let there = if there.is_empty() {
            "none".to_owned()
        } else {
            there.join(", ")
        };
        anyhow::anyhow!(
            "{}: {wanted}; the scene's sensors are: {there}",
            scene.path().display()
        )
    })
}

fn parse_define(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, value)) if !name.is_empty() => Ok((name.to_owned(), value.to_owned())),
        _ => Err("give NAME=VALUE, as in -D samples=16".to_owned()),
    }
}

/// Two finite numbers; whether they are on the receiver is for the probe to say.
fn parse_uv(text: &str) -> Result<DVec2, String> {
    let number = |text: &str| {
        text.trim()
            .parse()
            .ok()
            .filter(|value: &f64| value.is_finite())
    };
    text.split_once(',')
        .and_then(|(u, v)| Some(DVec2::new(number(u)?, number(v)?)))
        .ok_or_else(|| {
            "give two numbers in 0..=1 with a comma between them, as in 0.5,0.25".to_owned()
        })
}

fn parse_duration(text: &str) -> Result<Duration, String> {
    let error = || "give a number >= 0 with a unit: ms, s, m or h, as in 30s".to_owned();
    let split = text
        .find(|c: char| c.is_ascii_alphabetic())
        .unwrap_or(text.len());
    let (number, unit) = text.split_at(split);
    let factor = match unit {
        "ms" => 1e-3,
        "s" | "" => 1.0,
        "m" | "min" => 60.0,
        "h" => 3600.0,
        _ => return Err(error()),
    };
    let seconds: f64 = number.trim().parse().map_err(|_| error())?;
    Duration::try_from_secs_f64(seconds * factor).map_err(|_| error())
}

pub(super) fn parse_fraction(text: &str) -> Result<f64, String> {
    let (number, factor) = match text.strip_suffix('%') {
        Some(number) => (number, 0.01),
        None => (text, 1.0),
    };
    match number.trim().parse::<f64>() {
        Ok(value) if value > 0.0 && value.is_finite() => Ok(value * factor),
        _ => Err("give a number > 0, as a fraction (0.01) or in percent (1%)".to_owned()),
    }
}

fn parse_shard(text: &str) -> Result<Shard, String> {
    let parsed = text
        .split_once('/')
        .and_then(|(part, of)| Some((part.parse::<u32>().ok()?, of.parse::<u32>().ok()?)));
    match parsed {
        Some((part, count)) if (1..=count).contains(&part) => Ok(Shard {
            index: part - 1,
            count,
        }),
        _ => Err("give K/N with K from 1 to N, as in 1/3".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_have_units() {
        assert_eq!(parse_duration("30s"), Ok(Duration::from_secs(30)));
        assert_eq!(parse_duration("1.5m"), Ok(Duration::from_secs(90)));
        assert_eq!(parse_duration("250ms"), Ok(Duration::from_millis(250)));
        for text in ["", "s", "-1s", "1x", "nans", "1e300s"] {
            assert!(parse_duration(text).is_err(), "{text}");
        }
    }

    #[test]
    fn fractions_may_be_percentages() {
        assert_eq!(parse_fraction("1%"), Ok(0.01));
        assert_eq!(parse_fraction("0.25"), Ok(0.25));
        for text in ["", "%", "0", "-1%", "inf", "nan"] {
            assert!(parse_fraction(text).is_err(), "{text}");
        }
    }

    #[test]
    fn shards_count_from_one() {
        assert_eq!(parse_shard("3/3"), Ok(Shard { index: 2, count: 3 }));
        for text in ["0/3", "4/3", "1", "/", "a/b", "1/0"] {
            assert!(parse_shard(text).is_err(), "{text}");
        }
    }

    #[test]
    fn the_command_line_is_consistent() {
        use clap::CommandFactory;
        Args::command().debug_assert();
    }
}
