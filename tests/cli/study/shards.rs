//! A study in parts that run at once, in one folder.

use std::fs;

use super::folder::{Folder, text};

/// The truth, an attribution that needs its film, and four runs.
const STUDY: &str = r#"
[truth]
method = "beams"
error = "3%"
[[method]]
method = "photons"
photons = [1024, 4096, 16384]
[[method]]
method = "caustic-map"
photons = 64
map = 64
"#;

#[test]
fn a_study_in_parts_has_the_report_of_the_study_in_one_piece() {
    let folder = Folder::new();
    folder.study("s.toml", STUDY);
    let validate = |to: &str| {
        let output = folder.run(&["validate", "s.toml", "-o", to]);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{said}");
        said
    };
    let said = validate("whole");
    assert!(said.contains("stages of caustic-map"), "{said}");
    let whole = fs::read(folder.path("whole/report.json")).unwrap();
    for count in [1, 3, 7] {
        let to = format!("of-{count}");
        let program = assert_cmd::cargo::cargo_bin("nephroid");
        let parts: Vec<_> = (1..=count)
            .map(|part| {
                std::process::Command::new(&program)
                    .current_dir(folder.0.path())
                    .args(["validate", "s.toml", "-o", &to, "--threads", "1"])
                    .args(["--shard", &format!("{part}/{count}")])
                    .stdout(std::process::Stdio::piped())
                    .stderr(std::process::Stdio::piped())
                    .spawn()
                    .unwrap()
            })
            .collect();
        let mut made = 0;
        for part in parts {
            let output = part.wait_with_output().unwrap();
            let said = text(&output.stderr);
            assert_eq!(output.status.code(), Some(0), "{said}");
            assert!(text(&output.stdout).contains("without --shard"), "{said}");
            assert!(!said.contains("kept from before"), "{said}");
            // The line with which a run begins.
            made += said.matches(" ...\n").count();
        }
        assert_eq!(made, 6, "of {count} parts");
        assert!(!folder.path(&format!("{to}/report.json")).exists());
        let said = validate(&to);
        assert_eq!(said.matches("kept from before").count(), 6, "{said}");
        let merged = fs::read(folder.path(&format!("{to}/report.json"))).unwrap();
        assert!(merged == whole, "{count} parts");
    }
}

#[test]
fn parts_are_dealt_over_all_poses() {
    let folder = Folder::new();
    folder.study(
        "p.toml",
        "poses = [{ size = [8, 12] }]\n[truth]\nmethod = \"beams\"\nerror = \"5%\"\n[[method]]\nmethod = \"photons\"\n\
         photons = 1024\n",
    );
    for part in 1..=4 {
        let shard = format!("{part}/4");
        let output = folder.run(&["validate", "p.toml", "-o", "r", "--shard", &shard]);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{said}");
        assert_eq!(said.matches("[ 1/1] ").count(), 2, "{said}");
    }
    let output = folder.run(&["validate", "p.toml", "-o", "r"]);
    let said = text(&output.stderr);
    assert_eq!(said.matches("kept from before").count(), 4, "{said}");
    assert!(folder.path("r/poses.json").exists());
    // Truths take longest: of two parts each has one of the two.
    for part in ["1/2", "2/2"] {
        let output = folder.run(&["validate", "p.toml", "-o", "r", "--shard", part]);
        let said = text(&output.stderr);
        assert_eq!(said.matches("] truth, beams").count(), 2, "{said}");
    }
}

#[test]
fn a_part_refuses_what_the_whole_would_and_tells_what_its_time_did_not_suffice_for() {
    let folder = Folder::new();
    let one = "[truth]\nmethod = \"beams\"\nerror = \"5%\"\n[[method]]\nmethod = \"photons\"\nphotons = 1024\n";
    folder.study("p.toml", &format!("poses = [{{ size = [8, 12] }}]\n{one}"));
    folder.study("s.toml", &format!("time = \"0.001s\"\n{one}"));
    let refused = |study: &str| {
        let candidate = ["--candidate", "mine=nowhere.exr", "--shard", "1/1"];
        let output = folder.run(&[&["validate", study, "-o", "r"], &candidate[..]].concat());
        assert_eq!(output.status.code(), Some(2), "{}", text(&output.stderr));
        text(&output.stderr)
    };
    assert!(refused("p.toml").contains("poses"));
    assert!(refused("s.toml").contains("nowhere.exr"));
    let output = folder.run(&["validate", "s.toml", "-o", "r", "--shard", "1/1"]);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(
        said.contains("were not made: the study's time was over"),
        "{said}"
    );
}
