//! Scenes that no closed form takes: each is refused by the name of what is in the way.

use nephroid::internals::reference::closed_form::{ClosedFormSettings, solve, supports};
use nephroid::internals::run::Progress;
use nephroid::internals::scene::Scene;

use crate::support::oracles::PANE;
use crate::support::recognised::{edited, of_text};
use crate::support::scenes::{bundled, meter};

const SMALL: [u32; 2] = [4, 4];

/// Asserts that a scene is refused in a sentence that holds `words`.
fn assert_refused(scene: &Scene, words: &str) {
    let refused = supports(scene, meter(scene)).unwrap_err();
    assert!(refused.to_string().contains(words), "{refused}");
    let settings = ClosedFormSettings::default();
    assert_eq!(
        solve(scene, meter(scene), settings, &Progress::default()).unwrap_err(),
        refused
    );
}

fn assert_edit_refused(name: &str, text: &str, replacement: &str, words: &str) {
    assert_refused(&edited(name, &[(text, replacement)], SMALL), words);
}

/// The scene with something more before its end.
fn assert_addition_refused(name: &str, addition: &str, words: &str) {
    assert_edit_refused(name, "</scene>", &format!("{addition}</scene>"), words);
}

const BALL_CENTER: &str = r#"<point name="center" x="0" y="0" z="1.4"/>"#;
const LAMP: &str = r#"<point name="position" x="0" y="0" z="4"/>"#;
const FLOOR: &str = r#"<shape type="rectangle" id="floor-surface">"#;

// ---- the sensor -----------------------------------------------------------------------------------

#[test]
fn a_camera() {
    let scene = bundled("glass-ball", 4);
    let camera = scene
        .sensors()
        .iter()
        .find(|sensor| sensor.id == "camera")
        .unwrap();
    let refused = supports(&scene, camera).unwrap_err().to_string();
    assert!(
        refused.contains("sensor \"camera\" is a perspective"),
        "{refused}"
    );
}

#[test]
fn a_receiver_that_is_a_disc() {
    assert_edit_refused(
        "glass-ball",
        FLOOR,
        r#"<shape type="disk" id="floor-surface">"#,
        "measures shape \"floor-surface\" (disk)",
    );
}

#[test]
fn a_receiver_that_is_a_mesh() {
    assert_edit_refused(
        "glass-ball",
        FLOOR,
        r#"<shape type="cube" id="floor-surface">"#,
        "measures shape \"floor-surface\" (cube)",
    );
}

#[test]
fn a_sheared_receiver() {
    assert_edit_refused(
        "glass-ball",
        r#"<scale x="2" y="2"/>"#,
        r#"<rotate z="1" angle="30"/><scale x="2" y="1"/>"#,
        "\"floor-surface\", whose sides are not at a right angle",
    );
}

#[test]
fn a_receiver_that_is_rough_metal() {
    assert_edit_refused(
        "glass-ball",
        r#"<bsdf type="diffuse">
            <rgb name="reflectance" value="0.8, 0.8, 0.8"/>
        </bsdf>"#,
        r#"<bsdf type="roughconductor"/>"#,
        "of material roughconductor",
    );
}

#[test]
fn too_many_events() {
    let scene = bundled("glass-ball", 4);
    let settings = ClosedFormSettings { max_depth: 33 };
    let refused = solve(&scene, meter(&scene), settings, &Progress::default())
        .unwrap_err()
        .to_string();
    assert!(refused.contains("max_depth is 33; 0 to 32"), "{refused}");
}

// ---- the light ------------------------------------------------------------------------------------

#[test]
fn two_emitters() {
    assert_addition_refused(
        "glass-ball",
        r#"<emitter type="directional"><vector name="direction" x="0" y="0" z="-1"/></emitter>"#,
        "emitters 0 (point) and 1 (directional) both shine",
    );
}

#[test]
fn no_emitter() {
    assert_edit_refused(
        "glass-ball",
        "100, 100, 100",
        "0, 0, 0",
        "no emitter shines",
    );
}

#[test]
fn light_from_all_round() {
    assert_edit_refused(
        "coffee-cup",
        r#"<emitter type="directional" id="sun">
        <vector name="direction" x="0.6" y="0" z="-1"/>
        <rgb name="irradiance" value="1000, 1000, 1000"/>"#,
        r#"<emitter type="constant" id="sun"><rgb name="radiance" value="1, 1, 1"/>"#,
        "emitter 0 (constant) shines from all round",
    );
}

