//! What frames cost, and what shooting costs.

use std::time::Instant;

use nephroid::internals::approximation::local_irradiance::LocalIrradiance;
use nephroid::internals::approximation::local_irradiance::work::Work;
use nephroid::internals::approximation::{SensorFilm, Technique};
use nephroid::internals::radiometry::Rgb;
use nephroid::internals::run::format::three_digits;
use nephroid::internals::run::{Context, Counters};

use crate::judge::{Bench, on_floor, turntable};
use crate::support::cpu;
use crate::support::figures::{table, whole};
use crate::support::light_volume::sensor;
use crate::support::local_irradiance::{settings, tables};
use crate::support::technique::values;

/// CPU seconds for which each kind of frame is repeated.
const LONG: f64 = 1.5;

/// Table 1: frames of the camera by tables, and its rays alone.
pub fn frame() -> Vec<String> {
    let scene = turntable("ball", &[("width", "360"), ("height", "360")]);
    let view = sensor(&scene, "view");
    let film = SensorFilm::new(&scene, view).unwrap();
    let rays = cpu::milliseconds(LONG, || {
        let black = |_: &_, _: &mut Work| Rgb::BLACK;
        std::hint::black_box(film.evaluate(&scene, 1, black));
    });
    let few = ("photons", "16384");
    let cases: [(&str, Vec<(&str, &str)>); 6] = [
        ("grid 64³", vec![few]),
        (
            "6 shells, level 5",
            vec![few, ("space", "shells"), ("shell-level", "5")],
        ),
        (
            "multi-resolution of these",
            vec![few, ("space", "multi-resolution"), ("shell-level", "5")],
        ),
        (
            "multi-resolution of 64³",
            vec![few, ("space", "multi-resolution"), ("tree", "grid")],
        ),
        (
            "harmonics of order 5, 6 shells, level 4",
            vec![
                ("photons", "256"),
                ("directions", "harmonics"),
                ("storage", "f32"),
                ("space", "shells"),
            ],
        ),
        (
            "harmonics of order 5, grid 64³",
            vec![
                ("photons", "256"),
                ("directions", "harmonics"),
                ("storage", "f32"),
            ],
        ),
    ];
    let mut lines = vec![vec![
        "camera rays alone".to_owned(),
        three_digits(rays),
        String::new(),
        String::new(),
        String::new(),
        String::new(),
        String::new(),
        String::new(),
        String::new(),
    ]];
    let mut grid: Option<(f64, Counters)> = None;
    for (name, given) in cases {
        let given = [&given[..], &[("samples", "1")]].concat();
        let values = values(&LocalIrradiance, &given);
        let context = Context::default();
        let mut ready = LocalIrradiance
            .prepare(&scene, view, &values, &context)
            .unwrap();
        let mut counters = Counters::default();
        let whole_frame = cpu::milliseconds(LONG, || {
            counters = ready.frame(&scene, view, &context).unwrap().counters;
        });
        let added = whole_frame - rays;
        let (of_grid, grid_counters) = grid.get_or_insert((added, counters.clone()));
        let ratio =
            |key: &str| three_digits(counters.get(key) as f64 / grid_counters.get(key) as f64);
        let queries = counters.get("queries") as f64;
        let each = |key: &str| three_digits(counters.get(key) as f64 / queries);
        lines.push(vec![
            name.to_owned(),
            three_digits(whole_frame),
            three_digits(100.0 * added / rays),
            three_digits(added / *of_grid),
            three_digits(1e6 * added / queries),
            each("fetches"),
            ratio("fetches"),
            ratio("bytes"),
            each("nodes"),
        ]);
    }
    vec![table(
        &[
            "table",
            ">CPU ms a frame",
            ">added to rays, %",
            ">added by grid's",
            ">ns a query",
            ">fetches a query",
            ">fetches by grid's",
            ">bytes by grid's",
            ">nodes a query",
        ],
        &lines,
    )]
}

/// Counters of frames by samples and objects.
pub fn samples() -> Vec<String> {
    let mut lines = Vec::new();
    for (name, frequency) in [
        ("ball", "4"),
        ("ball", "16"),
        ("bumpy", "4"),
        ("bumpy", "16"),
    ] {
        let scene = turntable(name, &[("size", "128")]);
        let method = tables(&[("frequency", frequency), ("photons", "4096")]);
        let found = on_floor(&method, &scene);
        let count = |key: &str| {
            let one = found.counters.iter().find(|one| one.name == key);
            whole(one.map_or(0, |one| one.count))
        };
        lines.push(vec![
            format!("`{name}`"),
            frequency.to_owned(),
            count("queries"),
            count("fetches"),
            count("bytes"),
            count("nodes"),
        ]);
    }
    vec![table(
        &["scene", ">f", ">queries", ">fetches", ">bytes", ">nodes"],
        &lines,
    )]
}

/// The cost of a sample's photons, by the ball's.
pub fn shooting() -> Vec<String> {
    let paper = [
        ("ball", 1.7),
        ("cube", 2.4),
        ("prism", 2.0),
        ("ring", 1.3),
        ("terrain", 4.5),
        ("bumpy", 25.0),
    ];
    let mut lines = Vec::new();
    let mut ball = None;
    for (name, seconds) in paper {
        let bench = Bench::new(name, &[("size", "8")]);
        let own = settings(&[("photons", "262144")]);
        let layout = bench.layout(&own);
        let (wall, start) = (Instant::now(), cpu::seconds());
        let shed = bench.shed(&own, &layout);
        let (spent, work) = (cpu::seconds() - start, shed.work);
        let of = |count: u64| count as f64;
        let [own, rays, deposits] = [spent, of(work.rays), of(work.deposits)];
        let first = *ball.get_or_insert([own, rays, deposits]);
        eprintln!("{name}: {:.2} s", wall.elapsed().as_secs_f64());
        lines.push(vec![
            format!("`{name}`"),
            three_digits(own),
            three_digits(own / first[0]),
            three_digits(seconds / 1.7),
            three_digits(rays / of(work.photons)),
            three_digits(rays / first[1]),
            three_digits(deposits / of(work.photons)),
            three_digits(deposits / first[2]),
            three_digits(1e9 * own / deposits),
        ]);
    }
    vec![table(
        &[
            "scene",
            ">CPU s a sample",
            ">by `ball`",
            ">the paper's",
            ">rays a photon",
            ">by `ball`",
            ">deposits a photon",
            ">by `ball`",
            ">ns a deposit",
        ],
        &lines,
    )]
}
