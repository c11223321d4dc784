//! The shipped scenes: solved as they are, and within the bounds of beams on every texel.

use glam::DVec3;
use nephroid::internals::mitsuba::{load, load_parts};
use nephroid::internals::radiometry::Rgb;
use nephroid::internals::reference::closed_form::{Bundled, ClosedFormSettings, solve, supports};
use nephroid::internals::run::{Estimate, LayerName, Progress, Quantity};
use nephroid::internals::scene::{Crop, Emitter, Scene};
use nephroid::internals::transport::signature::Signature;

use crate::support::recognised::{assert_agrees, both, changed, compared, layer_of};
use crate::support::scenes::{bundled, bundled_file, meter};

const SIDE: usize = 32;

/// Specular events followed.
const DEPTH: u32 = 8;

#[test]
fn the_glass_balls_every_texel_is_within_the_beams_bounds() {
    assert_agrees("glass-ball", &bundled("glass-ball", SIDE), DEPTH, 600);
}

#[test]
fn the_coffee_cups_every_texel_is_within_the_beams_bounds() {
    assert_agrees("coffee-cup", &bundled("coffee-cup", SIDE), DEPTH, 400);
}

#[test]
fn the_mirror_rings_every_texel_is_within_the_beams_bounds() {
    assert_agrees("mirror-ring", &bundled("mirror-ring", SIDE), DEPTH, 350);
}

/// Right below its lamp the ring shades a sliver 3y²/10R wide, between its foot and the shadow of its rim: 7 % of
/// some texels of 512 x 512, but 4e-4 of the widest of 4096 x 4096. What no point sees must be in the bounds.
#[test]
fn the_sliver_below_a_rings_lamp_is_within_bounds_however_narrow() {
    const CROP: u32 = 8;
    for size in [512, 1024, 4096] {
        let mut parts = load_parts(&bundled_file("mirror-ring"), &[]).unwrap();
        for sensor in &mut parts.sensors {
            (sensor.film.width, sensor.film.height) = (size, size);
            sensor.film.crop = Crop {
                offset_x: size / 4 - CROP / 2,
                offset_y: size / 2 - CROP / 2,
                width: CROP,
                height: CROP,
            };
        }
        let (known, beams) = both(&Scene::new(parts).unwrap(), 1);
        let [mine, theirs] = [&known, &beams].map(|it| {
            let direct = layer_of(it, Signature::DIRECT).unwrap();
            direct.interval.clone().unwrap()
        });
        let brightest = mine.high.iter().map(|value| value.0[0]).fold(0.0, f64::max);
        for texel in 0..mine.low.len() {
            let apart = (theirs.low[texel].0[0] - mine.high[texel].0[0])
                .max(mine.low[texel].0[0] - theirs.high[texel].0[0]);
            // Bisection finds each edge to 2⁻¹⁴ of a cell of 1/8, and rounding moves both shadows by 1e-16 of
            // a meter or two, 1e-12 of a texel.
            assert!(
                apart < 2e-5 * brightest,
                "{size} {texel}: {:e}",
                apart / brightest
            );
            let width = theirs.high[texel].0[0] - theirs.low[texel].0[0];
            // 64 cells of 1/64 along the sliver's two lines, and those beside them.
            assert!(width < 4.0 / 64.0 * brightest, "{size} {texel}: {width}");
        }
    }
}

#[test]
fn the_prisms_every_texel_is_within_the_beams_bounds() {
    assert_agrees("prism", &bundled("prism", SIDE), DEPTH, 300);
}

#[test]
fn the_cubes_every_texel_is_within_the_beams_bounds() {
    assert_agrees("cube", &bundled("cube", SIDE), DEPTH, 300);
}

#[test]
fn the_diamonds_every_texel_is_within_the_beams_bounds() {
    assert_agrees("diamond", &bundled("diamond", SIDE), DEPTH, 1000);
}

#[test]
fn the_turned_cubes_every_texel_is_within_the_beams_bounds() {
    assert_agrees(
        "turntable-cube",
        &bundled("turntable-cube", SIDE),
        DEPTH,
        300,
    );
}

#[test]
fn the_lying_prisms_every_texel_is_within_the_beams_bounds() {
    assert_agrees(
        "turntable-prism",
        &bundled("turntable-prism", SIDE),
        DEPTH,
        300,
    );
}

