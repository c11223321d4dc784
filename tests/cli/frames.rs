//! `nephroid render --frames` and `nephroid inspect --method`, as typed.

use std::fs;
use std::path::Path;
use std::process::Output;

use assert_cmd::Command;
use nephroid::internals::film::{Image, exr};

/// A small caustics volume in the box.
const VOLUME: [&str; 10] = [
    "--method",
    "caustics-volume",
    "--set",
    "photons=400",
    "--set",
    "g-buffer=40",
    "--set",
    "slabs=2",
    "-D",
    "size=16",
];

fn nephroid(command: &str, scene: &str, more: &[&str]) -> Output {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    Command::cargo_bin("nephroid")
        .unwrap()
        .arg(command)
        .arg(scenes.join(scene))
        .args(more)
        .output()
        .unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// All values as bits: errors that are not known are NaN.
fn samples(image: &Image) -> Vec<(&str, Vec<u32>)> {
    let bits = |values: &[f32]| values.iter().map(|value| value.to_bits()).collect();
    let channels = image.channels.iter();
    channels
        .map(|channel| (channel.name.as_str(), bits(&channel.samples)))
        .collect()
}

/// Renders frames, and each of them by itself; all must have the same bits. Returns the table of counters.
fn frames_and_single_ones(
    scene: &str,
    common: &[&str],
    frames: &[&str],
    single: &[&[&str]],
) -> String {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).display().to_string();
    let all = file("all.exr");
    let mut more = common.to_vec();
    more.extend(["-o", &all]);
    for frame in frames {
        more.extend(["--frames", frame]);
    }
    let made = nephroid("render", scene, &more);
    assert!(made.status.success(), "{}", text(&made.stderr));
    assert!(!Path::new(&all).exists(), "frames have numbers");
    for (number, define) in (1..).zip(single) {
        let alone = file("alone.exr");
        let mut more = common.to_vec();
        more.extend(["-o", &alone]);
        more.extend(define.iter().flat_map(|one| ["-D", one]));
        let made = nephroid("render", scene, &more);
        assert!(made.status.success(), "{}", text(&made.stderr));
        let alone = exr::read(alone.as_ref()).unwrap();
        let frame = exr::read(file(&format!("all-{number:03}.exr")).as_ref()).unwrap();
        assert!(
            alone
                .channels
                .iter()
                .any(|it| it.samples.iter().any(|value| *value > 0.0))
        );
        assert!(
            samples(&alone) == samples(&frame),
            "{define:?} in {scene}, {common:?}"
        );
        assert!(Path::new(&file(&format!("all-{number:03}.png"))).exists());
    }
    assert!(!Path::new(&file(&format!("all-{:03}.exr", single.len() + 1))).exists());
    fs::read_to_string(file("all.csv")).unwrap()
}

#[test]
fn frames_have_the_bits_of_frames_by_themselves_and_unchanged_slabs_no_work() {
    let changed = [&VOLUME[..], &["--set", "update=changed"]].concat();
    // Two millimetres are within the box that the first frame has around the ball.
    let table = frames_and_single_ones(
        "cornell-caustics.xml",
        &changed,
        &[
            "lift = [0, 0.002, 0.3, 0.3]",
            "light_x = { from = 0, to = 0.2, count = 2 }",
        ],
        &[
            &["lift=0"],
            &["lift=0.002"],
            &["lift=0.3"],
            &["lift=0.3"],
            &["light_x=0"],
            &["light_x=0.2"],
        ],
    );
    let lines: Vec<Vec<&str>> = table
        .lines()
        .map(|line| line.split(',').collect())
        .collect();
    assert_eq!(
        lines[0][..6],
        ["frame", "lift", "light_x", "file", "mean", "photons"]
    );
    let column = |name: &str| lines[0].iter().position(|it| *it == name).unwrap();
    let of =
        |name: &str| -> Vec<&str> { lines[1..].iter().map(|line| line[column(name)]).collect() };
    assert_eq!(of("lift"), ["0", "0.002", "0.3", "0.3", "", ""]);
    assert_eq!(of("light_x"), ["", "", "", "", "0", "0.2"]);
    assert_eq!(of("file")[5], "all-006.exr");
    // The fourth frame is the third: the projectors' pass alone, and no picture.
    assert_eq!(of("passes"), ["3", "3", "3", "1", "3", "3"]);
    let texels = of("texels");
    assert!(texels[2] != "0" && texels[3] == "0", "{texels:?}");
}

