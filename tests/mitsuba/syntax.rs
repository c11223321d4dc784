//! Syntax of Mitsuba's scene files: places, parameters, includes, old versions, and the hash.

use nephroid::internals::mitsuba::{load, load_leniently};
use nephroid::internals::radiometry::Rgb;
use nephroid::internals::scene::{Material, SceneParts};

use crate::support::scene_files::{Folder, error, scene, scene_of_version};

#[test]
fn errors_name_file_line_column_plugin_and_what_is_allowed() {
    let message = error("<shape type=\"sphere\">\n  <bsdf type=\"hair\"/>\n</shape>");
    assert_eq!(
        message,
        "scene.xml:3:3: bsdf \"hair\" is not modelled; modelled bsdfs are: \
         blendbsdf, bumpmap, conductor, dielectric, diffuse, mask, normalmap, null, plastic, principled, \
         principledthin, roughconductor, roughdielectric, roughplastic, thindielectric, twosided"
    );
    let message = error("<shape type=\"sphere\">\n<float name=\"radios\" value=\"2\"/></shape>");
    assert_eq!(
        message,
        "scene.xml:3:1: shape \"sphere\" has no parameter \"radios\"; did you mean \"radius\"? \
         (its parameters: center, flip_normals, radius, silhouette_sampling_weight, to_world)"
    );
}

/// Four problems: two parameters of one plugin, a plugin, and a mesh file.
const PROBLEMS: &str = "<shape type=\"sphere\"><float name=\"raduis\" value=\"1\"/><float name=\"mass\" value=\"2\"/></shape>\n\
    <shape type=\"sphere\"><bsdf type=\"velvet\"/></shape>\n\
    <shape type=\"ply\"><string name=\"filename\" value=\"none.ply\"/></shape>";

#[test]
fn all_problems_of_a_file_are_told_at_once_each_with_its_place() {
    let folder = Folder::new();
    let file = folder.write(
        "scene.xml",
        format!("<scene version=\"3.0.0\">\n{PROBLEMS}\n</scene>"),
    );
    let error = load(&file, &[]).unwrap_err();
    let told: Vec<(u32, &str)> = error
        .all()
        .map(|one| (one.at.line, one.message.as_str()))
        .collect();
    let begins = [
        (
            2,
            "shape \"sphere\" has no parameter \"raduis\"; did you mean \"radius\"?",
        ),
        (2, "shape \"sphere\" has no parameter \"mass\""),
        (3, "bsdf \"velvet\" is not modelled"),
        (4, "shape \"ply\", parameter \"filename\""),
    ];
    assert_eq!(told.len(), begins.len(), "{told:?}");
    for ((line, message), (expected, begin)) in told.into_iter().zip(begins) {
        assert_eq!(line, expected);
        assert!(message.starts_with(begin), "{message}");
    }
    let said = error.to_string();
    assert!(
        said.ends_with("(and 3 more: nephroid inspect lists them)"),
        "{said}"
    );
}

#[test]
fn mesh_files_that_cannot_be_read_are_all_named() {
    let folder = Folder::new();
    folder.write("a.ply", "no mesh");
    folder.write("b.obj", "f 1 2 3");
    let shapes = "<shape type=\"ply\"><string name=\"filename\" value=\"a.ply\"/></shape>\
        <shape type=\"obj\"><string name=\"filename\" value=\"b.obj\"/></shape>";
    let file = folder.write(
        "scene.xml",
        format!("<scene version=\"3.0.0\">{shapes}</scene>"),
    );
    let error = load(&file, &[]).unwrap_err();
    assert_eq!(error.all().count(), 2);
}

