//! The program as a process: its commands, its messages, and the memory that it takes.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;
use std::{fs, thread};

pub fn scene(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("scenes")
        .join(name)
}

/// `nephroid render` of the glass ball.
pub fn render(size: usize, output: &Path, arguments: &[&str]) -> Command {
    render_file(&scene("glass-ball.xml"), size, output, arguments)
}

/// `nephroid render` of a scene that has a parameter `size`.
pub fn render_file(scene: &Path, size: usize, output: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_nephroid"));
    command
        .arg("render")
        .arg(scene)
        .args(["-D", &format!("size={size}"), "-o"])
        .arg(output)
        .args(arguments)
        .stdout(Stdio::null())
        .stderr(Stdio::piped());
    command
}

pub fn message(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// The most memory \[bytes\] that a program had at once, as the system counts it, and what it printed where
/// it did not fail.
#[cfg(target_os = "linux")]
pub fn peak_memory(child: Child) -> (u64, Vec<u8>) {
    let (peak, output) = watched(child);
    assert!(output.status.success(), "{}", message(&output));
    (peak, output.stdout)
}

/// The most memory \[bytes\] that a program had at once; `None` if it refused to begin for lack of it.
#[cfg(target_os = "linux")]
pub fn peak_or_refusal(child: Child) -> Option<u64> {
    let (peak, output) = watched(child);
    if output.status.success() {
        return Some(peak);
    }
    let said = message(&output);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("GB of memory"), "{said}");
    None
}

#[cfg(target_os = "linux")]
fn watched(mut child: Child) -> (u64, Output) {
    let file = format!("/proc/{}/status", child.id());
    let mut peak = 0;
    loop {
        if let Some(bytes) = fs::read_to_string(&file).ok().as_deref().and_then(peak_in) {
            peak = peak.max(bytes);
        }
        if child.try_wait().unwrap().is_some() {
            return (peak, child.wait_with_output().unwrap());
        }
        thread::sleep(Duration::from_micros(200));
    }
}

/// Most memory \[bytes\] by `/proc/.../status`. For a moment a started process still has the memory of the
/// one that starts it, where other tests render; the kernel gives it its own before its own name.
#[cfg(target_os = "linux")]
fn peak_in(status: &str) -> Option<u64> {
    let of = |key| status.lines().find_map(|line| line.strip_prefix(key));
    if of("Name:")?.trim() != "nephroid" {
        return None;
    }
    let kilobytes = of("VmHWM:")?.trim().strip_suffix("kB")?.trim();
    Some(1024 * kilobytes.parse::<u64>().ok()?)
}

/// `nephroid inspect` of a scene.
#[cfg(target_os = "linux")]
pub fn inspect(scene: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_nephroid"));
    command
        .arg("inspect")
        .arg(scene)
        .arg("--json")
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    command
}

/// The glass ball with a camera that has as many pixels as the floor has texels.
pub fn with_a_square_camera(folder: &Path) -> PathBuf {
    let text = fs::read_to_string(scene("glass-ball.xml")).unwrap();
    let square = text
        .replace(r#"value="640""#, r#"value="$size""#)
        .replace(r#"value="480""#, r#"value="$size""#);
    assert_ne!(square, text);
    let path = folder.join("square.xml");
    fs::write(&path, square).unwrap();
    path
}
