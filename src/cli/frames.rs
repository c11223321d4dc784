//! `nephroid render --frames`: an image for each frame of an animation.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use serde::Serialize;

use super::args::RenderArgs;
use super::choice::choose;
use super::outcome::Outcome;
use super::output;
use super::progress;
use super::run::Run;
use super::scene::load_with;
use super::summary::Summary;
use crate::film::atomic;
use crate::method::sensors::choose_sensor;
use crate::run::format::number;
use crate::run::{Budget, Context, Counter};
use crate::scene::Scene;
use crate::setting::Given;
use crate::study::report::{field, parameters};

/// A frame that is done. Serialised, it is an entry of what `--json` prints.
#[derive(Serialize)]
struct Frame {
    /// From 1.
    #[serde(rename = "frame")]
    number: usize,
    /// Its parameters of the scene.
    define: Given,
    /// Time of the frame alone, without its preparation \[s\]; of methods that tell it.
    #[serde(rename = "frame_seconds")]
    seconds: Option<f64>,
    /// Work of the frame.
    work: Vec<Counter>,
    #[serde(flatten)]
    summary: Summary,
}

/// Renders frames, and lists their counters in a table beside the images. A frame that is under way when the
/// run is stopped is given up.
///
/// # Errors
///
/// As a run by itself, with the frame; images of the frames before it are there then.
pub fn render(
    args: &RenderArgs,
    frames: &[Given],
    extension: &str,
    context: &Context,
) -> anyhow::Result<Outcome> {
    let last = output::output_path(args.output.as_deref(), &args.scene.scene, extension)?;
    let first = scene_of(args, &frames[0])?;
    let context = &context.beside(&first);
    let (sensor, method, notice) = choose(args, &first)?;
    let id = sensor.id.clone();
    if let Some(notice) = notice {
        eprintln!("note: {notice}");
    }
    let mut sequence = method.frames();
    let mut first = Some(first);
    let mut done: Vec<Frame> = Vec::new();
    let mut warned: Vec<String> = Vec::new();
    for (index, define) in frames.iter().enumerate() {
        let start = Instant::now();
        let told = format!(
            "frame {} of {}: {}",
            index + 1,
            frames.len(),
            parameters(define)
        );
        context.progress.begin_part();
        let mut one = || -> anyhow::Result<Option<Frame>> {
            let scene = match first.take() {
                Some(first) => first,
                None => scene_of(args, define)?,
            };
            let sensor = &args.filter.filtered(choose_sensor(&scene, Some(&id))?);
            let rendering = progress::watch(&context.progress, || {
                sequence.frame(&scene, sensor, &Budget::default(), context)
            })?;
            if context.progress.is_stopped() {
                return Ok(None);
            }
            let run = Run {
                scene: &scene,
                sensor,
                method: &method,
                rendering: &rendering,
                elapsed: start.elapsed(),
            };
            let mut summary = Summary::of(&run);
            let files = output::write(&run, &summary, &numbered(&last, index, frames.len()))?;
            summary.files = files
                .iter()
                .map(|file| file.display().to_string())
                .collect();
            Ok(Some(Frame {
                number: index + 1,
                define: define.clone(),
                seconds: rendering.frame_time.as_ref().map(Duration::as_secs_f64),
                work: rendering.counters.clone(),
                summary,
            }))
        };
        let Some(frame) = one().map_err(|error| error.context(told.clone()))? else {
            eprintln!("stopped: {} of {} frames were made", index, frames.len());
            break;
        };
        // What was said of a frame before is not news.
        for warning in &frame.summary.warnings {
            if !warned.contains(warning) {
                eprintln!("warning: {told}: {warning}");
                warned.push(warning.clone());
            }
        }
        if !args.json {
            say!("{told}: {}", line(&frame));
        }
        done.push(frame);
    }
    let table = last.with_extension("csv");
    let text = csv(&done);
    atomic::write(&table, |file| file.write_all(text.as_bytes()))?;
    if args.json {
        say!("{}", serde_json::to_string_pretty(&done)?);
    } else {
        say!("wrote {}", table.display());
    }
    let is_whole = done.len() == frames.len() && done.iter().all(|it| it.summary.complete);
    Ok(if is_whole {
        Outcome::Complete
    } else {
        Outcome::Incomplete
    })
}

