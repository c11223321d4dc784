//! `nephroid compare` as a user meets it: exit codes, tables, JSON, maps, messages.

use std::path::Path;
use std::process::Output;

use assert_cmd::Command;
use nephroid::internals::film::{Image, exr};
use nephroid::internals::metric::{CompareImage, CompareSettings, compare};

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> String {
        self.0.path().join(name).display().to_string()
    }

    fn write(&self, name: &str, image: &Image) -> String {
        let path = self.path(name);
        exr::write(path.as_ref(), image).unwrap();
        path
    }

    /// Runs `nephroid compare` in this folder.
    fn compare(&self, arguments: &[&str]) -> Output {
        Command::cargo_bin("nephroid")
            .unwrap()
            .current_dir(self.0.path())
            .arg("compare")
            .args(arguments)
            .output()
            .unwrap()
    }

    fn json(&self, arguments: &[&str]) -> (serde_json::Value, Option<i32>) {
        let arguments: Vec<&str> = arguments.iter().copied().chain(["--json"]).collect();
        let output = self.compare(&arguments);
        let report = serde_json::from_slice(&output.stdout);
        (
            report.unwrap_or_else(|_| panic!("{}", text(&output.stderr))),
            output.status.code(),
        )
    }
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

const SIZE: usize = 40;

/// Light with contrast and colour at a texel.
fn light(i: usize) -> [f64; 3] {
    let (x, y) = ((i % SIZE) as f64, (i / SIZE) as f64);
    let ring = 0.05 + 20.0 / (1.0 + ((x - 20.0).hypot(y - 18.0) - 9.0).powi(2));
    [ring, 0.8 * ring, 0.3 * ring + 0.01 * x]
}

