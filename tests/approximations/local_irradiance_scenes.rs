//! Local precomputed irradiance in scenes with more than an object and a meter: cameras, ceilings, panes that are
//! not there, floors without end, meshes that are turned.

use std::fs;

use nephroid::internals::approximation::local_irradiance::object::SpecularObject;
use nephroid::internals::generate::{bumpy_ball, write_ply};
use nephroid::internals::mitsuba;
use nephroid::internals::radiometry::Rgb;
use nephroid::internals::run::{Budget, Context};
use nephroid::internals::scene::Scene;

use crate::support::approximation::{GLASS, ball, lit_by, scene_of};
use crate::support::local_irradiance::{exact_but, rendered, settings, sun, tables, texels};
use crate::support::scenes::{bundled_file, meter};
use crate::support::technique;

/// A ball of glass in the sun over a floor of some reflectance, seen from above by a camera.
fn seen_from_above(reflectance: [f64; 3]) -> Scene {
    let [red, green, blue] = reflectance;
    scene_of(&format!(
        r#"<scene version="3.0.0">
        {}
        {}
        <shape type="rectangle" id="floor">
            <transform name="to_world"><scale x="4" y="4"/></transform>
            <bsdf type="diffuse"><rgb name="reflectance" value="{red}, {green}, {blue}"/></bsdf>
        </shape>
        <sensor type="perspective" id="view">
            <float name="fov" value="40"/>
            <transform name="to_world"><lookat origin="5, 0, 6" target="1, 0, 0" up="0, 0, 1"/></transform>
            <film type="hdrfilm">
                <integer name="width" value="24"/><integer name="height" value="24"/>
                <rfilter type="box"/>
            </film>
        </sensor></scene>"#,
        sun([0.4, 0.0, -0.9]),
        ball(GLASS),
    ))
}

fn image(settings: &[(&str, &str)], scene: &Scene) -> Vec<Rgb> {
    let context = Context::default();
    let method = exact_but(&[&[("photons", "65536")], settings].concat());
    let sensor = &scene.sensors()[0];
    let rendering = method.run(scene, sensor, &Budget::default(), &context);
    rendering.unwrap().estimate.total.values
}

#[test]
fn a_camera_sees_the_colour_of_the_floor_with_cells_and_without() {
    let colour = [0.8, 0.4, 0.1];
    for settings in [
        &[][..],
        &[("space", "grid"), ("region", "clamp")],
        &[("storage", "u8")],
    ] {
        let white = image(settings, &seen_from_above([1.0; 3]));
        let coloured = image(settings, &seen_from_above(colour));
        let mut lit = 0;
        for (white, coloured) in white.iter().zip(&coloured) {
            lit += u32::from(!white.is_black());
            // The same photons, in sums of whole quanta of less than 1e-9 (a camera's have room for 2^24 times its
            // typical flux), wrong by half of one each: a pixel has at most some thousands. Numbers are rounded as
            // irradiance, before the floor's colour comes in.
            for ((white, coloured), albedo) in white.0.iter().zip(coloured.0).zip(colour) {
                assert!(
                    (coloured - white * albedo).abs() <= 1e-7,
                    "{settings:?}: {white:?} {coloured:?}"
                );
            }
        }
        assert!(lit > 50, "{settings:?}: {lit}");
    }
}

#[test]
fn a_camera_sees_with_cells_what_it_sees_without() {
    let scene = seen_from_above([0.5; 3]);
    let sum = |image: &[Rgb]| image.iter().map(|value| value.mean()).sum::<f64>();
    let exact = sum(&image(&[("photons", "1048576")], &scene));
    let cells = [("photons", "1048576"), ("space", "grid"), ("cells", "96")];
    let by_cells = sum(&image(&cells, &scene));
    // Cells of 6/96 of the radius beside pixels of about 0.2: cells spread light by a third of a pixel, which
    // moves a few hundredths of it across the image's border and the ball's outline.
    assert!((by_cells / exact - 1.0).abs() < 0.05, "{by_cells} {exact}");
}

