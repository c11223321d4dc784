//! Results have the same bits whatever the processor and the C library: `numeric::math` has functions of its
//! own.
//!
//! glibc chooses the forms of its functions by processor, and the variable `GLIBC_TUNABLES` hides parts of a
//! processor from it. So one machine plays two. The variable must be set before a program starts, and takes
//! part in nothing else that it does.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use assert_cmd::Command;
use nephroid::internals::film::exr;

/// Hides fused multiply-add and wide vectors from glibc, as on a processor of 2011.
const OLDER: &str = "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4,-AVX512F";

/// Glass and mirrors, one and many surfaces, meshes and formulas, light of a point, a direction and an area.
const SCENES: [&str; 6] = [
    "glass-ball",
    "mirror-ring",
    "coffee-cup",
    "water",
    "cornell-glass",
    "turntable-prism",
];

/// All methods, on films so small that all of this takes about a minute of one core.
const METHODS: [(&str, &str); 12] = [
    ("beams", "--error 10%"),
    ("beams", "--error 30% --max-depth 3 --sensor camera"),
    ("photons", "--photons 65536"),
    ("photons", "--photons 32768 --sensor camera"),
    ("path", "--spp 2 --replicates 2 --sensor camera"),
    (
        "photon-map",
        "--map-photons 1024 --photons 2048 --replicates 2 --sensor camera",
    ),
    (
        "full",
        "--spp 2 --replicates 2 --photons 4096 --map-photons 1024 --error 50% --max-depth 3 --sensor camera",
    ),
    ("closed-form", ""),
    ("caustic-map", "--set photons=64 --set map=64"),
    ("light-volume", ""),
    (
        "caustics-volume",
        "--set photons=400 --set g-buffer=40 --set slabs=2",
    ),
    ("local-irradiance", "--set photons=4096"),
];

/// Keys of JSON that hold times, and paths of folders.
const LEFT_OUT: [&str; 4] = ["seconds", "timing", "scene", "command"];

/// The program in a folder of its own, as on an older processor or on this one.
fn nephroid(folder: &Path, is_older: bool, words: &str) -> (i32, Vec<u8>, String) {
    let mut command = Command::cargo_bin("nephroid").unwrap();
    command.current_dir(folder).args(words.split_whitespace());
    match is_older {
        true => command.env("GLIBC_TUNABLES", OLDER),
        false => command.env_remove("GLIBC_TUNABLES"),
    };
    let output = command.output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    (output.status.code().unwrap(), output.stdout, said)
}

/// What the standard library's functions give, as a number for all bits.
#[test]
#[ignore = "a part of the tests of this file, which start it in a process of its own"]
fn standard_functions() {
    let mut hash: u64 = 0;
    for i in 0..100_000 {
        let x = 0.003 + f64::from(i) * 1.000_1e-4;
        for value in [x.sin(), x.cos(), x.exp(), x.ln(), x.atan(), x.tan()] {
            hash = hash.rotate_left(5).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ value.to_bits();
        }
    }
    println!("standard functions {hash:016x}");
}

/// True if the variable changes what the C library computes. If it does not, there is nothing to compare, and
/// the reason is printed.
fn can_be_older() -> bool {
    let run = |is_older: bool| {
        let mut command = Command::new(std::env::current_exe().unwrap());
        command.args([
            "same_bits::standard_functions",
            "--exact",
            "--ignored",
            "--nocapture",
        ]);
        match is_older {
            true => command.env("GLIBC_TUNABLES", OLDER),
            false => command.env_remove("GLIBC_TUNABLES"),
        };
        let said = String::from_utf8(command.output().unwrap().stdout).unwrap();
        let hash = said
            .split("standard functions ")
            .nth(1)
            .unwrap_or_else(|| panic!("{said}"));
        hash[..16].to_owned()
    };
    let is_gnu = cfg!(all(
        target_os = "linux",
        target_env = "gnu",
        target_arch = "x86_64"
    ));
    let can = is_gnu && run(false) != run(true);
    if !can {
        println!("skipped: GLIBC_TUNABLES changes no function of this system's C library");
    }
    can
}

