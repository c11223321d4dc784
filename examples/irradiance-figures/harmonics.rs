//! Spherical harmonics: of the light's direction, and on shells.

use nephroid::internals::radiometry::Rgb;
use nephroid::internals::run::format::three_digits;

use crate::judge::{floor, l1, on_floor, percent, sum, turntable};
use crate::support::figures::table;
use crate::support::local_irradiance::{exact_but, tables};

/// Light below zero, by all light of the truth.
fn negative(image: &[Rgb], truth: &[Rgb]) -> f64 {
    image.iter().map(|it| (-it.mean()).max(0.0)).sum::<f64>() / sum(truth)
}

/// Errors by order, of the same photons in shells.
pub fn harmonics() -> Vec<String> {
    let mut lines = Vec::new();
    for name in ["ball", "prism", "bumpy"] {
        let scene = turntable(name, &[("size", "64")]);
        let photons = if name == "bumpy" { "256" } else { "1024" };
        let truth = exact_but(&[
            ("normal", "fixed"),
            ("region", "clamp"),
            ("scene", "alone"),
            ("photons", "131072"),
        ]);
        let truth = floor(&truth, &scene);
        let base = [("storage", "f32"), ("space", "shells")];
        let of_light = |order| {
            vec![
                ("directions", "harmonics"),
                ("frequency", "7"),
                ("photons", photons),
                ("order", order),
            ]
        };
        let on_shells = |order| {
            vec![
                ("directions", "exact"),
                ("space", "shell-harmonics"),
                ("photons", "65536"),
                ("order", order),
            ]
        };
        for (kind, given) in [
            (
                "none: shells",
                vec![("directions", "exact"), ("photons", "131072")],
            ),
            ("of light, order 5", of_light("5")),
            ("of light, order 15", of_light("15")),
            ("on shells, order 5", on_shells("5")),
            ("on shells, order 15", on_shells("15")),
        ] {
            let of_base = base
                .iter()
                .filter(|(key, _)| given.iter().all(|(own, _)| own != key));
            let all: Vec<_> = of_base.copied().chain(given.iter().copied()).collect();
            let found = on_floor(&tables(&all), &scene);
            let image = &found.estimate.total.values;
            let count = |key: &str| {
                let one = found.counters.iter().find(|one| one.name == key);
                one.map_or(0.0, |one| one.count as f64)
            };
            lines.push(vec![
                format!("`{name}`"),
                kind.to_owned(),
                percent(l1(&truth, image)),
                percent(sum(image) / sum(&truth)),
                percent(negative(image, &truth)),
                three_digits(count("fetches") / count("queries")),
                three_digits(count("resident") / f64::powi(1024.0, 2)),
            ]);
        }
        eprintln!("{}", table(&["scene"], &lines));
    }
    vec![table(
        &[
            "scene",
            "harmonics",
            ">L1, %",
            ">energy, %",
            ">below zero, %",
            ">fetches a query",
            ">MiB",
        ],
        &lines,
    )]
}
