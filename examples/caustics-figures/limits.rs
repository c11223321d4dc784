//! Section 5: light that goes back, and glass in glass.

use nephroid::internals::metric::Figure;

use crate::judge::values;
use crate::support::caustic_scenes::{ball_below_ceiling, ball_in_ball};
use crate::support::caustics_volume::{EXACT, truth, volume};
use crate::support::figures::{figures, shown, table};
use crate::support::scenes::meter;

/// Texels a row of meters, and rows.
const SIDE: usize = 64;

/// Likely error of the truths.
const TRUTH: f64 = 0.02;

/// What brings the light back.
pub fn limits() -> Vec<String> {
    let scenes = [ball_below_ceiling(SIDE), ball_in_ball(SIDE)];
    let truths = scenes.each_ref().map(|scene| truth(scene, TRUTH));
    let sweep = ("sweep", "exact");
    let ways = ("interface", "exact");
    let surfaces = ("layers", "exact");
    let light = ("emission", "exact");
    let mut lines = Vec::new();
    for (name, settings) in [
        ("default", vec![]),
        ("`slabs=8`", vec![("slabs", "8")]),
        ("`sweep=exact`", vec![sweep]),
        ("`interface=exact`", vec![ways]),
        ("`layers=exact`", vec![surfaces]),
        ("`layers=peel`", vec![("layers", "peel")]),
        ("`cull=none`", vec![("cull", "none")]),
        ("`interface` and `cull=none`", vec![ways, ("cull", "none")]),
        ("`sweep` and `interface`", vec![sweep, ways]),
        ("`sweep` and `layers`", vec![sweep, surfaces]),
        ("`interface` and `layers`", vec![ways, surfaces]),
        ("all three", vec![sweep, ways, surfaces]),
        (
            "all three and `cull=none`",
            vec![sweep, ways, surfaces, ("cull", "none")],
        ),
        (
            "all three and `emission`",
            vec![sweep, ways, surfaces, light],
        ),
        (
            "all three and `projector`",
            vec![sweep, ways, surfaces, ("projector", "exact")],
        ),
        (
            "these four and `emission`",
            vec![sweep, ways, surfaces, ("projector", "exact"), light],
        ),
        ("all exact", [&EXACT[..], &[("photons", "10000")]].concat()),
    ] {
        let mut cells = vec![name.to_owned()];
        for (scene, truth) in scenes.iter().zip(&truths) {
            let meter = meter(scene);
            let found = figures(
                scene,
                meter,
                truth,
                &values(&volume(&settings), scene, &meter.id),
            );
            cells.extend([Figure::Energy, Figure::L1].map(|figure| shown(&found, figure)));
        }
        lines.push(cells);
    }
    vec![table(
        &[
            "exact",
            ">light that goes back: energy, %",
            ">L1, %",
            ">glass in glass: energy, %",
            ">L1, %",
        ],
        &lines,
    )]
}
