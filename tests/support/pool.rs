//! The pool, and what light volumes make of it.

use std::fmt::Write as _;
use std::fs;

use glam::DVec3;
use nephroid::internals::generate::write_ply;
use nephroid::internals::geometry::MeshParts;
use nephroid::internals::method::Method;
use nephroid::internals::mitsuba;
use nephroid::internals::run::Rendering;
use nephroid::internals::scene::Scene;

use super::light_volume::run_on;
use super::scenes::bundled_file;

#[allow(unused_imports, reason = "every program uses its own part of this")]
pub use super::light_volume::{count as work, exact_but, sensor, volume};

/// The cameras under water, in the order of the paper's Table 1, by the percentage of beams that they see.
pub const VIEWS: [&str; 4] = ["view-50", "view-35", "view-100", "view-25"];

/// What hangs above the water.
pub const OCCLUDERS: [&str; 3] = ["none", "disc", "fence"];

/// Vertices a row of the paper's meshes.
pub const MESHES: [&str; 3] = ["120", "160", "200"];

/// Table 1, speedup of the hierarchy in percent: by [`VIEWS`] and [`MESHES`].
pub const SPEEDUPS: [[f64; 3]; 4] = [
    [63.35, 79.50, 85.44],
    [36.52, 49.89, 55.38],
    [112.26, 134.81, 143.31],
    [21.3, 32.41, 37.22],
];

/// The pool under an occluder, with `side` x `side` texels on meters.
pub fn metered(occluder: &str, side: usize) -> Scene {
    load(&[("occluder", occluder), ("size", &side.to_string())])
}

/// The pool under an occluder, with so many pixels a row of a camera, and rows.
pub fn viewed(occluder: &str, [width, height]: [usize; 2]) -> Scene {
    let (width, height) = (width.to_string(), height.to_string());
    load(&[
        ("occluder", occluder),
        ("width", &width),
        ("height", &height),
    ])
}

fn load(parameters: &[(&str, &str)]) -> Scene {
    let owned = |(key, value): &(&str, &str)| ((*key).into(), (*value).into());
    let parameters: Vec<_> = parameters.iter().map(owned).collect();
    mitsuba::load(&bundled_file("pool"), &parameters).unwrap()
}

/// The pool with 8 · 4ⁿ triangles in the place of its ball, in the ball's box.
pub fn with_round_mesh(levels: u32, [width, height]: [usize; 2]) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    let shipped = bundled_file("pool");
    let text = fs::read_to_string(&shipped).unwrap();
    let (before, rest) = text
        .split_once(r#"<shape type="sphere" id="ball">"#)
        .unwrap();
    let (_, after) = rest.split_once("</shape>").unwrap();
    let ball = r#"<shape type="ply" id="ball"><string name="filename" value="ball.ply"/></shape>"#;
    fs::write(
        folder.path().join("pool.xml"),
        [before, ball, after].concat(),
    )
    .unwrap();
    for name in ["pool.ply", "pool-none.xml"] {
        fs::copy(shipped.with_file_name(name), folder.path().join(name)).unwrap();
    }
    let mut bytes = Vec::new();
    let mesh = octahedral_ball(DVec3::new(-0.55, 0.45, 0.75), 0.3, levels);
    write_ply(&mesh, "for a test", &mut bytes).unwrap();
    fs::write(folder.path().join("ball.ply"), bytes).unwrap();
    let size = [("width", width), ("height", height)].map(|(key, it)| (key.into(), it.to_string()));
    mitsuba::load(&folder.path().join("pool.xml"), &size).unwrap()
}

/// An octahedron, quartered so often, with all vertices on a ball. Six of them are at the sides of its box.
fn octahedral_ball(center: DVec3, radius: f64, levels: u32) -> MeshParts {
    let mut faces: Vec<[DVec3; 3]> = Vec::new();
    for (x, y, z) in [
        (1.0, 1.0, 1.0),
        (-1.0, 1.0, 1.0),
        (1.0, -1.0, 1.0),
        (-1.0, -1.0, 1.0),
        (1.0, 1.0, -1.0),
        (-1.0, 1.0, -1.0),
        (1.0, -1.0, -1.0),
        (-1.0, -1.0, -1.0),
    ] {
        let face = [DVec3::X * x, DVec3::Y * y, DVec3::Z * z];
        let [a, b, c] = face;
        faces.push(if x * y * z > 0.0 {
            [a, b, c]
        } else {
            [a, c, b]
        });
    }
    for _ in 0..levels {
        let quartered = faces.iter().flat_map(|&[a, b, c]| {
            let middle = |a: DVec3, b: DVec3| (a + b).normalize();
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        });
        faces = quartered.collect();
    }
    let corners = faces.iter().flatten();
    MeshParts {
        positions: corners.map(|corner| center + *corner * radius).collect(),
        triangles: (0..faces.len() as u32)
            .map(|face| [3 * face, 3 * face + 1, 3 * face + 2])
            .collect(),
        ..MeshParts::default()
    }
}

/// What a light volume makes of a sensor.
pub fn rendered(scene: &Scene, id: &str, volume: &Method) -> Rendering {
    run_on(volume, scene, id)
}

/// Texels that two renderings have in other bits.
pub fn unlike(one: &Rendering, other: &Rendering) -> usize {
    let (a, b) = (&one.estimate.total.values, &other.estimate.total.values);
    a.iter().zip(b).filter(|(a, b)| a.0 != b.0).count()
}

/// A line of a table.
pub fn line(cells: &[String]) -> String {
    let mut line = String::from("|");
    for cell in cells {
        write!(line, " {cell} |").unwrap();
    }
    line
}
