//! Tables of counters.

use nephroid::internals::run::Rendering;
use nephroid::internals::run::format::three_digits;

use crate::support::figures::{table, whole};
use crate::support::pool::{
    MESHES, OCCLUDERS, SPEEDUPS, VIEWS, rendered, unlike, viewed, volume, with_round_mesh, work,
};

/// Films for counters that do not depend on pixels.
const SMALL: [usize; 2] = [64, 48];

/// Half the paper's films: fragments and blends are a quarter of its.
const HALF: [usize; 2] = [512, 384];

/// Table 2, frames a second: by view and mesh of the rows Reference, Hierarchical, Shadow Culling, Vector
/// Accum.
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
    for (place, view) in VIEWS.iter().enumerate() {
        for (row, preset) in PRESETS.iter().enumerate() {
            // The first two do not look at occluders.
            let occluders = if row < 2 {
                &OCCLUDERS[..1]
            } else {
                &OCCLUDERS[1..]
            };
            for occluder in occluders {
                let scene = viewed(occluder, HALF);
                let rendering = rendered(&scene, view, &volume(&[("preset", preset)]));
                lines.push(vec![
                    format!("`{view}`"),
                    format!("`{preset}`"),
                    (*occluder).to_owned(),
                    whole(all(&rendering, "draws")),
                    whole(work(&rendering, "clamp", "vertices")),
                    millions(work(&rendering, "inside", "fragments")),
                    whole(work(&rendering, "accumulate", "blends")),
                    millions(work(&rendering, "accumulate", "bytes")),
                    if row > 0 {
                        change(FRAMES[row - 1][place][0], FRAMES[row][place][0])
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
                all(&rendering, "draws") as f64
            };
            let [reference, hierarchy] =
                ["reference", "hierarchical"].map(|preset| draws("none", preset));
            let [disc, fence] = ["disc", "fence"].map(|it| draws(it, "shadow-culling"));
            meshes.push(vec![
                format!("`{view}`"),
                (*grid).to_owned(),
                whole(reference as u64),
                change(reference, hierarchy),
                change(hierarchy, disc),
                change(hierarchy, fence),
                // Times a frame.
                change(FRAMES[2][place][size], FRAMES[1][place][size]),
                change(FRAMES[1][place][size], FRAMES[0][place][size]),
            ]);
        }
    }
    vec![
        table(
            &[
                "view",
                "preset",
                "occluder",
                ">draws",
                ">vertices",
                ">M fragments",
                ">blends",
                ">MB of blends",
                ">the paper's frames a second, %",
            ],
            &lines,
        ),
        table(
            &[
                "view",
                ">W",
                ">draws, reference",
                ">hierarchical, %",
                ">disc culled, %",
                ">fence culled, %",
                ">the paper's time: culling, %",
                ">hierarchy, %",
            ],
            &meshes,
        ),
    ]
}

/// The change from one number to another, in percent.
fn change(from: f64, to: f64) -> String {
    format!("{:+.1}", 100.0 * (to / from - 1.0))
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
    let renderings = [1, 3, 5, 6].map(|levels| {
        let scene = with_round_mesh(levels, SMALL);
        (levels, rendered(&scene, VIEWS[0], &volume(&[])))
    });
    let lines = renderings.iter().map(|(levels, rendering)| {
        let count = |stage: &str, kind: &str| whole(work(rendering, stage, kind));
        vec![
            whole(8 * 4_u64.pow(*levels)),
            count("clamp", "tests"),
            count("clamp", "draws"),
            count("clamp", "vertices"),
            count("inside", "fragments"),
            whole(unlike(rendering, &renderings[0].1) as u64),
        ]
    });
    vec![table(
        &[
            ">triangles of the ball",
            ">tests",
            ">draws",
            ">vertices",
            ">fragments",
            ">pixels unlike the first's",
        ],
        &lines.collect::<Vec<_>>(),
    )]
}

/// Milliseconds of the hierarchy's upkeep and of what it saves.
pub fn upkeep() -> Vec<String> {
    /// Runs of which the least time counts.
    const RUNS: usize = 3;
    let scene = viewed("disc", SMALL);
    let mut lines = Vec::new();
    for view in [VIEWS[0], VIEWS[2]] {
        for grid in MESHES {
            let least = |clamp: &str| {
                let settings = [("grid", grid), ("clamp", clamp), ("inside", "exact")];
                let mut times = [f64::INFINITY; 2];
                for _ in 0..RUNS {
                    let rendering = rendered(&scene, view, &volume(&settings));
                    for (time, stage) in times.iter_mut().zip(["clamp", "shadow-cull"]) {
                        *time = time.min(milliseconds(&rendering, stage));
                    }
                }
                times
            };
            let ([beams, _], [nodes, shadows]) = (least("beams"), least("hierarchy"));
            lines.push(vec![
                format!("`{view}`"),
                grid.to_owned(),
                three_digits(beams),
                three_digits(nodes),
                three_digits(beams / nodes),
                three_digits(shadows),
            ]);
        }
    }
    let drawn = rendered(&viewed("disc", HALF), VIEWS[0], &volume(&[]));
    vec![
        table(
            &[
                "view",
                ">W",
                ">`clamp=beams`, ms",
                ">`clamp=hierarchy`, ms",
                ">ratio",
                ">`shadow-cull`, ms",
            ],
            &lines,
        ),
        format!(
            "`view-50` at 512 x 384: `clamp` {} ms, `shadow-cull` {} ms, `inside` {} ms.",
            three_digits(milliseconds(&drawn, "clamp")),
            three_digits(milliseconds(&drawn, "shadow-cull")),
            three_digits(milliseconds(&drawn, "inside"))
        ),
    ]
}

/// Time of a stage.
fn milliseconds(rendering: &Rendering, stage: &str) -> f64 {
    let stages = rendering.stages.iter().filter(|it| it.name == stage);
    1e3 * stages.map(|it| it.seconds).sum::<f64>()
}
