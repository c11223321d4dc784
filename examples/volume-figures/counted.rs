//! Tables of counters.

use nephroid::internals::run::Rendering;
use nephroid::internals::run::format::three_digits;

use crate::judge::{table, whole};
use crate::support::pool::{
    MESHES, OCCLUDERS, SPEEDUPS, VIEWS, rendered, unlike, viewed, volume, with_round_mesh, work,
};

/// Films for counters that do not depend on pixels.
const SMALL: [usize; 2] = [64, 48];

/// Films of the paper.
const FULL: [usize; 2] = [1024, 768];

/// Table 2, frames a second: by view and mesh of the rows Reference, Hierarchical, Shadow Culling, Vector Accum.
const FRAMES: [[[f64; 3]; 4]; 4] = [
    [
        [6.51, 4.57, 3.33],
        [10.75, 7.15, 4.98],
        [5.51, 3.31, 2.19],
        [11.51, 8.37, 6.20],
    ],
    [
        [6.85, 4.89, 3.58],
        [11.98, 7.98, 5.17],
        [5.86, 3.50, 2.25],
        [12.55, 9.39, 6.46],
    ],
    [
        [7.33, 5.40, 4.00],
        [13.34, 9.32, 6.05],
        [6.55, 4.07, 2.59],
        [14.98, 11.50, 7.90],
    ],
    [
        [5.58, 4.26, 3.27],
        [11.48, 8.51, 5.81],
        [6.34, 4.00, 2.54],
        [11.64, 9.44, 7.24],
    ],
];

const PRESETS: [&str; 4] = ["reference", "hierarchical", "shadow-culling", "vector"];

fn percent(part: u64, all: u64) -> String {
    three_digits(100.0 * part as f64 / all as f64)
}

/// Table 1.
pub fn culling() -> Vec<String> {
    let scene = viewed("none", SMALL);
    let tests = |view: &str, grid: &str, clamp: &str| {
        let settings = [
            ("grid", grid),
            ("clamp", clamp),
            ("shadow-cull", "exact"),
            ("inside", "exact"),
        ];
        rendered(&scene, view, &volume(&settings))
    };
    let mut lines = Vec::new();
    for (view, speedups) in VIEWS.iter().zip(SPEEDUPS) {
        for (grid, speedup) in MESHES.iter().zip(speedups) {
            let (all, few) = (tests(view, grid, "beams"), tests(view, grid, "hierarchy"));
            let begun = work(&all, "surface", "beams");
            let [one, other] = [&all, &few].map(|it| work(it, "clamp", "tests"));
            lines.push(vec![
                format!("`{view}`"),
                (*grid).to_owned(),
                percent(begun - work(&all, "clamp", "culled"), begun),
                whole(one),
                whole(other),
                three_digits(one as f64 / other as f64),
                three_digits(1.0 + speedup / 100.0),
            ]);
        }
    }
    let pixels = [[16, 12], SMALL, [256, 192]].map(|size| {
        let rendering = rendered(
            &viewed("none", size),
            VIEWS[0],
            &volume(&[("inside", "exact")]),
        );
        whole(work(&rendering, "clamp", "tests"))
    });
    vec![
        table(
            &[
                "view",
                ">W",
                ">seen, %",
                ">tests, beam by beam",
                ">tests, hierarchy",
                ">ratio of tests",
                ">ratio of the paper's frames",
            ],
            &lines,
        ),
        format!(
            "Tests of `view-50` on films of 16, 64 and 256 pixels a row: {}.",
            pixels.join(", ")
        ),
    ]
}

/// A rendering's work, summed over stages.
fn all(rendering: &Rendering, kind: &str) -> u64 {
    rendering.stages.iter().map(|it| it.work.get(kind)).sum()
}

/// Table 2.
pub fn drawing() -> Vec<String> {
    let mut lines = Vec::new();
    for occluder in OCCLUDERS {
        let scene = viewed(occluder, FULL);
        for (place, view) in VIEWS.iter().enumerate() {
            for (row, preset) in PRESETS.iter().enumerate() {
                let rendering = rendered(&scene, view, &volume(&[("preset", preset)]));
                let frames = FRAMES[row][place][0];
                let before = if row > 0 {
                    FRAMES[row - 1][place][0]
                } else {
                    frames
                };
                lines.push(vec![
                    occluder.to_owned(),
                    format!("`{view}`"),
                    (*preset).to_owned(),
                    whole(all(&rendering, "draws")),
                    whole(work(&rendering, "clamp", "vertices")),
                    millions(work(&rendering, "inside", "fragments")),
                    millions(work(&rendering, "accumulate", "blends")),
                    millions(work(&rendering, "accumulate", "bytes")),
                    if row > 0 {
                        format!("{:+.1}", 100.0 * (frames / before - 1.0))
                    } else {
                        String::new()
                    },
                ]);
            }
        }
    }
    let mut meshes = Vec::new();
    for (place, view) in VIEWS.iter().enumerate() {
        for (size, grid) in MESHES.iter().enumerate() {
            let draws = |occluder: &str, preset: &str| {
                let settings = [("preset", preset), ("grid", *grid), ("inside", "exact")];
                let rendering = rendered(&viewed(occluder, SMALL), view, &volume(&settings));
                all(&rendering, "draws")
            };
            let change =
                |more: u64, less: u64| format!("{:+.1}", 100.0 * (less as f64 / more as f64 - 1.0));
            let culled = |occluder: &str| {
                change(
                    draws(occluder, "hierarchical"),
                    draws(occluder, "shadow-culling"),
                )
            };
            meshes.push(vec![
                format!("`{view}`"),
                (*grid).to_owned(),
                whole(draws("none", "reference")),
                change(draws("none", "reference"), draws("none", "hierarchical")),
                culled("disc"),
                culled("fence"),
                format!(
                    "{:+.1}",
                    100.0 * (FRAMES[1][place][size] / FRAMES[2][place][size] - 1.0)
                ),
            ]);
        }
    }
    vec![
        table(
            &[
                "occluder",
                "view",
                "preset",
                ">draws",
                ">vertices",
                ">M fragments",
                ">M blends",
                ">MB of blends",
                ">frames a second, change in %",
            ],
            &lines,
        ),
        table(
            &[
                "view",
                ">W",
                ">draws, reference",
                ">hierarchy, %",
                ">disc culled, %",
                ">fence culled, %",
                ">time a frame by the paper's culling, %",
            ],
            &meshes,
        ),
    ]
}

