//! Light volumes against closed forms in flat water, and against the truth by beams with all stages exact.

use glam::DVec2;
use nephroid::internals::generate::{WATER as WAVES, height_field};
use nephroid::internals::run::{Budget, Context};

use crate::support::approximation::{relative_rmse, truth};
use crate::support::light_volume::{
    EXACT, SUN, WATER, count, exact_but, flat_pool, flat_water, floor, pool, run_on, scene_of, sea,
    sensor, volume, with_mesh,
};
use crate::support::scenes::bundled_file;

/// Rounding of a texel's value in flat water: coordinates up to 3 are differences of products, and an area is
/// some hundred times smaller than their squares. Hundreds of roundings of 1e-16 by a thousand.
const ROUNDING: f64 = 1e-12 * 1e3;

fn assert_all(values: &[f64], expected: f64, what: &str) {
    for (texel, value) in values.iter().enumerate() {
        let off = (value / expected - 1.0).abs();
        assert!(
            off < ROUNDING,
            "{what}, texel {texel}: {value} instead of {expected}"
        );
    }
}

#[test]
fn in_flat_water_horizontal_planes_and_the_cosine_of_the_floor_give_the_truth_by_the_cosine_below()
{
    // Sides of beams run through texel centres: each centre must have one beam all the same.
    for degrees in [0.0, 30.0, 60.0] {
        let scene = flat_pool(degrees, "", 9);
        let (above, below, share) = flat_water(degrees);
        let exact = SUN * above * share;
        let with = |settings: &[(&str, &str)]| {
            let settings = [&[("accumulate", "exact"), ("grid", "25")], settings].concat();
            floor(&volume(&settings), &scene)
        };
        assert_all(&with(&[]), exact * below, "slices");
        assert_all(&with(&[("cosine", "vector")]), exact * below, "vectors");
        assert_all(
            &with(&[("density", "perpendicular")]),
            exact,
            "perpendicular",
        );
        assert_all(
            &with(&[("axis", "refracted")]),
            exact,
            "planes across the light",
        );
        assert_all(
            &with(&[("density", "exact"), ("cosine", "exact")]),
            exact,
            "exact",
        );
        assert_all(
            &with(&[("flux", "literal")]),
            exact * below / above,
            "without the first cosine",
        );
        assert_all(
            &with(&[("fresnel", "none")]),
            SUN * above * below,
            "no Fresnel",
        );
        let dealt = floor(&exact_but(&[("grid", "25")]), &scene);
        assert_all(&dealt, exact, "dealt");
    }
}

#[test]
fn eight_bits_round_flat_water_to_their_step() {
    let scene = flat_pool(0.0, "", 4);
    let (above, _, share) = flat_water(0.0);
    // One irradiance of flat water is 63.75 of 255 steps for a white of 4: 64 of them.
    let values = floor(&volume(&[("accumulate", "u8"), ("white", "4")]), &scene);
    assert_all(&values, SUN * above * share * 64.0 / 63.75, "u8");
    let values = floor(&volume(&[("accumulate", "u8"), ("white", "600")]), &scene);
    assert_all(
        &values.iter().map(|it| it + 1.0).collect::<Vec<_>>(),
        1.0,
        "below half a step",
    );
}

#[test]
fn schlick_is_the_approximation_of_flat_waters_transmittance() {
    let scene = flat_pool(60.0, "", 2);
    let (above, below, _) = flat_water(60.0);
    let normal: f64 = (0.33_f64 / 2.33).powi(2);
    let share = 1.0 - (normal + (1.0 - normal) * (1.0 - above).powi(5));
    let values = floor(
        &volume(&[("accumulate", "exact"), ("fresnel", "schlick")]),
        &scene,
    );
    assert_all(&values, SUN * above * share * below, "Schlick");
}

