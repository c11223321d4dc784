//! The script of the GitHub Action, as a job runs it.

use std::fs;
use std::path::Path;

use super::folder::{Folder, text};

/// What a job has after the step: the exit code, the summary on its page, and the step's outputs.
fn job(folder: &Folder, inputs: &[(&str, &str)]) -> (Option<i32>, String, String) {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join(".github/validate.sh");
    let [summary, outputs] = ["job-summary", "job-outputs"].map(|name| folder.path(name));
    for file in [&summary, &outputs] {
        fs::write(file, "").unwrap();
    }
    let output = std::process::Command::new("bash")
        .arg(script)
        .current_dir(folder.0.path())
        .env("NEPHROID", assert_cmd::cargo::cargo_bin("nephroid"))
        .env("GITHUB_STEP_SUMMARY", &summary)
        .env("GITHUB_OUTPUT", &outputs)
        .env("STUDY", "a.toml")
        .env("OUTPUT", "r")
        .envs(inputs.iter().copied())
        .output()
        .unwrap();
    let [summary, outputs] = [summary, outputs].map(|file| fs::read_to_string(file).unwrap());
    let said = text(&output.stdout) + &text(&output.stderr);
    (output.status.code(), summary, outputs + &said)
}

#[test]
fn an_action_ends_as_the_study_does_and_shows_its_summary() {
    let folder = Folder::with_films();
    // A file's name may hold spaces, as a value of several lines may hold empty ones.
    let films = fs::read_dir(folder.path("r/runs")).unwrap();
    let mut films = films.map(|film| film.unwrap().path());
    let film = films.find(|film| film.extension().is_some_and(|end| end == "exr"));
    fs::copy(film.unwrap(), folder.path("my image.exr")).unwrap();
    let candidate = ("CANDIDATE", "\nmine=my image.exr\n");

    let (code, summary, told) = job(&folder, &[candidate, ("MAX_ERROR", "photons=90%\r\n")]);
    assert_eq!(code, Some(0), "{told}");
    assert!(told.contains("result=kept\n"), "{told}");
    assert!(summary.contains("| mine |"), "{summary}");
    assert_eq!(
        summary,
        fs::read_to_string(folder.path("r/summary.md")).unwrap()
    );

    let limits = "photons=0.001%\nbeams=90%";
    let inputs = [("MAX_ERROR", limits), ("ARGUMENTS", "--margin\n2%\n")];
    let (code, summary, told) = job(&folder, &inputs);
    assert_eq!(code, Some(1), "{told}");
    assert!(
        told.contains("result=exceeded\n") && told.contains("::error"),
        "{told}"
    );
    assert!(summary.contains("photons"), "{summary}");
    let report = fs::read_to_string(folder.path("r/report.json")).unwrap();
    assert!(report.contains("\"margin\": 0.02"), "{report}");

    // The summary of the run before is no result of one that fails.
    let (code, summary, told) = job(&folder, &[("CANDIDATE", "mine=nowhere.exr")]);
    assert_eq!(code, Some(2), "{told}");
    assert!(told.contains("result=failed\n"), "{told}");
    assert_eq!(summary, "");
}
