//! Films, photons and triangles take no more memory than is promised.

use std::fs;
use std::path::Path;

use glam::{DVec2, DVec3};
use nephroid::internals::generate::{WATER, height_field, write_ply};
use nephroid::internals::geometry::MeshParts;
use tempfile::TempDir;

use super::program::{
    inspect, peak_memory, peak_or_refusal, render, render_file, with_a_square_camera,
};

/// Most memory \[bytes\] that a sensor's film takes, by `inspect`.
fn said(scene: &Path, size: usize, sensor: &str, method: &str) -> u64 {
    let definition = ["-D", &format!("size={size}")];
    let output = inspect(scene).args(definition).output().unwrap();
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let sensors = json["sensors"].as_array().unwrap();
    let sensor = sensors.iter().find(|one| one["id"] == sensor).unwrap();
    sensor["costs"][method]["bytes"].as_u64().unwrap()
}

/// Each method, the sensor that it fills, and a run of it that takes little time and much memory: photon maps
/// keep light that is seen directly and by way of glass apart.
const RUNS: [(&str, &str, &[&str]); 6] = [
    ("photons", "floor", &["--photons", "65536"]),
    ("beams", "floor", &["--error", "0.1%"]),
    ("caustic-map", "floor", &["--set", "photons=64"]),
    ("path", "camera", &["--spp", "2", "--replicates", "2"]),
    (
        "photon-map",
        "camera",
        &[
            "--seen",
            "anyhow",
            "--photons",
            "65536",
            "--map-photons",
            "4096",
            "--replicates",
            "2",
        ],
    ),
    (
        "full",
        "camera",
        &[
            "--error",
            "50%",
            "--photons",
            "65536",
            "--spp",
            "2",
            "--replicates",
            "2",
        ],
    ),
];

/// Memory \[bytes\] that the system and the allocator add: pages are counted, sizes rounded up, freed memory
/// kept for later.
const SLACK: u64 = 8_000_000;

/// Program, threads' stacks and buffers of a technique take the same for any film: the film is what a larger
/// one takes, and is said to take, more than one of 16 x 16.
fn assert_films_take_no_more_than_said(sizes_and_methods: &[(usize, &[&str])]) {
    let folder = TempDir::new().unwrap();
    let output = folder.path().join("a.exr");
    let scene = with_a_square_camera(folder.path());
    for (method, sensor, arguments) in RUNS {
        let run = |size: usize| {
            let mut command = render_file(&scene, size, &output, arguments);
            command.args(["--method", method, "--sensor", sensor]);
            peak_memory(command.spawn().unwrap()).0
        };
        let mut small = None;
        for (size, methods) in sizes_and_methods {
            if !methods.contains(&method) {
                continue;
            }
            let more = run(*size).saturating_sub(*small.get_or_insert_with(|| run(16)));
            let of = |size| said(&scene, size, sensor, method);
            let most = of(*size) - of(16);
            println!(
                "{method}: {:.1} MB more for {size} x {size} texels; {:.1} MB at most, as inspect says",
                more as f64 / 1e6,
                most as f64 / 1e6
            );
            assert!(more <= most + SLACK, "{method}, {size}");
            // And not so much that a film that fits would be refused.
            assert!(most <= 4 * (more + SLACK), "{method}, {size}");
        }
    }
}

const ALL: &[&str] = &[
    "photons",
    "beams",
    "caustic-map",
    "path",
    "photon-map",
    "full",
];

#[test]
fn a_film_takes_no_more_memory_than_inspect_says() {
    // Photon maps take half a minute for the largest.
    let quick = &["photons", "beams", "caustic-map", "path", "full"];
    assert_films_take_no_more_than_said(&[(64, ALL), (256, ALL), (512, quick)]);
}

#[test]
#[ignore = "two minutes, and 4 GB of memory"]
fn a_film_of_1024_x_1024_takes_no_more_memory_than_inspect_says() {
    assert_films_take_no_more_than_said(&[(1024, ALL)]);
}