#[test]
fn with_all_stages_exact_the_error_falls_to_less_than_a_third_with_each_level() {
    let scene = sea(&WAVES[..3], 40, 20.0, 48);
    let truth = truth(&scene, "LTD", 3e-5);
    let error = |level: &str| {
        let values = run_on(&exact_but(&[("levels", level)]), &scene, "meter")
            .estimate
            .total
            .values;
        relative_rmse(&values, &truth.modelled).unwrap()
    };
    // Linear interpolation of landings: a quarter with each level, but at the caustics' edges.
    let errors = ["0", "1", "2"].map(error);
    assert!(
        errors[1] < errors[0] / 2.8 && errors[2] < errors[1] / 2.8,
        "{errors:?}"
    );
    // A thousandth at level 2; the truth's own error is less than a tenth of that.
    assert!(errors[2] < 1e-3, "{errors:?}");
}

#[test]
fn with_all_stages_exact_floor_and_wall_of_the_pool_are_right_with_and_without_occluders() {
    for occluder in ["none", "fence"] {
        let given = [("size", "48"), ("occluder", occluder)];
        let given = given.map(|(key, value)| (key.into(), value.to_owned()));
        let scene = nephroid::internals::mitsuba::load(&bundled_file("pool"), &given).unwrap();
        for id in ["floor", "wall"] {
            let beams =
                nephroid::internals::method::Method::new("beams", &Default::default()).unwrap();
            let budget = Budget::error(1e-3);
            let context = Context::default();
            let truth = beams
                .run(&scene, sensor(&scene, id), &budget, &context)
                .unwrap();
            let truth = truth
                .estimate
                .layers
                .iter()
                .find(|it| it.name.to_string() == "LTD")
                .unwrap();
            let values = run_on(&exact_but(&[("levels", "2")]), &scene, id)
                .estimate
                .total
                .values;
            let error = relative_rmse(&values, &truth.values).unwrap();
            assert!(error < 5e-3, "{occluder} {id}: {error}");
        }
    }
}

#[test]
fn all_light_that_is_dealt_out_is_what_falls_on_the_water() {
    // Vertical sun: each triangle takes in the light of its own part of the square, of whatever slope. All of
    // it lands: the water is well within the floor. Its sides are numbers that the file can have.
    let mesh = height_field(DVec2::splat(0.75), 1.0, &WAVES, 30);
    let scene = with_mesh(&mesh, 0.0, 16);
    let texel = (2.0_f64 / 16.0).powi(2);
    for settings in [
        &[("fresnel", "none")][..],
        &[("fresnel", "none"), ("surface", "triangles")],
    ] {
        let sum: f64 = floor(&exact_but(settings), &scene).iter().sum();
        let expected = SUN * 1.5 * 1.5;
        assert!(
            (sum * texel / expected - 1.0).abs() < 1e-12,
            "{settings:?} {}",
            sum * texel / expected
        );
    }
    // What each stage does to the flux adds up to the image's.
    let rendering = run_on(&volume(&[]), &scene, "meter");
    let entries: f64 = rendering.flux.iter().map(|entry| entry.flux.mean()).sum();
    let image: f64 = rendering
        .estimate
        .total
        .values
        .iter()
        .map(|value| value.mean() * texel)
        .sum();
    assert!((entries / image - 1.0).abs() < 1e-9, "{entries} {image}");
    assert!((rendering.flux[0].flux.mean() / (SUN * 1.5 * 1.5) - 1.0).abs() < 1e-12);
}

/// A screen above the half of the water with x < 0.
const SCREEN: &str = r#"<shape type="rectangle"><transform name="to_world"><scale x="4" y="4"/>
    <translate x="-4" z="1.5"/></transform><bsdf type="diffuse"/></shape>"#;