#[test]
fn unknown_parameters_are_left_out_of_a_lenient_reading_and_nothing_else_is() {
    let folder = Folder::new();
    let read = |elements: &str| {
        let file = folder.write(
            "scene.xml",
            format!("<scene version=\"3.0.0\">\n{elements}\n</scene>"),
        );
        load_leniently(&file, &[])
    };
    // A material that two shapes use is read twice, and warned of once.
    let odd = "<bsdf type=\"diffuse\" id=\"grey\"><float name=\"glow\" value=\"1\"/></bsdf>\n\
        <shape type=\"sphere\"><float name=\"mass\" value=\"2\"/><ref id=\"grey\"/></shape>\n\
        <shape type=\"disk\"><ref id=\"grey\"/></shape>";
    let scene = read(odd).unwrap();
    let told: Vec<String> = scene
        .warnings()
        .iter()
        .map(|one| format!("{} {}", one.at.as_ref().unwrap().line, one.message))
        .collect();
    assert_eq!(told.len(), 2, "{told:?}");
    let left_out = |begin: &str| {
        told.iter()
            .any(|one| one.starts_with(begin) && one.ends_with("it is left out"))
    };
    assert!(
        left_out("2 bsdf \"diffuse\" has no parameter \"glow\"")
            && left_out("3 shape \"sphere\" has no parameter \"mass\""),
        "{told:?}"
    );
    // What is known must be right, plugins must be modelled, and objects be where they can be.
    for wrong in [
        "<shape type=\"sphere\"><string name=\"radius\" value=\"1\"/></shape>",
        "<bsdf type=\"velvet\" id=\"it\"/><shape type=\"sphere\"><ref id=\"it\"/></shape>",
        "<bsdf type=\"diffuse\" id=\"it\"><shape type=\"sphere\"/></bsdf><shape type=\"sphere\"><ref id=\"it\"/></shape>",
    ] {
        assert!(read(wrong).is_err(), "{wrong}");
    }
}

#[test]
fn malformed_files_are_errors_with_a_place() {
    for (text, expected) in [
        ("", "scene.xml:1:1: not well-formed XML"),
        (
            "<scene version=\"3.0.0\">\n<shape>\n</scene>",
            "scene.xml:3:1: not well-formed XML",
        ),
        (
            "<scene/>",
            "scene.xml:1:1: the outermost element needs a version",
        ),
        (
            "<scene version=\"three\"/>",
            "scene.xml:1:1: the outermost element needs a version",
        ),
        (
            "<shape version=\"3.0.0\" type=\"sphere\"/>",
            "scene.xml:1:1: the outermost element must be <scene>",
        ),
        (
            "<!DOCTYPE scene [<!ENTITY a \"b\">]><scene version=\"3.0.0\"/>",
            "scene.xml:1:1: not well-formed XML: ",
        ),
    ] {
        let folder = Folder::new();
        folder.write("scene.xml", text);
        let message = folder.load("scene.xml", &[]).unwrap_err();
        assert!(
            message.starts_with(expected),
            "{message:?} does not begin with {expected:?}"
        );
    }
    let folder = Folder::new();
    let missing = folder.load("none.xml", &[]).unwrap_err();
    assert!(
        missing.starts_with("none.xml: cannot be read: ")
            && missing.matches("none.xml").count() == 1,
        "{missing}"
    );
    folder.write("scene.xml", b"<scene version=\"3.0.0\">\n\xff</scene>");
    assert!(
        folder
            .load("scene.xml", &[])
            .unwrap_err()
            .contains("line 2 is not UTF-8")
    );
}

