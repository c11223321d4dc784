//! Arguments of the commands: one file a subject.

mod cache;
mod parse;
mod probe;
mod render;
mod settings;

use std::path::PathBuf;

use clap::{Parser, Subcommand};

pub use cache::CacheArgs;
pub use parse::parse_fraction;
pub(super) use parse::{parse_define, parse_shard};
pub use probe::ProbeArgs;
pub use render::{FilterArg, RenderArgs};
pub use settings::SettingArgs;

use super::compare::CompareArgs;
use super::validate::ValidateArgs;

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
    /// Judge methods by the truth over their settings; write a report of what less error costs
    Validate(ValidateArgs),
    /// Say which stage of an approximation makes how much of its error
    Attribute(AttributeArgs),
    /// Make all tables that a technique looks up, and keep them for later runs
    Tables(TablesArgs),
    /// List the methods, or the settings of one
    Methods(MethodsArgs),
    /// Write the shipped scenes, their meshes at any fineness
    Generate(GenerateArgs),
    /// Write man pages and completions of shells, for packages
    #[command(hide = true)]
    Manual(ManualArgs),
}

/// The scene.
#[derive(Debug, clap::Args)]
pub struct SceneArgs {
    /// The scene file, Mitsuba 3 XML
    pub scene: PathBuf,

    /// Set a parameter of the scene file (its `$NAME`)
    #[arg(short = 'D', value_name = "NAME=VALUE", value_parser = parse::parse_define)]
    pub define: Vec<(String, String)>,

    /// Give an interface an index that depends on the wavelength, for photons: the id of a bsdf or a shape,
    /// and bk7, f2, sf10, sf11, fused-silica, water, diamond, cauchy:A,B,... or sellmeier:B1,...,C1,...
    /// (powers of µm)
    #[arg(long, value_name = "ID=GLASS", value_parser = parse::parse_dispersion)]
    pub dispersion: Vec<(String, String)>,

    /// Leave out parameters that a plugin does not know, each with a warning
    #[arg(long)]
    pub lenient: bool,
}

/// `nephroid inspect`.
#[derive(Debug, clap::Args)]
pub struct InspectArgs {
    /// The scene
    #[command(flatten)]
    pub scene: SceneArgs,

    /// Print what this method costs, and what a pilot of a few photons advises
    #[arg(long, value_name = "NAME")]
    pub method: Option<String>,

    /// Change a setting of the method, e.g. slabs=2; `nephroid methods NAME` lists all
    #[arg(long, value_name = "KEY=VALUE", value_parser = parse::parse_define, requires = "method")]
    pub set: Vec<(String, String)>,

    /// The sensor of the advice, by id [default: the first irradiancemeter, else the first camera]
    #[arg(long, value_name = "ID", requires = "method")]
    pub sensor: Option<String>,

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

    /// The sensor the shards were made for [default: that of `nephroid render` with their method]
    #[arg(long, value_name = "ID")]
    pub sensor: Option<String>,

    /// The film's filter
    #[command(flatten)]
    pub filter: FilterArg,

    /// The settings the shards were made with
    #[command(flatten)]
    pub settings: SettingArgs,

    /// Other settings that the shards were made with, as of `nephroid render`
    #[arg(long, value_name = "KEY=VALUE", value_parser = parse::parse_define)]
    pub set: Vec<(String, String)>,

    /// Print the summary as JSON
    #[arg(long)]
    pub json: bool,
}

/// `nephroid attribute`.
#[derive(Debug, clap::Args)]
pub struct AttributeArgs {
    /// The scene
    #[command(flatten)]
    pub scene: SceneArgs,

    /// The sensor to fill, by id [default: the first irradiancemeter]
    #[arg(long, value_name = "ID")]
    pub sensor: Option<String>,

    /// The technique [default: the first that `nephroid methods` lists]
    #[arg(long, value_name = "NAME")]
    pub method: Option<String>,

    /// Change a setting of the technique, e.g. splat=fixed; `nephroid methods NAME` lists all
    #[arg(long, value_name = "KEY=VALUE", value_parser = parse::parse_define)]
    pub set: Vec<(String, String)>,

    /// The folder of tables
    #[command(flatten)]
    pub cache: CacheArgs,

    /// The figure that is shared out: l1, energy, misplaced, displaced or l2
    #[arg(long, value_name = "NAME", value_parser = parse::parse_figure, default_value = "l1")]
    pub figure: crate::metric::Figure,

    /// Texels that the longer side of the sensor has at least: each run is made on squares of its texels,
    /// the largest that leave so many
    #[arg(long, value_name = "N", default_value_t = 128, value_parser = clap::value_parser!(u16).range(1..))]
    pub side: u16,

    /// The reference that makes the truth: photons are sooner over meshes of many bent faces
    #[arg(long, value_name = "NAME", value_parser = crate::study::attribution::wanted::TRUTHS, default_value = "beams")]
    pub truth: String,

    /// The likely error at which the truth is good enough
    #[arg(long, value_name = "ERROR", value_parser = parse_fraction, default_value = "0.3%")]
    pub error: f64,

    /// The longest that the truth may take, e.g. 30s, 2m
    #[arg(long, value_name = "TIME", value_parser = parse::parse_duration)]
    pub time: Option<std::time::Duration>,

    /// Print as JSON
    #[arg(long)]
    pub json: bool,
}

/// `nephroid tables`.
#[derive(Debug, clap::Args)]
pub struct TablesArgs {
    /// The scene
    #[command(flatten)]
    pub scene: SceneArgs,

    /// The folder to keep the tables in; made where missing. Tables that are there are not made again
    #[arg(long, value_name = "DIR")]
    pub cache: PathBuf,

    /// The technique [default: the first that makes tables]
    #[arg(long, value_name = "NAME")]
    pub method: Option<String>,

    /// Change a setting of the technique, e.g. frequency=8; `nephroid methods NAME` lists all
    #[arg(long, value_name = "KEY=VALUE", value_parser = parse::parse_define)]
    pub set: Vec<(String, String)>,

    /// A sensor that the tables could be read for, by id [default: the first irradiancemeter, else the first
    /// camera]; tables do not depend on it
    #[arg(long, value_name = "ID")]
    pub sensor: Option<String>,

    /// Bytes that all tables may take, e.g. 64MB: of light directions, cells and numbers, pilots choose those
    /// that err least
    #[arg(long, value_name = "BYTES", value_parser = parse::parse_bytes)]
    pub bytes: Option<u64>,

    /// Write the tables as raw volumes into this folder, too, with a description: tables.json
    #[arg(long, value_name = "DIR")]
    pub export: Option<PathBuf>,

    /// Memory that the program may take; a run that would take more is refused before it starts [default:
    /// what is free]
    #[arg(long, value_name = "SIZE", value_parser = parse::parse_bytes)]
    pub memory: Option<u64>,

    /// Threads [default: all cores]; tables do not depend on it
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
}

/// `nephroid methods`.
#[derive(Debug, clap::Args)]
pub struct MethodsArgs {
    /// The method whose settings are listed [default: all methods, a line each]
    pub name: Option<String>,
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

/// `nephroid manual`.
#[derive(Debug, clap::Args)]
pub struct ManualArgs {
    /// The folder to write them into; made where missing
    #[arg(short, long, value_name = "DIR", default_value = "out/manual")]
    pub output: PathBuf,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        use clap::CommandFactory;
        Args::command().debug_assert();
    }
}
