//! Cells of space, and the numbers in them.

use nephroid::internals::approximation::local_irradiance::Settings;
use nephroid::internals::approximation::local_irradiance::variants::Storage;
use nephroid::internals::run::format::three_digits;

use crate::judge::{Bench, floor, l1, percent, sum};
use crate::support::figures::{compared, table, whole};
use crate::support::light_volume::sensor;
use crate::support::local_irradiance::{exact_but, settings};

/// What stays as it is while cells alone are judged.
const ALL: [(&str, &str); 3] = [("normal", "fixed"), ("region", "clamp"), ("scene", "alone")];

fn photons(name: &str) -> (&'static str, &'static str) {
    let number = if name == "bumpy" { "16384" } else { "65536" };
    ("photons", number)
}

/// Error of cells alone: grids, and shells at radii that are even or adapted.
pub fn cells() -> Vec<String> {
    let (mut grids, mut shells) = (Vec::new(), Vec::new());
    for name in ["ball", "cube", "prism", "ring", "bumpy"] {
        let bench = Bench::new(name, &[("size", "48")]);
        let own = photons(name);
        let truth = exact_but(&[&ALL[..], &[own, ("seed", "1")]].concat());
        let truth = floor(&truth, &bench.scene);
        let error = |given: &[(&str, &str)]| {
            let settings = settings(&[&[own, ("storage", "f32")], given].concat());
            let layout = bench.layout(&settings);
            let shed = bench.shed(&settings, &layout);
            let table = layout.table(&settings, shed.values, shed.tally);
            percent(l1(&truth, &bench.image(&settings, &layout, &table)))
        };
        let again = exact_but(&[&ALL[..], &[own, ("seed", "2")]].concat());
        let noise = percent(l1(&truth, &floor(&again, &bench.scene)));
        let mut row = vec![format!("`{name}`")];
        row.extend(["16", "32", "64", "96"].map(|cells| error(&[("cells", cells)])));
        row.push(noise);
        grids.push(row);
        for radii in ["uniform", "adapted"] {
            let mut row = vec![format!("`{name}`"), format!("`{radii}`")];
            row.extend(["3", "6", "12", "24", "48"].map(|count| {
                error(&[
                    ("space", "shells"),
                    ("radii", radii),
                    ("shells", count),
                    ("shell-level", "3"),
                ])
            }));
            shells.push(row);
        }
        eprintln!("{}", table(&["scene"], &[&grids[..], &shells[..]].concat()));
    }
    let cubes = [16u64, 32, 64, 96].map(|it| format!(">{}³: {} cells", it, whole(it.pow(3))));
    let mut head: Vec<&str> = vec!["scene"];
    head.extend(cubes.iter().map(String::as_str));
    head.push(">noise alone");
    vec![
        table(&head, &grids),
        table(
            &["scene", "radii", ">3 shells", ">6", ">12", ">24", ">48"],
            &shells,
        ),
    ]
}

/// Bytes against doubles, of the same photons in the same cubes.
pub fn storage() -> Vec<String> {
    let mut lines = Vec::new();
    for (name, drop) in [
        ("ball", "1.4"),
        ("ball", "2"),
        ("ball", "3"),
        ("cube", "1.1"),
        ("prism", "0.7"),
        ("ring", "0.32"),
        ("bumpy", "2"),
    ] {
        let bench = Bench::new(name, &[("size", "64"), ("drop", drop)]);
        let exact = settings(&[photons(name), ("storage", "exact")]);
        let layout = bench.layout(&exact);
        let shed = bench.shed(&exact, &layout);
        let image = |storage: Storage, range: f64| {
            let own = Settings {
                storage,
                range,
                ..exact.clone()
            };
            let table = layout.table(&own, shed.values.clone(), shed.tally);
            (bench.image(&own, &layout, &table), table.saturated)
        };
        let (truth, _) = image(Storage::Exact, 3.0);
        let mut cells = vec![format!("`{name}`"), drop.to_owned()];
        for (storage, range) in [
            (Storage::U8, 3.0),
            (Storage::U8, 30.0),
            (Storage::F16, 3.0),
            (Storage::F32, 3.0),
        ] {
            let (own, saturated) = image(storage, range);
            cells.push(percent(l1(&truth, &own)));
            if storage == Storage::U8 && range < 10.0 {
                cells.push(percent(sum(&own) / sum(&truth)));
                cells.push(whole(saturated));
                let floor = sensor(&bench.scene, "floor");
                let seen = compared(&bench.scene, floor, &truth, &own);
                cells.push(seen.flip.map_or("-".into(), |it| three_digits(it.mean)));
            }
        }
        lines.push(cells);
    }
    vec![table(
        &[
            "scene",
            ">drop, m",
            ">`u8` to 3: L1, %",
            ">energy, %",
            ">cells cut off",
            ">FLIP",
            ">`u8` to 30: L1, %",
            ">`f16`: L1, %",
            ">`f32`: L1, %",
        ],
        &lines,
    )]
}