fn millions(number: u64) -> String {
    three_digits(number as f64 * 1e-6)
}

/// Beams culled by query.
pub fn shadow_culling() -> Vec<String> {
    let mut lines = Vec::new();
    for occluder in ["disc", "fence"] {
        let scene = viewed(occluder, SMALL);
        for grid in MESHES {
            let of = |queries: &str| {
                let settings = [("grid", grid), ("queries", queries), ("inside", "exact")];
                let rendering = rendered(&scene, VIEWS[2], &volume(&settings));
                let [queries, culled] =
                    ["queries", "culled"].map(|kind| work(&rendering, "shadow-cull", kind));
                let begun = work(&rendering, "surface", "beams");
                (queries, culled, begun)
            };
            let ((queries, culled, begun), (fewer, _, _)) = (of("all"), of("overlap"));
            lines.push(vec![
                occluder.to_owned(),
                grid.to_owned(),
                whole(queries),
                whole(culled),
                percent(culled, begun),
                three_digits(culled as f64 / queries as f64),
                whole(fewer),
                three_digits(culled as f64 / fewer as f64),
            ]);
        }
    }
    vec![table(
        &[
            "occluder",
            ">W",
            ">queries",
            ">beams culled",
            ">of all, %",
            ">culled a query",
            ">queries=overlap",
            ">culled a query",
        ],
        &lines,
    )]
}

/// Queries where nothing is in shadow.
pub fn unshadowed() -> Vec<String> {
    let scene = viewed("none", SMALL);
    let lines: Vec<Vec<String>> = ["all", "overlap"]
        .iter()
        .map(|queries| {
            let settings = [("queries", *queries), ("inside", "exact")];
            let rendering = rendered(&scene, VIEWS[2], &volume(&settings));
            let counts = ["queries", "culled"].map(|kind| work(&rendering, "shadow-cull", kind));
            vec![
                format!("`queries={queries}`"),
                whole(counts[0]),
                whole(counts[1]),
            ]
        })
        .collect();
    vec![table(&["no occluder", ">queries", ">culled"], &lines)]
}

/// The ball as finer and finer meshes.
pub fn objects() -> Vec<String> {
    let lines: Vec<Vec<String>> = [1, 3, 5, 6]
        .iter()
        .map(|&levels| {
            let scene = with_round_mesh(levels, SMALL);
            let rendering = rendered(&scene, VIEWS[0], &volume(&[]));
            let count = |stage: &str, kind: &str| whole(work(&rendering, stage, kind));
            vec![
                whole(8 * 4_u64.pow(levels)),
                count("clamp", "tests"),
                count("clamp", "draws"),
                count("clamp", "vertices"),
                count("inside", "fragments"),
                count("accumulate", "blends"),
            ]
        })
        .collect();
    vec![table(
        &[
            ">triangles of the ball",
            ">tests",
            ">draws",
            ">vertices",
            ">fragments",
            ">blends",
        ],
        &lines,
    )]
}

/// Seconds of the hierarchy's upkeep.
pub fn upkeep() -> Vec<String> {
    /// Runs of which the one of least time counts.
    const RUNS: usize = 3;
    let scene = viewed("disc", FULL);
    let mut lines = Vec::new();
    for (view, grid) in [("view-50", "120"), ("view-50", "200"), ("view-100", "200")] {
        let runs = (0..RUNS).map(|_| rendered(&scene, view, &volume(&[("grid", grid)])));
        let seconds = |it: &Rendering| it.stages.iter().map(|it| it.seconds).sum::<f64>();
        let least = runs.min_by(|a, b| seconds(a).total_cmp(&seconds(b)));
        let least = least.expect("a run");
        let of = |name: &str| {
            let stages = least.stages.iter().filter(|it| it.name == name);
            stages.map(|it| it.seconds).sum::<f64>()
        };
        let prepared: f64 = least.preparation.iter().map(|it| it.seconds).sum();
        let sum = seconds(&least);
        lines.push(vec![
            format!("`{view}`"),
            grid.to_owned(),
            three_digits(1e3 * sum),
            three_digits(1e3 * of("clamp")),
            three_digits(1e3 * of("shadow-cull")),
            three_digits(100.0 * (of("clamp") + of("shadow-cull")) / sum),
            three_digits(1e3 * prepared),
        ]);
    }
    let exact = volume(&[]);
    let [one, other] = [0, 1].map(|_| rendered(&scene, VIEWS[3], &exact));
    vec![
        table(
            &[
                "view",
                ">W",
                ">ms a frame",
                ">`clamp`",
                ">`shadow-cull`",
                ">both, %",
                ">made once, ms",
            ],
            &lines,
        ),
        format!("Pixels of two runs that differ: {}.", unlike(&one, &other)),
    ]
}