#[test]
fn a_camera_sees_the_same_light_however_many_rays_look_for_the_floor() {
    // A ray a pixel misses slivers of the floor beside the border of the image and behind the ball, which
    // photons find.
    let scene = seen_from_above([0.5; 3]);
    let [few, many] = ["1", "8"].map(|samples| image(&[("samples", samples)], &scene));
    for (one, other) in few.iter().zip(&many) {
        // A quotient and its product, of some units of 2⁻⁵³.
        let off = (*one + *other * -1.0).0.map(f64::abs);
        assert!(
            off.iter()
                .zip(other.0)
                .all(|(off, value)| *off <= 1e-14 * value),
            "{one:?} {other:?}"
        );
    }
}

#[test]
fn the_border_of_a_spot_lamp_turns_with_the_light_about_an_axis() {
    // The cone fades across the ball: twisted about the light it would fade elsewhere.
    let spot = r#"<emitter type="spot"><transform name="to_world"><lookat origin="2, 1, 5" target="0.9, -0.4, 1.4"
        up="0, 0, 1"/></transform><rgb name="intensity" value="30, 30, 30"/>
        <float name="cutoff_angle" value="16"/><float name="beam_width" value="2"/></emitter>"#;
    let scene = scene_of(&lit_by(spot, &ball(GLASS), 8));
    let light = |settings: &[(&str, &str)]| {
        let method = exact_but(&[&[("photons", "262144")], settings].concat());
        texels(&method, &scene)
    };
    let exact = light(&[]);
    let apart = |found: &[f64]| {
        let off: f64 = found.iter().zip(&exact).map(|(a, b)| (a - b).abs()).sum();
        off / exact.iter().sum::<f64>()
    };
    let noise = apart(&light(&[("seed", "1")]));
    let turned = [
        ("directions", "barycentric"),
        ("symmetry", "axis"),
        ("axis-samples", "4096"),
        ("tables", "needed"),
    ];
    // Samples are 0.04 degrees apart, a hundredth of a texel. Noise is that of other photons, twice over.
    let found = apart(&light(&turned));
    assert!(found < 2.0 * noise + 0.01, "{found} {noise}");
}

#[test]
fn what_is_behind_a_lamp_is_not_in_its_way() {
    let lamp = r#"<emitter type="point"><point name="position" x="0.2" y="-0.3" z="5"/>
        <rgb name="intensity" value="30, 30, 30"/></emitter>"#;
    let ceiling = r#"<shape type="rectangle"><transform name="to_world"><scale value="9"/>
        <rotate x="1" angle="180"/><translate z="6"/></transform><bsdf type="diffuse"/></shape>"#;
    let method = exact_but(&[("light", "directional"), ("photons", "65536")]);
    let below = |more: &str| {
        let scene = scene_of(&lit_by(lamp, &format!("{}{more}", ball(GLASS)), 16));
        texels(&method, &scene)
    };
    let open = below("");
    assert!(open.iter().sum::<f64>() > 0.0);
    assert_eq!(below(ceiling), open);
}

#[test]
fn light_belongs_to_the_object_that_it_meets_first() {
    let above = |z: f64, x: f64| {
        format!(
            r#"<shape type="sphere"><point name="center" x="{x}" y="0" z="{z}"/>
               <float name="radius" value="0.5"/><bsdf type="conductor"/></shape>"#
        )
    };
    // The upper ball shades half of the lower one: each sheds light on the floor, or none if it is shaded.
    let light = |objects: &str, settings: &[(&str, &str)]| -> f64 {
        let scene = scene_of(&lit_by(&sun([0.3, 0.0, -0.95]), objects, 8));
        let method = exact_but(&[&[("photons", "262144")], settings].concat());
        texels(&method, &scene).iter().sum()
    };
    let (upper, lower) = (above(2.4, -0.2), above(0.7, 0.3));
    let both = format!("{upper}{lower}");
    // As one object: a wire too thin to matter joins their boxes.
    let wire = r#"<shape type="cylinder"><point name="p0" x="0" y="3.9" z="0.5"/><point name="p1" x="0" y="0.3" z="2.9"/>
        <float name="radius" value="1e-5"/><bsdf type="conductor"/></shape>"#;
    let joined = light(&format!("{both}{wire}"), &[]);
    let apart = light(&both, &[]);
    // 2^18 stratified photons: totals are known to a few thousandths.
    assert!((apart / joined - 1.0).abs() < 0.01, "{apart} {joined}");
    assert!(light(&lower, &[]) + light(&upper, &[]) > 1.02 * joined);
}

