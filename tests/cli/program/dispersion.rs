//! The flag `--dispersion`: what a run with it writes and says, and what it cannot be.

use nephroid::internals::film::exr;
use serde_json::Value;

use super::folder::{Folder, nephroid, scene, text};

#[test]
fn a_render_says_which_glass_it_had_in_summary_json_and_file() {
    let folder = Folder::new();
    let path = folder.path("rainbow.exr");
    let run = |more: &[&str]| {
        let scene = scene("rainbow.xml");
        let path = path.to_str().unwrap();
        let flags = [
            "render",
            &scene,
            "-D",
            "size=16",
            "--photons",
            "200000",
            "-o",
            path,
        ];
        let output = nephroid(&[&flags[..], more].concat());
        assert!(output.status.success(), "{}", text(&output.stderr));
        text(&output.stdout)
    };
    let said = run(&["--dispersion", "prism=sf11"]);
    for expected in [
        "photons",
        "dispersion: prism is sf11 (n_d 1.78472, Abbe number 25.76); wavelengths from 380 to 780 nm",
        "white is D65",
    ] {
        assert!(said.contains(expected), "{expected} in {said}");
    }
    let image = exr::read(&path).unwrap();
    assert_eq!(image.metadata("dispersion"), Some("{\"prism\":\"sf11\"}"));
    assert!(image.metadata("wavelengths").unwrap().contains("D65"));
    assert!(
        image
            .metadata("conventions")
            .unwrap()
            .contains("may be below zero")
    );
    // Green light has less than no red.
    let red = image.channel("E.R").unwrap();
    assert!(red.samples.iter().any(|value| *value < 0.0));
    assert!(image.channel("E.lo.R").is_none() && image.channel("E.stderr.R").is_some());
    let coloured = std::fs::read(path.with_extension("png")).unwrap();

    let json: Value =
        serde_json::from_str(&run(&["--dispersion", "prism=sf11", "--json"])).unwrap();
    assert_eq!(json["dispersion"]["prism"], "sf11");
    let plain: Value = serde_json::from_str(&run(&["--method", "photons", "--json"])).unwrap();
    assert!(plain.get("dispersion").is_none() && plain.get("wavelengths").is_none());
    assert!(exr::read(&path).unwrap().metadata("dispersion").is_none());
    assert_ne!(coloured, std::fs::read(path.with_extension("png")).unwrap());
}

#[test]
fn what_cannot_be_dispersed_is_said_and_exits_with_2() {
    let folder = Folder::new();
    let path = folder.path("a.exr").display().to_string();
    let prism = scene("prism.xml");
    for (command, more, expected) in [
        (
            "render",
            ["--dispersion", "prysm=bk7"],
            "no bsdf and no shape has the id \"prysm\"; did you mean \"prism\"?",
        ),
        (
            "render",
            ["--dispersion", "prism=bk8"],
            "no glass is called \"bk8\"; did you mean \"bk7\"?; known are bk7",
        ),
        (
            "render",
            ["--dispersion", "prism"],
            "give ID=GLASS, as in prism=bk7",
        ),
        (
            "render",
            ["--dispersion", "prism=cauchy:0.01"],
            "the index at 380 nm is 0.01",
        ),
        (
            "render",
            ["--dispersion", "floor-surface=bk7"],
            "is of plugin diffuse",
        ),
    ] {
        let output = nephroid(&[&[command, &prism, "-o", &path], &more[..]].concat());
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains(expected), "{expected} in {said}");
    }
    let dispersed = ["--dispersion", "prism=bk7"];
    let probe = [&["probe", &prism, "--at", "0.5,0.5"], &dispersed[..]].concat();
    let said = text(&nephroid(&probe).stderr);
    assert!(
        said.contains("light of each wavelength has a path of its own"),
        "{said}"
    );
    let beams = [
        &["render", &prism, "-o", &path, "--method", "beams"],
        &dispersed[..],
    ]
    .concat();
    let said = text(&nephroid(&beams).stderr);
    assert!(said.contains("the method beams knows one index"), "{said}");
    let inspect = [&["inspect", &prism], &dispersed[..]].concat();
    let said = text(&nephroid(&inspect).stdout);
    assert!(said.contains("yes  dispersion: prism is bk7"), "{said}");
    assert!(!folder.path("a.exr").exists());
}