/// An image as `nephroid render` writes it, all light times `factor`, with standard errors of 2 %.
fn rendered(factor: f64) -> Image {
    let mut image = Image::new(SIZE, SIZE);
    let scaled = |part: f64| -> Vec<[f64; 3]> {
        (0..SIZE * SIZE)
            .map(|i| light(i).map(|v| part * v))
            .collect()
    };
    // Factors on what a file holds, so that the copy is brighter by exactly that.
    let stored = |values: Vec<[f64; 3]>| -> Vec<[f64; 3]> {
        values
            .into_iter()
            .map(|rgb| rgb.map(|v| factor * f64::from(v as f32)))
            .collect()
    };
    for (layer, part) in [("E", 1.0), ("LD", 0.25), ("LTTD", 0.75)] {
        image.add_rgb(layer, &stored(scaled(part)));
        image.add_rgb(&format!("{layer}.stderr"), &scaled(0.02 * part));
    }
    image.add_scalar("count.Y", (0..SIZE * SIZE).map(|i| i as f64));
    image.add_metadata("settings", r#"{"replicates":32}"#);
    image.add_metadata("unit", "W/m²");
    image
}

/// An image as Mitsuba writes it: red, green and blue.
fn plain(value: impl Fn(usize) -> [f64; 3]) -> Image {
    let mut image = Image::new(SIZE, SIZE);
    image.add_rgb("", &(0..SIZE * SIZE).map(value).collect::<Vec<_>>());
    image
}

#[test]
fn a_file_and_itself_differ_in_nothing_and_the_exit_code_is_0() {
    let folder = Folder::new();
    folder.write("a.exr", &rendered(1.0));
    let (report, code) = folder.json(&["a.exr", "a.exr", "--margin", "0.5%"]);
    assert_eq!(code, Some(0));
    let layers = report["layers"].as_array().unwrap();
    let names: Vec<&str> = layers
        .iter()
        .map(|it| it["layer"].as_str().unwrap())
        .collect();
    assert_eq!(names, ["E", "LD", "LTTD"]);
    for layer in layers {
        let difference = &layer["difference"];
        for zero in ["rmse", "relative_rmse", "rel_mse", "smape", "mae"] {
            assert_eq!(difference[zero], 0.0, "{zero}");
        }
        assert_eq!(difference["energy_ratio"], 1.0);
        assert_eq!(difference["worst"]["difference"], 0.0);
        assert_eq!(layer["flip"]["mean"], 0.0);
        assert_eq!(layer["similarity"]["ssim"], 1.0);
        assert_eq!(layer["equivalence"]["bias"]["relative"], 0.0);
        assert_eq!(layer["equivalence"]["verdict"], "equivalent");
    }
    assert_eq!(report["verdict"], "equivalent");
    assert_eq!(report["unit"], "W/m²");
}

#[test]
fn a_copy_brighter_by_1_percent_has_that_bias_and_is_different_at_a_margin_of_half_a_percent() {
    let folder = Folder::new();
    folder.write("a.exr", &rendered(1.0));
    folder.write("b.exr", &rendered(1.01));
    let (report, code) = folder.json(&["a.exr", "b.exr", "--margin", "0.5%"]);
    assert_eq!(code, Some(1));
    assert_eq!(report["verdict"], "different");
    for layer in report["layers"].as_array().unwrap() {
        let bias = &layer["equivalence"]["bias"];
        // Stored as f32, each texel is right to 6e-8.
        assert!((bias["relative"].as_f64().unwrap() - 0.01).abs() < 1e-7);
        assert_eq!(bias["verdict"], "different");
        let difference = &layer["difference"];
        assert!((difference["energy_ratio"].as_f64().unwrap() - 1.01).abs() < 1e-7);
    }
    let (report, code) = folder.json(&["a.exr", "b.exr", "--margin", "2%"]);
    assert_eq!(
        (code, report["verdict"].as_str()),
        (Some(0), Some("equivalent"))
    );
    // The other way round the truth is the brighter one.
    let (report, _) = folder.json(&["a.exr", "b.exr", "--reference", "b"]);
    let bias = report["layers"][0]["equivalence"]["bias"]["relative"]
        .as_f64()
        .unwrap();
    assert!((bias - (1.0 / 1.01 - 1.0)).abs() < 1e-7);
    let output = folder.compare(&["a.exr", "b.exr", "--margin", "0.5%"]);
    let table = text(&output.stdout);
    for expected in [
        "a.exr (reference) · B b.exr · 40 x 40 texels",
        "means [W/m²]",
        "+1.0000 %",
        "1.010000",
        "within 0.5 % of the reference's mean?",
        "verdict at 0.5 %: different",
        "window of 11 x 11 texels",
        "HDR-FLIP, 67.0 pixels a degree",
    ] {
        assert!(table.contains(expected), "{expected} in {table}");
    }
}

#[test]
fn without_error_bars_too_a_brighter_copy_is_different() {
    let folder = Folder::new();
    folder.write("a.exr", &plain(light));
    folder.write("b.exr", &plain(|i| light(i).map(|v| 1.01 * v)));
    let output = folder.compare(&["a.exr", "b.exr", "--margin", "0.5%"]);
    assert_eq!(output.status.code(), Some(1));
    let table = text(&output.stdout);
    assert!(table.contains("neither image has error bars"), "{table}");
    assert_eq!(folder.compare(&["a.exr", "a.exr"]).status.code(), Some(0));
}

#[test]
fn the_library_says_what_the_command_says_to_the_last_digit() {
    let folder = Folder::new();
    let a = folder.write("a.exr", &rendered(1.0));
    let b = folder.write("b.exr", &rendered(1.003));
    let printed = text(&folder.compare(&[&a, &b, "--json"]).stdout);
    let source = |path: &str| CompareImage::new(path, exr::read(Path::new(path)).unwrap());
    let report = compare(&source(&a), &source(&b), &CompareSettings::default()).unwrap();
    let without_space = |text: &str| text.split_whitespace().collect::<String>();
    let layers = serde_json::to_string(&report.layers).unwrap();
    assert!(layers.len() > 1000);
    assert!(without_space(&printed).contains(&without_space(&layers)));
}

#[test]
fn an_image_of_mitsuba_without_layers_is_compared_as_all_light() {
    let folder = Folder::new();
    folder.write("ours.exr", &rendered(1.0));
    folder.write("mitsuba.exr", &plain(|i| light(i).map(|v| 1.002 * v)));
    let (report, code) = folder.json(&["ours.exr", "mitsuba.exr"]);
    assert_eq!(code, Some(0));
    let layers = report["layers"].as_array().unwrap();
    assert_eq!(layers.len(), 1);
    assert_eq!(
        (layers[0]["layer"].as_str(), layers[0]["is_total"].as_bool()),
        (Some("total"), Some(true))
    );
    let note = "mitsuba.exr has no error bars: it counts as exact";
    assert_eq!(report["notes"], serde_json::json!([note]));
    // Our errors are 2 %, the difference 0.2 %: z = 0.1 in each texel.
    let found = &layers[0]["significance"];
    assert!(
        (found["mean_z"].as_f64().unwrap() - 0.1).abs() < 1e-3,
        "{found}"
    );
    assert_eq!(found["tests"], 3 * SIZE * SIZE);
}

#[test]
fn mitsubas_moments_are_error_bars_once_the_number_of_samples_is_known() {
    let folder = Folder::new();
    folder.write("ours.exr", &plain(light));
    // XYZ of linear sRGB (IEC 61966-2-1), as `moment` has its mean and second moment of samples.
    let xyz = |[r, g, b]: [f64; 3]| {
        [
            0.412453 * r + 0.357580 * g + 0.180423 * b,
            0.212671 * r + 0.715160 * g + 0.072169 * b,
            0.019334 * r + 0.119193 * g + 0.950227 * b,
        ]
    };
    let (samples, deviation) = (101.0, 0.5f64);
    let mut image = plain(|i| light(i).map(|v| 1.01 * v));
    for (c, name) in ["X", "Y", "Z"].into_iter().enumerate() {
        let mean = |i: usize| 1.01 * xyz(light(i))[c];
        let texels = 0..SIZE * SIZE;
        image.add_scalar(format!("nested.{name}"), texels.clone().map(mean));
        // Samples with a deviation of half their mean.
        let square = |i: usize| mean(i) * mean(i) * (1.0 + deviation * deviation);
        image.add_scalar(format!("m2_nested.{name}"), texels.map(square));
    }
    folder.write("moments.exr", &image);
    let output = folder.compare(&["ours.exr", "moments.exr"]);
    assert_eq!(output.status.code(), Some(2));
    let message = text(&output.stderr);
    assert!(
        message.contains("moments.exr has second moments (m2_nested.X)"),
        "{message}"
    );
    let (report, _) = folder.json(&["ours.exr", "moments.exr", "--samples-b", "101"]);
    let found = &report["layers"][0]["significance"];
    // d = 0.01 v and σ = 0.5 · 1.01 v / √100.
    let z = 0.01 / (deviation * 1.01 / (samples - 1.0f64).sqrt());
    let mean = found["mean_z"].as_f64().unwrap();
    // Second moments are differences of stored numbers: 1e-6 of σ²; matrices have six digits.
    assert!((mean - z).abs() < 1e-4, "{mean} {z}");
    assert_eq!(found["extreme"]["freedom"], 100.0);
}

#[test]
fn standard_errors_may_come_from_a_file_of_their_own() {
    let folder = Folder::new();
    folder.write("a.exr", &plain(light));
    folder.write("b.exr", &plain(|i| light(i).map(|v| 1.03 * v)));
    folder.write("error.exr", &plain(|i| light(i).map(|v| 0.01 * v)));
    let mut variance = Image::new(SIZE, SIZE);
    let squares: Vec<[f64; 3]> = (0..SIZE * SIZE)
        .map(|i| light(i).map(|v| (0.01 * v) * (0.01 * v)))
        .collect();
    variance.add_rgb("variance", &squares);
    folder.write("variance.exr", &variance);
    for errors in ["error.exr", "variance.exr"] {
        let (report, _) = folder.json(&["a.exr", "b.exr", "--error-b", errors, "--margin", "5%"]);
        let found = &report["layers"][0]["significance"];
        // Six digits of f32, in a quotient.
        assert!(
            (found["mean_z"].as_f64().unwrap() - 3.0).abs() < 1e-4,
            "{found}"
        );
        assert_eq!(report["verdict"], "equivalent");
    }
    folder.write("none.exr", &{
        let mut image = Image::new(SIZE, SIZE);
        image.add_scalar("depth.Z", vec![1.0; SIZE * SIZE]);
        image
    });
    let output = folder.compare(&["a.exr", "b.exr", "--error-a", "none.exr"]);
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        message.contains("none.exr: no errors of layer total"),
        "{message}"
    );
}