#[test]
fn a_pane_that_is_not_there_takes_no_light() {
    let mirror = r#"<shape type="rectangle"><transform name="to_world"><scale value="0.5"/>
        <rotate y="1" angle="90"/><translate x="-1.5" z="1"/></transform><bsdf type="twosided">
        <bsdf type="conductor"/></bsdf></shape>"#;
    let pane = r#"<shape type="rectangle"><transform name="to_world"><scale value="3"/>
        <translate z="0.2"/></transform><bsdf type="null"/></shape>"#;
    let method = exact_but(&[("photons", "65536")]);
    let light = |more: &str| -> f64 {
        let scene = scene_of(&lit_by(
            &sun([-0.6, 0.0, -0.8]),
            &format!("{mirror}{more}"),
            8,
        ));
        texels(&method, &scene).iter().sum()
    };
    let open = light("");
    assert!(open > 0.0);
    // Rays start anew behind the pane: a few cross the borders of texels, which does not change their sum.
    assert!(
        (light(pane) / open - 1.0).abs() < 1e-6,
        "{} {open}",
        light(pane)
    );
}

#[test]
fn tables_of_a_region_that_grows_are_refused_if_they_fit_alone_but_not_together() {
    let scene = scene_of(&lit_by(&sun([0.2, 0.0, -1.0]), &ball(GLASS), 8));
    let run = |directions: &str, normal: &str, memory_limit: u64| {
        let context = Context {
            memory_limit: Some(memory_limit),
            ..Context::default()
        };
        let method = tables(&[
            ("photons", "4096"),
            ("cells", "20"),
            ("reach", "1.2"),
            ("storage", "f16"),
            ("region", "exact"),
            ("directions", directions),
            ("normal", normal),
        ]);
        let ran = method.run(&scene, meter(&scene), &Budget::default(), &context);
        ran.map(drop).map_err(|error| error.to_string())
    };
    // What is too little for one table says how many cells there are.
    let said = run("exact", "fixed", 10_000_000).unwrap_err();
    let (before, _) = said.split_once(" cells are more than fit").unwrap();
    let cells: f64 = before.rsplit(' ').next().unwrap().parse().unwrap();
    // A number takes 120 bytes and 24 a thread, of which these tests have up to eight: one table takes 144 to
    // 312 a cell. Three take 384 to 552, and one of vectors 432 to 936.
    let threads = rayon::current_num_threads().min(8) as f64;
    let limit = (cells * (130.0 + 24.0 * threads)) as u64;
    assert_eq!(run("exact", "fixed", limit), Ok(()));
    for (directions, normal) in [("barycentric", "fixed"), ("exact", "vector")] {
        let said = run(directions, normal, limit).unwrap_err();
        assert!(
            said.contains("region=exact: "),
            "{directions} {normal}: {said}"
        );
    }
}

