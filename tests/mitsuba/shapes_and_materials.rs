//! Meaning of shapes and bsdfs in Mitsuba's scene files. Numbers called Mitsuba's
//! were read back from Mitsuba 3.9.1, `scalar_rgb`, with `mi.load_string` and `mi.traverse`.

use glam::DVec3;
use nephroid::internals::geometry::Shape;
use nephroid::internals::radiometry::Rgb;
use nephroid::internals::scene::{Color, Material, MaterialId, MediumId, Scalar, Scene};

use crate::support::scene_files::{Folder, assert_close, error, scene};

/// Bounds are rounded outward, by far less than this at the sizes used here.
const PADDING: f64 = 1e-6;

fn material(bsdf: &str) -> Result<Material, String> {
    let parts = scene(&format!("<shape type=\"sphere\">{bsdf}</shape>"))?;
    Ok(parts.materials[parts.objects[0].material.0 as usize].clone())
}

#[test]
fn transforms_apply_in_the_order_written() {
    let parts = scene(
        "<shape type=\"sphere\"><float name=\"radius\" value=\"0.5\"/><point name=\"center\" value=\"1, 0, 0\"/>\
         <transform name=\"to_world\"><scale value=\"2\"/><rotate z=\"1\" angle=\"90\"/><translate z=\"3\"/></transform></shape>",
    )
    .unwrap();
    let bounds = parts.shapes[0].bounds();
    // Center (1, 0, 0) -> (2, 0, 0) -> (0, 2, 0) -> (0, 2, 3), radius 0.5 * 2.
    assert!(
        bounds
            .center()
            .abs_diff_eq(DVec3::new(0.0, 2.0, 3.0), PADDING)
    );
    assert!(bounds.extent().abs_diff_eq(DVec3::splat(2.0), PADDING));
}

#[test]
fn a_cylinder_runs_from_p0_to_p1() {
    let parts = scene(
        "<shape type=\"cylinder\"><point name=\"p0\" x=\"1\" y=\"1\" z=\"1\"/><point name=\"p1\" x=\"4\" y=\"1\" z=\"1\"/>\
         <float name=\"radius\" value=\"0.5\"/></shape>",
    )
    .unwrap();
    let bounds = parts.shapes[0].bounds();
    assert!(
        bounds.min.abs_diff_eq(DVec3::new(1.0, 0.5, 0.5), PADDING),
        "{bounds:?}"
    );
    assert!(
        bounds.max.abs_diff_eq(DVec3::new(4.0, 1.5, 1.5), PADDING),
        "{bounds:?}"
    );
    assert!(
        error("<shape type=\"cylinder\"><point name=\"p1\" value=\"0\"/></shape>")
            .contains("p0 and p1 to differ")
    );
}

#[test]
fn a_cube_has_mitsubas_24_vertices() {
    let parts = scene("<shape type=\"cube\"/>").unwrap();
    let Shape::Mesh(cube) = &parts.shapes[0] else {
        panic!("not a mesh")
    };
    assert_eq!((cube.positions().len(), cube.triangle_count()), (24, 12));
    assert_eq!(cube.positions()[0], DVec3::new(1.0, -1.0, -1.0));
}

#[test]
fn instances_copy_their_group_into_the_world() {
    let parts = scene(
        "<shape type=\"shapegroup\" id=\"group\"><shape type=\"sphere\" id=\"ball\"/><shape type=\"rectangle\"/></shape>\
         <shape type=\"instance\" id=\"one\"><ref id=\"group\"/></shape>\
         <shape type=\"instance\"><ref id=\"group\"/><transform name=\"to_world\"><translate x=\"10\"/></transform></shape>",
    )
    .unwrap();
    let ids: Vec<_> = parts
        .objects
        .iter()
        .map(|object| object.id.as_str())
        .collect();
    assert_eq!(
        ids,
        [
            "one/ball",
            "one/rectangle_0",
            "instance_0/ball",
            "instance_0/rectangle_0"
        ]
    );
    assert!(
        parts.shapes[2]
            .bounds()
            .center()
            .abs_diff_eq(DVec3::new(10.0, 0.0, 0.0), PADDING)
    );
    let shining = "<shape type=\"shapegroup\" id=\"g\"><shape type=\"sphere\"><emitter type=\"area\"/></shape></shape>\
                   <shape type=\"instance\"><ref id=\"g\"/></shape>";
    assert!(error(shining).contains("a shape that is shown by instances cannot shine"));
}

