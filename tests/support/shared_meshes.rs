//! Scanned and modelled meshes, where there are any beside the crate (they are not part of it).

use std::fs;
use std::path::PathBuf;

use glam::DVec3;
use nephroid::internals::geometry::MeshParts;

/// A mesh of the folder beside the crate, or `None` (said aloud) where there is none: `float x y z`, then
/// faces as `uchar` and three `int`s.
pub fn shared_mesh(name: &str) -> Option<MeshParts> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("../shared/meshes")
        .join(format!("{name}.ply"));
    let Ok(bytes) = fs::read(&path) else {
        println!("skipped {name}: no such file in ../shared/meshes");
        return None;
    };
    let end = bytes.windows(11).position(|w| w == b"end_header\n")? + 11;
    let header = String::from_utf8_lossy(&bytes[..end]).into_owned();
    let count = |element: &str| -> usize {
        let line = header.lines().find(|line| line.starts_with(element));
        line.and_then(|line| line.rsplit(' ').next()?.parse().ok())
            .expect("a count")
    };
    let (vertices, faces) = (count("element vertex"), count("element face"));
    let word = |at: usize| [bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]];
    let positions = (0..vertices)
        .map(|i| {
            let x = |axis: usize| f64::from(f32::from_le_bytes(word(end + 12 * i + 4 * axis)));
            DVec3::new(x(0), x(1), x(2))
        })
        .collect();
    let first = end + 12 * vertices;
    let triangles = (0..faces)
        .map(|i| std::array::from_fn(|k| u32::from_le_bytes(word(first + 13 * i + 1 + 4 * k))))
        .collect();
    Some(MeshParts {
        positions,
        triangles,
        ..MeshParts::default()
    })
}