/// The closed forms by number and those that the files are recognised as have the same texels. Meshes are
/// files of `f32`, so edges of polygons are up to 1e-7 of the body from where the numbers put them.
#[test]
fn solids_of_flat_facets_are_those_that_their_files_hold() {
    let known = Bundled::all(2);
    for name in [
        "prism",
        "cube",
        "diamond",
        "turntable-cube",
        "turntable-prism",
    ] {
        let numbers = known.iter().find(|it| it.scene == name).unwrap();
        let scene = bundled(name, SIDE);
        let settings = ClosedFormSettings { max_depth: 4 };
        let file = solve(&scene, meter(&scene), settings, &Progress::default()).unwrap();
        let sun = scene.emitters()[0].strength().0[0];
        let mut seen = 0;
        for &path in &numbers.paths {
            let signature = path.signature();
            let layer = file
                .layers
                .iter()
                .find(|it| it.name.to_string() == signature);
            let map = numbers.map(path, SIDE, 0);
            for (texel, value) in map.iter().enumerate() {
                let found = layer.map_or(0.0, |layer| layer.values[texel].0[0]);
                assert!(
                    (value - found).abs() < 1e-5 * sun,
                    "{name} {signature} {texel}: {value} {found}"
                );
            }
            seen += u32::from(layer.is_some());
        }
        assert!(seen >= 3, "{name}: {seen}");
    }
}

/// With the sun in the zenith the ball of the turntable is on the axis of its light.
#[test]
fn under_the_zenith_the_turntables_ball_is_known() {
    let side = SIDE.to_string();
    let parameters = [("size", side.as_str()), ("elevation", "90")]
        .map(|(name, value)| (name.to_owned(), value.to_owned()));
    let scene = load(&bundled_file("turntable-ball"), &parameters).unwrap();
    assert_agrees("turntable-ball", &scene, DEPTH, 600);
}

/// The sun travels along −(cos el cos az, cos el sin az, sin el).
#[test]
fn the_turntables_sun_stands_where_its_angles_say() {
    for (azimuth, elevation) in [(30.0_f64, 60.0_f64), (-75.0, 12.0), (300.0, 90.0)] {
        let parameters = [("azimuth", azimuth), ("elevation", elevation)]
            .map(|(name, value)| (name.to_owned(), value.to_string()));
        let scene = load(&bundled_file("turntable-ring"), &parameters).unwrap();
        let Emitter::Directional { direction, .. } = &scene.emitters()[0] else {
            panic!("no sun");
        };
        let (sin, cos) = elevation.to_radians().sin_cos();
        let (side, ahead) = azimuth.to_radians().sin_cos();
        let expected = -DVec3::new(cos * ahead, cos * side, sin);
        assert!(direction.distance(expected) < 1e-15, "{direction}");
    }
}

/// A map with rows and columns exchanged, and one of half the light, must be caught: on the cube, which is
/// the same in no such way.
#[test]
fn exchanged_axes_and_half_the_light_are_caught() {
    let (known, beams) = both(&bundled("cube", SIDE), 4);
    assert_eq!(compared(&known, &beams).apart, 0);
    let exchanged = changed(&known, |map: &[Rgb]| {
        (0..SIDE * SIDE)
            .map(|texel| map[texel % SIDE * SIDE + texel / SIDE])
            .collect()
    });
    assert!(compared(&exchanged, &beams).apart > 100);
    let reversed = changed(&known, |map: &[Rgb]| {
        map.chunks(SIDE).rev().flatten().copied().collect()
    });
    assert!(compared(&reversed, &beams).apart > 100);
    let halved = changed(&known, |map: &[Rgb]| {
        map.iter().map(|value| *value * 0.5).collect()
    });
    assert!(compared(&halved, &beams).apart > 100);
}