#[test]
fn regions_and_normals_that_would_not_fit_are_refused_by_name() {
    let small = format!(
        r#"<shape type="sphere"><point name="center" x="0" y="0" z="0.05"/>
           <float name="radius" value="0.001"/>{GLASS}</shape>"#
    );
    let far = scene_of(&lit_by(&sun([0.0, 0.0, -1.0]), &small, 8));
    let refusal = |scene: &Scene, settings: &[(&str, &str)], memory_limit: Option<u64>| {
        let context = Context {
            memory_limit,
            ..Context::default()
        };
        let method = tables(&[&[("photons", "4096")], settings].concat());
        let ran = method.run(scene, meter(scene), &Budget::default(), &context);
        ran.map(drop).unwrap_err().to_string()
    };
    // 2.8 m of floor are 940 times the region of 3 mm: 60,000 cubes each way.
    for space in ["grid", "shells"] {
        let settings = [("region", "exact"), ("space", space), ("shell-level", "8")];
        let said = refusal(&far, &settings, Some(20_000_000_000));
        for words in ["region=exact", "up to 2.65", "region=clamp"] {
            assert!(said.contains(words), "{space}: {said}");
        }
    }
    // A floor of many normals, in cells that are merged: each normal takes all cells of a tree.
    let folder = tempfile::tempdir().unwrap();
    let mut file = fs::File::create(folder.path().join("bumps.ply")).unwrap();
    write_ply(&bumpy_ball(1.0, 8), "", &mut file).unwrap();
    let xml = format!(
        r#"<scene version="3.0.0">{}{}
        <shape type="ply"><string name="filename" value="bumps.ply"/>
            <transform name="to_world"><scale x="3" y="3" z="0.2"/><translate z="-0.6"/></transform>
            <bsdf type="diffuse"/></shape>
        <sensor type="perspective" id="view"><float name="fov" value="40"/>
            <transform name="to_world"><lookat origin="5, 0, 6" target="1, 0, 0" up="0, 0, 1"/></transform>
            <film type="hdrfilm"><integer name="width" value="32"/><integer name="height" value="32"/>
                <rfilter type="box"/></film></sensor></scene>"#,
        sun([0.0, 0.0, -1.0]),
        ball(GLASS)
    );
    let file = folder.path().join("scene.xml");
    fs::write(&file, xml).unwrap();
    let scene = mitsuba::load(&file, &[]).unwrap();
    let method = tables(&[
        ("photons", "4096"),
        ("normal", "exact"),
        ("space", "multi-resolution"),
        ("tree", "grid"),
    ]);
    let context = Context {
        memory_limit: Some(1_000_000_000),
        ..Context::default()
    };
    let ran = method.run(&scene, &scene.sensors()[0], &Budget::default(), &context);
    let said = ran.map(drop).unwrap_err().to_string();
    for words in ["normal=exact", "normal=fixed", "multi-resolution"] {
        assert!(said.contains(words), "{said}");
    }
}

#[test]
fn a_mesh_of_floats_has_the_same_form_however_it_is_turned() {
    let settings = settings(&[]);
    let form = |name: &str, given: &[(&str, &str)]| {
        let given: Vec<_> = technique::given(given).into_iter().collect();
        let scene = mitsuba::load(&bundled_file(name), &given).unwrap();
        let objects = SpecularObject::all(&scene).unwrap();
        objects[0].form(&settings)
    };
    for name in ["turntable-bumpy", "turntable-ring", "turntable-prism"] {
        let home = form(name, &[]);
        for turn in ["37", "90", "213.7"] {
            assert_eq!(
                form(name, &[("turn", turn), ("drop", "1.75")]),
                home,
                "{name} {turn}"
            );
        }
    }
}

#[test]
fn bytes_count_what_they_cut_off() {
    let scene = scene_of(&lit_by(&sun([0.0, 0.0, -1.0]), &ball(GLASS), 8));
    let saturated = |storage: &str, range: &str| {
        let method = tables(&[("photons", "65536"), ("storage", storage), ("range", range)]);
        rendered(&method, &scene)
            .counters
            .iter()
            .find(|one| one.name == "saturated")
            .map_or(0, |one| one.count)
    };
    // In the focus below a ball irradiance is far above 3, and nowhere is it above 10⁶.
    assert!(saturated("u8", "3") > 0);
    assert!(saturated("u8", "1") > saturated("u8", "3"));
    assert_eq!(saturated("u8", "1e6"), 0);
    assert_eq!(saturated("f16", "3"), 0);
}
