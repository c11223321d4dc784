//! Runs that the program refuses, or makes with a warning.

use std::path::PathBuf;

use super::folder::{Folder, nephroid, scene, text};

#[test]
fn beams_leave_light_of_rough_glass_out_with_a_warning_and_a_varying_mask_is_refused() {
    let folder = Folder::new();
    let scene = |floor: &str| {
        format!(
            "<scene version=\"3.0.0\"><emitter type=\"point\"><point name=\"position\" x=\"0\" y=\"0\" z=\"5\"/></emitter>\
             <shape type=\"sphere\" id=\"frosted\"><point name=\"center\" x=\"0\" y=\"0\" z=\"2\"/><bsdf type=\"roughdielectric\"/></shape>\
             <shape type=\"sphere\"><point name=\"center\" x=\"3\" y=\"0\" z=\"2\"/><bsdf type=\"dielectric\"/></shape>\
             <shape type=\"rectangle\" id=\"floor\">{floor}<sensor type=\"irradiancemeter\"><film type=\"hdrfilm\">\
             <integer name=\"width\" value=\"4\"/><integer name=\"height\" value=\"4\"/></film></sensor></shape></scene>"
        )
    };
    let exr = folder.path("a.exr").display().to_string();
    let rough = folder.write("rough.xml", &scene("<bsdf type=\"roughplastic\"/>"));
    for method in ["photons", "beams"] {
        let output = nephroid(&[
            "render", &rough, "--method", method, "--error", "30%", "-o", &exr,
        ]);
        let said = text(&output.stdout) + &text(&output.stderr);
        assert!(output.status.success(), "{said}");
        assert_eq!(
            said.contains(
                "light by way of frosted (roughdielectric), floor (roughplastic) is left out"
            ),
            method == "beams",
            "{said}"
        );
    }
    // Without a method photons are taken, since they follow all of it.
    let output = nephroid(&["render", &rough, "--error", "30%", "-o", &exr]);
    let said = text(&output.stdout) + &text(&output.stderr);
    assert!(output.status.success(), "{said}");
    assert!(
        said.contains("texels · photons") && !said.contains("left out"),
        "{said}"
    );
    let mask = "<bsdf type=\"mask\"><texture type=\"checkerboard\" name=\"opacity\"/><bsdf type=\"diffuse\"/></bsdf>";
    let masked = folder.write("masked.xml", &scene(mask));
    let output = nephroid(&["render", &masked, "--photons", "100", "-o", &exr]);
    assert_eq!(output.status.code(), Some(2));
    let said = text(&output.stderr);
    assert!(
        said.contains("shape \"floor\" has a mask whose opacity is a texture"),
        "{said}"
    );
}

#[test]
fn what_is_wrong_is_said_with_its_place_and_exits_with_2() {
    let folder = Folder::new();
    let rough = folder.write(
        "rough.xml",
        "<scene version=\"3.0.0\">\n  <shape type=\"sphere\">\n    <bsdf type=\"hair\"/>\n  </shape>\n</scene>\n",
    );
    let broken = folder.write(
        "broken.xml",
        "<scene version=\"3.0.0\">\n  <shape\n</scene>",
    );
    let no_meter = folder.write("empty.xml", "<scene version=\"3.0.0\"></scene>");
    let missing = folder.path("missing.xml").display().to_string();
    let glass_ball = scene("glass-ball.xml");
    let lit_by_a_lamp = scene("cornell-glass.xml");
    let cases: Vec<(Vec<&str>, Vec<&str>)> = vec![
        (
            vec!["render", &rough],
            vec!["rough.xml:3:5", "hair", "dielectric"],
        ),
        (vec!["render", &broken], vec!["broken.xml:"]),
        (vec!["render", &missing], vec!["missing.xml"]),
        (vec!["render", &no_meter], vec!["irradiancemeter", "none"]),
        (
            vec!["render", &glass_ball, "--sensor", "door"],
            vec!["\"door\"", "\"floor\"", "\"camera\""],
        ),
        (vec!["render", &glass_ball, "-o", "x.png"], vec![".exr"]),
        (
            vec![
                "render",
                &glass_ball,
                "--photons",
                "1",
                "-D",
                "size=8",
                "-o",
                "/no/such/folder/a.exr",
            ],
            vec!["/no/such/folder"],
        ),
        (vec!["render", &glass_ball, "--error=-1%"], vec!["--error"]),
        (vec!["render", &glass_ball, "--shard", "4/3"], vec!["1/3"]),
        (
            vec!["render", &glass_ball, "-D", "colour=red"],
            vec!["colour"],
        ),
        (
            vec!["render", &glass_ball, "--spp", "4", "--method", "beams"],
            vec![
                "beams",
                "\"--spp\"; it is one of path, full; there are error, time, rays",
            ],
        ),
        (
            vec!["render", &glass_ball, "--seed", "4", "--method", "beams"],
            vec!["beams", "\"--seed\"; it is one of photons, path"],
        ),
        (
            vec!["render", &lit_by_a_lamp, "--method", "beams"],
            vec!["emitter 0", "shape \"lamp-surface\"", "use photons"],
        ),
        (
            vec![
                "render",
                &glass_ball,
                "--method",
                "photons",
                "--set",
                "splat=fixed",
            ],
            vec!["\"splat\"; it is one of caustic-map"],
        ),
        (
            vec!["render", &glass_ball, "--photons", "0"],
            vec!["--photons is \"0\"", "whole numbers 1..="],
        ),
        (
            vec!["render", &glass_ball, "--set", "foo=1"],
            vec!["no setting is called \"foo\"", "photons", "splat"],
        ),
        (
            vec![
                "render",
                &glass_ball,
                "--photons",
                "9",
                "--set",
                "photons=8",
            ],
            vec!["photons is given twice, as \"9\" and as \"8\""],
        ),
        (
            vec!["attribute", &glass_ball, "--set", "map=9", "--set", "map=8"],
            vec!["map is given twice, as \"9\" and as \"8\""],
        ),
        (
            vec!["render", &glass_ball, "--method", "beam"],
            vec!["did you mean \"beams\"?", "closed-form"],
        ),
        (vec!["render"], vec!["SCENE"]),
        (vec!["generate", "teapot"], vec!["teapot", "glass-ball"]),
    ];
    for (arguments, expected) in cases {
        let output = nephroid(&arguments);
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
        for part in expected {
            assert!(
                message.contains(part),
                "{arguments:?}: {part} is not in {message}"
            );
        }
    }
}