#[test]
fn elements_that_cannot_be_are_named_with_their_place() {
    for (elements, expected) in [
        (
            "<shap type=\"sphere\"/>",
            "scene.xml:2:1: <shap>: this tag is not known; did you mean \"shape\"?",
        ),
        (
            "<shape/>",
            "scene.xml:2:1: <shape>: the attribute \"type\" is missing",
        ),
        (
            "<shape type=\"sphere\" tipe=\"x\"/>",
            "scene.xml:2:1: <shape>: the attribute \"tipe\" is not known here",
        ),
        (
            "<float name=\"a\" value=\"1\"/>",
            "scene.xml:2:1: scene has no parameter \"a\"",
        ),
        (
            "<shape type=\"sphere\"><float name=\"radius\"/></shape>",
            "scene.xml:2:22: <float>: the attribute \"value\" is missing",
        ),
        (
            "<shape type=\"sphere\"><float name=\"radius\" value=\"x\"/></shape>",
            "scene.xml:2:22: <float>: \"x\" is not a number",
        ),
        (
            "<shape type=\"sphere\"><float name=\"radius\" value=\"1\"><rgb/></float></shape>",
            "scene.xml:2:53: <rgb> cannot be inside <float>",
        ),
        (
            "<shape type=\"sphere\"><float name=\"radius\" value=\"1\"/>\n<float name=\"radius\" value=\"2\"/></shape>",
            "scene.xml:3:1: <float>: \"radius\" was given in line 2 already",
        ),
        (
            "<shape type=\"sphere\"><point name=\"center\" x=\"1\" y=\"2\"/></shape>",
            "scene.xml:2:22: <point>: the attribute \"z\" is missing",
        ),
        (
            "<shape type=\"sphere\"><transform name=\"to_world\"><turn/></transform></shape>",
            "scene.xml:2:49: <turn>: a transform is made of translate",
        ),
        (
            "<shape type=\"sphere\"><string name=\"radius\" value=\"1\"/></shape>",
            "scene.xml:2:22: shape \"sphere\", parameter \"radius\": must be a float, not a string",
        ),
        (
            "<ref id=\"glas\"/><bsdf type=\"diffuse\" id=\"glass\"/>",
            "scene.xml:2:1: no object has the id \"glas\"; did you mean \"glass\"?",
        ),
        (
            "<bsdf type=\"diffuse\" id=\"a\"/>\n<bsdf type=\"diffuse\" id=\"a\"/>",
            "scene.xml:3:1: the id \"a\" is taken by scene.xml:2:1",
        ),
        (
            "<alias id=\"a\" as=\"b\"/>",
            "scene.xml:2:1: <alias>: no object before it has the id \"a\"",
        ),
        (
            "<path value=\"nowhere\"/>",
            "scene.xml:2:1: <path>: there is no folder nowhere",
        ),
        (
            "<include filename=\"nowhere.xml\"/>",
            "scene.xml:2:1: <include>: there is no file nowhere.xml",
        ),
        (
            "<include filename=\"scene.xml\"/>",
            "scene.xml:2:1: <include>: scene.xml includes itself",
        ),
        (
            "<film type=\"$kind\"/>",
            "scene.xml:2:1: parameter $kind has no value",
        ),
    ] {
        let message = error(elements);
        assert!(
            message.starts_with(expected),
            "{message:?} does not begin with {expected:?}"
        );
    }
}

#[test]
fn parameters_come_from_the_caller_then_from_the_first_default() {
    let folder = Folder::new();
    let text = "<scene version=\"3.0.0\"><default name=\"r\" value=\"2\"/><default name=\"r\" value=\"3\"/>\
                <shape type=\"sphere\"><float name=\"radius\" value=\"$r\"/></shape></scene>";
    folder.write("scene.xml", text);
    let radius = |parts: SceneParts| parts.shapes[0].bounds().max.x.round();
    assert_eq!(radius(folder.load("scene.xml", &[]).unwrap()), 2.0);
    assert_eq!(
        radius(folder.load("scene.xml", &[("r", "5")]).unwrap()),
        5.0
    );
    let message = folder.load("scene.xml", &[("radius", "5")]).unwrap_err();
    assert_eq!(
        message,
        "scene.xml: the parameter \"radius\" was given, but the file uses no $radius"
    );
}

