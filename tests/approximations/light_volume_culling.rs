//! Light volumes: what culling and clamping leave out, and what a stencil buffer takes to be in a beam.

use glam::{DVec2, DVec3};
use nephroid::internals::generate::Wave;
use nephroid::internals::scene::Scene;

use crate::support::light_volume::{
    FLAT, SUN, WATER, count, flat_pool, flat_water, floor, run_on, scene_of, sea, volume,
};
use crate::support::scenes::bundled_file;

/// Numbers that look random, in 0..1: the additive sequence of the golden ratio.
fn noise(index: u32) -> f64 {
    (f64::from(index) * 0.618_033_988_749_894_9 + 0.137).fract()
}

/// A sea like no other: its waves and its sun.
fn random_sea(index: u32) -> Scene {
    let waves: Vec<Wave> = (0..4)
        .map(|wave| {
            let of = |what: u32| noise(97 * index + 7 * wave + what);
            let length = 3.0 + 15.0 * of(0);
            let angle = std::f64::consts::TAU * of(1);
            Wave {
                amplitude: 0.3 * of(2) / length,
                wave: DVec2::from_angle(angle) * length,
                phase: std::f64::consts::TAU * of(3),
            }
        })
        .collect();
    sea(&waves, 24, 70.0 * noise(index), 16)
}

#[test]
fn padded_hulls_lose_no_beam_of_a_hundred_seas() {
    for index in 0..100 {
        let scene = random_sea(index);
        let run = |clamp| {
            let settings = [
                ("clamp", clamp),
                ("accumulate", "exact"),
                ("splits", "2"),
                ("shadow-cull", "exact"),
            ];
            run_on(&volume(&settings), &scene, "meter")
        };
        let (nodes, beams, all) = (run("hierarchy"), run("beams"), run("exact"));
        assert_eq!(count(&nodes, "clamp", "escapes"), 0, "sea {index}");
        let bits = |rendering: &nephroid::internals::run::Rendering| {
            let values = rendering.estimate.total.values.iter();
            values
                .map(|value| value.0.map(f64::to_bits))
                .collect::<Vec<_>>()
        };
        assert!(
            bits(&nodes) == bits(&all) && bits(&beams) == bits(&all),
            "sea {index}"
        );
        assert!(
            count(&nodes, "clamp", "draws") <= count(&all, "clamp", "draws"),
            "sea {index}"
        );
    }
}

#[test]
fn the_papers_hulls_lose_crests_and_overhanging_triangles_and_say_so() {
    let scene = random_sea(3);
    let rendering = run_on(
        &volume(&[("hull", "paper"), ("splits", "2")]),
        &scene,
        "meter",
    );
    assert!(count(&rendering, "clamp", "escapes") > 0);
}

/// A camera under flat water, below all beams' starts, that looks down on the floor.
fn camera(more: &str) -> Scene {
    let xml = crate::support::light_volume::pool(20.0, &format!("{FLAT}{WATER}</shape>{more}"), 2);
    let sensor = r#"<sensor type="perspective" id="camera"><float name="fov" value="60"/>
        <transform name="to_world"><lookat origin="0.1, -0.7, 0.5" target="0, 0.1, 0" up="0, 0, 1"/></transform>
        <film type="hdrfilm"><integer name="width" value="60"/><integer name="height" value="44"/>
        <rfilter type="box"/></film></sensor></scene>"#;
    scene_of(&xml.replace("</scene>", sensor))
}

#[test]
fn a_stencil_buffer_finds_each_pixel_of_flat_water_in_one_beam() {
    // One slice of 16 at the floor is drawn, a sixteenth of the depth; the eye is above it.
    let scene = camera("");
    let (above, below, share) = flat_water(20.0);
    // A diffuse floor of 0.5 sends E/2π.
    let expected = SUN * above * share * below * 0.5 * std::f64::consts::FRAC_1_PI;
    let run = |inside| {
        let settings = [("inside", inside), ("accumulate", "exact"), ("grid", "61")];
        run_on(&volume(&settings), &scene, "camera")
    };
    for inside in ["exact", "stencil"] {
        let rendering = run(inside);
        let lit: Vec<f64> = rendering
            .estimate
            .total
            .values
            .iter()
            .map(|it| it.mean())
            .filter(|it| *it > 0.0)
            .collect();
        assert!(lit.len() > 1000, "{}", lit.len());
        // Homogeneous coordinates lose three digits more than planes.
        let off = lit
            .iter()
            .filter(|value| (*value / expected - 1.0).abs() > 1e-9)
            .count();
        assert_eq!(off, 0, "{inside}: {off} of {}", lit.len());
    }
    let fragments = |inside| count(&run(inside), "inside", "fragments");
    assert!(fragments("stencil") > 0 && fragments("exact") > 0);
}

