//! Light space loses no caustic: what was culled cannot meet specular geometry.
//!
//! Brute force: rays all over each emitter's charts, traced to their first specular surface. A
//! ray that meets one must start in a cell that was kept.

use std::path::Path;

use glam::DVec2;
use nephroid::internals::geometry::TraversalCounters;
use nephroid::internals::mitsuba;
use nephroid::internals::numeric::{Stream, StreamKind};
use nephroid::internals::scene::{Material, Scene};
use nephroid::internals::transport::domain::LightSpace;

fn load(name: &str) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("scenes")
        .join(name);
    mitsuba::load(&path, &[]).unwrap()
}

/// Whether a ray meets a specular surface, looking through nothing but null surfaces.
fn meets_specular(scene: &Scene, ray: &nephroid::internals::geometry::Ray) -> bool {
    let mut counters = TraversalCounters::default();
    let mut ray = *ray;
    loop {
        let world = scene.world();
        let Some(hit) = world.closest_hit(&ray, f64::INFINITY, &mut counters) else {
            return false;
        };
        let material = scene.material_of(hit.shape);
        if *material != Material::Null {
            return material.is_specular(scene.materials());
        }
        ray = world.surface_point(&ray, &hit).spawn(ray.direction);
    }
}

#[test]
fn no_ray_outside_the_cells_meets_specular_geometry() {
    const RAYS: u64 = 60_000;
    // Parallel light starts as a rectangle round the glass: on some scenes that is all of it.
    for (name, has_dark_part) in [
        ("glass-ball.xml", true),
        ("glass-ball-mesh.xml", true),
        ("mirror-ring.xml", true),
        ("lens.xml", true),
        ("cornell-glass.xml", true),
        ("cornell-caustics.xml", true),
        ("turntable-ball.xml", true),
        ("turntable-ring.xml", true),
        ("turntable-bumpy.xml", true),
        ("diamond.xml", true),
        ("coffee-cup.xml", false),
        ("water.xml", false),
        ("pool.xml", false),
        ("prism.xml", false),
        ("parabolic-mirror.xml", false),
    ] {
        let scene = load(name);
        let light = LightSpace::new(&scene).unwrap();
        let stream = Stream::new(StreamKind::Sobol, 5);
        let (mut met, mut culled) = (0, 0);
        for (number, chart) in light.charts().iter().enumerate() {
            let root = light.root(chart);
            let stream = stream.split(number as u64);
            for index in 0..RAYS / light.charts().len() as u64 {
                let [x, y, u, v] = stream.point4(index);
                let at = DVec2::new(x, y);
                let emission = chart.emit(&root, at, DVec2::new(u, v));
                if emission.measure == 0.0 {
                    continue;
                }
                let kept = light.holds(number, root.at(at));
                culled += u64::from(!kept);
                if meets_specular(&scene, &emission.ray) {
                    met += 1;
                    assert!(
                        kept,
                        "{name}: chart {number} at {at} is culled but meets glass"
                    );
                }
            }
        }
        // Neither half of the claim is empty.
        assert!(met > 0, "{name}: no ray met specular geometry");
        assert!(culled > 0 || !has_dark_part, "{name}: nothing was culled");
    }
}

#[test]
fn an_allotment_gives_every_photon_to_some_cell() {
    let scene = load("glass-ball.xml");
    let light = LightSpace::new(&scene).unwrap();
    let shares: f64 = (0..light.cells().len()).map(|cell| light.share(cell)).sum();
    // A telescoping sum of exact differences of neighbours: rounding of one each at most.
    assert!((shares - 1.0).abs() < light.cells().len() as f64 * f64::EPSILON);
    for count in [1, 2, 3, 1000, 1 << 19, (1 << 32) - 1] {
        for offset in [0.0, 0.25, 0.5, 1.0 - 2f64.powi(-20)] {
            let sum: u64 = (0..light.cells().len())
                .map(|cell| light.allotment(cell, count, offset))
                .sum();
            assert_eq!(sum, count, "offset {offset}");
        }
    }
}

#[test]
fn scenes_without_glass_or_light_have_an_empty_light_space() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("dull.xml");
    for emitter in [
        r#"<emitter type="point"><rgb name="intensity" value="0"/></emitter>"#,
        r#"<emitter type="point"><rgb name="intensity" value="1"/></emitter>"#,
    ] {
        let glass = if emitter.contains("\"0\"") {
            r#"<shape type="sphere"><bsdf type="dielectric"/></shape>"#
        } else {
            ""
        };
        std::fs::write(
            &path,
            format!(r#"<scene version="3.0.0">{emitter}{glass}<shape type="rectangle"/></scene>"#),
        )
        .unwrap();
        let scene = mitsuba::load(&path, &[]).unwrap();
        assert!(LightSpace::new(&scene).unwrap().is_empty(), "{emitter}");
    }
}

#[test]
fn a_check_refuses_what_has_no_light_space_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("lamp.xml");
    let glass = r#"<shape type="sphere"><bsdf type="dielectric"/></shape>"#;
    let lamp = |shape: &str, inside: &str, kind: &str, light: &str| {
        format!(
            r#"{glass}<shape type="{shape}">{inside}<emitter type="{kind}"><rgb name="radiance" value="{light}"/></emitter></shape>"#
        )
    };
    let inward = r#"<boolean name="flip_normals" value="true"/>"#;
    let blend = r#"<shape type="sphere"><bsdf type="blendbsdf"><float name="weight" value="0.5"/>
        <bsdf type="dielectric"/><bsdf type="thindielectric"/></bsdf></shape>"#;
    for (inside, is_refused) in [
        (lamp("cylinder", "", "area", "1"), true),
        (lamp("cylinder", "", "area", "0"), false),
        (lamp("sphere", inward, "area", "1"), true),
        (lamp("sphere", "", "area", "1"), false),
        (lamp("rectangle", "", "directionalarea", "1"), false),
        (blend.to_owned(), true),
        (r#"<emitter type="constant"/>"#.to_owned(), false),
    ] {
        let text = format!(r#"<scene version="3.0.0">{inside}</scene>"#);
        std::fs::write(&path, text).unwrap();
        let scene = mitsuba::load(&path, &[]).unwrap();
        let refusal = LightSpace::new(&scene).err();
        assert_eq!(LightSpace::check(&scene).err(), refusal, "{inside}");
        assert_eq!(refusal.is_some(), is_refused, "{inside}");
    }
}

#[test]
fn shares_by_importance_leave_every_cell_half_of_its_own() {
    let mut light = LightSpace::new(&load("glass-ball.xml")).unwrap();
    let before: Vec<f64> = (0..light.cells().len())
        .map(|cell| light.share(cell))
        .collect();
    // All of importance is in one cell: half of the samples are, and its own.
    let mut squares = vec![0.0; before.len()];
    let bright = before.len() / 3;
    squares[bright] = 2.0;
    light.share_by(&squares);
    for (cell, own) in before.iter().enumerate() {
        let more = if cell == bright { 0.5 } else { 0.0 };
        // Differences of cumulative sums of at most 1: each is rounded to 2^-53, of two of them and their halves.
        let error = light.share(cell) - (0.5 * own + more);
        assert!(error.abs() < 4.0 * f64::EPSILON, "{cell}: {error:e}");
    }
    // Nothing is important: nothing changes.
    let shares: Vec<f64> = (0..before.len()).map(|cell| light.share(cell)).collect();
    light.share_by(&vec![0.0; before.len()]);
    assert!((0..before.len()).all(|cell| light.share(cell) == shares[cell]));
}
