//! `nephroid probe`.

use std::time::Duration;

use glam::DVec2;

use super::SceneArgs;
use super::parse::{parse_duration, parse_shading_normals, parse_uv};
use crate::reference::probe::{MAX_RAYS, MAX_REFINE, ProbeSettings};
use crate::transport::scatter::ShadingNormals;
use crate::transport::signature::MAX_EVENTS;

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
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(0..=MAX_EVENTS as i64))]
    pub max_depth: u32,

    /// Effect of interpolated normals on flux
    #[arg(long, value_name = "WORD", value_parser = parse_shading_normals, default_value = "flux")]
    pub shading_normals: ShadingNormals,

    /// Look for small features: divide all of light N times more before the search; 4 times the work each
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=MAX_REFINE as i64))]
    pub refine: u32,

    /// Stop after this many rays [default: 33554432]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=MAX_RAYS))]
    pub rays: Option<u64>,

    /// Stop after this time, e.g. 30s, 2m
    #[arg(long, value_name = "TIME", value_parser = parse_duration)]
    pub time: Option<Duration>,

    /// Print as JSON
    #[arg(long)]
    pub json: bool,
}

impl ProbeArgs {
    /// The settings that the flags ask for.
    pub fn settings(&self) -> ProbeSettings {
        let default = ProbeSettings::default();
        ProbeSettings {
            max_depth: self.max_depth,
            shading_normals: self.shading_normals,
            first_level: self.refine,
            max_rays: self.rays.unwrap_or(default.max_rays),
        }
    }
}
