//! Scenes made from the shipped ones, moved, turned, resized, and coloured, and scenes of other kinds: each
//! solved, and within the bounds of beams on every texel.

use glam::DVec3;
use nephroid::internals::scene::Scene;

use crate::support::oracles::PANE;
use crate::support::recognised::{assert_agrees, edited, known, layer_of, of_text};

const SQUARE: [u32; 2] = [32, 32];

/// Columns and rows that differ, and no multiple of each other.
const OBLONG: [u32; 2] = [40, 24];

const DEPTH: u32 = 6;

#[test]
fn a_ball_of_other_size_height_index_and_light() {
    let scene = edited(
        "glass-ball",
        &[
            (r#"z="1.4""#, r#"z="1.1""#),
            (r#"name="radius" value="1""#, r#"name="radius" value="0.7""#),
            (r#"value="1.5""#, r#"value="1.8""#),
            (r#"z="4""#, r#"z="2.9""#),
            ("100, 100, 100", "30, 60, 90"),
        ],
        OBLONG,
    );
    assert_agrees("another ball", &scene, DEPTH, 600);
}

/// The receiver is no square and turned about its normal; the whole scene lies on its side.
#[test]
fn a_ball_beside_a_turned_oblong_wall() {
    let scene = edited(
        "glass-ball",
        &[
            (r#"x="0" y="0" z="4""#, r#"x="5" y="2" z="1""#),
            (r#"x="0" y="0" z="1.4""#, r#"x="2.4" y="2" z="1""#),
            (
                r#"<scale x="2" y="2"/>"#,
                r#"<scale x="1.5" y="0.8"/><rotate z="1" angle="33"/><rotate y="1" angle="90"/><translate x="1" y="2" z="1"/>"#,
            ),
        ],
        OBLONG,
    );
    assert_agrees("a wall", &scene, DEPTH, 600);
}

/// Glass whose reflections are yellowish and whose transmissions are bluish.
#[test]
fn a_ball_of_tinted_glass_in_parallel_light() {
    let scene = edited(
        "glass-ball",
        &[
            (
                r#"<float name="ext_ior" value="1.0"/>"#,
                r#"<float name="ext_ior" value="1.1"/>
                   <rgb name="specular_reflectance" value="0.9, 0.8, 0.5"/>
                   <rgb name="specular_transmittance" value="0.7, 0.8, 0.95"/>"#,
            ),
            (
                r#"type="point" id="lamp""#,
                r#"type="directional" id="lamp""#,
            ),
            (
                r#"<point name="position" x="0" y="0" z="4"/>"#,
                r#"<vector name="direction" x="0" y="0" z="-1"/>"#,
            ),
            (r#"name="intensity""#, r#"name="irradiance""#),
        ],
        SQUARE,
    );
    assert_agrees("tinted", &scene, DEPTH, 600);
}

/// Light along y, on a receiver whose v runs along the world's −x and whose middle is off the cup's axis.
fn turned_cup(size: [u32; 2]) -> Scene {
    edited(
        "coffee-cup",
        &[
            (r#"x="0.6" y="0" z="-1""#, r#"x="0" y="0.7" z="-1""#),
            (r#"z="8"/>"#, r#"z="6"/>"#),
            (
                r#"<scale x="4" y="4"/>"#,
                r#"<scale x="4.5" y="3"/><rotate z="1" angle="90"/><translate x="0.7" y="0.4"/>"#,
            ),
            (
                r#"<string name="material" value="none"/>"#,
                r#"<string name="material" value="none"/><rgb name="specular_reflectance" value="0.9, 0.8, 0.7"/>"#,
            ),
        ],
        size,
    )
}

#[test]
fn a_cup_on_a_turned_receiver() {
    assert_agrees("a turned cup", &turned_cup(OBLONG), DEPTH, 300);
}

/// Photons measure light of many reflections in the place of beams: part of it begins where their pilot saw
/// none begin, and what they may miss there is in the bounds.
#[test]
fn a_cup_whose_faintest_light_is_measured_by_photons() {
    let (_, beams) = assert_agrees("by photons", &turned_cup([48, 32]), 12, 600);
    let noisy = beams.layers.iter().filter(|layer| {
        let mut errors = layer.standard_error.iter();
        errors.any(|error| !error.is_black())
    });
    assert!(noisy.count() > 0, "photons measured nothing");
}

/// Light that travels along −x: the receiver's x is turned by two right angles.
#[test]
fn a_cup_in_light_from_the_other_side() {
    let scene = edited(
        "coffee-cup",
        &[(r#"x="0.6" y="0" z="-1""#, r#"x="-0.8" y="0" z="-1""#)],
        OBLONG,
    );
    assert_agrees("from the other side", &scene, DEPTH, 300);
}

/// A point inside the circle, seen from above, on its −y side.
#[test]
fn a_ring_below_a_point_within_it() {
    let scene = edited(
        "mirror-ring",
        &[(r#"x="-1" y="0" z="1""#, r#"x="0" y="-0.4" z="1.3""#)],
        OBLONG,
    );
    assert_agrees("a point within", &scene, DEPTH, 150);
}

/// Outside of it, on its +y side, over a receiver that is mirrored and oblong.
#[test]
fn a_ring_below_a_point_beside_it() {
    let scene = edited(
        "mirror-ring",
        &[
            (r#"x="-1" y="0" z="1""#, r#"x="0" y="1.5" z="1.3""#),
            (r#"<scale x="2" y="2"/>"#, r#"<scale x="2" y="-1.6"/>"#),
        ],
        OBLONG,
    );
    assert_agrees("a point beside", &scene, DEPTH, 300);
}

/// The receiver is turned by 25°, mirrored (v runs against the normal's left hand), oblong, and off the
/// middle.
#[test]
fn a_cube_over_a_turned_and_mirrored_receiver() {
    let scene = edited(
        "cube",
        &[(
            r#"<scale x="2" y="2"/>"#,
            r#"<scale x="2" y="-1.4"/><rotate z="1" angle="25"/><translate x="0.3" y="0.2"/>"#,
        )],
        OBLONG,
    );
    assert_agrees("a mirrored receiver", &scene, DEPTH, 300);
}

/// A cropped film is that part of the whole.
#[test]
fn a_cropped_film_is_a_part_of_the_whole() {
    let whole = edited("cube", &[], OBLONG);
    let mut text = std::fs::read_to_string(crate::support::bundled_file("cube")).unwrap();
    text = text.replacen(
        r#"<integer name="height" value="$size"/>"#,
        r#"<integer name="height" value="$size"/>
           <integer name="crop_offset_x" value="7"/><integer name="crop_offset_y" value="5"/>
           <integer name="crop_width" value="11"/><integer name="crop_height" value="9"/>"#,
        1,
    );
    text = text.replacen(
        r#"name="width" value="$size""#,
        r#"name="width" value="40""#,
        1,
    );
    text = text.replacen(
        r#"name="height" value="$size""#,
        r#"name="height" value="24""#,
        1,
    );
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("scene.xml");
    std::fs::write(&file, text).unwrap();
    let scene = nephroid::internals::scene::Scene::new(
        nephroid::internals::mitsuba::load_parts(&file, &[]).unwrap(),
    )
    .unwrap();
    let (part, whole) = (known(&scene, 4), known(&whole, 4));
    assert_eq!([part.width, part.height], [11, 9]);
    for layer in &part.layers {
        let nephroid::internals::run::LayerName::Path(signature) = layer.name else {
            unreachable!("one path each");
        };
        let of_whole = layer_of(&whole, signature).unwrap();
        for texel in 0..99 {
            let at = (texel / 11 + 5) * 40 + texel % 11 + 7;
            let off = layer.values[texel].0[0] - of_whole.values[at].0[0];
            // Borders of texels differ by roundings: 1e-15 of the receiver, 1e-13 of a texel, times the sun's
            // 1000 W/m².
            assert!(off.abs() < 1e-9, "{signature} {texel}: {off:e}");
        }
    }
}

#[test]
fn a_pane_below_a_point_and_in_parallel_light() {
    assert_agrees("a pane", &of_text(PANE, SQUARE), DEPTH, 1000);
    let parallel = PANE
        .replace(r#"type="point""#, r#"type="directional""#)
        .replace(
            r#"<point name="position" x="0" y="0" z="2"/>"#,
            r#"<vector name="direction" x="0" y="0" z="-1"/>"#,
        )
        .replace("intensity", "irradiance");
    assert_agrees(
        "a pane in the sun",
        &of_text(&parallel, SQUARE),
        DEPTH,
        1000,
    );
}

fn over_floor(light: &str) -> nephroid::internals::scene::Scene {
    of_text(
        &format!(
            r#"<scene version="3.0.0">{light}
            <shape type="rectangle" id="floor">
                <transform name="to_world"><scale x="1" y="0.6"/></transform>
                <bsdf type="diffuse"/>
                <sensor type="irradiancemeter"><film type="hdrfilm"><rfilter type="box"/></film></sensor>
            </shape></scene>"#
        ),
        OBLONG,
    )
}

/// Nothing is in the way: direct light alone, within what the quadrature of direct light and the formula
/// claim.
#[test]
fn lights_alone_with_the_receiver() {
    for (name, light) in [
        (
            "point",
            r#"<emitter type="point"><point name="position" x="0.4" y="-1.2" z="0.8"/>
               <rgb name="intensity" value="1, 2, 3"/></emitter>"#,
        ),
        (
            "directional",
            r#"<emitter type="directional"><vector name="direction" x="0.4" y="0.2" z="-0.8"/>
               <rgb name="irradiance" value="1, 2, 3"/></emitter>"#,
        ),
        (
            "spot",
            r#"<emitter type="spot"><transform name="to_world">
               <lookat origin="0, 0, 1.5" target="0, 0, 0" up="0, 1, 0"/></transform>
               <float name="cutoff_angle" value="30"/><float name="beam_width" value="18"/>
               <rgb name="intensity" value="1, 2, 3"/></emitter>"#,
        ),
    ] {
        let scene = over_floor(light);
        let (known, _) = assert_agrees(name, &scene, 2, 0);
        assert_eq!(known.layers.len(), 1);
        assert!(known.total.range().max > 0.1, "{name}");
    }
}

/// Light from a leaning rectangle, beside the sum over the cells of it and of each texel.
///
/// The midpoint rule errs by h²/24 times the second derivative, some 6/r² of the value on each of four axes:
/// cells of 0.015 m and 0.0125 m at r = 1.2 m and more make 2e-4 of it at most.
#[test]
fn a_leaning_rectangles_light_is_the_sum_over_its_cells() {
    let scene = over_floor(
        r#"<shape type="rectangle"><transform name="to_world"><scale x="0.3" y="0.2"/>
           <rotate x="1" angle="160"/><translate x="0.3" y="-0.4" z="1.4"/></transform>
           <emitter type="area"><rgb name="radiance" value="1, 2, 3"/></emitter></shape>"#,
    );
    let known = known(&scene, 2);
    assert_eq!(known.layers.len(), 1);
    let (sin, cos) = 160.0_f64.to_radians().sin_cos();
    let normal = DVec3::new(0.0, -sin, cos);
    let middles =
        |cells: u32| (0..cells).map(move |i| (2.0 * f64::from(i) + 1.0) / f64::from(cells) - 1.0);
    let (columns, rows) = (f64::from(OBLONG[0]), f64::from(OBLONG[1]));
    for (texel, value) in known.layers[0].values.iter().enumerate() {
        let column = (texel % OBLONG[0] as usize) as f64;
        let row = (texel / OBLONG[0] as usize) as f64;
        let mut sum = 0.0;
        for (u, v) in middles(4).flat_map(|u| middles(4).map(move |v| (u, v))) {
            let point = DVec3::new(
                (2.0 * column + 1.0 + u) / columns - 1.0,
                0.6 * ((2.0 * row + 1.0 + v) / rows - 1.0),
                0.0,
            );
            for (x, y) in middles(40).flat_map(|x| middles(40).map(move |y| (x, y))) {
                let on_lamp = DVec3::new(0.3 * x + 0.3, 0.2 * y * cos - 0.4, 0.2 * y * sin + 1.4);
                let offset = point - on_lamp;
                let squared = offset.length_squared();
                sum += -offset.z * offset.dot(normal).max(0.0) / (squared * squared);
            }
        }
        let exact = sum / 16.0 / 1600.0 * (0.6 * 0.4);
        for (channel, radiance) in [1.0, 2.0, 3.0].into_iter().enumerate() {
            let off = value.0[channel] / (radiance * exact) - 1.0;
            assert!(off.abs() < 2e-4, "{texel}: {off:e}");
        }
    }
}
