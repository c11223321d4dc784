//! What a `study.toml` says, and what is told of one that says it wrongly: file, line, column, and what is
//! allowed.

use std::path::{Path, PathBuf};
use std::time::Duration;

use nephroid::internals::mitsuba;
use nephroid::internals::setting::Words as _;
use nephroid::internals::study::plan::PlanError;
use nephroid::internals::study::{SensorPlan, StudyFile, StudyPlan, StudyRun};

fn parse(contents: &str) -> StudyFile {
    StudyFile::parse(Path::new("studies/a.toml"), contents).unwrap()
}

/// The message of a file that is refused.
fn refused(contents: &str) -> String {
    StudyFile::parse(Path::new("studies/a.toml"), contents)
        .unwrap_err()
        .to_string()
}

fn scene(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("scenes")
        .join(name)
}

/// The plan of a study of one sensor of a shipped scene, small.
fn plan(name: &str, rest: &str) -> Result<SensorPlan, PlanError> {
    let mut plans = plans(name, rest)?.sensors;
    assert_eq!(plans.len(), 1);
    Ok(plans.remove(0))
}

/// The plan of a study of a shipped scene, small.
fn plans(name: &str, rest: &str) -> Result<StudyPlan, PlanError> {
    let path = scene(name);
    let contents = format!("scene = {:?}\n{rest}", path.display().to_string());
    let file = StudyFile::parse(Path::new("a.toml"), &contents).unwrap();
    let define = [("size".to_owned(), "8".to_owned())];
    StudyPlan::new(&file, &mitsuba::load(&path, &define).unwrap())
}

#[test]
fn every_key_means_what_the_manual_says() {
    let study = parse(
        r#"
scene = "../scenes/glass-ball.xml"
sensor = "floor"
define = { size = 64, name = "x" }
seed = 7
repeats = 3
margin = "2%"
time = "2m"

[truth]
method = "beams"
error = "0.1%"

[[method]]
name = "few"
method = "photons"
photons = [100, 200]
seed = [1, 2]

[[candidate]]
name = "mine"
file = "mine.exr"
seconds = 0.004

[max-error]
mine = "5%"
"mine@floor:displaced" = "2texels"
"mine:resolution" = "2cm"
"#,
    );
    assert_eq!(study.scene, Path::new("studies/../scenes/glass-ball.xml"));
    assert_eq!(study.sensors, ["floor"]);
    let define: Vec<(&str, &str)> = study
        .define
        .iter()
        .map(|(key, value)| (key.as_str(), value.as_str()))
        .collect();
    assert_eq!(define, [("name", "x"), ("size", "64")]);
    assert_eq!((study.seed, study.repeats), (7, 3));
    assert_eq!(
        (study.margin, study.time),
        (Some(0.02), Some(Duration::from_secs(120)))
    );
    assert_eq!(study.truths[&None].settings[0]["error"], "0.1%");
    // The product of both lists.
    let few = &study.methods[0];
    assert_eq!((few.name.as_str(), few.method.as_str()), ("few", "photons"));
    let pairs: Vec<(&str, &str)> = few
        .settings
        .iter()
        .map(|one| (one["photons"].as_str(), one["seed"].as_str()))
        .collect();
    assert_eq!(
        pairs,
        [("100", "1"), ("100", "2"), ("200", "1"), ("200", "2")]
    );
    assert_eq!(study.candidates[0].file, Path::new("studies/mine.exr"));
    assert_eq!(study.candidates[0].seconds, Some(0.004));
    let limits: Vec<(String, String)> = study
        .max_error
        .iter()
        .map(|one| (one.place(), one.limit.to_string()))
        .collect();
    let expected = [
        ("mine", "l1 5.00 %"),
        ("mine", "resolution 0.0200 m"),
        ("mine@floor", "displaced 2.00 texels"),
    ];
    assert_eq!(
        limits,
        expected.map(|(place, limit)| (place.to_owned(), limit.to_owned()))
    );
}

#[test]
fn ranges_hold_both_ends() {
    let values = |range: &str| -> Vec<String> {
        let text =
            format!("scene = \"a.xml\"\n[[method]]\nmethod = \"photons\"\nphotons = {range}\n");
        let settings = &parse(&text).methods[0].settings;
        settings.iter().map(|one| one["photons"].clone()).collect()
    };
    assert_eq!(
        values("{ from = 1000, to = 64000, times = 4 }"),
        ["1000", "4000", "16000", "64000"]
    );
    assert_eq!(
        values("{ from = 10, to = 35, step = 10 }"),
        ["10", "20", "30"]
    );
    assert_eq!(values("{ from = 5, to = 5, step = 1 }"), ["5"]);
    assert_eq!(
        values("{ from = 10, to = 40, count = 4 }"),
        ["10", "20", "30", "40"]
    );
}