/// JSON without what is never the same twice.
fn without_time(json: &[u8]) -> serde_json::Value {
    fn strip(value: &mut serde_json::Value) {
        match value {
            serde_json::Value::Object(map) => {
                map.retain(|key, _| !LEFT_OUT.iter().any(|one| key.contains(one)));
                map.values_mut().for_each(strip);
            }
            serde_json::Value::Array(all) => all.iter_mut().for_each(strip),
            _ => (),
        }
    }
    let mut value = serde_json::from_slice(json).unwrap();
    strip(&mut value);
    value
}

/// Bits of each channel of an image.
fn channels(path: &Path) -> BTreeMap<String, Vec<u32>> {
    let image = exr::read(path).unwrap();
    let bits = |samples: &[f32]| samples.iter().map(|value| value.to_bits()).collect();
    let channels = image.channels.iter();
    channels
        .map(|one| (one.name.clone(), bits(&one.samples)))
        .collect()
}

/// Films, pictures and summaries of all methods; returns by how many methods each scene was rendered.
fn films(scene: &str) -> Vec<&'static str> {
    let folder = tempfile::tempdir().unwrap();
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let file = |name: &str| folder.path().join(name);
    let mut rendered = Vec::new();
    for (method, settings) in METHODS {
        let results = [false, true].map(|is_older| {
            let words = format!(
                "render {}/{scene}.xml -D size=24 --method {method} {settings} --json -o film.exr",
                scenes.display()
            );
            let (code, json, said) = nephroid(folder.path(), is_older, &words);
            if code != 0 {
                // A refusal, and not a mistake of this test.
                assert_eq!(code, 2, "{scene} by {method}: {said}");
                return Err(said);
            }
            let result = (
                channels(&file("film.exr")),
                fs::read(file("film.png")).unwrap(),
                without_time(&json),
            );
            fs::remove_file(file("film.exr")).unwrap();
            fs::remove_file(file("film.png")).unwrap();
            Ok(result)
        });
        let [here, older] = results;
        assert!(here == older, "{scene} by {method} {settings}: bits differ");
        if here.is_ok() && !rendered.contains(&method) {
            rendered.push(method);
        }
    }
    rendered
}

#[test]
fn films_have_the_same_bits_on_an_older_processor() {
    if !can_be_older() {
        return;
    }
    let mut rendered: Vec<&str> = SCENES.into_iter().flat_map(films).collect();
    rendered.sort_unstable();
    rendered.dedup();
    let mut all: Vec<&str> = METHODS.iter().map(|(method, _)| *method).collect();
    all.sort_unstable();
    all.dedup();
    assert_eq!(rendered, all, "a method is in no comparison");
}

#[test]
fn shards_have_the_same_bytes_on_an_older_processor() {
    if !can_be_older() {
        return;
    }
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let folder = tempfile::tempdir().unwrap();
    for scene in SCENES {
        let [here, older] = [false, true].map(|is_older| {
            let words = format!(
                "render {}/{scene}.xml -D size=32 --photons 262144 --shard 1/2 -o part.shard",
                scenes.display()
            );
            let (code, _, said) = nephroid(folder.path(), is_older, &words);
            assert_eq!(code, 0, "{said}");
            fs::read(folder.path().join("part.shard")).unwrap()
        });
        assert!(here == older, "the shards of {scene} differ");
    }
}

#[test]
fn a_study_has_the_same_report_on_an_older_processor() {
    if !can_be_older() {
        return;
    }
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let folder = tempfile::tempdir().unwrap();
    let study = format!(
        r#"
scene = "{}/mirror-ring.xml"
define = {{ size = 16 }}
margin = "5%"
[truth]
method = "beams"
error = "2%"
[[method]]
method = "beams"
error = "20%"
[[method]]
method = "photons"
photons = {{ from = 4096, to = 65536, times = 4 }}
[[method]]
method = "caustic-map"
mode = "reflection"
photons = 64
map = 64
"#,
        scenes.display()
    );
    fs::write(folder.path().join("study.toml"), study).unwrap();
    let reports = [(false, "here"), (true, "older")].map(|(is_older, report)| {
        let words = format!("validate study.toml -o {report}");
        let (code, _, said) = nephroid(folder.path(), is_older, &words);
        assert_eq!(code, 0, "{said}");
        fs::read(folder.path().join(report).join("report.json")).unwrap()
    });
    assert!(reports[0] == reports[1], "report.json differs");
}
