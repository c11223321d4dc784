//! Speed of reading scene and mesh files, in megabytes a second.
//!
//! The files are made here. Meshes have normals, so that none are computed; the time covers reading the file,
//! the hash, parsing, and the mesh's checks.
#![allow(
    clippy::disallowed_methods,
    reason = "oracles and figures of a bench, no results"
)]

use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

use nephroid::internals::mitsuba::load_parts;

/// Quads along each side of the meshes.
const SIZE: u32 = 600;
/// Shapes of the XML file.
const SHAPES: u32 = 20_000;
/// The best of this many runs is reported.
const RUNS: u32 = 5;

fn main() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let meshes = [
        ("obj", "mesh.obj", obj()),
        ("ply", "ascii.ply", ply_ascii()),
        ("ply", "binary.ply", ply_binary()),
    ];
    for (plugin, name, bytes) in meshes {
        let text = format!(
            "<scene version=\"3.0.0\"><shape type=\"{plugin}\"><string name=\"filename\" value=\"{name}\"/></shape></scene>"
        );
        fs::write(folder.path().join(name), &bytes).expect("a mesh file");
        measure(folder.path(), name, &text, bytes.len());
    }
    let text = xml();
    measure(folder.path(), "scene.xml", &text, text.len());
}

fn measure(folder: &Path, name: &str, text: &str, bytes: usize) {
    let path = folder.join("bench.xml");
    fs::write(&path, text).expect("a scene file");
    let run = || -> Duration {
        let start = Instant::now();
        let parts = load_parts(&path, &[]).expect("the scene loads");
        let elapsed = start.elapsed();
        drop(parts);
        elapsed
    };
    let best = (0..RUNS).map(|_| run()).min().unwrap_or_default();
    let megabytes = bytes as f64 / 1e6;
    println!(
        "{name:<12} {megabytes:7.1} MB in {:7.1} ms: {:6.0} MB/s",
        best.as_secs_f64() * 1e3,
        megabytes / best.as_secs_f64()
    );
}

/// The corners of a wavy sheet with their normals.
fn corners() -> impl Iterator<Item = [f32; 6]> {
    (0..=SIZE).flat_map(|row| {
        (0..=SIZE).map(move |column| {
            let (x, y) = (column as f32 * 0.01, row as f32 * 0.01);
            [
                x,
                y,
                (3.0 * x).sin() * (2.0 * y).cos(),
                0.1 * x.sin(),
                0.1 * y.sin(),
                1.0,
            ]
        })
    })
}

/// The corners of every triangle, counted from 0.
fn triangles() -> impl Iterator<Item = [u32; 3]> {
    let width = SIZE + 1;
    (0..SIZE).flat_map(move |row| {
        (0..SIZE).flat_map(move |column| {
            let first = row * width + column;
            [
                [first, first + 1, first + width + 1],
                [first, first + width + 1, first + width],
            ]
        })
    })
}

fn obj() -> Vec<u8> {
    let mut text = String::new();
    for [x, y, z, nx, ny, nz] in corners() {
        writeln!(text, "v {x:.6} {y:.6} {z:.6}\nvn {nx:.6} {ny:.6} {nz:.6}").expect("memory");
    }
    for [a, b, c] in triangles().map(|triangle| triangle.map(|index| index + 1)) {
        writeln!(text, "f {a}//{a} {b}//{b} {c}//{c}").expect("memory");
    }
    text.into_bytes()
}

fn ply_header(format: &str) -> String {
    let vertices = (SIZE + 1) * (SIZE + 1);
    let faces = 2 * SIZE * SIZE;
    let properties: String = ["x", "y", "z", "nx", "ny", "nz"]
        .map(|name| format!("property float {name}\n"))
        .concat();
    format!(
        "ply\nformat {format} 1.0\nelement vertex {vertices}\n{properties}element face {faces}\n\
         property list uchar int vertex_indices\nend_header\n"
    )
}

fn ply_ascii() -> Vec<u8> {
    let mut text = ply_header("ascii");
    for [x, y, z, nx, ny, nz] in corners() {
        writeln!(text, "{x:.6} {y:.6} {z:.6} {nx:.6} {ny:.6} {nz:.6}").expect("memory");
    }
    for [a, b, c] in triangles() {
        writeln!(text, "3 {a} {b} {c}").expect("memory");
    }
    text.into_bytes()
}

fn ply_binary() -> Vec<u8> {
    let mut bytes = ply_header("binary_little_endian").into_bytes();
    bytes.extend(corners().flatten().flat_map(f32::to_le_bytes));
    for triangle in triangles() {
        bytes.push(3);
        bytes.extend(triangle.into_iter().flat_map(u32::to_le_bytes));
    }
    bytes
}

fn xml() -> String {
    let mut text = String::from("<scene version=\"3.0.0\">\n");
    for n in 0..SHAPES {
        write!(
            text,
            "\t<bsdf type=\"diffuse\" id=\"material_{n}\">\n\t\t<rgb name=\"reflectance\" value=\"0.1, 0.2, 0.3\"/>\n\t</bsdf>\n\
             \t<shape type=\"rectangle\" id=\"shape_{n}\">\n\t\t<transform name=\"to_world\">\n\t\t\t<rotate x=\"1\" angle=\"{n}\"/>\n\
             \t\t\t<matrix value=\"1 0 0 {n} 0 1 0 2 0 0 1 3 0 0 0 1\"/>\n\t\t</transform>\n\t\t<ref id=\"material_{n}\"/>\n\t</shape>\n"
        )
        .expect("memory");
    }
    text + "</scene>\n"
}