/// A forecast allows for the most layers. Where two layers are asked for and all get light, the others' too,
/// it holds within a tenth, and half the slack: vectors of these sizes are freed to the allocator alone.
#[test]
fn a_forecast_of_layers_that_are_all_lit_holds_within_a_tenth() {
    let folder = TempDir::new().unwrap();
    let output = folder.path().join("a.exr");
    let scene = super::program::scene("glass-ball.xml");
    let of = |method: &str, size: usize| {
        let size = format!("size={size}");
        let words = ["--method", method, "--set", "layers=2", "-D", &size];
        let printed = inspect(&scene).args(words).output().unwrap().stdout;
        let json: serde_json::Value = serde_json::from_slice(&printed).unwrap();
        find(&json, "cost").unwrap()["bytes"].as_u64().unwrap()
    };
    for (method, limit) in [
        ("beams", ["--error", "1%"]),
        ("photons", ["--photons", "65536"]),
    ] {
        let run = |size: usize| {
            let mut command = render(size, &output, &limit);
            command.args(["--method", method, "--layers", "2"]);
            peak_memory(command.spawn().unwrap()).0
        };
        let small = run(16);
        for size in [256, 512] {
            let more = run(size).saturating_sub(small) as f64;
            let said = (of(method, size) - of(method, 16)) as f64;
            println!(
                "{method}: {:.1} MB more for {size} x {size} texels of two layers; inspect says {:.1} MB",
                more / 1e6,
                said / 1e6
            );
            assert!(
                (more - said).abs() <= 0.1 * said + 0.5 * SLACK as f64,
                "{method}, {size}"
            );
        }
    }
}

/// The value of a key, wherever it is.
fn find<'a>(json: &'a serde_json::Value, key: &str) -> Option<&'a serde_json::Value> {
    match json {
        serde_json::Value::Object(map) => map
            .get(key)
            .or_else(|| map.values().find_map(|value| find(value, key))),
        serde_json::Value::Array(all) => all.iter().find_map(|value| find(value, key)),
        _ => None,
    }
}

/// Eight layers, direct light and their sum, with bounds: 72 bytes a texel each.
#[test]
fn a_map_of_512_x_512_texels_by_beams_takes_at_most_300_mb() {
    let folder = TempDir::new().unwrap();
    let output = folder.path().join("a.exr");
    let mut command = render(512, &output, &["--method", "beams", "--error", "0.1%"]);
    let (peak, _) = peak_memory(command.spawn().unwrap());
    println!("{:.1} MB for 512 x 512 texels by beams", peak as f64 / 1e6);
    assert!(peak <= 300_000_000, "{peak}");
}

/// What is begun stays below the limit, and a limit that is too low is refused before the run.
#[test]
fn memory_that_is_asked_for_is_kept_or_refused() {
    let folder = TempDir::new().unwrap();
    let output = folder.path().join("a.exr");
    for method in ["beams", "photons", "caustic-map"] {
        let mut smallest = None;
        for megabytes in [50, 100, 150, 200, 300, 400, 600] {
            let limit = format!("{megabytes}MB");
            let mut command = render(384, &output, &["--method", method, "--memory", &limit]);
            if method == "photons" {
                command.args(["--photons", "65536"]);
            }
            let Some(peak) = peak_or_refusal(command.spawn().unwrap()) else {
                assert!(smallest.is_none(), "{method}: refused at {megabytes} MB");
                continue;
            };
            println!("{method}: {:.1} MB of {megabytes} MB", peak as f64 / 1e6);
            assert!(
                peak <= megabytes * 1_000_000,
                "{method}: {peak} of {megabytes} MB"
            );
            smallest.get_or_insert(megabytes);
        }
        // Refused at 50 MB, begun at 600.
        assert!(smallest.is_some_and(|it| it > 50), "{method}: {smallest:?}");
    }
}