#[test]
fn a_shadow_on_vertices_fades_over_one_cell_and_an_exact_one_ends_at_once() {
    let scene = flat_pool(0.0, SCREEN, 80);
    let (_, _, share) = flat_water(0.0);
    let full = SUN * share;
    // Vertices each 0.25, at x = 0 among them, which the screen's edge hides or not: cells from there on.
    let linear = |settings: &[(&str, &str)]| {
        let more = [
            ("grid", "25"),
            ("accumulate", "exact"),
            ("shadow-cull", "exact"),
            ("shadow-map", "0"),
        ];
        floor(&volume(&[&more, settings].concat()), &scene)[..80].to_vec()
    };
    let faded = linear(&[]);
    let lit = linear(&[("shadow", "none")]);
    assert_all(&lit, full, "no shadow");
    // The edge is on a border of cells, or in the middle of some.
    for grid in ["25", "24"] {
        let exact = linear(&[("shadow", "exact"), ("grid", grid)]);
        for (column, value) in exact.iter().enumerate() {
            let expected = if column < 40 { 0.0 } else { full };
            assert!(
                (value - expected).abs() < ROUNDING * full,
                "grid {grid}, column {column}: {value}"
            );
        }
    }
    // Dark vertices end at x = 0 or before: in the cell beside them light grows in proportion.
    let start = faded.iter().position(|value| *value > 0.0).unwrap();
    assert!([30, 40].contains(&start), "{start}");
    for column in 0..10 {
        let expected = full * (column as f64 + 0.5) / 10.0;
        let value = faded[start + column];
        assert!(
            (value / expected - 1.0).abs() < ROUNDING,
            "column {column}: {value} instead of {expected}"
        );
    }
    assert_all(&faded[start + 10..], full, "beyond the cell");
}

#[test]
fn a_disc_under_water_casts_its_shadow_with_exact_occlusion_only() {
    let disc = r#"<shape type="disk"><transform name="to_world"><scale value="0.3"/><translate z="0.5"/></transform>
        <bsdf type="twosided"><bsdf type="diffuse"/></bsdf></shape>"#;
    let scene = flat_pool(0.0, disc, 40);
    let full = SUN * flat_water(0.0).2;
    for (settings, is_shaded) in [
        (&[("accumulate", "exact")][..], false),
        (&[("accumulate", "exact"), ("occlusion", "exact")], true),
    ] {
        let values = floor(&volume(settings), &scene);
        for (texel, value) in values.iter().enumerate() {
            let place = DVec2::new((texel % 40) as f64, (texel / 40) as f64);
            let distance = ((place + 0.5) / 20.0 - 1.0).length();
            let expected = if is_shaded && distance < 0.3 {
                0.0
            } else {
                full
            };
            assert!(
                (value - expected).abs() < ROUNDING * full,
                "{texel}: {value} instead of {expected}"
            );
        }
    }
}

#[test]
fn what_lies_across_the_light_is_right_by_vectors_and_wrong_by_flat_water() {
    // A floor is lit by waves' slopes: with exact cosines the truth, with vectors nearly, with flat water
    // less.
    let scene = sea(&WAVES[..2], 60, 40.0, 24);
    let values = |cosine| floor(&exact_but(&[("cosine", cosine)]), &scene);
    let (exact, vector, flat) = (values("exact"), values("vector"), values("flat"));
    let off = |values: &[f64]| -> f64 {
        let difference: f64 = values.iter().zip(&exact).map(|(a, b)| (a - b).abs()).sum();
        difference / exact.iter().sum::<f64>()
    };
    // Midpoints, not areas: their own error is below a per cent. Slopes up to 0.3 turn light by 0.1.
    assert!(off(&vector) < 0.01, "{}", off(&vector));
    assert!(
        off(&flat) > 1.5 * off(&vector),
        "{} {}",
        off(&flat),
        off(&vector)
    );
}