/// Direct light first, then paths in order, none dark; the sum is theirs; nothing is traced.
#[test]
fn an_estimate_holds_what_every_estimate_holds() {
    let scene = bundled("glass-ball", SIDE);
    let estimate = solve(
        &scene,
        meter(&scene),
        ClosedFormSettings::default(),
        &Progress::default(),
    )
    .unwrap();
    assert_eq!(estimate.quantity, Quantity::Irradiance);
    assert_eq!([estimate.width, estimate.height], [SIDE, SIDE]);
    assert_eq!(estimate.layers[0].name.to_string(), "LD");
    assert_eq!(estimate.layers[1].name.to_string(), "LRD");
    assert_eq!(estimate.layers[2].name.to_string(), "LTTD");
    // One reflection inside sends all light upward or beyond this floor.
    let names: Vec<String> = estimate
        .layers
        .iter()
        .map(|layer| layer.name.to_string())
        .collect();
    assert!(!names.contains(&"LTRTD".to_owned()), "{names:?}");
    assert_eq!(estimate.paths, 0);
    assert_eq!(estimate.counts, vec![0; SIDE * SIDE]);
    assert!(!estimate.incomplete);
    assert_eq!(estimate.total.name, LayerName::Total);
    for texel in 0..SIDE * SIDE {
        let sum: f64 = estimate
            .layers
            .iter()
            .map(|layer| layer.values[texel].0[1])
            .sum();
        let total = estimate.total.values[texel].0[1];
        // Up to 18 sums, each rounded.
        assert!((sum - total).abs() <= 20.0 * f64::EPSILON * total);
        let bounds = estimate.total.interval.as_ref().unwrap();
        assert!(bounds.low[texel].0[1] <= total && total <= bounds.high[texel].0[1]);
    }
    assert_accuracy(&estimate, 1e-8);
}

/// Largest relative errors that are claimed on small films.
///
/// - The ball's are 1e-10 of a texel, and 4e-12 of circles that cross some 30 texels.
/// - The cups' are 1e-7 of their light without mirrors, of which the reflected is a third.
/// - Polygons' are 1e-9 of the sun in each of five layers, whose lit texels have some thirtieth of it.
#[test]
fn the_claimed_errors_are_small() {
    for (name, most) in [
        ("glass-ball", 1e-8),
        ("coffee-cup", 1e-6),
        ("mirror-ring", 1e-6),
        ("prism", 1e-6),
        ("cube", 1e-6),
    ] {
        let scene = bundled(name, SIDE);
        let settings = ClosedFormSettings { max_depth: 6 };
        assert_accuracy(
            &solve(&scene, meter(&scene), settings, &Progress::default()).unwrap(),
            most,
        );
    }
}

fn assert_accuracy(estimate: &Estimate, most: f64) {
    let error = estimate.relative_error.unwrap();
    assert!(error > 0.0 && error < most, "{error:e}");
}

#[test]
fn the_other_shipped_scenes_are_refused_each_with_its_reason() {
    for (name, reason) in [
        (
            "glass-ball-mesh",
            "shape \"ball\" (ply) has interpolated normals",
        ),
        ("lens", "shape \"lens\" (ply) has interpolated normals"),
        ("water", "shape \"surface\" (ply) has interpolated normals"),
        (
            "pool",
            "shape \"wall-surface\" (rectangle) and shape \"wall-low-x\" (rectangle) and 5 more shapes are in the scene",
        ),
        (
            "parabolic-mirror",
            "shape \"dish\" (ply) has interpolated normals",
        ),
        ("rainbow", "in the scene"),
        (
            "glass-ball-behind-pane",
            "shape \"ball\" (sphere) and shape \"pane\" (rectangle) are in the scene",
        ),
        (
            "cornell-glass",
            "emitter 0 (area) shines from a surface, and there is shape \"ceiling\" (rectangle) beside it",
        ),
        (
            "cornell-caustics",
            "shape \"left-surface\" (rectangle) and shape \"right-surface\" (rectangle) and 3 more shapes are in the scene",
        ),
        (
            "turntable-ball",
            "in the receiver's coordinates: with a ball it must be (0, 0, -1)",
        ),
        (
            "turntable-ring",
            "shape \"object\" (ply) has interpolated normals",
        ),
        (
            "turntable-bumpy",
            "shape \"object\" (ply) has interpolated normals",
        ),
        ("turntable-terrain", "shape \"terrain\" (ply)"),
    ] {
        let scene = bundled(name, 4);
        let refused = supports(&scene, meter(&scene)).unwrap_err().to_string();
        assert!(refused.contains(reason), "{name}: {refused}");
    }
}