#[test]
fn what_is_wrong_is_told_with_its_place_and_what_is_allowed() {
    let method = "scene = \"a.xml\"\n[[method]]\nmethod = \"photons\"\n";
    for (contents, place, says) in [
        (
            "scen = \"a.xml\"\n".to_owned(),
            "studies/a.toml:1:1: ",
            "needs a key \"scene\"",
        ),
        (
            "scene = \"a.xml\"\nsede = 3\n".to_owned(),
            "studies/a.toml:2:1: ",
            "did you mean \"seed\"?",
        ),
        (
            "scene = \"a.xml\"\nseed = -3\n".to_owned(),
            "studies/a.toml:2:8: ",
            "whole numbers from 0",
        ),
        (
            "scene = \"a.xml\"\nmargin = 0\n".to_owned(),
            "studies/a.toml:2:10: ",
            "numbers > 0",
        ),
        (
            "scene = \"a.xml\"\ntime = \"soon\"\n".to_owned(),
            "studies/a.toml:2:8: ",
            "\"30s\"",
        ),
        ("scene = [\n".to_owned(), "studies/a.toml:", "array"),
        (
            format!("{method}fotons = 3\n"),
            "studies/a.toml:4:10: ",
            "did you mean \"photons\"?",
        ),
        (
            format!("{method}photons = 0\n"),
            "studies/a.toml:4:11: ",
            "whole numbers 1..=",
        ),
        (
            format!("{method}photons = [1, {{}}]\n"),
            "studies/a.toml:4:15: ",
            "numbers or texts only",
        ),
        (
            format!("{method}photons = []\n"),
            "studies/a.toml:4:11: ",
            "empty list",
        ),
        (
            format!("{method}photons = {{ from = 1, to = 5 }}\n"),
            "studies/a.toml:4:11: ",
            "\"times\"",
        ),
        (
            format!("{method}photons = {{ from = 1, to = 5, stop = 1 }}\n"),
            "studies/a.toml:4:31: ",
            "did you mean \"step\"?",
        ),
        (
            format!("{method}photons = {{ from = 1, to = 1e9, step = 1 }}\n"),
            "studies/a.toml:4:11: ",
            "more than 1000 values",
        ),
        (
            format!("{method}samples = \"sobel\"\n"),
            "studies/a.toml:4:11: ",
            "sobol, random",
        ),
        (
            "scene = \"a.xml\"\n[[method]]\nmethod = \"photon\"\n".to_owned(),
            "studies/a.toml:3:10: ",
            "did you mean \"photons\"?",
        ),
        (
            "scene = \"a.xml\"\n[truth]\nmethod = \"beams\"\nerror = [\"1%\", \"2%\"]\n".to_owned(),
            "studies/a.toml:2:1: ",
            "one run",
        ),
        (
            "scene = \"a.xml\"\n[[candidate]]\nname = \"a\"\n".to_owned(),
            "studies/a.toml:2:1: ",
            "needs a key \"file\"",
        ),
        (
            "scene = \"a.xml\"\nsensor = \"a\"\nsensors = [\"b\"]\n".to_owned(),
            "studies/a.toml:3:11: ",
            "either sensor or sensors",
        ),
        (
            "scene = \"a.xml\"\n[truth.floor]\nmethod = \"beam\"\n".to_owned(),
            "studies/a.toml:3:10: ",
            "did you mean \"beams\"?",
        ),
        (
            "scene = \"a.xml\"\nmethod = 3\n".to_owned(),
            "studies/a.toml:2:10: ",
            "[[method]]",
        ),
    ] {
        let message = refused(&contents);
        assert!(message.starts_with(place), "{contents}\n{message}");
        assert!(message.contains(says), "{contents}\n{message}");
    }
}

#[test]
fn a_missing_file_is_named() {
    let message = StudyFile::read(Path::new("nowhere/a.toml"))
        .unwrap_err()
        .to_string();
    assert!(message.contains("nowhere/a.toml"), "{message}");
}

#[test]
fn no_text_makes_the_reader_panic() {
    let whole = "scene = \"a.xml\"\n[[method]]\nmethod = \"photons\"\nphotons = { from = 1, to = 8, times = 2 }\n";
    for end in 0..whole.len() {
        for tail in ["", "=", "\"", "[", "[[", "{", "\u{fffd}", "1e999", "'ü"] {
            let _ = StudyFile::parse(Path::new("a.toml"), &format!("{}{tail}", &whole[..end]));
        }
    }
}

#[test]
fn a_scene_alone_is_judged_by_beams_where_they_can_follow_its_light() {
    let plan = plan("glass-ball.xml", "").unwrap();
    assert_eq!(plan.sensor, "floor");
    assert_eq!(plan.truth.method.name(), "beams");
    let names: Vec<&str> = plan.runs.iter().map(|run| run.method.name()).collect();
    assert!(names.contains(&"beams") && names.contains(&"photons"));
    // Beams draw nothing by lot: they have no seed.
    assert!(!plan.truth.given.contains_key("seed"));
}

