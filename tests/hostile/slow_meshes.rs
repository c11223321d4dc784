//! Meshes made to be slow.

use glam::DVec3;
use nephroid::internals::geometry::MeshParts;

use super::honest::Kind;
use super::watch::{alone, load_elements};
use crate::support::mutation::ply;

/// A mesh of triangles, one round each of these points.
fn specks(corners: impl Iterator<Item = [DVec3; 3]>) -> MeshParts {
    let positions: Vec<DVec3> = corners.flatten().collect();
    MeshParts {
        triangles: (0..positions.len() as u32 / 3)
            .map(|face| [3 * face, 3 * face + 1, 3 * face + 2])
            .collect(),
        positions,
        ..MeshParts::default()
    }
}

#[test]
fn meshes_made_to_be_slow_are_read_in_time() {
    let _alone = alone();
    const COUNT: u32 = 100_000;
    let at = |place: DVec3| [place, place + DVec3::X, place + DVec3::Y];
    let cases = [
        (
            "triangles in one place, apart by rounding",
            specks((0..COUNT).map(|n| at(DVec3::Z * (f64::from(n) * 1e-15)))),
        ),
        (
            "triangles in a row",
            specks((0..COUNT).map(|n| at(DVec3::X * f64::from(n)))),
        ),
        (
            "triangles in a tower",
            specks((0..COUNT).map(|n| at(DVec3::Z * f64::from(n)))),
        ),
        (
            "triangles round one another",
            specks((0..COUNT).map(|n| {
                at(DVec3::ZERO).map(|p| (p - DVec3::new(1.0, 1.0, 0.0) / 3.0) * f64::from(n + 1))
            })),
        ),
        (
            "triangles each half as large as the last",
            specks((0..COUNT).map(|n| at(DVec3::ZERO).map(|p| p * 0.999_f64.powi(n as i32)))),
        ),
        ("positions whose hashes collide", colliding(COUNT)),
    ];
    for (case, mesh) in cases {
        let outcome = Kind::BinaryPly.load(&ply(&mesh, "binary_little_endian"));
        println!(
            "{case}: {} bytes of heap, {:.2} s",
            outcome.peak, outcome.seconds
        );
        if let Err(error) = outcome.result {
            panic!("{case}: {error}");
        }
    }
    let polygon: String = (1..=100_000).map(|n| format!(" {n}")).collect();
    let vertices: String = (0..100_000)
        .map(|n| format!("v {} {} 0\n", n % 1000, n / 1000))
        .collect();
    let star: String = (2..100_000)
        .map(|n| format!("f 1 {n} {}\n", n + 1))
        .collect();
    let normals: String = (0..100_000)
        .map(|n| format!("vn 0 {n} 1\nf 1//{} 2 3\n", n + 1))
        .collect();
    for (case, text) in [
        (
            "a face of 100 000 corners",
            format!("{vertices}f{polygon}\n"),
        ),
        ("100 000 faces round a vertex", format!("{vertices}{star}")),
        (
            "a vertex with 100 000 normals",
            format!("{vertices}{normals}"),
        ),
    ] {
        let outcome = Kind::Obj.load(text.as_bytes());
        println!(
            "{case}: {} bytes of heap, {:.2} s",
            outcome.peak, outcome.seconds
        );
        if let Err(error) = outcome.result {
            panic!("{case}: {error}");
        }
    }
    // Glass, so that they are looked at for surfaces at the same place; and each round the last, so that none
    // are.
    let ball = |radius: f64| {
        format!(
            "<shape type=\"sphere\"><float name=\"radius\" value=\"{radius}\"/><bsdf type=\"dielectric\"/></shape>\n"
        )
    };
    let nested: String = (1..=50_000).map(|i| ball(1e-3 * f64::from(i))).collect();
    for (case, balls) in [
        ("in one place", ball(1.0).repeat(50_000)),
        ("round one another", nested),
    ] {
        let outcome = load_elements(&balls);
        println!("50 000 balls of glass {case}: {:.2} s", outcome.seconds);
        let scene = outcome.result.expect("balls are a scene");
        assert!(
            scene.warnings().len() < 100,
            "{case}: {} warnings",
            scene.warnings().len()
        );
    }
}

/// Triangles of positions that all had the same hash while the hash had no secret: the multiplication of two
/// coordinates' bits is undone by the third's.
fn colliding(faces: u32) -> MeshParts {
    const START: u64 = 0x9e37_79b9_7f4a_7c15;
    let mix = |state: u64, word: u64| {
        let product = u128::from(state ^ word ^ START) * 0xbf58_476d_1ce4_e5b9;
        (product as u64) ^ ((product >> 64) as u64)
    };
    let mut positions = Vec::new();
    let mut n = 0_u32;
    while positions.len() < 3 * faces as usize {
        n += 1;
        let (x, y) = (1.0 + f64::from(n) * 1e-6, 1.0_f64);
        let state = mix(mix(0, x.to_bits()), y.to_bits());
        let z = f64::from_bits(state ^ 0x1234_5678);
        if z.is_finite() && z.abs() < 1e60 && z.abs() > 1e-60 {
            positions.push(DVec3::new(x, y, z));
        }
    }
    specks(
        positions
            .chunks_exact(3)
            .map(|corners| [corners[0], corners[1], corners[2]])
            .collect::<Vec<_>>()
            .into_iter(),
    )
}