#[test]
fn what_is_undecided_passes_unless_equivalence_is_required() {
    let folder = Folder::new();
    // Noise of 30 % that alternates irregularly, in 1600 texels: the mean is known to about 1 %.
    let noise = |i: usize| 1.0 + 0.3 * ((i * 7919 % 1009) as f64 / 504.0 - 1.0);
    let mut a = plain(light);
    a.add_rgb(
        "stderr",
        &(0..SIZE * SIZE)
            .map(|i| light(i).map(|v| 0.18 * v))
            .collect::<Vec<_>>(),
    );
    folder.write("a.exr", &a);
    folder.write("b.exr", &plain(|i| light(i).map(|v| v * noise(i))));
    let run = |flags: &[&str]| {
        let arguments: Vec<&str> = ["a.exr", "b.exr", "--margin", "0.1%"]
            .into_iter()
            .chain(flags.iter().copied())
            .collect();
        folder.json(&arguments)
    };
    let (report, code) = run(&[]);
    assert_eq!(
        (report["verdict"].as_str(), code),
        (Some("undecided"), Some(0))
    );
    assert_eq!(run(&["--require-equivalence"]).1, Some(1));
}

#[test]
fn maps_are_pictures_of_each_layer_chosen() {
    let folder = Folder::new();
    folder.write("a.exr", &rendered(1.0));
    folder.write("b.exr", &rendered(1.01));
    let output = folder.compare(&[
        "a.exr",
        "b.exr",
        "--margin",
        "2%",
        "--maps",
        "out/maps",
        "--layer",
        "LTTD",
        "--layer",
        "E",
        "--no-flip",
    ]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let table = text(&output.stdout);
    for layer in ["E", "LTTD"] {
        for kind in ["difference", "relative", "z"] {
            let name = format!("out/maps/{layer}-{kind}.png");
            let bytes = std::fs::read(folder.path(&name)).unwrap();
            assert!(bytes.starts_with(b"\x89PNG"), "{name}");
            assert!(table.contains(&format!("wrote {name}")), "{table}");
        }
    }
    assert!(!Path::new(&folder.path("out/maps/LD-z.png")).exists());
}

#[test]
fn crops_are_compared_alone() {
    let folder = Folder::new();
    folder.write("a.exr", &plain(light));
    let spot = 12 + 30 * SIZE;
    folder.write(
        "b.exr",
        &plain(|i| light(i).map(|v| if i == spot { v + 5.0 } else { v })),
    );
    let (report, code) = folder.json(&["a.exr", "b.exr", "--crop", "10,25,20,15"]);
    let worst = &report["layers"][0]["difference"]["worst"];
    assert_eq!(
        (worst["x"].as_u64(), worst["y"].as_u64()),
        (Some(12), Some(30))
    );
    assert_eq!(report["layers"][0]["size"], serde_json::json!([20, 15]));
    assert_eq!(code, Some(1));
    assert_eq!(
        folder
            .compare(&["a.exr", "b.exr", "--crop", "0,0,10,10"])
            .status
            .code(),
        Some(0)
    );
}

#[test]
fn what_cannot_be_compared_is_an_error_of_code_2_that_names_the_place() {
    let folder = Folder::new();
    folder.write("a.exr", &rendered(1.0));
    folder.write("small.exr", &{
        let mut image = Image::new(3, 2);
        image.add_rgb("", &[[1.0; 3]; 6]);
        image
    });
    folder.write(
        "hole.exr",
        &plain(|i| {
            if i == 85 {
                [1.0, f64::NAN, 1.0]
            } else {
                [1.0; 3]
            }
        }),
    );
    std::fs::write(folder.path("text.exr"), "no image").unwrap();
    for (arguments, expected) in [
        (
            vec!["a.exr", "small.exr"],
            "a.exr has 40 x 40 texels, small.exr has 3 x 2",
        ),
        (
            vec!["a.exr", "hole.exr"],
            "hole.exr: channel G is NaN at pixel (5, 2)",
        ),
        (
            vec!["a.exr", "hole.exr", "--crop", "0,1,40,5"],
            "pixel (5, 2)",
        ),
        (vec!["a.exr", "missing.exr"], "cannot read missing.exr"),
        (vec!["a.exr", "text.exr"], "cannot read text.exr"),
        (
            vec!["a.exr", "a.exr", "--layer", "LRD"],
            "layer \"LRD\" is not in both",
        ),
        (vec!["a.exr", "a.exr", "--margin", "0"], "--margin"),
        (vec!["a.exr", "a.exr", "--level", "60%"], "--level"),
        (
            vec!["a.exr", "a.exr", "--crop", "0,0,41,1"],
            "is not within 40 x 40",
        ),
        (
            vec!["a.exr", "a.exr", "--pixels-per-degree", "0"],
            "--pixels-per-degree",
        ),
        (vec!["a.exr"], "B.exr"),
    ] {
        let output = folder.compare(&arguments);
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
        assert!(message.contains(expected), "{arguments:?}: {message}");
        assert_eq!(text(&output.stdout), "");
    }
}

/// Texels of few samples, by the bounds that go with them, are counted apart, and the table says so.
#[test]
fn values_of_few_samples_are_told_beside_the_tests() {
    let folder = Folder::new();
    let photons = |seed: f64| {
        let mut image = Image::new(SIZE, SIZE);
        // A tenth of the texels have a standard error of a third, and so (E / σ)² = 9; the others 2 %.
        let error = |i: usize| {
            if i.is_multiple_of(10) {
                1.0 / 3.0
            } else {
                0.02
            }
        };
        let scaled = |part: &dyn Fn(usize) -> f64| -> Vec<[f64; 3]> {
            (0..SIZE * SIZE)
                .map(|i| light(i).map(|v| v * part(i)))
                .collect()
        };
        image.add_rgb("E", &scaled(&|i| 1.0 + seed * error(i)));
        image.add_rgb("E.stderr", &scaled(&error));
        image.add_rgb("E.lo", &scaled(&|i| 1.0 - 3.0 * error(i)));
        image.add_rgb("E.hi", &scaled(&|i| 1.0 + 3.0 * error(i)));
        image.add_metadata("confidence", "0.999");
        image.add_metadata("settings", r#"{"replicates":32}"#);
        image
    };
    folder.write("a.exr", &photons(0.3));
    folder.write("b.exr", &photons(-0.3));
    let few = SIZE * SIZE / 10 * 3;
    let (report, _) = folder.json(&["a.exr", "b.exr"]);
    let found = &report["layers"][0]["significance"];
    assert_eq!(found["few"], few);
    assert_eq!(found["tests"], SIZE * SIZE * 3 - few);
    let said = text(&folder.compare(&["a.exr", "b.exr"]).stdout);
    let note = format!("E: {few} values of few samples are judged by their bounds");
    assert!(said.contains(&note), "{said}");
}