#[test]
fn joined_cells_leave_no_crack_and_lose_no_light() {
    // A shadow's border keeps cells small, beside large ones: flat water is as bright everywhere else.
    let scene = flat_pool(0.0, SCREEN, 41);
    let (_, _, share) = flat_water(0.0);
    let settings = |lod| {
        let rest = [
            ("grid", "65"),
            ("accumulate", "exact"),
            ("shadow-cull", "exact"),
        ];
        volume(&[&rest, &[("lod", lod)][..]].concat())
    };
    let (joined, all) = (
        run_on(&settings("0.1"), &scene, "meter"),
        run_on(&settings("0"), &scene, "meter"),
    );
    let beams = |rendering: &_| count(rendering, "surface", "beams");
    assert!(
        beams(&joined) < beams(&all) / 4,
        "{} {}",
        beams(&joined),
        beams(&all)
    );
    let values: Vec<f64> = joined
        .estimate
        .total
        .values
        .iter()
        .map(|value| value.mean())
        .collect();
    for row in values.chunks(41) {
        assert_all(&row[24..], SUN * share, "in the light");
    }
    // On waves, whatever is joined: all that falls on the square of water.
    let sea = sea(&WAVES, 64, 0.0, 16);
    for lod in ["0.01", "0.3", "10"] {
        let rendering = run_on(&volume(&[("grid", "65"), ("lod", lod)]), &sea, "meter");
        let falls = rendering.flux[0].flux.mean();
        // The grid's border is moved inwards by a billionth.
        assert!((falls / (SUN * 16.0) - 1.0).abs() < 1e-8, "{lod}: {falls}");
    }
}

#[test]
fn cells_of_a_grid_that_reach_beside_round_water_are_left_out_with_a_warning() {
    let disc = format!(
        r#"<shape type="disk" id="pond"><transform name="to_world"><scale x="3" y="3"/><translate z="1"/></transform>
        {WATER}</shape>"#
    );
    let pond = scene_of(&pool(0.0, &disc, 8));
    let said = |scene: &_, lod: &str| {
        let settings = [("grid", "21"), ("lod", lod)];
        run_on(&volume(&settings), scene, "meter")
            .warnings
            .join("\n")
    };
    let of = said(&pond, "0");
    assert!(
        of.contains("shape \"pond\" does not fill its rectangle"),
        "{of}"
    );
    assert!(of.contains("of 800 triangles"), "{of}");
    assert!(said(&pond, "1").contains("lod joins no cells"));
    let square = flat_pool(0.0, "", 8);
    assert!(!said(&square, "0").contains("does not fill"));
}

#[test]
fn bits_do_not_depend_on_threads() {
    let scene = sea(&WAVES, 50, 25.0, 40);
    let given = [("width", "80"), ("height", "60")];
    let given = given.map(|(key, value)| (key.into(), value.to_owned()));
    let pool = nephroid::internals::mitsuba::load(&bundled_file("pool"), &given).unwrap();
    let cases = [
        (&scene, "meter", volume(&[])),
        (&scene, "meter", exact_but(&[])),
        (
            &scene,
            "meter",
            volume(&[("lookup", "exact"), ("cosine", "vector")]),
        ),
        (&pool, "view-50", volume(&[])),
        (
            &pool,
            "view-25",
            volume(&[("cosine", "vector"), ("lod", "0.2")]),
        ),
    ];
    for (scene, id, method) in cases {
        let bits = |threads| {
            let context = Context {
                threads: Some(threads),
                ..Context::default()
            };
            let rendering = method
                .run(scene, sensor(scene, id), &Budget::default(), &context)
                .unwrap();
            let values = rendering.estimate.total.values;
            let work: Vec<_> = rendering.stages.into_iter().map(|one| one.work).collect();
            (
                values
                    .into_iter()
                    .map(|value| value.0.map(f64::to_bits))
                    .collect::<Vec<_>>(),
                work,
            )
        };
        let one = bits(1);
        assert!(
            one == bits(2) && one == bits(5),
            "{id} {:?}",
            method.given()
        );
    }
}