#[test]
fn merged_shapes_stay_shapes_of_their_own() {
    let parts = scene(
        "<shape type=\"sphere\" id=\"ball\"/>\
         <shape type=\"merge\"><ref id=\"ball\"/><shape type=\"cube\" id=\"a\"/>\
         <shape type=\"cube\" id=\"b\"><transform name=\"to_world\"><translate x=\"3\"/></transform></shape></shape>",
    )
    .unwrap();
    let ids: Vec<_> = (parts.objects.iter())
        .map(|object| object.id.as_str())
        .collect();
    assert_eq!(ids, ["ball", "ball", "a", "b"]);
    let center = parts.shapes[3].bounds().center();
    assert!(center.abs_diff_eq(3.0 * DVec3::X, PADDING));
    let nested =
        "<shape type=\"merge\"><shape type=\"merge\"><shape type=\"cube\"/></shape></shape>";
    assert!(error(nested).contains("cannot be inside a merge"));
    let moved =
        "<shape type=\"merge\"><transform name=\"to_world\"/><shape type=\"cube\"/></shape>";
    assert!(error(moved).contains("to_world"));
}

#[test]
fn singular_transforms_and_broken_mesh_files_name_the_shape_that_asks() {
    let flat = "<shape type=\"rectangle\"><transform name=\"to_world\"><scale z=\"0\"/></transform></shape>";
    assert!(error(flat).starts_with(
        "scene.xml:2:25: shape \"rectangle\", parameter \"to_world\": the matrix cannot be inverted"
    ));
    let folder = Folder::new();
    folder.write("bad.ply", "ply\nformat ascii 1.0\nelement vertex x\n");
    folder.write("scene.xml", "<scene version=\"3.0.0\">\n<shape type=\"ply\"><string name=\"filename\" value=\"bad.ply\"/></shape></scene>");
    assert_eq!(
        folder.load("scene.xml", &[]).unwrap_err(),
        "scene.xml:2:1: shape \"ply\": bad.ply: line 3: \"x\" is not a number of elements"
    );
    let missing =
        error("<shape type=\"obj\"><string name=\"filename\" value=\"none.obj\"/></shape>");
    assert!(
        missing.starts_with(
            "scene.xml:2:19: shape \"obj\", parameter \"filename\": none.obj cannot be read"
        ),
        "{missing}"
    );
    assert!(error("<shape type=\"obj\"/>").contains("needs the parameter \"filename\""));
}

#[test]
fn a_shape_without_bsdf_is_half_white() {
    assert_eq!(
        material("").unwrap(),
        Material::Diffuse {
            reflectance: Color::Constant(Rgb::grey(0.5))
        }
    );
    assert_eq!(
        material("<bsdf type=\"diffuse\"/>").unwrap(),
        Material::Diffuse {
            reflectance: Color::Constant(Rgb::grey(0.5))
        }
    );
}

#[test]
fn a_dielectric_is_bk7_in_air_unless_told() {
    let indices = |bsdf: &str| match material(bsdf).unwrap() {
        Material::Dielectric {
            interior_ior,
            exterior_ior,
            ..
        }
        | Material::ThinDielectric {
            interior_ior,
            exterior_ior,
            ..
        } => (interior_ior, exterior_ior),
        other => panic!("{other:?}"),
    };
    let (inside, outside) = indices("<bsdf type=\"dielectric\"/>");
    assert_close(inside / outside, 1.504183292388916); // Mitsuba's `eta`
    assert_eq!(
        indices("<bsdf type=\"thindielectric\"/>"),
        (1.5046, 1.000277)
    );
    let water = "<string name=\"int_ior\" value=\"Water\"/><float name=\"ext_ior\" value=\"1\"/>";
    assert_eq!(
        indices(&format!("<bsdf type=\"dielectric\">{water}</bsdf>")),
        (1.333, 1.0)
    );
    let negative = "<bsdf type=\"dielectric\"><float name=\"int_ior\" value=\"-1\"/></bsdf>";
    assert!(
        material(negative)
            .unwrap_err()
            .contains("\"int_ior\": must be above 0, not -1")
    );
    let unknown = "<bsdf type=\"dielectric\"><string name=\"int_ior\" value=\"watre\"/></bsdf>";
    assert!(
        material(unknown)
            .unwrap_err()
            .contains("did you mean \"water\"?")
    );
}