#[test]
fn frames_of_methods_without_a_state_are_runs() {
    let turn = ["elevation=40", "elevation=80"];
    let tables: &[&str] = &[
        "--method",
        "local-irradiance",
        "--set",
        "photons=4096",
        "--set",
        "cells=16",
    ];
    for (scene, common) in [
        ("cornell-caustics.xml", &VOLUME[..]),
        (
            "glass-ball.xml",
            &["--method", "caustic-map", "--set", "photons=32"],
        ),
        (
            "water.xml",
            &["--method", "light-volume", "--set", "grid=12"],
        ),
        ("glass-ball.xml", &["--photons", "4096"]),
        ("turntable-ball.xml", tables),
    ] {
        let (frames, single): (&str, [&[&str]; 2]) = match scene {
            "turntable-ball.xml" => (
                "size = 8\nelevation = [40, 80]",
                [&["size=8", turn[0]], &["size=8", turn[1]]],
            ),
            _ => ("size = [8, 12]", [&["size=8"], &["size=12"]]),
        };
        // `-D` is for all frames, and a frame's own parameters go before it.
        let common: Vec<&str> = common
            .iter()
            .copied()
            .filter(|it| *it != "size=16" && *it != "-D")
            .collect();
        frames_and_single_ones(scene, &[&common[..]].concat(), &[frames], &single);
    }
}

#[test]
fn parameters_of_frames_go_before_those_of_all_frames() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("a.exr").display().to_string();
    let more = [
        "--method",
        "closed-form",
        "-D",
        "size=4",
        "--frames",
        "size = [8]",
        "-o",
        &out,
    ];
    let made = nephroid("render", "glass-ball.xml", &more);
    assert!(made.status.success(), "{}", text(&made.stderr));
    assert_eq!(
        exr::read(&folder.path().join("a-001.exr")).unwrap().width,
        8
    );
}

#[test]
fn frames_that_are_wrong_are_refused_with_their_place() {
    for (frames, says) in [
        ("lift = [0, 1", "--frames:1:"),
        ("", "parameters of the scene"),
        ("lift = { from = 0, to = 1 }", "by \"count\" from 2 on"),
        (
            "lift = { from = 0, to = 1, count = 1 }",
            "whole numbers 2..=1000",
        ),
        (
            "lift = { from = 0, to = 1, count = 3, step = 1 }",
            "a range has one of",
        ),
        (
            "size = { from = 1, to = 2000, step = 1 }",
            "more than 1000 values",
        ),
        ("nix = [0, 1]", "no $nix"),
    ] {
        let made = nephroid("render", "cornell-caustics.xml", &["--frames", frames]);
        let said = text(&made.stderr);
        assert_eq!(made.status.code(), Some(2), "{frames}: {said}");
        assert!(said.contains(says), "{frames}: {said}");
    }
}

#[test]
fn inspect_prints_a_pilots_advice_for_a_method_and_none_for_others() {
    let inspect = |more: &[&str]| {
        let found = nephroid("inspect", "prism.xml", more);
        (
            text(&found.stdout),
            text(&found.stderr),
            found.status.code(),
        )
    };
    let (said, _, code) = inspect(&["--method", "caustics-volume"]);
    assert_eq!(code, Some(0));
    // The frames agree: one slab has as much light as all surfaces, three have 7 to 9 % less.
    for line in [
        "  slabs=1: two surfaces a slab lose 0.00 % and make 0.00 % that is not there",
        "  slabs=3: two surfaces a slab lose 9.09 % and make 0.00 % that is not there",
        "  light leaves by z+ (entry) 0.00 %, z- 100.00 %",
        "(slabs=3): slabs=1 would lose 0.0 % of the light",
    ] {
        assert!(said.contains(line), "{line}: {said}");
    }
    let (said, _, _) = inspect(&["--method", "caustics-volume", "--set", "slabs=1"]);
    assert!(!said.contains("would lose"), "{said}");
    let (said, _, _) = inspect(&["--method", "beams", "--json"]);
    let found: serde_json::Value = serde_json::from_str(&said).unwrap();
    assert_eq!(found["advice"]["method"], "beams");
    assert_eq!(found["advice"]["lines"], serde_json::json!([]));
    let (said, _, _) = inspect(&[]);
    assert!(!said.contains("pilot"), "{said}");
    let (_, said, code) = inspect(&["--method", "light-volume"]);
    assert_eq!(code, Some(2), "{said}");
}