#[test]
fn what_it_cannot_work_on_is_refused_by_name() {
    let refused = |shapes: &str, settings: &[(&str, &str)]| {
        let scene = scene_of(&crate::support::light_volume::pool(0.0, shapes, 2));
        let refusal = volume(settings)
            .supports(&scene, sensor(&scene, "meter"))
            .unwrap_err();
        refusal.to_string()
    };
    let water = format!(r#"<shape type="rectangle" id="water">{WATER}</shape>"#);
    let other = format!(r#"<shape type="rectangle" id="puddle">{WATER}</shape>"#);
    let ball = format!(r#"<shape type="sphere" id="ball">{WATER}</shape>"#);
    assert!(refused("", &[]).contains("no shape refracts"));
    assert!(refused(&ball, &[]).contains("\"ball\" is closed"));
    let both = format!("{water}{other}");
    let text = refused(&both, &[]);
    assert!(
        text.contains("\"water\"") && text.contains("\"puddle\"") && text.contains("surface-shape")
    );
    assert!(refused(&both, &[("surface-shape", "lake")]).contains("water, puddle"));
    assert!(refused(&water, &[("cosine", "vector"), ("accumulate", "u8")]).contains("signs"));
    assert!(refused(&water, &[("shadow-map", "0")]).contains("shadow-cull=dark"));
    assert!(refused(&water, &[("grid", "1")]).contains("2..=4097"));
    assert!(refused(&water, &[("buckets", "1024"), ("splits", "12")]).contains("leaves"));
    // The rectangle's back: light comes from below.
    let turned = format!(
        r#"<shape type="rectangle" id="water"><transform name="to_world"><rotate x="1" angle="180"/></transform>{WATER}</shape>"#
    );
    assert!(refused(&turned, &[]).contains("under water"));
    let chosen = scene_of(&crate::support::light_volume::pool(0.0, &both, 2));
    let method = volume(&[("surface-shape", "puddle")]);
    assert!(method.supports(&chosen, sensor(&chosen, "meter")).is_ok());
}

#[test]
fn a_black_image_says_why() {
    let screen = r#"<shape type="rectangle"><transform name="to_world"><scale x="9" y="9"/>
        <translate z="1.5"/></transform><bsdf type="diffuse"/></shape>"#;
    let covered = flat_pool(0.0, screen, 2);
    let rendering = run_on(&volume(&[]), &covered, "meter");
    assert!(
        rendering
            .warnings
            .iter()
            .any(|it| it.contains("culled in shadow")),
        "{:?}",
        rendering.warnings
    );
    let rendering = run_on(&volume(&[("shadow-cull", "exact")]), &covered, "meter");
    assert!(
        rendering.warnings.iter().any(|it| it.contains("in shadow")),
        "{:?}",
        rendering.warnings
    );
}

#[test]
fn presets_are_the_rows_of_table_2() {
    let variants = |preset| {
        let stages = volume(&[("preset", preset)]).stages();
        let of = |name: &str| {
            stages
                .iter()
                .find(|stage| stage.name == name)
                .unwrap()
                .variant
                .clone()
        };
        [of("clamp"), of("shadow-cull"), of("cosine"), of("shadow")]
    };
    assert_eq!(variants("reference"), ["beams", "exact", "flat", "vertex"]);
    assert_eq!(
        variants("hierarchical"),
        ["hierarchy", "exact", "flat", "vertex"]
    );
    assert_eq!(
        variants("shadow-culling"),
        ["hierarchy", "hierarchy", "flat", "vertex"]
    );
    assert_eq!(
        variants("vector"),
        ["hierarchy", "hierarchy", "vector", "vertex"]
    );
    let method = volume(&[("preset", "reference"), ("clamp", "hierarchy")]);
    assert_eq!(
        method
            .stages()
            .iter()
            .find(|stage| stage.name == "clamp")
            .unwrap()
            .variant,
        "hierarchy"
    );
    assert_eq!(EXACT.len(), method.stages().len());
}
