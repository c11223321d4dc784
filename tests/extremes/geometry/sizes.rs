//! Meshes of one triangle, and of a million.

use std::io::Read;
use std::path::Path;
use std::time::Instant;

use flate2::read::GzDecoder;
use glam::DVec3;
use nephroid::internals::geometry::MeshParts;
use nephroid::internals::numeric::ExactSum;
use nephroid::internals::optics::dielectric_reflectance;

use super::runs::{IOR, assert_share, load, photons, received, row, says, unseen};
use crate::support::geometry::{bumpy_torus, leaks, within_torus, world_of};
use crate::support::mutation::obj;

#[test]
fn a_mesh_of_one_triangle_is_an_interface() {
    let triangle = MeshParts {
        positions: vec![
            DVec3::new(-1.0, -1.0, 1.0),
            DVec3::new(1.0, -1.0, 1.0),
            DVec3::new(0.0, 1.0, 1.0),
        ],
        triangles: vec![[0, 1, 2]],
        ..MeshParts::default()
    };
    let scene = load("one.obj", &obj(&triangle), "", -DVec3::Z).unwrap();
    assert!(says(&scene, "3 open edges"), "{:?}", scene.warnings());
    let estimate = photons(&scene);
    let reflected = dielectric_reflectance(1.0, IOR);
    assert_share(unseen(&estimate), reflected, "reflected");
    assert_share(received(&estimate, "LTD"), 1.0 - reflected, "transmitted");
}

#[test]
fn a_generated_mesh_of_more_faces_than_the_dragon_is_built_closes_and_keeps_its_rays() {
    let parts = bumpy_torus(934, 467);
    assert!(parts.triangles.len() > 871_414);
    // What closes has area vectors whose sum is 0, for the very positions that it has: the edges' parts
    // cancel.
    let mut sums = [(); 3].map(|()| ExactSum::new());
    let mut sizes = ExactSum::new();
    for face in &parts.triangles {
        let [a, b, c] = face.map(|vertex| parts.positions[vertex as usize]);
        let (ab, ac) = (b - a, c - a);
        let area = 0.5 * ab.cross(ac);
        sizes.add(ab.length() * ac.length());
        for (sum, part) in sums.iter_mut().zip(area.to_array()) {
            sum.add(part);
        }
    }
    // A part is half the difference of two products of differences. Each product is rounded three times (4u
    // with room for what is of second order), the difference once: 5u of the products' magnitudes, which by
    // Cauchy and Schwarz are at most the edges' lengths multiplied. The sum itself is exact.
    let allowed = 0.5 * 5.0 * 0.5 * f64::EPSILON * sizes.value();
    let off = sums.map(|sum| sum.value().abs()).into_iter();
    let off = off.fold(0.0, f64::max);
    let start = Instant::now();
    let world = world_of(parts.clone());
    let seconds = start.elapsed().as_secs_f64();
    let found = leaks(&parts, &world, (1.0, DVec3::ZERO), 50_000, within_torus);
    println!(
        "{} faces: built in {seconds:.1} s, area vectors sum to {off:.1e}, allowed {allowed:.1e}; {found:?}",
        parts.triangles.len()
    );
    // A face that is missing or turned round is a million million times as large.
    assert!(off <= allowed && allowed < 1e-12, "{off:e}, {allowed:e}");
    assert_eq!((found.rays, found.out, found.into), (50_000, 0, 0));
    assert!(
        found.seen > 10_000,
        "{} points are met from without",
        found.seen
    );
}

#[test]
fn a_mesh_of_871_thousand_triangles_closes_its_ledger() {
    let file =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/meshes/raw/dragon_vrip_871k.ply.gz");
    let Ok(compressed) = std::fs::read(&file) else {
        println!("skipped: there is no {}", file.display());
        return;
    };
    let mut bytes = Vec::new();
    GzDecoder::new(&*compressed)
        .read_to_end(&mut bytes)
        .unwrap();
    let placing =
        r#"<transform name="to_world"><rotate x="1" angle="90"/><scale value="8"/></transform>"#;
    let start = Instant::now();
    let scene = load("dragon.ply", &bytes, placing, DVec3::new(0.1, 0.2, -1.0)).unwrap();
    println!(
        "loaded in {:.1} s, {} MB",
        start.elapsed().as_secs_f64(),
        scene.world().memory_bytes() >> 20
    );
    for warning in scene.warnings() {
        println!("{}", warning.message);
    }
    let estimate = photons(&scene);
    assert!(row(&estimate, "LTTD").total().mean() > 0.0);
    println!("closes to {:.1e}", estimate.ledger.closure_error().unwrap());
}
