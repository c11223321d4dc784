//! A camera close to a surface sees a millionth of what a facet's light falls on: its image costs no more for
//! that, and is right.

use glam::DVec2;

use nephroid::internals::mitsuba;
use nephroid::internals::scene::Scene;

use crate::support::bundled_file;
use crate::support::probes::{of, probe_at, sum};
use crate::support::scene_files::Folder;
use crate::support::seen::by_beams;

/// Pixels a side.
const SIDE: usize = 64;
/// Half the side of the floor.
const FLOOR: f64 = 2.0;
const ALBEDO: f64 = 0.8;

/// The bundled cube, lit by `emitter`, seen by a camera at a height straight above a place of the floor.
fn cube(emitter: &str, place: DVec2, height: f64) -> Scene {
    let xml = std::fs::read_to_string(bundled_file("cube")).unwrap();
    let begins = xml.find("<emitter").unwrap();
    let ends = xml.find("</emitter>").unwrap() + "</emitter>".len();
    let (x, y) = (place.x, place.y);
    let view = format!(r#"origin="{x}, {y}, {height}" target="{x}, {y}, 0" up="0, 1, 0""#);
    let xml = [&xml[..begins], emitter, &xml[ends..]]
        .concat()
        .replace(
            r#"origin="3.4, -3.2, 2.9" target="0.3, 0.1, 0.35" up="0, 0, 1""#,
            &view,
        )
        .replace(
            r#"<float name="fov""#,
            r#"<float name="near_clip" value="1e-9"/><float name="fov""#,
        )
        .replace(r#"value="640""#, &format!(r#"value="{SIDE}""#))
        .replace(r#"value="480""#, &format!(r#"value="{SIDE}""#));
    assert!(xml.contains(&view) && xml.contains("near_clip"));
    let folder = Folder::new();
    mitsuba::load(&folder.write("cube.xml", xml), &[]).unwrap()
}

const SUN: &str = r#"<emitter type="directional"><vector name="direction" x="0.5" y="0.2" z="-1"/>
  <rgb name="irradiance" value="1000"/></emitter>"#;

const LAMP: &str = r#"<emitter type="point"><point name="position" x="-1" y="-0.4" z="3"/>
  <rgb name="intensity" value="1000"/></emitter>"#;

/// Places within the light that goes through top and bottom, one of them by way of a side, too.
const PLACES: [DVec2; 2] = [DVec2::new(0.3, 0.12), DVec2::new(0.45, 0.1)];

#[test]
fn a_camera_close_to_the_floor_sees_the_light_that_probes_find_there() {
    // A lamp's polygons have bent edges: from three centimeters, its light is sooner done.
    for (emitter, height, error) in [(SUN, 1e-3, 1e-3), (SUN, 1e-6, 1e-2), (LAMP, 3e-2, 1e-1)] {
        for place in PLACES {
            let scene = cube(emitter, place, height);
            let (image, _) = by_beams(&scene, "camera", error);
            let layer = image
                .layers
                .iter()
                .find(|one| one.name.to_string() == "LTTD");
            let layer = layer.unwrap();
            let probed = probe_at(&scene, FLOOR, place, 2);
            let truth = sum(&of(&probed, "LTTD")) * ALBEDO / std::f64::consts::PI;
            assert!(truth > 1.0, "{place}: {truth}");
            let bounds = layer.interval.as_ref().unwrap();
            let mean = |values: &[nephroid::internals::radiometry::Rgb]| {
                values.iter().map(|one| one.mean()).sum::<f64>() / values.len() as f64
            };
            let (low, high) = (mean(&bounds.low), mean(&bounds.high));
            // The view is even about the probed point: a change over h meters of light that varies over one
            // is h² in the mean.
            // Coordinates of a meter are rounded to 1e-10 of a micrometre's view.
            let room = (height * height).max(1e-6) * truth;
            assert!(
                low - room <= truth && truth <= high + room,
                "{place}: {truth} is not in {low}..{high}"
            );
            // The error that was asked for, of light as even as this.
            let value = mean(&layer.values);
            assert!(
                (value - truth).abs() <= 2.0 * error * truth,
                "{value} {truth}"
            );
        }
    }
}

#[test]
fn a_small_view_costs_no_more_by_pixel_than_a_large_one() {
    // Eight meters up, the camera sees the whole floor.
    let far = cube(SUN, DVec2::ZERO, 8.0);
    let large = by_beams(&far, "camera", 1e-2).0.counters.rays;
    for (place, height) in [(PLACES[0], 1e-3), (PLACES[1], 1e-3), (PLACES[1], 1e-6)] {
        let near = cube(SUN, place, height);
        let small = by_beams(&near, "camera", 1e-2).0.counters.rays;
        println!("{place}, {height}: {small} rays, {large} for all of the floor");
        assert!(
            small <= 4 * large,
            "{place}, {height}: {small} rays, {large} for all"
        );
    }
}