#[test]
fn a_conductor_is_a_mirror_unless_told() {
    let of = |parameters: &str| -> Result<_, String> {
        match material(&format!("<bsdf type=\"conductor\">{parameters}</bsdf>"))? {
            Material::Conductor {
                eta,
                k,
                specular_reflectance,
            } => Ok((eta, k, specular_reflectance.even())),
            other => panic!("{other:?}"),
        }
    };
    let mirror = (Rgb::BLACK, Rgb::WHITE, Rgb::WHITE);
    assert_eq!(of(""), Ok(mirror));
    assert_eq!(of("<string name=\"material\" value=\"none\"/>"), Ok(mirror));
    // Mitsuba keeps k = 1 where only eta is given.
    assert_eq!(
        of("<float name=\"eta\" value=\"2\"/>"),
        Ok((Rgb::grey(2.0), Rgb::WHITE, Rgb::WHITE))
    );
    let (eta, k, _) = of("<string name=\"material\" value=\"Al\"/>").unwrap();
    assert_eq!(
        (eta, k),
        (
            Rgb([1.6575, 0.880405, 0.521244]),
            Rgb([9.22381, 6.2695, 4.837])
        )
    );
    let both = "<string name=\"material\" value=\"Al\"/><float name=\"k\" value=\"1\"/>";
    assert!(of(both).unwrap_err().contains("exclude each other"));
    let bright = "<float name=\"specular_reflectance\" value=\"1.5\"/>";
    assert!(of(bright).unwrap_err().contains("must lie in 0..=1"));
}