#[test]
fn an_eye_above_sees_each_pixel_in_one_beam_only_with_both_caps() {
    // The floor lies a hair above the lowest plane: what is under it is behind the floor, and its cap must
    // not count; what is over it, the first plane's cap, must. Objects between need both.
    let ball = r#"<shape type="sphere"><point name="center" x="0" y="0.2" z="0.4"/>
        <float name="radius" value="0.3"/><bsdf type="diffuse"/></shape>"#;
    let scene = camera(ball);
    let run = |inside| {
        let settings = [
            ("inside", inside),
            ("accumulate", "exact"),
            ("grid", "61"),
            ("cosine", "vector"),
        ];
        run_on(&volume(&settings), &scene, "camera")
            .estimate
            .total
            .values
    };
    let (exact, stencil) = (run("exact"), run("stencil"));
    // Vectors of flat water are all the same: pixels differ if they are in more or fewer beams.
    let differ = exact
        .iter()
        .zip(&stencil)
        .filter(|(a, b)| (a.mean() - b.mean()).abs() > 1e-9 * SUN);
    let differ = differ.count();
    // The eye is in a beam that reaches from the ball's box to the floor, or it is not: few pixels at most.
    assert!(differ * 200 < exact.len(), "{differ} of {}", exact.len());
}

#[test]
fn a_stencil_buffer_finds_each_pixel_of_a_sea_in_as_many_beams_as_hold_it() {
    // A sea's faces are not plane: both diagonals differ. With one light everywhere, sums count beams.
    let given = [("width", "96"), ("height", "72")];
    let given = given.map(|(key, value)| (key.into(), value.to_owned()));
    let pool = nephroid::internals::mitsuba::load(&bundled_file("pool"), &given).unwrap();
    let run = |inside, slices| {
        let settings = [
            ("inside", inside),
            ("grid", "60"),
            ("slices", slices),
            ("accumulate", "f32"),
        ];
        run_on(&volume(&settings), &pool, "view-25")
            .estimate
            .total
            .values
    };
    let (exact, stencil) = (run("exact", "64"), run("stencil", "64"));
    // A pixel in a beam more or less differs by a third of flat water's light or so, where beams spread, and
    // by more where they meet. Values of faces differ from those of points by less than a tenth in thin
    // slices.
    let is_off = |(a, b): &(
        &nephroid::internals::radiometry::Rgb,
        &nephroid::internals::radiometry::Rgb,
    )| { (a.mean() - b.mean()).abs() > 0.2 * a.mean().max(b.mean()) };
    let off = exact.iter().zip(&stencil).filter(is_off).count();
    assert!(off * 100 < exact.len(), "{off} of {}", exact.len());
    // Between two planes only, faces are far from plane: if beams cut the face between them along different
    // diagonals, pixels are in none. Sides of the light on the floor may be seen by either alone.
    let (exact, stencil) = (run("exact", "1"), run("stencil", "1"));
    let is_crack = |(a, b): &(
        &nephroid::internals::radiometry::Rgb,
        &nephroid::internals::radiometry::Rgb,
    )| a.mean() > 0.0 && b.is_black();
    let cracks = exact.iter().zip(&stencil).filter(is_crack).count();
    assert!(cracks * 1000 < exact.len(), "{cracks} of {}", exact.len());
}

#[test]
fn with_the_eye_in_a_beam_faces_before_surfaces_do_not_tell_and_faces_behind_do() {
    // All planes are drawn: the eye is in a beam. Before surfaces all pixels beyond it count one face too
    // few.
    let scene = camera("");
    let run = |inside, test| {
        let settings = [
            ("inside", inside),
            ("depth-test", test),
            ("accumulate", "exact"),
            ("clamp", "exact"),
            ("grid", "7"),
        ];
        run_on(&volume(&settings), &scene, "camera")
            .estimate
            .total
            .values
    };
    let exact = run("exact", "fail");
    let off = |test| {
        let values = run("stencil", test);
        let pairs = exact.iter().zip(&values);
        pairs
            .filter(|(a, b)| (a.mean() - b.mean()).abs() > 1e-9 * SUN)
            .count()
    };
    assert_eq!(off("fail"), 0);
    assert!(off("pass") > exact.len() / 2, "{}", off("pass"));
}

