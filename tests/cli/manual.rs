//! Man pages and completions of shells, as packagers make them.

use std::fs;

use assert_cmd::Command;

/// The commands that the program's help lists.
fn commands() -> Vec<String> {
    let output = Command::cargo_bin("nephroid")
        .unwrap()
        .arg("--help")
        .output()
        .unwrap();
    let help = String::from_utf8(output.stdout).unwrap();
    let (_, listed) = help.split_once("Commands:\n").unwrap();
    let (listed, _) = listed.split_once("\n\n").unwrap();
    // Continued lines are indented further.
    let lines = listed.lines().filter(|line| !line.starts_with("   "));
    lines
        .map(|line| line.split_whitespace().next().unwrap().to_owned())
        .filter(|name| name != "help")
        .collect()
}

#[test]
fn each_command_has_a_page_and_each_shell_a_completion_of_all_commands() {
    let folder = tempfile::tempdir().unwrap();
    let to = folder.path().join("a/b");
    Command::cargo_bin("nephroid")
        .unwrap()
        .arg("manual")
        .arg("--output")
        .arg(&to)
        .assert()
        .success();
    let read = |name: &str| fs::read_to_string(to.join(name)).unwrap();
    let commands = commands();
    assert!(commands.iter().any(|name| name == "render"), "{commands:?}");
    for command in &commands {
        let page = read(&format!("nephroid-{command}.1"));
        assert!(
            page.contains(".SH OPTIONS") || page.contains(".SH SYNOPSIS"),
            "{page}"
        );
    }
    // The manual of a command names what can be typed.
    assert!(read("nephroid-attribute.1").contains("truth"));
    for file in [
        "nephroid.bash",
        "_nephroid",
        "nephroid.fish",
        "_nephroid.ps1",
    ] {
        let completion = read(file);
        for command in &commands {
            assert!(completion.contains(command), "{file} lacks {command}");
        }
        assert!(
            completion.contains("photons"),
            "{file} lacks values of --truth"
        );
    }
}

#[test]
fn a_folder_that_cannot_be_made_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    fs::write(&file, "").unwrap();
    let output = Command::cargo_bin("nephroid")
        .unwrap()
        .arg("manual")
        .arg("--output")
        .arg(file.join("below"))
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2));
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("below"), "{said}");
}