#[test]
fn an_output_that_cannot_be_written_is_refused_before_the_run_with_its_cause_once() {
    let folder = Folder::new();
    let glass_ball = scene("glass-ball.xml");
    std::fs::create_dir(folder.path("folder.exr")).unwrap();
    std::fs::create_dir(folder.path("taken.png")).unwrap();
    let mut outputs = vec![folder.path("folder.exr"), folder.path("taken.exr")];
    if cfg!(target_os = "linux") {
        outputs.push(PathBuf::from("/proc/a.exr"));
    }
    for output in outputs {
        // A year's photons: the test would not end if the run began.
        let arguments = ["render", &glass_ball, "--photons", "281474976710656", "-o"];
        let output = output.to_str().unwrap();
        let done = nephroid(&[&arguments[..], &[output]].concat());
        let message = text(&done.stderr);
        assert_eq!(done.status.code(), Some(2), "{message}");
        assert!(message.contains("cannot write"), "{message}");
        let parts: Vec<&str> = message.trim().split(": ").collect();
        for part in &parts {
            let times = parts.iter().filter(|other| *other == part).count();
            assert_eq!(times, 1, "{message}");
        }
    }
    assert_eq!(std::fs::read_dir(folder.0.path()).unwrap().count(), 2);
}

#[test]
fn an_option_that_changes_the_method_is_noticed() {
    let folder = Folder::new();
    let path = folder.path("seed.exr");
    let note = |name: &str, more: &[&str]| {
        let scene = scene(name);
        let common = ["render", &scene, "-D", "size=8", "--error", "90%", "-o"];
        let output = nephroid(&[&common[..], &[path.to_str().unwrap()], more].concat());
        assert!(output.status.success(), "{}", text(&output.stderr));
        (text(&output.stdout), text(&output.stderr))
    };
    let (summary, notice) = note("glass-ball.xml", &["--seed", "3"]);
    assert!(summary.contains("· photons"), "{summary}");
    assert!(
        notice.starts_with("note: --seed") && notice.contains("beams"),
        "{notice}"
    );
    // Where it does what one would think, there is nothing to say.
    for more in [&["--seed", "3", "--method", "photons"][..], &[]] {
        assert_eq!(note("glass-ball.xml", more).1, "");
    }
    assert_eq!(note("cornell-glass.xml", &["--seed", "3"]).1, "");
}

#[test]
fn a_method_that_is_taken_because_beams_would_not_end_is_noticed() {
    let folder = Folder::new();
    let path = folder.path("bumpy.exr").display().to_string();
    let scene = scene("turntable-bumpy.xml");
    let notice = |more: &[&str]| {
        let common = ["render", &scene, "-o", &path];
        text(&nephroid(&[&common[..], more].concat()).stderr)
    };
    let asked = notice(&["--time", "1s"]);
    let told = "note: photons measure all light: beams would take about ";
    assert!(
        asked.starts_with(told) && asked.contains("to an error of 0.100 %"),
        "{asked}"
    );
    // Whoever says how many photons there are to be, expects photons.
    assert_eq!(notice(&["--photons", "4096"]), "");
}

#[test]
fn what_cannot_be_done_is_refused_before_the_run() {
    let folder = Folder::new();
    let path = folder.path("x.exr");
    let missing = folder.path("missing").join("x.exr");
    let glass_ball = scene("glass-ball.xml");
    let exr = path.to_str().unwrap();
    for (arguments, expected) in [
        (
            vec!["-D", "size=100000000", "-o", exr],
            "1 to 1048576 each way",
        ),
        (vec!["--photons", "0", "-o", exr], "--photons"),
        (
            vec!["--photons", "18446744073709551615", "-o", exr],
            "--photons",
        ),
        (
            vec!["--error", "1%", "--replicates", "1", "-o", exr],
            "at least 2 replicates",
        ),
        (vec!["-o", missing.to_str().unwrap()], "does not exist"),
    ] {
        let arguments: Vec<&str> = ["render", &glass_ball]
            .into_iter()
            .chain(arguments)
            .collect();
        let output = nephroid(&arguments);
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
        assert!(message.contains(expected), "{arguments:?}: {message}");
        assert!(!path.exists());
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_film_larger_than_the_memory_is_refused_with_what_it_takes() {
    let folder = Folder::new();
    let path = folder.path("huge.exr");
    // 2⁴⁰ texels of at least 400 bytes: no machine has that.
    let output = nephroid(&[
        "render",
        &scene("glass-ball.xml"),
        "-D",
        "size=1048576",
        "-o",
        path.to_str().unwrap(),
    ]);
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(message.contains("GB of memory"), "{message}");
    assert!(!path.exists());
}