#[test]
fn beams_out_of_view_are_not_drawn_and_no_pixel_changes() {
    let given = [("width", "64"), ("height", "48")];
    let given = given.map(|(key, value)| (key.into(), value.to_owned()));
    let pool = nephroid::internals::mitsuba::load(&bundled_file("pool"), &given).unwrap();
    // As the scene's file says, measured by a program of its own.
    for (view, seen) in [
        ("view-50", 0.50),
        ("view-35", 0.35),
        ("view-100", 1.0),
        ("view-25", 0.25),
    ] {
        let run = |clamp| {
            let settings = [
                ("clamp", clamp),
                ("inside", "exact"),
                ("accumulate", "exact"),
            ];
            run_on(&volume(&settings), &pool, view)
        };
        let (nodes, beams, all) = (run("hierarchy"), run("beams"), run("exact"));
        assert!(
            nodes.estimate.total.values == all.estimate.total.values,
            "{view}"
        );
        assert!(
            beams.estimate.total.values == all.estimate.total.values,
            "{view}"
        );
        let culled = count(&beams, "clamp", "culled") as f64 / 28_322.0;
        assert!((1.0 - culled - seen).abs() < 0.02, "{view}: {culled}");
        assert!(
            count(&nodes, "clamp", "tests") * 2 < count(&beams, "clamp", "tests"),
            "{view}"
        );
        assert!(count(&all, "clamp", "tests") == 0 && count(&all, "clamp", "culled") == 0);
    }
}

/// A screen above the part of the water with x < `edge`.
fn screen(edge: f64) -> String {
    format!(
        r#"<shape type="rectangle"><transform name="to_world"><scale x="4" y="4"/>
        <translate x="{}" z="1.5"/></transform><bsdf type="diffuse"/></shape>"#,
        edge - 4.0
    )
}

#[test]
fn leaves_in_shadow_are_culled_by_the_share_of_them_that_is() {
    // Leaves are 6/32 wide; the screen covers 16 columns of them and three quarters of the next.
    let scene = flat_pool(0.0, &screen(0.75 * 6.0 / 32.0), 16);
    let culled = |s_min: &str| {
        let settings = [("grid", "129"), ("s-min", s_min)];
        let rendering = run_on(&volume(&settings), &scene, "meter");
        (
            count(&rendering, "shadow-cull", "culled"),
            count(&rendering, "shadow-cull", "queries"),
        )
    };
    // 4 x 4 cells of two triangles in each of 32 leaves of a column.
    let column = 32 * 4 * 4 * 2;
    assert_eq!(culled("0.7").0, 17 * column);
    assert_eq!(culled("0.8").0, 16 * column);
    assert_eq!(culled("1").0, 0);
    // Roots and below: of four columns of roots, two are all dark and one in part. Each level has four times
    // the nodes of what is open.
    let (_, queries) = culled("0.7");
    assert!(queries < 32 * 32, "{queries}");
    let dark = |settings: &[(&str, &str)]| {
        let rest = [("grid", "129"), ("accumulate", "exact")];
        floor(&volume(&[&rest, settings].concat()), &scene)
    };
    // Culling beams that are dark at all three vertices changes nothing, with fewer beams.
    assert_eq!(
        dark(&[("shadow-cull", "dark")]),
        dark(&[("shadow-cull", "exact")])
    );
    let rendering = run_on(
        &volume(&[("grid", "129"), ("shadow-cull", "dark")]),
        &scene,
        "meter",
    );
    assert!(count(&rendering, "shadow-cull", "culled") >= 16 * column);
    assert_eq!(count(&rendering, "shadow-cull", "queries"), 0);
}

#[test]
fn an_occluder_beside_the_waters_image_shades_nothing() {
    let bare = floor(&volume(&[]), &flat_pool(0.0, "", 8));
    for (x, y) in [(9, 0), (-9, 0), (0, 9), (0, -9), (9, 9), (-9, -9)] {
        let screen = format!(
            r#"<shape type="rectangle"><transform name="to_world"><translate x="{x}" y="{y}" z="1.5"/></transform>
            <bsdf type="diffuse"/></shape>"#
        );
        assert_eq!(
            floor(&volume(&[]), &flat_pool(0.0, &screen, 8)),
            bare,
            "{x} {y}"
        );
    }
}

#[test]
fn nodes_are_where_the_water_is_whatever_planes_cut_beams() {
    // The sun at 50°: nodes taken for places across its light would be half a metre off.
    let scene = flat_pool(50.0, &screen(0.0), 16);
    let culled = |axis| {
        let settings = [("grid", "129"), ("axis", axis)];
        count(
            &run_on(&volume(&settings), &scene, "meter"),
            "shadow-cull",
            "culled",
        )
    };
    assert!(culled("water") > 0);
    assert_eq!(culled("refracted"), culled("water"));
}

