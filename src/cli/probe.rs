//! `nephroid probe`: every specular path to one point.

use std::sync::Arc;
use std::time::Instant;

use anyhow::Context;
use glam::DVec3;

use super::args::ProbeArgs;
use super::outcome::Outcome;
use super::progress;
use super::scene::load;
use crate::method::sensors::choose_sensor;
use crate::radiometry::Rgb;
use crate::reference::probe::{MAX_LEVEL, PathLine, ProbeReport, SearchEnd};
use crate::run::Progress;

/// Part of all light below which paths are summed up in the table.
const FAINT: f64 = 1e-6;

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
    let deadline = args.time.and_then(|time| start.checked_add(time));
    let limits = (deadline, &*progress);
    let report = ProbeReport::search((&scene, sensor), args.at, args.settings(), limits)
        .with_context(|| scene.path().display().to_string())?;
    if args.json {
        say!("{}", serde_json::to_string_pretty(&report)?);
    } else {
        print(&report);
    }
    Ok(if report.complete {
        Outcome::Complete
    } else {
        Outcome::Incomplete
    })
}

/// Prints the table of paths.
fn print(report: &ProbeReport) {
    let incomplete = if report.complete {
        ""
    } else {
        " · INCOMPLETE"
    };
    say!("{}: sensor {}{incomplete}", report.scene, report.sensor);
    let [u, v] = report.uv;
    say!("  at u, v = {u}, {v}: {}", triple(report.position));
    say!(
        "\n  {:<10} {:>13} {:>13} {:>7} {:>11} {:>9}  met on the way",
        "path",
        "E [W/m²]",
        "|J|",
        "",
        "fold [m]",
        "off [m]"
    );
    let (bright, faint): (Vec<_>, Vec<_>) = report
        .paths
        .iter()
        .partition(|path| mean(path.irradiance) >= FAINT * mean(report.irradiance));
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
            met(path)
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
    say!("  {:<10} {:>13}", "sum", shown(report.irradiance));
    say!("");
    if !report.paths.is_empty() {
        say!(
            "|J| is receiver area per light: {}. fold: first-order distance on the receiver.",
            units(report)
        );
    }
    say!(
        "{} paths; {} patches of light looked at, {} rays; divided {} times of at most {MAX_LEVEL}",
        report.paths.len(),
        report.patches,
        report.counters.rays,
        report.divisions
    );
    let reason = match report.search {
        SearchEnd::Complete => {
            "the point is on a fold, a focus or the edge of a surface, or all but"
        }
        SearchEnd::OutOfRays => "the search ran out of rays (--rays)",
        SearchEnd::Stopped => "the search was stopped",
    };
    if report.unresolved_patches > 0 {
        say!(
            "warning: {} patches were left unclear: {reason}; paths may be missing",
            report.unresolved_patches
        );
    }
    for warning in report.warnings {
        say!("warning: {warning}");
    }
}

fn units(report: &ProbeReport) -> String {
    let mut units: Vec<&str> = report.paths.iter().map(|path| path.jacobian_unit).collect();
    units.sort_unstable();
    units.dedup();
    units.join(" or ")
}

/// The surfaces on the way, as "ball T (0.1, 0.2, 0.3)".
fn met(path: &PathLine) -> String {
    let words = path.vertices.iter().map(|vertex| {
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
