//! The report's claims on splats: errors by splat, kernel and number of photons.

use nephroid::internals::run::format::three_digits;
use nephroid::internals::scene::Scene;

use crate::support::approximation::{
    GLASS, ball, bumpy_ball_over_floor, error, mesh_over_floor, over_floor, scene_of, shared_mesh,
    truth, with_splat,
};
use crate::support::figures::table;

/// Texels a row of the meter.
const SIDE: usize = 256;

/// Meshes of the report and others, with the likely error that their truth is asked for.
const MESHES: [(&str, f64); 5] = [
    ("beethoven_5k", 3e-2),
    ("buddha_50k", 3e-2),
    ("bunny_69k", 3e-2),
    ("gargoyle_96k", 5e-2),
    ("dragon_200k", 1e-1),
];

/// All splats of the report, and how many of them have a kernel.
const SPLATS: [&str; 5] = [
    "fixed",
    "multi-resolution",
    "thin-lens",
    "thick-lens",
    "two-curvatures",
];
const WITH_KERNEL: usize = 4;

fn lines(name: &str, scene: &Scene, accuracy: f64) -> [Vec<Vec<String>>; 2] {
    let truth = truth(scene, "LTTD", accuracy);
    let known = truth.relative_error.unwrap_or(f64::NAN);
    let of = |kernel: &str, splats: &[&str]| -> Vec<Vec<String>> {
        let of_photons = |photons: &str| {
            let errors: Vec<f64> = splats
                .iter()
                .map(|splat| error(&with_splat(splat, kernel, photons), scene, &truth))
                .collect();
            let mut cells = vec![
                name.to_owned(),
                format!("± {} %", three_digits(100.0 * known)),
                photons.to_owned(),
            ];
            cells.extend(errors.iter().map(|found| {
                let text = format!("{found:.3}");
                if *found > errors[0] {
                    format!("**{text}**")
                } else {
                    text
                }
            }));
            cells
        };
        ["512", "1024"].map(of_photons).into()
    };
    [
        of("gaussian", &SPLATS),
        of("wyman-2008", &SPLATS[..WITH_KERNEL]),
    ]
}

/// Relative RMSE by splat: by Gaussians, and by the filter of the authors' demo.
pub fn claims() -> Vec<String> {
    let ball = scene_of(&over_floor(&ball(GLASS), SIDE));
    let bumpy = bumpy_ball_over_floor(SIDE);
    let mut tables = [Vec::new(), Vec::new()];
    let mut add = |name: &str, scene: &Scene, accuracy: f64| {
        for (table, lines) in tables.iter_mut().zip(lines(name, scene, accuracy)) {
            table.extend(lines);
        }
    };
    add("ball", &ball, 1e-2);
    add("bumpy ball", &bumpy, 2e-2);
    for (name, accuracy) in MESHES {
        if let Some(mesh) = shared_mesh(name) {
            eprintln!("{name}");
            add(&format!("`{name}`"), &mesh_over_floor(mesh, SIDE), accuracy);
        }
    }
    let head = |splats: &[&str]| {
        let mut head = vec!["scene".to_owned(), ">truth".to_owned(), ">N".to_owned()];
        head.extend(splats.iter().map(|splat| format!(">`{splat}`")));
        head
    };
    let counts = [SPLATS.len(), WITH_KERNEL];
    let tables = tables.iter().zip(counts);
    tables
        .map(|(lines, count)| {
            let head = head(&SPLATS[..count]);
            table(&head.iter().map(String::as_str).collect::<Vec<_>>(), lines)
        })
        .collect()
}