#[test]
fn includes_aliases_references_and_paths_are_followed() {
    let folder = Folder::new();
    folder.write(
        "meshes/triangle.obj",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
    );
    folder.write("parts/glass.xml", "<scene version=\"3.0.0\"><bsdf type=\"dielectric\" id=\"glass\"/><alias id=\"glass\" as=\"window\"/></scene>");
    folder.write(
        "parts/ball.xml",
        "<shape version=\"3.0.0\" type=\"sphere\" id=\"ball\"><ref id=\"window\"/></shape>",
    );
    folder.write(
        "scene.xml",
        "<scene version=\"3.0.0\"><path value=\"meshes\"/><include filename=\"parts/glass.xml\"/>\
         <include filename=\"parts/ball.xml\"/><shape type=\"obj\"><string name=\"filename\" value=\"triangle.obj\"/>\
         <ref name=\"whatever\" id=\"glass\"/></shape></scene>",
    );
    let parts = folder.load("scene.xml", &[]).unwrap();
    let ids: Vec<_> = parts
        .objects
        .iter()
        .map(|object| object.id.as_str())
        .collect();
    assert_eq!(ids, ["ball", "obj_0"]);
    assert_eq!(
        parts.objects[0].declared_at.file,
        folder.path().join("parts/ball.xml")
    );
    // One material, used twice.
    assert_eq!(parts.materials.len(), 1);
    assert!(matches!(parts.materials[0], Material::Dielectric { .. }));
}

#[test]
fn nesting_without_end_is_an_error_not_a_crash() {
    let deep = "<shape type=\"shapegroup\">".repeat(100_000);
    let message = error(&format!("{deep}{}", "</shape>".repeat(100_000)));
    assert!(
        message.contains("elements nest more than 64 levels deep"),
        "{message}"
    );
    let chain: String = (0..100_000)
        .map(|n| {
            format!(
                "<bsdf type=\"mask\" id=\"b{n}\"><ref id=\"b{}\"/></bsdf>\n",
                n + 1
            )
        })
        .chain(["<bsdf type=\"diffuse\" id=\"b100000\"/>".to_owned()])
        .collect();
    assert!(error(&chain).contains("more than 64 levels deep"));
    let reversed: String = chain
        .lines()
        .rev()
        .map(|line| format!("{line}\n"))
        .collect();
    assert!(error(&reversed).contains("more than 64 levels deep"));
    let crowd: String = (0..100_000).map(|n| format!(" a{n}=\"\"")).collect();
    assert_eq!(
        error(&format!("<shape{crowd}/>")),
        "scene.xml:2:1: an element with more than 64 attributes"
    );
    let ring = "<bsdf type=\"mask\" id=\"a\"><ref id=\"b\"/></bsdf><bsdf type=\"twosided\" id=\"b\"><ref id=\"a\"/></bsdf>";
    assert!(error(ring).contains("bsdf \"a\" holds itself through references"));
    let folder = Folder::new();
    for n in 0..20 {
        folder.write(
            &format!("{n}.xml"),
            format!(
                "<scene version=\"3.0.0\"><include filename=\"{}.xml\"/></scene>",
                n + 1
            ),
        );
    }
    assert!(
        folder
            .load("0.xml", &[])
            .unwrap_err()
            .contains("more than 15 levels deep")
    );
}

