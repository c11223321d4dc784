//! Tables of counters, beside the milliseconds of the paper's Tables 4 to 6.

use nephroid::internals::run::Rendering;
use nephroid::internals::run::format::three_digits;

use crate::judge::{OBJECTS, rendered};
use crate::support::caustics_volume::{count, volume};
use crate::support::figures::{table, whole};

/// Texels of meters: counters of photons do not depend on them.
const SIDE: usize = 32;

/// The rows of Tables 4 to 6.
const PRESETS: [&str; 3] = ["lowest", "middle", "best"];

/// Milliseconds of all passes by Tables 4 to 6: by slabs, preset and scene.
const TOTALS: [[[f64; 5]; 3]; 3] = [
    [
        [95.0, 98.0, 40.0, 134.0, 104.0],
        [105.0, 109.0, 108.0, 162.0, 112.0],
        [105.0, 109.0, 108.0, 162.0, 112.0],
    ],
    [
        [133.0, 150.0, 171.0, 217.0, 200.0],
        [151.0, 159.0, 160.0, 241.0, 224.0],
        [176.0, 212.0, 191.0, 371.0, 335.0],
    ],
    [
        [189.0, 163.0, 71.0, 221.0, 243.0],
        [207.0, 220.0, 216.0, 273.0, 289.0],
        [263.0, 277.0, 315.0, 414.0, 453.0],
    ],
];

/// Milliseconds of the projectors by Tables 4 to 6: by slabs, preset and scene.
const PROJECTORS: [[[f64; 5]; 3]; 3] = [
    [
        [47.0, 44.0, 18.0, 62.0, 50.0],
        [52.0, 45.0, 52.0, 69.0, 54.0],
        [52.0, 45.0, 52.0, 69.0, 54.0],
    ],
    [
        [43.0, 52.0, 72.0, 72.0, 67.0],
        [48.0, 40.0, 50.0, 71.0, 68.0],
        [58.0, 47.0, 70.0, 117.0, 105.0],
    ],
    [
        [49.0, 43.0, 14.0, 58.0, 65.0],
        [44.0, 50.0, 47.0, 60.0, 71.0],
        [63.0, 54.0, 73.0, 95.0, 102.0],
    ],
];

/// Runs by scene, preset and slabs.
fn run(scene: usize, preset: &str, slabs: usize) -> Rendering {
    let slabs = slabs.to_string();
    let method = volume(&[("preset", preset), ("slabs", &slabs)]);
    rendered(&method, &OBJECTS[scene].scene(SIDE), "floor")
}

fn of(rendering: &Rendering, name: &str) -> u64 {
    let found = rendering.counters.iter().find(|it| it.name == name);
    found.map_or(0, |counter| counter.count)
}

fn ratio(one: u64, other: u64) -> String {
    if other == 0 {
        return "-".to_owned();
    }
    three_digits(one as f64 / other as f64)
}

/// Three slabs by one.
pub fn passes() -> Vec<String> {
    let mut lines = Vec::new();
    for (scene, object) in OBJECTS.iter().enumerate() {
        for (row, preset) in PRESETS.iter().enumerate() {
            let [one, three] = [1, 3].map(|slabs| run(scene, preset, slabs));
            let mut cells = vec![object.row(), format!("`{preset}`")];
            for name in [
                "passes",
                "texels",
                "triangles",
                "steps",
                "fetches",
                "copied",
            ] {
                cells.push(ratio(of(&three, name), of(&one, name)));
            }
            cells.push(three_digits(TOTALS[2][row][scene] / TOTALS[0][row][scene]));
            lines.push(cells);
        }
    }
    vec![table(
        &[
            "scene",
            "preset",
            ">passes",
            ">texels",
            ">triangles",
            ">steps",
            ">fetches",
            ">copied",
            ">the paper's ms",
        ],
        &lines,
    )]
}

/// The best settings by the lowest, and projection by a mean slab.
pub fn totals() -> Vec<String> {
    let (mut growth, mut shares) = (Vec::new(), Vec::new());
    for slabs in 1..=3 {
        for (scene, object) in OBJECTS.iter().enumerate() {
            let [low, best] = ["lowest", "best"].map(|preset| run(scene, preset, slabs));
            let mut cells = vec![slabs.to_string(), object.row()];
            for name in ["photons", "texels", "steps", "fetches", "copied", "bytes"] {
                cells.push(ratio(of(&best, name), of(&low, name)));
            }
            let paper = TOTALS[slabs - 1][2][scene] / TOTALS[slabs - 1][0][scene];
            cells.push(three_digits(paper));
            growth.push(cells);
            let mut cells = vec![slabs.to_string(), object.row()];
            for (rendering, row) in [(&low, 0), (&best, 2)] {
                let steps = count(rendering, "march", "steps");
                let slab = steps / slabs as u64;
                cells.push(ratio(count(rendering, "projector", "steps"), slab));
                let [all, last] = [TOTALS, PROJECTORS].map(|it| it[slabs - 1][row][scene]);
                cells.push(three_digits(last / ((all - last) / slabs as f64)));
            }
            shares.push(cells);
        }
    }
    vec![
        table(
            &[
                ">slabs",
                "scene",
                ">photons",
                ">texels",
                ">steps",
                ">fetches",
                ">copied",
                ">bytes",
                ">the paper's ms",
            ],
            &growth,
        ),
        table(
            &[
                ">slabs",
                "scene",
                ">`lowest`: steps",
                ">the paper's ms",
                ">`best`: steps",
                ">the paper's ms",
            ],
            &shares,
        ),
    ]
}

/// Counts by scene at the best settings.
pub fn polygons() -> Vec<String> {
    let mut lines = Vec::new();
    for slabs in [1, 3] {
        for (scene, object) in OBJECTS.iter().enumerate() {
            let rendering = run(scene, "best", slabs);
            let mut cells = vec![slabs.to_string(), object.row()];
            for name in ["triangles", "steps", "copied"] {
                cells.push(whole(of(&rendering, name)));
            }
            cells.push(three_digits(TOTALS[slabs - 1][2][scene]));
            lines.push(cells);
        }
    }
    vec![table(
        &[
            ">slabs",
            "scene",
            ">triangles drawn",
            ">steps",
            ">copied",
            ">the paper's ms",
        ],
        &lines,
    )]
}