#[test]
fn a_scene_with_an_area_light_is_judged_by_photons_of_a_seed_of_their_own() {
    let plan = plan("cornell-glass.xml", "seed = 5\n").unwrap();
    assert_eq!(plan.truth.method.name(), "photons");
    let seed = |run: &StudyRun| run.method.settings()["seed"].as_u64();
    assert_eq!(seed(&plan.truth), Some((1 << 63) + 5));
    assert!(plan.runs.iter().all(|run| seed(run) == Some(5)));
}

#[test]
fn a_camera_is_judged_by_all_methods_together() {
    let plan = plan("glass-ball.xml", "sensor = \"camera\"\n").unwrap();
    assert_eq!(plan.truth.method.name(), "full");
    let names: Vec<&str> = plan.runs.iter().map(|run| run.method.name()).collect();
    // Of a point light paths find no caustic: one row of them tells so.
    assert_eq!(names, ["path", "full", "full", "full"]);
}

#[test]
fn a_method_runs_on_the_sensors_that_it_names_else_on_all_that_it_can_fill() {
    let plan = plans(
        "glass-ball.xml",
        r#"sensors = ["camera", "floor"]
[[method]]
method = "path"
[[method]]
method = "photons"
photons = 64
[[method]]
name = "here"
method = "beams"
sensor = "floor"
"#,
    )
    .unwrap();
    let names = |at: usize| -> Vec<&str> {
        let runs = plan.sensors[at].runs.iter();
        runs.map(|run| run.name.as_str()).collect()
    };
    assert_eq!(names(0), ["path", "photons"]);
    assert_eq!(names(1), ["photons", "here"]);
    let truths = plan.sensors.iter().map(|one| one.truth.method.name());
    assert_eq!(truths.collect::<Vec<_>>(), ["full", "beams"]);
}

#[test]
fn a_limit_on_one_sensor_goes_before_that_on_all() {
    let plan = plans(
        "glass-ball.xml",
        r#"sensors = ["camera", "floor"]
[[method]]
method = "photons"
photons = 64
[max-error]
photons = 0.5
"photons:l2" = 0.7
"photons@floor" = 0.1
"#,
    )
    .unwrap();
    let limits = |place: usize| -> Vec<(&str, f64)> {
        let limits = plan.sensors[place].max_error.iter();
        limits
            .map(|(_, limit)| (limit.figure.word(), limit.most))
            .collect()
    };
    assert_eq!(limits(0), [("l1", 0.5), ("l2", 0.7)]);
    assert_eq!(limits(1), [("l2", 0.7), ("l1", 0.1)]);
}

#[test]
fn what_cannot_be_planned_is_refused_with_what_can() {
    let message = |rest: &str| plan("glass-ball.xml", rest).unwrap_err().to_string();
    let sensor = message("sensor = \"flour\"\n");
    assert!(sensor.contains("\"floor\" (irradiancemeter)"), "{sensor}");
    let twice = message("sensors = [\"floor\", \"floor\"]\n");
    assert!(twice.contains("named twice"), "{twice}");
    let nowhere = message("[[method]]\nmethod = \"photons\"\nsensor = \"camera\"\n");
    assert!(nowhere.contains("there are floor"), "{nowhere}");
    let path = message("[[method]]\nmethod = \"path\"\n");
    assert!(path.contains("beams and photons"), "{path}");
    let twice = message("[[method]]\nmethod = \"photons\"\n[[method]]\nmethod = \"photons\"\n");
    assert!(twice.contains("another name"), "{twice}");
    let limit = message("[[method]]\nmethod = \"photons\"\n[max-error]\nfotons = 0.1\n");
    assert!(limit.contains("did you mean \"photons\"?"), "{limit}");
    for method in ["[[method]]\n", "[truth]\n"] {
        let timed = message(&format!("{method}method = \"beams\"\ntime = \"30s\"\n"));
        assert!(timed.contains("time is \"30s\""), "{timed}");
        assert!(timed.contains("depend on the machine"), "{timed}");
    }
}

#[test]
fn a_label_and_the_arguments_name_what_is_not_a_default() {
    let plan = plan(
        "glass-ball.xml",
        "seed = 3\n[[method]]\nmethod = \"photons\"\nphotons = 64\n",
    )
    .unwrap();
    assert_eq!(plan.runs[0].label(), "photons=64 seed=3");
    assert_eq!(plan.runs[0].label_without_seed(), "photons=64");
    assert_eq!(
        plan.runs[0].arguments(),
        "--method photons --photons 64 --seed 3"
    );
}