#[test]
fn old_files_mean_the_same_as_new_ones() {
    let old = "<sensor type=\"perspective\"><transform name=\"toWorld\"><lookAt origin=\"0 0 5\" target=\"0 0 0\" up=\"0 1 0\"/></transform>\
               <string name=\"fovAxis\" value=\"y\"/><float name=\"fov\" value=\"30\"/><film type=\"ldrfilm\"><boolean name=\"banner\" value=\"false\"/>\
               <float name=\"gamma\" value=\"2.2\"/></film></sensor>\
               <shape type=\"sphere\"><bsdf type=\"dielectric\"><float name=\"intIOR\" value=\"1.5\"/><string name=\"extIOR\" value=\"vacuum\"/>\
               <spectrum name=\"specularTransmittance\" value=\"0.5, 0.25, 1\"/></bsdf></shape>\
               <shape type=\"disk\"><bsdf type=\"diffuse\"><srgb name=\"diffuseReflectance\" value=\"#ffffff\"/></bsdf></shape>";
    let new = "<sensor type=\"perspective\"><transform name=\"to_world\"><lookat origin=\"0 0 5\" target=\"0 0 0\" up=\"0 1 0\"/></transform>\
               <string name=\"fov_axis\" value=\"y\"/><float name=\"fov\" value=\"30\"/><film type=\"hdrfilm\"/></sensor>\
               <shape type=\"sphere\"><bsdf type=\"dielectric\"><float name=\"int_ior\" value=\"1.5\"/><string name=\"ext_ior\" value=\"vacuum\"/>\
               <rgb name=\"specular_transmittance\" value=\"0.5, 0.25, 1\"/></bsdf></shape>\
               <shape type=\"disk\"><bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"1\"/></bsdf></shape>";
    let (old, new) = (scene_of_version("0.6.0", old).unwrap(), scene(new).unwrap());
    assert_eq!(old.sensors, new.sensors);
    assert_eq!(old.materials, new.materials);
}

#[test]
fn old_spellings_are_errors_in_new_files() {
    let lens = "<shape type=\"sphere\"><bsdf type=\"dielectric\"><float name=\"intIOR\" value=\"1.5\"/></bsdf></shape>";
    assert!(error(lens).contains("no parameter \"intIOR\"; did you mean \"int_ior\"?"));
    assert!(error("<shape type=\"disk\"><bsdf type=\"diffuse\"><srgb name=\"reflectance\" value=\"1\"/></bsdf></shape>").contains("<srgb>: this tag is not known"));
    assert!(
        error("<sensor type=\"perspective\"><film type=\"ldrfilm\"/></sensor>")
            .contains("the modelled film is hdrfilm")
    );
}

#[test]
fn an_old_conductors_surroundings_divide_its_index() {
    let text = "<shape type=\"sphere\"><bsdf type=\"conductor\"><string name=\"material\" value=\"Al\"/><float name=\"extEta\" value=\"2\"/></bsdf></shape>";
    let parts = scene_of_version("0.6.0", text).unwrap();
    let Material::Conductor { eta, .. } = parts.materials[0] else {
        panic!("not a conductor")
    };
    assert_eq!(eta, Rgb([1.6575, 0.880405, 0.521244]) / 2.0);
}

#[test]
fn the_hash_follows_contents_and_parameters_and_nothing_else() {
    let hash = |contents: &str, parameters: &[(&str, &str)], name: &str| {
        let folder = Folder::new();
        folder.write("mesh.obj", contents);
        let text = "<scene version=\"3.0.0\"><default name=\"r\" value=\"1\"/><shape type=\"sphere\"><float name=\"radius\" value=\"$r\"/></shape>\
                    <shape type=\"obj\"><string name=\"filename\" value=\"mesh.obj\"/></shape></scene>";
        folder.write(name, text);
        folder.load(name, parameters).unwrap().content_hash
    };
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let first = hash(triangle, &[], "a.xml");
    assert_eq!(first.len(), 64);
    assert_eq!(first, hash(triangle, &[], "sub/../b.xml"));
    assert_ne!(
        first,
        hash(
            &triangle.replace('1', "2").replace("f 2 2", "f 1 2"),
            &[],
            "a.xml"
        )
    );
    assert_ne!(first, hash(triangle, &[("r", "1")], "a.xml"));
}

#[test]
fn made_up_ids_avoid_those_of_the_file() {
    let parts = scene(
        "<shape type=\"sphere\"/><shape type=\"sphere\" id=\"sphere_1\"/><shape type=\"sphere\"/>",
    )
    .unwrap();
    let ids: Vec<_> = parts
        .objects
        .iter()
        .map(|object| object.id.as_str())
        .collect();
    assert_eq!(ids, ["sphere_0", "sphere_1", "sphere_2"]);
}
