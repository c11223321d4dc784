//! `nephroid probe`: every specular path to one point.

use std::sync::Arc;
use std::time::Instant;

use anyhow::Context;
use glam::DVec3;
use serde::Serialize;

use super::args::ProbeArgs;
use super::outcome::Outcome;
use super::progress;
use super::scene::load;
use crate::geometry::{Shape, TraversalCounters};
use crate::method::sensors::choose_sensor;
use crate::radiometry::Rgb;
use crate::reference::probe::{
    MAX_LEVEL, ProbeSettings, Probed, SearchEnd, SpecularPath, Vertex, probe_until,
};
use crate::run::Progress;
use crate::scene::{Emitter, Scene, Warning};
use crate::transport::scatter::Way;

/// Part of all light below which paths are summed up in the table.
const FAINT: f64 = 1e-6;

/// The output of `--json`.
#[derive(Serialize)]
struct ProbeReport<'a> {
    scene: String,
    content_hash: &'a str,
    sensor: &'a str,
    settings: ProbeSettings,
    uv: [f64; 2],
    position: [f64; 3],
    normal: [f64; 3],
    /// Pointwise irradiance [W/m²], all paths together.
    irradiance: [f64; 3],
    paths: Vec<PathLine<'a>>,
    /// True if nothing ended the search before it had looked everywhere.
    complete: bool,
    search: SearchEnd,
    /// Largest number of divisions of light space.
    divisions: u32,
    unresolved_patches: u64,
    patches: u64,
    counters: TraversalCounters,
    warnings: &'a [Warning],
}

#[derive(Serialize)]
struct PathLine<'a> {
    signature: String,
    emitter: usize,
    emitter_plugin: &'static str,
    origin: [f64; 3],
    direction: [f64; 3],
    vertices: Vec<VertexLine<'a>>,
    throughput: [f64; 3],
    jacobian: f64,
    jacobian_unit: &'static str,
    folded: bool,
    irradiance: [f64; 3],
    fold_distance: Option<f64>,
    residual: f64,
}

#[derive(Serialize)]
struct VertexLine<'a> {
    shape: &'a str,
    /// The face of a mesh.
    face: Option<u32>,
    event: &'static str,
    position: [f64; 3],
    normal: [f64; 3],
}

/// Runs the command.
///
/// # Errors
///
/// If the scene cannot be read, or the point cannot be probed.
pub fn probe(args: &ProbeArgs) -> anyhow::Result<Outcome> {
    let start = Instant::now();
    let progress = Arc::new(Progress::default());
    progress::stop_on_interrupt(&progress)?;
    let scene = load(&args.scene)?;
    let sensor = choose_sensor(&scene, args.sensor.as_deref())?;
    let settings = args.settings();
    let deadline = args.time.and_then(|time| start.checked_add(time));
    let stop = || {
        let is_late = deadline.is_some_and(|deadline| Instant::now() > deadline);
        is_late || progress.is_stopped()
    };
    let probed = probe_until(&scene, sensor, args.at, &settings, &stop)
        .with_context(|| scene.path().display().to_string())?;
    let report = ProbeReport {
        scene: scene.path().display().to_string(),
        content_hash: scene.content_hash(),
        sensor: &sensor.id,
        settings,
        uv: args.at.to_array(),
        position: probed.point.position.to_array(),
        normal: probed.point.geometric_normal.to_array(),
        irradiance: probed.irradiance().0,
        paths: path_lines(&scene, &probed),
        complete: probed.end == SearchEnd::Complete,
        search: probed.end,
        divisions: probed.level,
        unresolved_patches: probed.unresolved,
        patches: probed.patches,
        counters: probed.counters,
        warnings: scene.warnings(),
    };
    if args.json {
        say!("{}", serde_json::to_string_pretty(&report)?);
    } else {
        report.print();
    }
    Ok(if report.complete {
        Outcome::Complete
    } else {
        Outcome::Incomplete
    })
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

impl ProbeReport<'_> {
    fn print(&self) {
        let incomplete = if self.complete { "" } else { " · INCOMPLETE" };
        say!("{}: sensor {}{incomplete}", self.scene, self.sensor);
        let [u, v] = self.uv;
        say!("  at u, v = {u}, {v}: {}", triple(self.position));
        say!(
            "\n  {:<10} {:>13} {:>13} {:>7} {:>11} {:>9}  met on the way",
            "path",
            "E [W/m²]",
            "|J|",
            "",
            "fold [m]",
            "off [m]"
        );
        let (bright, faint): (Vec<_>, Vec<_>) = self
            .paths
            .iter()
            .partition(|path| mean(path.irradiance) >= FAINT * mean(self.irradiance));
        for path in bright {
            say!(
                "  {:<10} {:>13} {:>13.6e} {:>7} {:>11} {:>9.1e}  {}",
                path.signature,
                shown(path.irradiance),
                path.jacobian,
                if path.folded { "folded" } else { "" },
                path.fold_distance
                    .map_or("·".to_owned(), |distance| format!("{distance:.3e}")),
                path.residual,
                path.met()
            );
        }
        if !faint.is_empty() {
            let sum = faint.iter().map(|path| mean(path.irradiance)).sum::<f64>();
            say!(
                "  {:<10} {sum:>13.6}  {} paths below {FAINT:e} of the sum, which --json lists",
                "fainter",
                faint.len()
            );
        }
        say!("  {:<10} {:>13}", "sum", shown(self.irradiance));
        say!("");
        if !self.paths.is_empty() {
            say!(
                "|J| is receiver area per light: {}. fold: first-order distance on the receiver.",
                self.units()
            );
        }
        say!(
            "{} paths; {} patches of light looked at, {} rays; divided {} times of at most {MAX_LEVEL}",
            self.paths.len(),
            self.patches,
            self.counters.rays,
            self.divisions
        );
        let reason = match self.search {
            SearchEnd::Complete => {
                "the point is on a fold, a focus or the edge of a surface, or all but"
            }
            SearchEnd::OutOfRays => "the search ran out of rays (--rays)",
            SearchEnd::Stopped => "the search was stopped",
        };
        if self.unresolved_patches > 0 {
            say!(
                "warning: {} patches were left unclear: {reason}; paths may be missing",
                self.unresolved_patches
            );
        }
        for warning in self.warnings {
            say!("warning: {warning}");
        }
    }

    fn units(&self) -> String {
        let mut units: Vec<&str> = self.paths.iter().map(|path| path.jacobian_unit).collect();
        units.sort_unstable();
        units.dedup();
        units.join(" or ")
    }
}

impl PathLine<'_> {
    /// The surfaces on the way, as "ball T (0.1, 0.2, 0.3)".
    fn met(&self) -> String {
        let words = self.vertices.iter().map(|vertex| {
            let face = vertex
                .face
                .map_or_else(String::new, |face| format!("[{face}]"));
            format!(
                "{}{face} {} {}",
                vertex.shape,
                vertex.event,
                triple(vertex.position)
            )
        });
        words.collect::<Vec<_>>().join(", ")
    }
}

fn mean(irradiance: [f64; 3]) -> f64 {
    Rgb(irradiance).mean()
}

/// One number if all channels are the same, else three.
fn shown([red, green, blue]: [f64; 3]) -> String {
    if red == green && green == blue {
        format!("{red:.6}")
    } else {
        format!("{red:.6} {green:.6} {blue:.6}")
    }
}

fn triple(point: [f64; 3]) -> String {
    let DVec3 { x, y, z } = DVec3::from_array(point);
    format!("({x:.5}, {y:.5}, {z:.5})")
}