#[test]
fn a_spot_beside_the_middle_of_the_water_lights_the_floor_below_it() {
    let xml = crate::support::light_volume::pool(0.0, &format!("{FLAT}{WATER}</shape>"), 16);
    let from = xml.find("<emitter").unwrap();
    let to = xml.find("</emitter>").unwrap() + "</emitter>".len();
    let lamp = r#"<emitter type="spot"><transform name="to_world"><lookat origin="0.8, 0, 3" target="0.8, 0, 0" up="0, 1, 0"/></transform>
        <rgb name="intensity" value="900, 900, 900"/><float name="cutoff_angle" value="9"/><float name="beam_width" value="8"/></emitter>"#;
    let scene = scene_of(&format!("{}{lamp}{}", &xml[..from], &xml[to..]));
    let settings = [
        ("accumulate", "f32"),
        ("density", "perpendicular"),
        ("cosine", "exact"),
        ("grid", "200"),
    ];
    let values = floor(&volume(&settings), &scene);
    let dealt = floor(
        &crate::support::light_volume::exact_but(&[("grid", "200")]),
        &scene,
    );
    let (sum, expected): (f64, f64) = (values.iter().sum(), dealt.iter().sum());
    // Centres of texels stand for texels across the cone's border: a few of some thirty lit ones.
    assert!(
        expected > 0.0 && (sum / expected - 1.0).abs() < 0.1,
        "{sum} {expected}"
    );
}

#[test]
fn without_occluders_nothing_is_culled_and_boxes_save_the_queries() {
    let scene = flat_pool(0.0, "", 4);
    let run = |queries| run_on(&volume(&[("queries", queries)]), &scene, "meter");
    let (all, overlap) = (run("all"), run("overlap"));
    // The roots, and no more.
    assert_eq!(count(&all, "shadow-cull", "queries"), 16);
    assert_eq!(count(&overlap, "shadow-cull", "queries"), 0);
    assert_eq!(count(&all, "shadow-cull", "culled"), 0);
    assert_eq!(all.estimate.total.values, overlap.estimate.total.values);
}

#[test]
fn the_faintest_beams_are_left_out_up_to_a_share_of_the_light() {
    let scene = random_sea(5);
    let run = |share: &str| {
        run_on(
            &volume(&[("least-flux", share), ("accumulate", "exact")]),
            &scene,
            "meter",
        )
    };
    let lost = |share: &str| {
        let rendering = run(share);
        let of = |stage: &str| -> f64 {
            let entries = rendering.flux.iter().filter(|entry| entry.stage == stage);
            entries.map(|entry| entry.flux.mean()).sum()
        };
        (
            -of("clamp"),
            of("surface") + of("fresnel"),
            count(&rendering, "clamp", "draws"),
        )
    };
    let (none, all, draws) = lost("0");
    let (some, _, fewer) = lost("0.05");
    // What is lost is at most a twentieth of what was drawn, and nearly that: one of 1058 beams has 1e-3
    // on average, and none twice that.
    let share = (some - none) / (all - none);
    assert!((0.048..=0.05).contains(&share), "{share}");
    assert!(fewer < draws);
}

#[test]
fn light_of_a_point_lamp_goes_down_as_far_as_the_truth_has_it() {
    // Divergent light: its density falls as 1/r², and refracted rays spread. By the truth of beams.
    let xml = crate::support::light_volume::pool(0.0, &format!("{FLAT}{WATER}</shape>"), 16);
    let from = xml.find("<emitter").unwrap();
    let to = xml.find("</emitter>").unwrap() + "</emitter>".len();
    let lamp = r#"<emitter type="point"><point name="position" x="0.3" y="0.2" z="4"/><rgb name="intensity" value="900, 600, 300"/></emitter>"#;
    let scene = scene_of(&format!("{}{lamp}{}", &xml[..from], &xml[to..]));
    let truth = crate::support::approximation::truth(&scene, "LTD", 1e-3).modelled;
    let exact = crate::support::light_volume::exact_but(&[("levels", "0")]);
    let values = run_on(&exact, &scene, "meter").estimate.total.values;
    for (value, truth) in values.iter().zip(&truth) {
        // Channels too: 3 to 2 to 1. 120² vertices are 0.05 apart: linear to (0.05 / 3)²/8.
        for channel in 0..3 {
            assert!(
                (value.0[channel] / truth.0[channel] - 1.0).abs() < 2e-3,
                "{value:?} {truth:?}"
            );
        }
    }
    let off = DVec3::from(values[0].0);
    assert!((off.x / off.y - 1.5).abs() < 1e-9 && (off.x / off.z - 3.0).abs() < 1e-9);
}