/// Photons are not kept: tasks, a few for each thread, are all that there is of them.
fn assert_photons_take_no_memory(powers: &[u32], more: &[&str]) {
    let folder = TempDir::new().unwrap();
    let output = folder.path().join("a.exr");
    let mut fewest = None;
    for power in powers {
        let photons = (1_u64 << power).to_string();
        let mut command = render(16, &output, &["--method", "photons", "--photons", &photons]);
        let (peak, _) = peak_memory(command.args(more).spawn().unwrap());
        println!("{:.1} MB for 2^{power} photons {more:?}", peak as f64 / 1e6);
        let few = *fewest.get_or_insert(peak);
        assert!(
            peak <= few + SLACK,
            "{few} bytes, {peak} for 2^{power} photons {more:?}"
        );
    }
}

#[test]
fn memory_does_not_grow_with_the_number_of_photons() {
    assert_photons_take_no_memory(&[12, 16, 22], &[]);
}

#[test]
#[ignore = "half a minute"]
fn memory_does_not_grow_up_to_2_to_24_photons() {
    assert_photons_take_no_memory(&[12, 24], &[]);
}

/// A replicate's tasks, of 4096 photons each, stay until it ends: one replicate alone has the most of them.
#[test]
fn memory_does_not_grow_with_the_photons_of_one_replicate() {
    assert_photons_take_no_memory(&[12, 16, 22], &["--replicates", "1"]);
}

/// A scene of one mesh; what it takes as `inspect` says \[bytes\], and the most that the program had while it
/// read it.
fn memory_of(folder: &Path, mesh: &MeshParts) -> (u64, u64) {
    let mut bytes = Vec::new();
    write_ply(mesh, "", &mut bytes).unwrap();
    fs::write(folder.join("mesh.ply"), bytes).unwrap();
    let path = folder.join("mesh.xml");
    let text = r#"<scene version="3.0.0"><shape type="ply"><string name="filename" value="mesh.ply"/></shape></scene>"#;
    fs::write(&path, text).unwrap();
    let (peak, printed) = peak_memory(inspect(&path).spawn().unwrap());
    let json: serde_json::Value = serde_json::from_slice(&printed).unwrap();
    (json["memory_bytes"].as_u64().unwrap(), peak)
}

/// Rippled water, whose faces share each vertex with five others: 200 bytes a face. The same faces without a
/// vertex in common: a corner of its own takes a position and a normal of three `f64` each, 48 bytes more.
#[test]
fn a_triangle_takes_no_more_memory_than_is_promised() {
    let folder = TempDir::new().unwrap();
    let water = |side: u32| height_field(DVec2::ONE, 0.0, &WATER, side);
    // A run of a few milliseconds may end between two looks at it: the most of several is the program's own.
    let nothing = (0..16)
        .map(|_| memory_of(folder.path(), &water(2)).1)
        .max()
        .unwrap();
    let check = |what: &str, mesh: &MeshParts, promised: f64| {
        let faces = mesh.triangles.len() as f64;
        let (held, peak) = memory_of(folder.path(), mesh);
        let (each, reading) = (held as f64 / faces, peak.saturating_sub(nothing));
        println!(
            "{what} of {faces} faces: {each:.0} bytes a face, as inspect says: {:.2} MB; {:.2} MB while it was read",
            held as f64 / 1e6,
            reading as f64 / 1e6
        );
        assert!(each <= promised, "{what}, {faces} faces: {each}");
        // What is held is in memory, and reading takes less than four times the honest need.
        assert!(
            held <= reading + SLACK,
            "{what}, {faces} faces: {held} of {reading}"
        );
        assert!(
            reading <= 4 * held + SLACK,
            "{what}, {faces} faces: {held} of {reading}"
        );
    };
    for side in [8, 23, 72, 225, 708] {
        check("water", &water(side), 200.0);
    }
    let shared = water(72);
    let own = |of: &[DVec3]| {
        shared
            .triangles
            .iter()
            .flatten()
            .map(|&at| of[at as usize])
            .collect()
    };
    let soup = MeshParts {
        positions: own(&shared.positions),
        normals: shared.normals.as_deref().map(own),
        triangles: (0..shared.triangles.len() as u32)
            .map(|face| [0, 1, 2].map(|corner| 3 * face + corner))
            .collect(),
        ..MeshParts::default()
    };
    check("soup", &soup, 200.0 + 3.0 * 48.0);
}
