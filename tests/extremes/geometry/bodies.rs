//! Bodies that are open, lie in one another, cross themselves, or are inside out.

use glam::DVec3;
use nephroid::internals::geometry::MeshParts;
use nephroid::internals::optics::dielectric_reflectance;
use nephroid::internals::reference::beams;
use nephroid::internals::reference::beams::BeamSettings;
use nephroid::internals::run::Budget;
use nephroid::internals::run::{LayerName, Progress};

use super::runs::{
    FLAT, IOR, ROUNDING, assert_share, block, cube, inside_out, load, photons, received, says,
    share, together,
};
use crate::support::mutation::obj;

#[test]
fn a_closed_block_an_open_one_and_two_in_one_another_share_light_by_their_faces() {
    let passes = 1.0 - dielectric_reflectance(1.0, IOR);
    let down = -DVec3::Z;
    let run = |parts: &MeshParts| {
        let scene = load("block.obj", &obj(parts), FLAT, down).unwrap();
        (photons(&scene), scene)
    };
    let (closed, scene) = run(&cube());
    assert!(scene.warnings().is_empty(), "{:?}", scene.warnings());
    assert_share(received(&closed, "LTTD"), passes * passes, "closed");
    assert_share(
        received(&closed, "LTRRTD"),
        (passes * (1.0 - passes)).powi(2),
        "closed, twice reflected",
    );
    // Without its lower side: light goes in and never out.
    let mut open = cube();
    open.triangles.truncate(10);
    let (open, scene) = run(&open);
    assert!(says(&scene, "4 open edges"), "{:?}", scene.warnings());
    assert_share(received(&open, "LTD"), passes, "open");
    assert_share(share(&open, "LTTD"), 0.0, "open");
    // Each face bends light as if the other block were not there.
    let other = block(DVec3::new(-0.5, -0.5, 1.5), DVec3::new(0.5, 0.5, 2.5));
    let (both, scene) = run(&together(&cube(), &other));
    assert!(!says(&scene, "open"), "{:?}", scene.warnings());
    assert_share(
        received(&both, "LTTTTD"),
        passes.powi(4),
        "two in one another",
    );
    assert_share(received(&both, "LTTD"), 0.0, "two in one another");
}

/// A prism along y whose outline is a bow-tie under a roof: a closed mesh with two sides that cross one
/// another along the line x = 0, z = 1.25. Below it all faces have their outside within.
fn bow_tie() -> MeshParts {
    const OUTLINE: [[f64; 2]; 6] = [
        [-1.0, 1.75],
        [1.0, 1.75],
        [1.0, 1.5],
        [-1.0, 1.0],
        [1.0, 1.0],
        [-1.0, 1.5],
    ];
    let count = OUTLINE.len() as u32;
    let ends = [-1.0, 1.0].into_iter();
    let positions = ends.flat_map(|y| OUTLINE.map(|[x, z]| DVec3::new(x, y, z)));
    let sides = (0..count).flat_map(|i| {
        let j = (i + 1) % count;
        [[i, j, count + j], [i, count + j, count + i]]
    });
    let ends = (1..count - 1).flat_map(|k| [[0, k + 1, k], [count, count + k, count + k + 1]]);
    MeshParts {
        positions: positions.collect(),
        triangles: sides.chain(ends).collect(),
        ..MeshParts::default()
    }
}