/// The scene of a frame: its parameters go before those of `-D`.
fn scene_of(args: &RenderArgs, define: &Given) -> anyhow::Result<Scene> {
    let mut all = args.scene.define.clone();
    all.retain(|(key, _)| !define.contains_key(key));
    all.extend(
        define
            .iter()
            .map(|(key, value)| (key.clone(), value.clone())),
    );
    Ok(load_with(&args.scene, &all)?)
}

/// The file of a frame: `ball-007.exr` for `ball.exr`, with as many digits as the last one needs.
fn numbered(path: &Path, index: usize, count: usize) -> PathBuf {
    let digits = count.to_string().len().max(3);
    let mut name = path.file_stem().unwrap_or_default().to_owned();
    name.push(format!("-{:0digits$}", index + 1));
    let extension = path.extension().unwrap_or_default();
    name.push(".");
    name.push(extension);
    path.with_file_name(name)
}

/// A frame on the terminal: its file, its light and its work.
fn line(frame: &Frame) -> String {
    let summary = &frame.summary;
    let mut parts: Vec<String> = summary.files.first().cloned().into_iter().collect();
    let total = summary.layers.first();
    parts.extend(
        total.map(|layer| format!("mean {} {}", number(layer.mean), summary.quantity.unit())),
    );
    let work = frame.work.iter().filter(|one| one.count > 0);
    parts.extend(work.map(|one| format!("{} {}", one.count, one.name)));
    parts.extend(frame.seconds.map(|it| format!("{:.1} ms", 1e3 * it)));
    parts.join(", ")
}

/// A table of frames for spreadsheets: parameters, file, mean and counters. It is the same on any machine.
fn csv(frames: &[Frame]) -> String {
    fn names<'a>(all: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
        let mut known: Vec<&str> = Vec::new();
        for name in all {
            if !known.contains(&name) {
                known.push(name);
            }
        }
        known
    }
    let keys = names(
        frames
            .iter()
            .flat_map(|it| it.define.keys())
            .map(String::as_str),
    );
    let work = frames.iter().flat_map(|it| &it.work);
    let work = names(work.map(|one| one.name.as_str()));
    let mut out = String::from("frame");
    for name in keys
        .iter()
        .copied()
        .chain(["file", "mean"])
        .chain(work.iter().copied())
    {
        // Writing to a string does not fail.
        let _ = write!(out, ",{}", field(name));
    }
    out.push('\n');
    for frame in frames {
        let summary = &frame.summary;
        let mut cells = vec![frame.number.to_string()];
        cells.extend(
            keys.iter()
                .map(|key| field(frame.define.get(*key).map_or("", |it| it))),
        );
        let file = summary
            .files
            .first()
            .map(Path::new)
            .and_then(Path::file_name);
        cells.push(field(&file.unwrap_or_default().to_string_lossy()));
        cells.push(
            summary
                .layers
                .first()
                .map_or(String::new(), |it| it.mean.to_string()),
        );
        cells.extend(work.iter().map(|name| {
            let found = frame.work.iter().find(|one| one.name == *name);
            found.map_or(String::new(), |one| one.count.to_string())
        }));
        let _ = writeln!(out, "{}", cells.join(","));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_frames_sort_by_their_numbers() {
        let name = |index, count| {
            let path = numbered(Path::new("out/pool.calm.exr"), index, count);
            path.display().to_string()
        };
        assert_eq!(name(0, 30), "out/pool.calm-001.exr");
        assert_eq!(name(999, 1000), "out/pool.calm-1000.exr");
        assert_eq!(name(6, 1000), "out/pool.calm-0007.exr");
    }
}