#[test]
fn a_disc_that_shines() {
    let text = r#"<scene version="3.0.0">
        <shape type="disk" id="lamp"><transform name="to_world"><rotate x="1" angle="180"/><translate z="1"/></transform>
        <emitter type="area"/></shape>
        <shape type="rectangle"><bsdf type="diffuse"/><sensor type="irradiancemeter">
        <film type="hdrfilm"><rfilter type="box"/></film></sensor></shape></scene>"#;
    assert_refused(
        &of_text(text, SMALL),
        "emitter 0 (area) shines from shape \"lamp\" (disk)",
    );
    let leaning = text
        .replace(r#"type="disk""#, r#"type="rectangle""#)
        .replace(r#"angle="180""#, r#"angle="100""#);
    assert_refused(&of_text(&leaning, SMALL), "emitter 0 (area)");
}

#[test]
fn a_point_below_the_receiver() {
    let text = r#"<scene version="3.0.0">
        <emitter type="point"><point name="position" x="0" y="0" z="-1"/></emitter>
        <shape type="rectangle"><bsdf type="diffuse"/><sensor type="irradiancemeter">
        <film type="hdrfilm"><rfilter type="box"/></film></sensor></shape></scene>"#;
    assert_refused(
        &of_text(text, SMALL),
        "emitter 0 (point) has the height -1 over the receiver",
    );
    let spot = text.replace(
        r#"<emitter type="point"><point name="position" x="0" y="0" z="-1"/>"#,
        r#"<emitter type="spot"><transform name="to_world">
           <lookat origin="0, 0, 1" target="0.1, 0, 0" up="0, 1, 0"/></transform>"#,
    );
    assert_refused(&of_text(&spot, SMALL), "emitter 0 (spot) looks along");
}

// ---- what is in its way -----------------------------------------------------------------------------

#[test]
fn a_second_body() {
    assert_addition_refused(
        "glass-ball",
        r#"<shape type="sphere" id="pearl"><point name="center" x="1.5" y="0" z="0.3"/>
           <float name="radius" value="0.1"/><bsdf type="diffuse"/></shape>"#,
        "shape \"ball\" (sphere) and shape \"pearl\" (sphere) are in the scene",
    );
}

#[test]
fn a_single_flat_mirror() {
    assert_edit_refused(
        "coffee-cup",
        r#"<shape type="cylinder" id="cup">
        <point name="p0" x="0" y="0" z="0"/>
        <point name="p1" x="0" y="0" z="8"/>
        <float name="radius" value="4"/>"#,
        r#"<shape type="disk" id="cup">"#,
        "shape \"cup\" (disk) is a single flat surface",
    );
}

#[test]
fn a_ball_beside_the_axis() {
    assert_edit_refused(
        "glass-ball",
        BALL_CENTER,
        r#"<point name="center" x="1e-9" y="0" z="1.4"/>"#,
        "shape \"ball\" (sphere) has its centre (1e-9, 0e0) off the axis",
    );
    assert_edit_refused(
        "glass-ball",
        r#"<scale x="2" y="2"/>"#,
        r#"<scale x="2" y="2"/><translate y="0.25"/>"#,
        "off the axis",
    );
    assert_edit_refused(
        "glass-ball",
        r#"<scale x="2" y="2"/>"#,
        r#"<scale x="2" y="2"/><rotate x="1" angle="1"/>"#,
        "off the axis",
    );
}

#[test]
fn a_light_beside_a_balls_axis_or_within_it() {
    assert_edit_refused(
        "glass-ball",
        LAMP,
        r#"<point name="position" x="0" y="0.1" z="4"/>"#,
        "emitter 0 (point) is (0e0, 1e-1) off the axis",
    );
    assert_edit_refused(
        "glass-ball",
        LAMP,
        r#"<point name="position" x="0" y="0" z="2"/>"#,
        "emitter 0 (point) has the height 2 over the receiver, the top of shape \"ball\" (sphere)",
    );
    assert_edit_refused(
        "glass-ball",
        r#"<emitter type="point" id="lamp">
        <point name="position" x="0" y="0" z="4"/>
        <rgb name="intensity" value="100, 100, 100"/>"#,
        r#"<emitter type="directional" id="lamp"><vector name="direction" x="0.1" y="0" z="-1"/>"#,
        "with a ball it must be (0, 0, -1)",
    );
}

#[test]
fn a_ball_on_the_floor() {
    assert_edit_refused(
        "glass-ball",
        r#"z="1.4"/>"#,
        r#"z="1"/>"#,
        "shape \"ball\" (sphere) has its centre at the height 1 over the receiver and the radius 1",
    );
}

#[test]
fn a_ball_of_other_stuff() {
    for (material, words) in [
        ("conductor", "has the material conductor"),
        ("roughdielectric", "has the material roughdielectric"),
        ("thindielectric", "has the material thindielectric"),
    ] {
        let glass = r#"<bsdf type="dielectric">"#;
        let changed = format!(r#"<bsdf type="{material}">"#);
        let rest = if material == "conductor" {
            r#"<float name="int_ior" value="1.5"/>
            <float name="ext_ior" value="1.0"/>"#
        } else {
            ""
        };
        let scene = if rest.is_empty() {
            edited("glass-ball", &[(glass, &changed)], SMALL)
        } else {
            edited("glass-ball", &[(glass, &changed), (rest, "")], SMALL)
        };
        assert_refused(&scene, words);
    }
    assert_edit_refused(
        "glass-ball",
        r#"name="ext_ior" value="1.0""#,
        r#"name="ext_ior" value="1.6""#,
        "has the index 0.9375 relative to its surroundings",
    );
    assert_edit_refused(
        "glass-ball",
        r#"<float name="ext_ior" value="1.0"/>"#,
        r#"<texture name="specular_transmittance" type="checkerboard"/>"#,
        "dielectric with a texture",
    );
}

// ---- cups -----------------------------------------------------------------------------------------

#[test]
fn a_cup_of_metal_or_glass() {
    let perfect = r#"<string name="material" value="none"/>"#;
    assert_edit_refused(
        "coffee-cup",
        perfect,
        r#"<string name="material" value="Au"/>"#,
        "shape \"cup\" (cylinder) is a conductor of index eta",
    );
    assert_edit_refused(
        "coffee-cup",
        &format!(
            r#"<bsdf type="conductor">
            {perfect}"#
        ),
        r#"<bsdf type="dielectric">"#,
        "has the material dielectric",
    );
}

#[test]
fn a_cup_that_mirrors_outside() {
    assert_edit_refused(
        "coffee-cup",
        r#"<boolean name="flip_normals" value="true"/>"#,
        "",
        "shape \"cup\" (cylinder) mirrors outside",
    );
}

#[test]
fn a_cup_that_leans_or_hovers() {
    assert_edit_refused(
        "coffee-cup",
        r#"<point name="p1" x="0" y="0" z="8"/>"#,
        r#"<point name="p1" x="0.1" y="0" z="8"/>"#,
        "shape \"cup\" (cylinder) leans",
    );
    assert_edit_refused(
        "coffee-cup",
        r#"<point name="p0" x="0" y="0" z="0"/>"#,
        r#"<point name="p0" x="0" y="0" z="0.5"/>"#,
        "begins at the height 5e-1 over the receiver",
    );
}

#[test]
fn a_cups_light_that_is_aslant_or_low() {
    assert_edit_refused(
        "coffee-cup",
        r#"x="0.6" y="0" z="-1""#,
        r#"x="0.6" y="0.1" z="-1""#,
        "it must be along a side of the receiver",
    );
    assert_edit_refused(
        "mirror-ring",
        r#"x="-1" y="0" z="1""#,
        r#"x="-1" y="0" z="0.5""#,
        "emitter 0 (point) has the height 0.5 over the receiver, the cup's rim 0.6",
    );
    assert_edit_refused(
        "coffee-cup",
        r#"x="0.6" y="0" z="-1""#,
        r#"x="0.6" y="0" z="1""#,
        "emitter 0 (directional) comes from behind the receiver",
    );
}

// ---- solids -----------------------------------------------------------------------------------------

#[test]
fn a_solid_below_a_point() {
    assert_edit_refused(
        "cube",
        r#"<emitter type="directional" id="sun">
        <vector name="direction" x="0.5" y="0.2" z="-1"/>
        <rgb name="irradiance" value="1000, 1000, 1000"/>"#,
        r#"<emitter type="point" id="sun"><point name="position" x="0" y="0" z="4"/>"#,
        "emitter 0 (point) shines on shape \"cube\" (cube)",
    );
}

#[test]
fn a_solid_in_the_floor_or_lit_from_behind_it() {
    assert_edit_refused(
        "cube",
        r#"<translate z="0.75"/>"#,
        r#"<translate z="0.4"/>"#,
        "shape \"cube\" (cube) has a corner at the height",
    );
    assert_edit_refused(
        "cube",
        r#"x="0.5" y="0.2" z="-1""#,
        r#"x="0.5" y="0.2" z="1""#,
        "emitter 0 (directional) comes from behind the receiver",
    );
}

#[test]
fn a_solid_inside_out() {
    assert_edit_refused(
        "cube",
        r#"<shape type="cube" id="cube">"#,
        r#"<shape type="cube" id="cube"><boolean name="flip_normals" value="true"/>"#,
        "shape \"cube\" (cube) has its normals inside",
    );
}

/// A file's mesh of flat facets, with corners and faces given.
fn off_scene(vertices: &[[f64; 3]], faces: &[[u32; 3]]) -> Scene {
    let mut ply = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        vertices.len(),
        faces.len()
    );
    for [x, y, z] in vertices {
        ply += &format!("{x} {y} {z}\n");
    }
    for [a, b, c] in faces {
        ply += &format!("3 {a} {b} {c}\n");
    }
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("prism.ply"), ply).unwrap();
    let file = folder.path().join("prism.xml");
    let text = std::fs::read_to_string(crate::support::bundled_file("prism")).unwrap();
    std::fs::write(&file, text).unwrap();
    Scene::new(
        nephroid::internals::mitsuba::load_parts(&file, &[("size".to_owned(), "4".to_owned())])
            .unwrap(),
    )
    .unwrap()
}

/// A tetrahedron with a dent in one face, and one without one of its faces.
#[test]
fn a_solid_that_is_dented_or_open() {
    let corners = [
        [0.0, 0.0, 0.0],
        [0.1, 0.0, 0.0],
        [0.0, 0.1, 0.0],
        [0.0, 0.0, 0.1],
        [0.02, 0.02, 0.02],
    ];
    let rest = [[0, 2, 1], [0, 1, 3], [0, 3, 2]];
    let dented = [rest[0], rest[1], rest[2], [1, 2, 4], [2, 3, 4], [3, 1, 4]];
    assert_refused(
        &off_scene(&corners, &dented),
        "shape \"prism\" (ply) is not convex",
    );
    assert_refused(
        &off_scene(&corners[..4], &rest),
        "shape \"prism\" (ply) is no single closed surface",
    );
}

// ---- panes ------------------------------------------------------------------------------------------

fn assert_pane_refused(text: &str, replacement: &str, words: &str) {
    assert!(PANE.contains(text));
    assert_refused(&of_text(&PANE.replacen(text, replacement, 1), SMALL), words);
}

#[test]
fn panes_that_are_narrow_slanted_or_of_two_kinds() {
    let face = r#"<translate z="1.05"/>"#;
    assert_pane_refused(
        face,
        r#"<scale value="0.6"/><translate z="1.05"/>"#,
        "must reach farther than the receiver",
    );
    assert_pane_refused(
        face,
        r#"<rotate x="1" angle="2"/><translate z="1.05"/>"#,
        "is not parallel to the receiver",
    );
    assert_pane_refused(
        face,
        r#"<rotate x="1" angle="180"/><translate z="1.05"/>"#,
        "face the same way",
    );
    assert_pane_refused(
        r#"<translate z="1.05"/></transform>
        <ref id="glass"/>"#,
        r#"<translate z="1.05"/></transform>
        <bsdf type="dielectric"/>"#,
        "are of different glass",
    );
    assert_pane_refused(
        r#"x="0" y="0" z="2""#,
        r#"x="0.1" y="0" z="2""#,
        "emitter 0 (point) shines on a pane",
    );
    assert_pane_refused(
        r#"x="0" y="0" z="2""#,
        r#"x="0" y="0" z="1""#,
        "emitter 0 (point) is not above",
    );
}