#[test]
fn a_closed_mesh_that_crosses_itself_bends_light_by_the_side_of_each_face_that_it_meets() {
    // Light from straight above meets the roof, one of the two sides that cross (from within), the other one
    // below it, and the bottom: all of it, for it is bent towards the middle. It stays in planes of constant
    // y; angles are from the vertical there, on the half of positive x towards the middle.
    let slope = 0.25_f64;
    let tilt = slope.atan();
    // The roof, level: from its outside.
    let mut passes = 1.0 - dielectric_reflectance(1.0, IOR);
    // The upper side, from its inside.
    passes *= 1.0 - dielectric_reflectance(tilt.cos(), 1.0 / IOR);
    let between = (IOR * tilt.sin()).asin() - tilt;
    // The lower side is inside out: light comes from its inside, above it, and leaves the glass for what is
    // below.
    let to_lower = tilt - between;
    let before_lower = passes;
    passes *= 1.0 - dielectric_reflectance(to_lower.cos(), 1.0 / IOR);
    let below = tilt - (IOR * to_lower.sin()).asin();
    // The bottom, level, has its outside above it.
    passes *= 1.0 - dielectric_reflectance(below.cos(), IOR);
    let last = (below.sin() / IOR).asin();
    // If the faces below were those of a block like any other:
    let bent = (to_lower.sin() / IOR).asin();
    let otherwise = before_lower
        * (1.0 - dielectric_reflectance(to_lower.cos(), IOR))
        * (1.0 - dielectric_reflectance((tilt - bent).cos(), 1.0 / IOR));
    // Where x from 0 to 1 on the roof comes down to, linear in x: from the upper side, at 1.25 + slope x, to
    // the lower one, at 1.25 - slope x, to the bottom at 1, to the floor.
    let on_floor = |x: f64| {
        let down = 2.0 * slope * x / (1.0 + slope * between.tan());
        let lower = x - down * between.tan();
        let bottom = lower - slope * (1.0 - lower) * below.tan();
        bottom - last.tan()
    };
    let (inner, outer) = (on_floor(0.0), on_floor(1.0));

    let scene = load("tie.obj", &obj(&bow_tie()), FLAT, -DVec3::Z).unwrap();
    // Closed, and more of it is outward than inward.
    assert!(scene.warnings().is_empty(), "{:?}", scene.warnings());
    let by_photons = received(&photons(&scene), "LTTTTD");
    println!(
        "share {by_photons}, off by {:.1e}; other sides would make {:.1e} of it",
        by_photons - passes,
        otherwise - passes
    );
    assert!((otherwise - passes).abs() > 1e3 * ROUNDING);
    assert_share(by_photons, passes, "a bow-tie");

    // By beams: two images of the halves, each of constant irradiance, that overlap in the middle.
    let settings = BeamSettings {
        max_layers: 64,
        ..BeamSettings::default()
    };
    let sensor = &scene.sensors()[0];
    let (estimate, _) = beams::run(
        &scene,
        sensor,
        settings,
        &Budget::default(),
        &Progress::default(),
    )
    .unwrap();
    let signature = "LTTTTD".parse().unwrap();
    let layers = estimate.layers.iter();
    let mut layers = layers.filter(|layer| layer.name == LayerName::Path(signature));
    let layer = layers.next().expect("beams find that light");
    let bounds = layer.interval.as_ref().unwrap();
    let overlap = |low: f64, high: f64, texel: usize| {
        let from = -2.0 + 0.25 * texel as f64;
        (high.min(from + 0.25) - low.max(from)).max(0.0) / 0.25
    };
    let (mut lit, mut worst) = (0, 0.0_f64);
    for texel in 0..256 {
        let (column, row) = (texel % 16, texel / 16);
        let across = overlap(inner, outer, column) + overlap(-outer, -inner, column);
        let truth = passes / (outer - inner) * across * overlap(-1.0, 1.0, row);
        let [low, value, high] =
            [bounds.low[texel], layer.values[texel], bounds.high[texel]].map(|rgb| rgb.0[0]);
        assert!(
            low <= truth + ROUNDING && truth - ROUNDING <= high,
            "texel {column}, {row}: {truth} is not within {low} to {high}"
        );
        lit += usize::from(truth > 0.0);
        worst = worst.max((value - truth).abs());
    }
    println!("{lit} texels with light within bounds; beams are off by {worst:.1e} of E0 at worst");
    assert!(lit >= 64);
}

#[test]
fn a_block_inside_out_is_found_out_and_flip_normals_mends_it() {
    // 54.7° to three sides: beyond the critical angle of 41.8° for light that takes the outside for glass.
    let sun = DVec3::new(1.0, 1.0, -1.0);
    let inward = obj(&inside_out(cube()));
    let scene = load("block.obj", &inward, FLAT, sun).unwrap();
    assert!(says(&scene, "inside out"), "{:?}", scene.warnings());
    assert_share(share(&photons(&scene), "LRD"), 1.0, "inside out");
    let mended = format!(r#"{FLAT}<boolean name="flip_normals" value="true"/>"#);
    let scene = load("block.obj", &inward, &mended, sun).unwrap();
    assert!(scene.warnings().is_empty(), "{:?}", scene.warnings());
    let reflected = dielectric_reflectance(1.0 / 3_f64.sqrt(), IOR);
    assert_share(share(&photons(&scene), "LRD"), reflected, "mended");
    let scene = load("block.obj", &obj(&cube()), FLAT, sun).unwrap();
    assert_share(share(&photons(&scene), "LRD"), reflected, "outward");
}
