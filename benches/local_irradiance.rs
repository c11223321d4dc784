//! Frames that read tables, and the light that fills them: `cargo bench --bench local_irradiance`.
//!
//! A meter of 512² below the glass ball of `turntable-ball`, one look-up a texel, three light directions of 64³
//! cells: 24 fetches. Beside it the same frame from shells, merged cells and harmonics, as ratios to that. Times
//! are of the CPU, of all threads; finding the sensor's points is taken off.
#![allow(
    clippy::disallowed_methods,
    reason = "oracles and figures of a bench, no results"
)]

#[path = "../tests/support/mod.rs"]
mod support;

use nephroid::internals::approximation::local_irradiance::LocalIrradiance;
use nephroid::internals::approximation::local_irradiance::work::Work;
use nephroid::internals::approximation::{SensorFilm, Technique};
use nephroid::internals::mitsuba;
use nephroid::internals::radiometry::Rgb;
use nephroid::internals::run::{Context, Counters};
use nephroid::internals::scene::Scene;
use support::cpu;
use support::measured::long;
use support::scenes::{bundled_file, meter};
use support::technique::values;

/// CPU seconds for which each thing is repeated.
const LONG: f64 = 1.0;

/// What is read, by settings beside the default ones.
const KINDS: [(&str, &[(&str, &str)]); 6] = [
    ("grid 64³", &[]),
    ("grid 64³, f16", &[("storage", "f16")]),
    (
        "6 shells, level 5",
        &[("space", "shells"), ("shell-level", "5")],
    ),
    (
        "these, merged",
        &[("space", "multi-resolution"), ("shell-level", "5")],
    ),
    (
        "grid 64³, merged",
        &[("space", "multi-resolution"), ("tree", "grid")],
    ),
    (
        "harmonics of order 5, 6 shells",
        &[("space", "shell-harmonics"), ("storage", "f16")],
    ),
];

fn main() {
    println!("{} threads", rayon::current_num_threads());
    frames();
    shooting();
}

/// The scene of a turntable's object, with a meter of 512².
fn turntable(object: &str) -> Scene {
    let given = [("size".to_owned(), "512".to_owned())];
    mitsuba::load(&bundled_file(&format!("turntable-{object}")), &given).unwrap()
}

/// A line for each kind of table.
fn frames() {
    let scene = turntable("ball");
    let film = SensorFilm::new(&scene, meter(&scene)).unwrap();
    let points = cpu::milliseconds(long(LONG), || {
        let black = |_: &_, _: &mut Work| Rgb::BLACK;
        std::hint::black_box(film.evaluate(&scene, 1, black));
    });
    println!("\nframes of 512²; points alone: {points:.1} CPU ms");
    println!("| table | CPU ms | ns a query | by grid | fetches | bytes | nodes |");
    println!("|---|--:|--:|--:|--:|--:|--:|");
    let mut grid = None;
    for (name, given) in KINDS {
        let common = [("photons", "16384"), ("samples", "1")];
        let values = values(&LocalIrradiance, &[&common, given].concat());
        let context = Context::default();
        let mut ready = LocalIrradiance
            .prepare(&scene, meter(&scene), &values, &context)
            .unwrap();
        let mut counters = Counters::default();
        let whole = cpu::milliseconds(long(LONG), || {
            let frame = ready.frame(&scene, meter(&scene), &context).unwrap();
            counters = frame.counters;
        });
        let added = whole - points;
        let of_grid = *grid.get_or_insert(added);
        let queries = counters.get("queries") as f64;
        let each = |key: &str| counters.get(key) as f64 / queries;
        println!(
            "| {name} | {whole:.1} | {:.0} | {:.2} | {:.1} | {:.0} | {:.1} |",
            1e6 * added / queries,
            added / of_grid,
            each("fetches"),
            each("bytes"),
            each("nodes"),
        );
    }
}

/// A line for each object: one light sample of 2^16 photons into 64³ cells.
fn shooting() {
    println!("\none light sample of 65,536 photons");
    println!("| object | cells | CPU ms | rays a photon | deposits a photon | ns a deposit |");
    println!("|---|---|--:|--:|--:|--:|");
    for object in ["ball", "cube", "bumpy"] {
        let scene = turntable(object);
        for (name, given) in [KINDS[0], KINDS[2]] {
            let common = [
                ("photons", "65536"),
                ("directions", "nearest"),
                ("radii", "uniform"),
            ];
            let values = values(&LocalIrradiance, &[&common, given].concat());
            let context = Context::default();
            let mut counters = Counters::default();
            let spent = cpu::milliseconds(long(LONG), || {
                let ready = LocalIrradiance.prepare(&scene, meter(&scene), &values, &context);
                counters = Counters::default();
                for stage in ready.unwrap().work() {
                    for (name, count) in stage.work.iter() {
                        counters.add(name, count);
                    }
                }
            });
            let work = |key: &str| counters.get(key) as f64;
            println!(
                "| {object} | {name} | {spent:.0} | {:.1} | {:.0} | {:.1} |",
                work("rays") / work("photons"),
                work("deposits") / work("photons"),
                1e6 * spent / work("deposits"),
            );
        }
    }
}
