//! The light that a probe finds, with the names of what it met.

use std::time::Instant;

use glam::DVec2;
use serde::Serialize;

use super::error::ProbeError;
use super::found::{Probed, SearchEnd, SpecularPath, Vertex};
use super::run::probe_until;
use super::settings::ProbeSettings;
use crate::geometry::{Shape, TraversalCounters};
use crate::run::Progress;
use crate::scene::{Emitter, Scene, Sensor, Warning};
use crate::transport::scatter::Way;

/// All light that reaches a point, with names: the output of `nephroid probe --json`.
#[derive(Clone, Debug, Serialize)]
pub struct ProbeReport<'a> {
    /// The scene's file.
    pub scene: String,
    /// A hash of its contents and parameters.
    pub content_hash: &'a str,
    /// The sensor's id.
    pub sensor: &'a str,
    /// Limits of the search.
    pub settings: ProbeSettings,
    /// The point, by parameters of the sensor's shape.
    pub uv: [f64; 2],
    /// Its place in the world.
    pub position: [f64; 3],
    /// The surface's normal there.
    pub normal: [f64; 3],
    /// Pointwise irradiance \[W/m²\], all paths together.
    pub irradiance: [f64; 3],
    /// The paths, by signature, then the brightest first.
    pub paths: Vec<PathLine<'a>>,
    /// True if nothing ended the search before it had looked everywhere.
    pub complete: bool,
    /// The reason why the search ended.
    pub search: SearchEnd,
    /// Largest number of divisions of light space.
    pub divisions: u32,
    /// Patches of light space that may hold one more path.
    pub unresolved_patches: u64,
    /// Patches of light space that were traced.
    pub patches: u64,
    /// Work done.
    pub counters: TraversalCounters,
    /// Oddities of the scene.
    pub warnings: &'a [Warning],
}

/// One path of light.
#[derive(Clone, Debug, Serialize)]
pub struct PathLine<'a> {
    /// The specular events on the way.
    pub signature: String,
    /// The emitter, from 0 in the scene's order.
    pub emitter: usize,
    /// Its plugin.
    pub emitter_plugin: &'static str,
    /// The start of the ray.
    pub origin: [f64; 3],
    /// The unit direction in which it starts.
    pub direction: [f64; 3],
    /// Surfaces on the way, the receiver apart.
    pub vertices: Vec<VertexLine<'a>>,
    /// The part of light that goes this way.
    pub throughput: [f64; 3],
    /// Receiver area per light.
    pub jacobian: f64,
    /// Its unit.
    pub jacobian_unit: &'static str,
    /// True if the image is turned over.
    pub folded: bool,
    /// Pointwise irradiance \[W/m²\].
    pub irradiance: [f64; 3],
    /// First-order distance to the fold on the receiver \[m\]; none without one.
    pub fold_distance: Option<f64>,
    /// Distance \[m\] between the path's end and the point.
    pub residual: f64,
}

/// A surface on the way.
#[derive(Clone, Debug, Serialize)]
pub struct VertexLine<'a> {
    /// The shape's id.
    pub shape: &'a str,
    /// The face of a mesh.
    pub face: Option<u32>,
    /// R, T or passed.
    pub event: &'static str,
    /// Its place in the world.
    pub position: [f64; 3],
    /// The surface's normal there.
    pub normal: [f64; 3],
}

impl<'a> ProbeReport<'a> {
    /// Searches for all light that reaches `uv` of a sensor, until a moment, or until it is stopped.
    ///
    /// # Errors
    ///
    /// As [`probe_until`].
    pub fn search(
        (scene, sensor): (&'a Scene, &'a Sensor),
        uv: DVec2,
        settings: ProbeSettings,
        (deadline, progress): (Option<Instant>, &Progress),
    ) -> Result<Self, ProbeError> {
        let stop = || progress.is_over(deadline);
        let probed = probe_until(scene, sensor, uv, &settings, &stop)?;
        Ok(Self {
            scene: scene.path().display().to_string(),
            content_hash: scene.content_hash(),
            sensor: &sensor.id,
            settings,
            uv: uv.to_array(),
            position: probed.point.position.to_array(),
            normal: probed.point.geometric_normal.to_array(),
            irradiance: probed.irradiance().0,
            paths: path_lines(scene, &probed),
            complete: probed.end == SearchEnd::Complete,
            search: probed.end,
            divisions: probed.level,
            unresolved_patches: probed.unresolved,
            patches: probed.patches,
            counters: probed.counters,
            warnings: scene.warnings(),
        })
    }
}

fn path_lines<'a>(scene: &'a Scene, probed: &Probed) -> Vec<PathLine<'a>> {
    let line = |path: &SpecularPath| {
        let emitter = &scene.emitters()[path.emitter];
        PathLine {
            signature: path.signature.to_string(),
            emitter: path.emitter,
            emitter_plugin: emitter.plugin(),
            origin: path.origin.to_array(),
            direction: path.direction.to_array(),
            vertices: path
                .vertices
                .iter()
                .map(|vertex| vertex_line(scene, vertex))
                .collect(),
            throughput: path.throughput.0,
            jacobian: path.jacobian,
            jacobian_unit: match emitter {
                Emitter::Directional { .. } => "m²/m²",
                _ => "m²/sr",
            },
            folded: path.folded,
            irradiance: path.irradiance.0,
            fold_distance: path.fold_distance,
            residual: path.residual,
        }
    };
    probed.paths.iter().map(line).collect()
}

fn vertex_line<'a>(scene: &'a Scene, vertex: &Vertex) -> VertexLine<'a> {
    let is_mesh = matches!(
        scene.world().shapes()[vertex.shape as usize],
        Shape::Mesh(_)
    );
    VertexLine {
        shape: &scene.objects()[vertex.shape as usize].id,
        face: is_mesh.then_some(vertex.face),
        event: match vertex.way {
            Way::Passed => "passed",
            Way::Reflected => "R",
            Way::Transmitted => "T",
        },
        position: vertex.position.to_array(),
        normal: vertex.normal.to_array(),
    }
}