#[test]
fn masks_and_two_sided_materials_nest() {
    let mask = "<bsdf type=\"mask\"><float name=\"opacity\" value=\"0.25\"/><bsdf type=\"conductor\"/></bsdf>";
    assert!(matches!(
        material(mask),
        Ok(Material::Mask {
            opacity: Scalar::Constant(0.25),
            ..
        })
    ));
    let both = "<bsdf type=\"twosided\"><bsdf type=\"diffuse\"/></bsdf>";
    assert!(matches!(material(both), Ok(Material::TwoSided { front, back }) if front == back));
    let two = "<bsdf type=\"twosided\"><bsdf type=\"diffuse\"/><bsdf type=\"conductor\"/></bsdf>";
    assert!(matches!(material(two), Ok(Material::TwoSided { front, back }) if front != back));
    for (bsdf, expected) in [
        ("<bsdf type=\"mask\"/>", "needs a nested bsdf"),
        (
            "<bsdf type=\"twosided\"/>",
            "needs one or two nested bsdfs, not 0",
        ),
        (
            "<bsdf type=\"twosided\"><bsdf type=\"dielectric\"/></bsdf>",
            "cannot be inside twosided",
        ),
        (
            "<bsdf type=\"mask\"><rgb name=\"opacity\" value=\"1, 0, 0\"/><bsdf type=\"diffuse\"/></bsdf>",
            "must be the same in all channels",
        ),
        (
            "<bsdf type=\"diffuse\"/><bsdf type=\"diffuse\"/>",
            "may hold only one bsdf",
        ),
    ] {
        let message = material(bsdf).unwrap_err();
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn a_missing_image_is_a_warning_where_no_irradiance_depends_on_it_and_an_error_elsewhere() {
    let image = |name: &str| {
        format!(
            "<texture name=\"{name}\" type=\"bitmap\"><string name=\"filename\" value=\"none.png\"/></texture>"
        )
    };
    let parts = scene(&format!(
        "<shape type=\"rectangle\"><bsdf type=\"diffuse\">{}</bsdf></shape>",
        image("reflectance")
    ))
    .unwrap();
    assert!(parts.warnings[0].message.contains("none.png"));
    assert_eq!(
        parts.materials[0],
        Material::Diffuse {
            reflectance: Color::Unknown
        }
    );
    for (parameter, bsdf) in [
        ("opacity", "mask"),
        ("alpha", "roughconductor"),
        ("normalmap", "normalmap"),
        ("map", "bumpmap"),
    ] {
        let nested = if bsdf == "roughconductor" {
            ""
        } else {
            "<bsdf type=\"diffuse\"/>"
        };
        let message = material(&format!(
            "<bsdf type=\"{bsdf}\">{}{nested}</bsdf>",
            image(parameter)
        ))
        .unwrap_err();
        assert!(message.contains("needs its image"), "{message}");
    }
    let elsewhere = "<bsdf type=\"conductor\"><texture name=\"eta\" type=\"checkerboard\"/></bsdf>";
    assert!(
        material(elsewhere)
            .unwrap_err()
            .contains("texture \"checkerboard\" as \"eta\" of bsdf \"conductor\" is not modelled")
    );
    let misspelt = "<bsdf type=\"diffuse\"><texture name=\"reflectance\" type=\"checkerboard\"><float name=\"colour0\" value=\"1\"/></texture></bsdf>";
    assert!(
        material(misspelt)
            .unwrap_err()
            .contains("did you mean \"color0\"?")
    );
}

#[test]
fn rough_materials_say_what_they_need() {
    let bsdf = |plugin: &str, parameters: &str| {
        material(&format!("<bsdf type=\"{plugin}\">{parameters}</bsdf>"))
    };
    let both = "<float name=\"alpha\" value=\"0.1\"/><float name=\"alpha_u\" value=\"0.1\"/>";
    let half = "<float name=\"alpha_v\" value=\"0.1\"/>";
    let matched = "<float name=\"int_ior\" value=\"1.5\"/><float name=\"ext_ior\" value=\"1.5\"/>";
    for (plugin, parameters, expected) in [
        ("roughconductor", both, "give one"),
        ("roughconductor", half, "give one"),
        (
            "roughdielectric",
            matched,
            "needs indices of refraction that differ",
        ),
        (
            "roughplastic",
            matched,
            "needs indices of refraction that differ",
        ),
        (
            "principled",
            "<float name=\"eta\" value=\"1.5\"/><float name=\"specular\" value=\"0.5\"/>",
            "exclude each other",
        ),
        (
            "principled",
            "<float name=\"specular\" value=\"1.5\"/>",
            "must be from 0 to 1, not 1.5",
        ),
        (
            "principled",
            "<float name=\"metallic\" value=\"2\"/>",
            "must lie in 0..=1",
        ),
        (
            "principledthin",
            "<float name=\"metallic\" value=\"1\"/>",
            "has no parameter \"metallic\"",
        ),
        (
            "principledthin",
            "<float name=\"diff_trans\" value=\"2.5\"/>",
            "must lie in 0..=2, but is 2.5",
        ),
        (
            "principledthin",
            "<float name=\"eta\" value=\"0\"/>",
            "must be above 0, not 0",
        ),
        (
            "roughplastic",
            "<float name=\"alpha\" value=\"0\"/>",
            "must be above 0, not 0",
        ),
        (
            "roughconductor",
            "<float name=\"alpha\" value=\"-1\"/>",
            "must not be negative",
        ),
        (
            "roughconductor",
            "<string name=\"distribution\" value=\"phong\"/>",
            "must be one of beckmann, ggx, not \"phong\"",
        ),
        (
            "bumpmap",
            "<bsdf type=\"diffuse\"/>",
            "needs a nested texture",
        ),
        (
            "bumpmap",
            "<texture type=\"checkerboard\"/><bsdf type=\"diffuse\"/>",
            "only a bitmap can be a bump map",
        ),
        (
            "normalmap",
            "<rgb name=\"normalmap\" value=\"0.5, 0.5, 1\"/><bsdf type=\"twosided\"><bsdf type=\"diffuse\"/></bsdf>",
            "cannot hold a twosided: wrap it around the normalmap instead",
        ),
        (
            "twosided",
            "<bsdf type=\"roughdielectric\"/>",
            "cannot be inside twosided",
        ),
    ] {
        let message = bsdf(plugin, parameters).unwrap_err();
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn a_colour_of_vertices_needs_a_mesh_that_has_it() {
    let folder = Folder::new();
    folder.write(
        "scene.xml",
        "<scene version=\"3.0.0\"><shape type=\"ply\"><string name=\"filename\" value=\"a.ply\"/><bsdf type=\"diffuse\">\
         <texture type=\"mesh_attribute\" name=\"reflectance\"><string name=\"name\" value=\"vertex_color\"/></texture></bsdf></shape></scene>",
    );
    let load = |colors: [&str; 4]| {
        let [names, a, b, c] = colors;
        folder.write(
            "a.ply",
            format!(
                "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n{names}\
                 element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0 {a}\n1 0 0 {b}\n0 1 0 {c}\n3 0 1 2\n"
            ),
        );
        let parts = folder.load("scene.xml", &[]).unwrap();
        nephroid::internals::scene::Scene::new(parts)
            .map(|_| ())
            .map_err(|error| error.to_string())
    };
    let names = "property float r\nproperty float g\nproperty float b\n";
    assert_eq!(load([names, "1 0 0", "0 1 0", "0 0 1"]), Ok(()));
    assert!(
        load(["", "", "", ""])
            .unwrap_err()
            .contains("has no \"vertex_color\"")
    );
    // A file says what it has. A number that no scene uses may be anything, and none that one does.
    let other = "property float heat_0\nproperty float color_0\nproperty float color_1\n";
    let message = load([other, "1 1 1", "nan 1 1", "1 1 1"]).unwrap_err();
    assert!(
        message.contains("has no \"vertex_color\": it has vertex_heat"),
        "{message}"
    );
    let colors = format!("{names}property float heat_0\n");
    assert_eq!(load([&colors, "1 0 0 7", "0 1 0 nan", "0 0 1 7"]), Ok(()));
    let message = load([names, "1 0 0", "0 nan 0", "0 0 1"]).unwrap_err();
    assert!(message.contains("has numbers from NaN to NaN"), "{message}");
    let whole = names.replace("float", "uchar");
    assert!(
        load([&whole, "255 0 0", "0 1 0", "0 0 1"])
            .unwrap_err()
            .contains("has numbers from 0 to 255 for \"vertex_color\"")
    );
}

#[test]
fn a_blend_has_its_parts_in_the_files_order_and_a_weight_that_is_brought_to_the_unit_interval() {
    let grey = |albedo: f64| {
        format!("<bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"{albedo}\"/></bsdf>")
    };
    let blend = |weight: &str, first: &str, second: &str| {
        material(&format!(
            "<bsdf type=\"blendbsdf\"><float name=\"weight\" value=\"{weight}\"/>{first}{second}</bsdf>"
        ))
    };
    let named =
        |name: &str, albedo| grey(albedo).replace("<bsdf ", &format!("<bsdf name=\"{name}\" "));
    let of = |albedo: f64| Material::Diffuse {
        reflectance: Color::Constant(Rgb::grey(albedo)),
    };
    // Mitsuba 3.9.1 goes by places, not by names.
    let parts = scene(&format!(
        "<shape type=\"sphere\"><bsdf type=\"blendbsdf\">{}<float name=\"weight\" value=\"0.25\"/>{}</bsdf></shape>",
        named("b", 0.8),
        named("a", 0.1)
    ))
    .unwrap();
    assert_eq!(parts.materials[..2], [of(0.8), of(0.1)]);
    assert_eq!(
        parts.materials[2],
        Material::Blend {
            weight: Scalar::Constant(0.25),
            nested: [MaterialId(0), MaterialId(1)]
        }
    );
    // At the ends one is left.
    for (weight, left) in [("0", 0.8), ("-0.5", 0.8), ("1", 0.1), ("1.5", 0.1)] {
        assert_eq!(
            blend(weight, &grey(0.8), &grey(0.1)),
            Ok(of(left)),
            "{weight}"
        );
    }
    // A blend with nothing is a mask.
    for (first, second, opacity) in [("null", "diffuse", 0.25), ("diffuse", "null", 0.75)] {
        let plain = |plugin| format!("<bsdf type=\"{plugin}\"/>");
        let found = blend("0.25", &plain(first), &plain(second)).unwrap();
        assert!(
            matches!(found, Material::Mask { opacity: Scalar::Constant(it), .. } if it == opacity),
            "{found:?}"
        );
    }
}

#[test]
fn blends_that_cannot_be_say_what_to_write_instead() {
    let matt = "<bsdf type=\"diffuse\"/>";
    let half = "<float name=\"weight\" value=\"0.5\"/>";
    let height = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/mitsuba/height.png");
    let image = |name: &str| {
        format!(
            "<texture name=\"{name}\" type=\"bitmap\"><string name=\"filename\" value=\"{height}\"/></texture>"
        )
    };
    let mask = format!("<bsdf type=\"mask\">{matt}</bsdf>");
    let both = format!("<bsdf type=\"twosided\">{matt}</bsdf>");
    let bumpy = format!("<bsdf type=\"bumpmap\">{}{matt}</bsdf>", image("map"));
    let blend = |inside: &str| format!("<bsdf type=\"blendbsdf\">{inside}</bsdf>");
    let bump = |inside: &str| format!("<bsdf type=\"bumpmap\">{}{inside}</bsdf>", image("map"));
    for (bsdf, expected) in [
        (
            blend(&format!("{matt}{matt}")),
            "needs the parameter \"weight\"",
        ),
        (
            blend(&format!("{half}{matt}")),
            "needs two nested bsdfs, not 1",
        ),
        (
            blend(&format!("{half}{matt}{matt}{matt}")),
            "needs two nested bsdfs, not 3",
        ),
        (
            blend(&format!("{half}{matt}{mask}")),
            "put the mask around the blendbsdf",
        ),
        (
            blend(&format!("{}{matt}<bsdf type=\"null\"/>", image("weight"))),
            "make it the first",
        ),
        (
            bump(&blend(&format!("{half}{matt}{bumpy}"))),
            "put a bumpmap into the bumpmap instead",
        ),
        (
            bump(&blend(&format!("{half}{matt}{both}"))),
            "put a bumpmap into the twosided instead",
        ),
        (bump(&both), "wrap it around the bumpmap instead"),
        (
            format!(
                "<bsdf type=\"twosided\">{}</bsdf>",
                blend(&format!("{half}{matt}<bsdf type=\"dielectric\"/>"))
            ),
            "only one-sided materials",
        ),
        (
            "<bsdf type=\"twosided\"><bsdf type=\"principledthin\"/></bsdf>".to_owned(),
            "only one-sided materials",
        ),
    ] {
        let message = material(&bsdf).unwrap_err();
        assert!(message.contains(expected), "{message}");
    }
    // Blends that share their parts hold many in few lines: 2⁶ are taken, 2⁷ not, and none of 2⁶⁰ takes its time.
    let shared = |levels: usize| {
        let of = |level: usize| {
            let part = format!("<ref id=\"{}\"/>", level - 1);
            blend(&format!("{half}{part}{part}")).replacen(
                "<bsdf ",
                &format!("<bsdf id=\"{level}\" "),
                1,
            )
        };
        let all: String = (1..=levels).map(of).collect();
        scene(&format!(
            "<bsdf type=\"diffuse\" id=\"0\"/>{all}<shape type=\"sphere\"><ref id=\"{levels}\"/></shape>"
        ))
    };
    assert!(shared(6).is_ok());
    for levels in [7, 60] {
        let message = shared(levels).unwrap_err();
        assert!(message.contains("holds 128 materials"), "{message}");
    }
    // These mean something.
    for bsdf in [
        blend(&format!("{half}{both}{both}")),
        blend(&format!("{half}{both}{matt}")),
        blend(&format!(
            "{half}{bumpy}{}",
            blend(&format!("{half}{both}{bumpy}"))
        )),
        bump(&blend(&format!("{half}{matt}{matt}"))),
        format!(
            "<bsdf type=\"mask\">{}</bsdf>",
            blend(&format!("{half}{matt}{bumpy}"))
        ),
    ] {
        assert!(material(&bsdf).is_ok(), "{bsdf}");
    }
}

#[test]
fn what_no_shape_uses_is_ignored_even_where_it_is_not_modelled() {
    let parts = scene(
        "<integrator type=\"path_of_my_own\"><integer name=\"max_depth\" value=\"3\"/></integrator>\
         <bsdf type=\"hair\" id=\"unused\"/><medium type=\"homogeneous\" id=\"fog\"/>",
    )
    .unwrap();
    let what: Vec<_> = parts
        .ignored
        .iter()
        .map(|ignored| ignored.what.as_str())
        .collect();
    assert_eq!(
        what,
        [
            "integrator \"path_of_my_own\"",
            "bsdf \"hair\" (id \"unused\")",
            "medium \"homogeneous\" (id \"fog\")"
        ]
    );
    let used = "<medium type=\"homogeneous\" id=\"fog\"/><shape type=\"sphere\">\n<ref name=\"interior\" id=\"fog\"/></shape>";
    assert_eq!(
        error(used),
        "scene.xml:2:1: medium \"homogeneous\" scatters light, as its albedo is (0.75, 0.75, 0.75); media may absorb \
         light, but not scatter it: give a homogeneous medium the albedo 0"
    );
}

/// A scene of two shapes; the medium's parameters, and what the first shape holds.
fn media(parameters: &str, holds: &str) -> String {
    format!(
        "<medium type=\"homogeneous\" id=\"ink\">{parameters}</medium>\n\
         <shape type=\"sphere\">{holds}</shape>\n\
         <shape type=\"cube\"><ref name=\"exterior\" id=\"ink\"/></shape>"
    )
}

const NO_ALBEDO: &str = "<float name=\"albedo\" value=\"0\"/>";

#[test]
fn media_absorb_by_sigma_t_and_scale() {
    let interior = "<ref name=\"interior\" id=\"ink\"/>";
    let absorption = |parameters: &str| {
        let parts = scene(&media(&format!("{NO_ALBEDO}{parameters}"), interior)).unwrap();
        assert_eq!(parts.media[0].id, "ink");
        let [sphere, cube] = [0, 1].map(|shape| parts.objects[shape].boundary.unwrap());
        // Both shapes bound the same medium, each on its side.
        assert_eq!(sphere.interior, MediumId::new(0));
        assert_eq!(sphere.exterior, MediumId::CLEAR);
        assert_eq!(
            [cube.exterior, cube.interior],
            [sphere.interior, sphere.exterior]
        );
        parts.media[0].absorption.0
    };
    // Mitsuba's default extinction is 1.
    assert_eq!(absorption(""), [1.0; 3]);
    assert_eq!(
        absorption("<float name=\"sigma_t\" value=\"7\"/>"),
        [7.0; 3]
    );
    let colour = "<rgb name=\"sigma_t\" value=\"0.5, 1, 0\"/><float name=\"scale\" value=\"4\"/>";
    assert_eq!(absorption(colour), [2.0, 4.0, 0.0]);
    let ignored = "<phase type=\"isotropic\"/><boolean name=\"sample_emitters\" value=\"false\"/>";
    assert_eq!(absorption(ignored), [1.0; 3]);
}

#[test]
fn media_that_are_not_modelled_are_errors_with_the_reason() {
    let interior = "<ref name=\"interior\" id=\"ink\"/>";
    for (parameters, expected) in [
        (
            "<rgb name=\"albedo\" value=\"0, 0, 0.5\"/>",
            "scatters light, as its albedo is (0, 0, 0.5)",
        ),
        (
            "<rgb name=\"sigma_t\" value=\"0.5, 2, 0\"/>",
            "must lie in 0..=1, but is (0.5, 2, 0); \"scale\" multiplies it",
        ),
        (
            "<float name=\"sigma_t\" value=\"-1\"/>",
            "must not be negative",
        ),
        (
            "<float name=\"scale\" value=\"-1\"/>",
            "must be at least 0 and finite",
        ),
        (
            "<volume name=\"sigma_t\" type=\"gridvolume\"/>",
            "must be a float or an rgb, as media are the same everywhere",
        ),
        (
            "<rgb name=\"sigma_s\" value=\"0\"/>",
            "has no parameter \"sigma_s\"",
        ),
    ] {
        let albedo = if parameters.contains("albedo") {
            ""
        } else {
            NO_ALBEDO
        };
        let message = error(&media(&format!("{albedo}{parameters}"), interior));
        assert!(message.starts_with("scene.xml:2:"), "{message}");
        assert!(message.contains(expected), "{message}");
    }
    let heterogeneous =
        "<shape type=\"sphere\"><medium type=\"heterogeneous\" name=\"interior\"/></shape>";
    let message = error(heterogeneous);
    assert!(
        message.contains("medium \"heterogeneous\" is not modelled"),
        "{message}"
    );
    // Mitsuba takes no notice of a medium of another name.
    for holds in ["<ref id=\"ink\"/>", "<ref name=\"inside\" id=\"ink\"/>"] {
        let message = error(&media(NO_ALBEDO, holds));
        assert!(
            message.contains("neither its \"interior\" nor its \"exterior\""),
            "{message}"
        );
    }
}

#[test]
fn lamps_and_cameras_may_say_what_they_are_in() {
    let film = "<film type=\"hdrfilm\"/>";
    let parts = scene(&format!(
        "<medium type=\"homogeneous\" id=\"ink\">{NO_ALBEDO}</medium>\
         <emitter type=\"point\"/><emitter type=\"point\"><ref id=\"ink\"/></emitter>\
         <sensor type=\"perspective\">{film}</sensor><sensor type=\"perspective\"><ref id=\"ink\"/>{film}</sensor>"
    ))
    .unwrap();
    // Nothing bounds it: all of the scene is in it.
    assert_eq!(parts.immersed, [1]);
    let media: Vec<_> = parts.sensors.iter().map(|it| it.medium).collect();
    assert_eq!(media, [None, Some(MediumId::new(0))]);
    let fog = "<medium type=\"homogeneous\" id=\"fog\"/>\n<emitter type=\"point\"><ref id=\"fog\"/></emitter>";
    let message = error(fog);
    assert!(
        message.contains("medium \"homogeneous\" scatters light"),
        "{message}"
    );
}

#[test]
fn media_with_a_hole_and_integrators_that_ignore_them_are_warned_of() {
    let warned = |form: &str, integrator: &str| -> Vec<String> {
        let parts = scene(&format!(
            "<integrator type=\"{integrator}\"/><shape type=\"{form}\"><medium type=\"homogeneous\" name=\"interior\">\
             {NO_ALBEDO}</medium></shape>"
        ))
        .unwrap();
        let scene = Scene::new(parts).unwrap();
        scene
            .warnings()
            .iter()
            .map(|it| it.message.clone())
            .collect()
    };
    assert_eq!(warned("sphere", "volpath"), [""; 0]);
    assert_eq!(warned("cube", "volpathmis"), [""; 0]);
    let open = warned("rectangle", "volpath");
    assert!(
        open.len() == 1 && open[0].contains("bounds a medium and has an edge"),
        "{open:?}"
    );
    let ignored = warned("sphere", "path");
    let expected = "Mitsuba's path takes no notice of them";
    assert!(
        ignored.len() == 1 && ignored[0].contains(expected),
        "{ignored:?}"
    );
}
