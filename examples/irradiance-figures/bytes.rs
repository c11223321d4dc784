//! Fig. 11: bytes of full tables on shells, and of trees that are as good.

use nephroid::internals::approximation::local_irradiance::Settings;
use nephroid::internals::approximation::local_irradiance::variants::{Space, Storage};
use nephroid::internals::run::format::three_digits;

use crate::judge::{Bench, floor, l1, percent};
use crate::support::figures::table;
use crate::support::local_irradiance::{exact_but, settings};

/// The paper's kB of full tables and of trees, from level 2.
const PAPER: [[f64; 2]; 5] = [
    [5.7, 4.8],
    [22.5, 12.6],
    [90.1, 29.5],
    [360.0, 70.4],
    [1440.0, 179.0],
];

/// Tolerances of trees, from the coarsest.
const TOLERANCES: [f64; 12] = [
    4.0, 2.0, 1.0, 0.7, 0.5, 0.35, 0.25, 0.15, 0.1, 0.05, 0.02, 0.0,
];

/// Bytes by level: full tables, and the smallest trees whose error is at most 1.05 times theirs.
pub fn bytes() -> Vec<String> {
    let mut lines = Vec::new();
    for name in ["ring", "ball", "bumpy"] {
        let photons = if name == "bumpy" { "65536" } else { "1048576" };
        let bench = Bench::new(name, &[("size", "128")]);
        let all = [("normal", "fixed"), ("region", "clamp"), ("scene", "alone")];
        let truth = exact_but(&[&all[..], &[("photons", photons), ("seed", "1")]].concat());
        let truth = floor(&truth, &bench.scene);
        for (level, paper) in (2..).zip(PAPER) {
            let word = f64::from(level).to_string();
            let full = settings(&[
                ("space", "shells"),
                ("shell-level", &word),
                ("photons", photons),
                ("storage", "f32"),
            ]);
            // Cells that a tree can merge.
            let layout = bench.layout(&Settings {
                space: Space::MultiResolution,
                ..full.clone()
            });
            let shed = bench.shed(&full, &layout);
            let error = |settings: &Settings| {
                let table = layout.table(settings, shed.values.clone(), shed.tally);
                l1(&truth, &bench.image(settings, &layout, &table))
            };
            let size = |settings: &Settings| {
                let bytes = Settings {
                    storage: Storage::U8,
                    ..settings.clone()
                };
                let table = layout.table(&bytes, shed.values.clone(), shed.tally);
                table.bytes() as f64 / 1024.0
            };
            let (whole, kilobytes) = (error(&full), size(&full));
            let merged = |tolerance: f64| Settings {
                space: Space::MultiResolution,
                tolerance,
                ..full.clone()
            };
            let found = TOLERANCES.iter().find_map(|tolerance| {
                let tree = merged(*tolerance);
                let own = error(&tree);
                (own <= 1.05 * whole).then(|| (*tolerance, own, size(&tree)))
            });
            let (tolerance, own, tree) = found.expect("a tree that merges nothing");
            eprintln!("{name} {level} {kilobytes} {whole} {tolerance} {own} {tree}");
            lines.push(vec![
                format!("`{name}`"),
                level.to_string(),
                three_digits(kilobytes),
                three_digits(paper[0]),
                percent(whole),
                tolerance.to_string(),
                percent(own),
                three_digits(tree),
                three_digits(paper[1]),
                three_digits(kilobytes / tree),
                three_digits(paper[0] / paper[1]),
            ]);
        }
    }
    vec![table(
        &[
            "scene",
            ">level",
            ">full, kB",
            ">the paper's",
            ">L1, %",
            ">`tolerance`",
            ">tree: L1, %",
            ">kB",
            ">the paper's",
            ">saved, times",
            ">the paper's",
        ],
        &lines,
    )]
}
