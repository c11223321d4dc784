//! `nephroid validate`: what error costs, as a report.

mod args;
mod candidates;
mod poses;
mod work;

use std::path::{Path, PathBuf};
use std::time::Instant;

use super::outcome::Outcome;
use super::progress;
use super::render::set_threads;
use crate::study::StudyFile;
use crate::study::file::StudyCandidate;
use crate::study::report;
pub use args::ValidateArgs;
use work::Command;

/// Runs the command.
///
/// # Errors
///
/// If the study cannot be read, a run not be made, or the report not be written.
pub fn validate(args: &ValidateArgs) -> anyhow::Result<Outcome> {
    let start = Instant::now();
    set_threads(args.threads)?;
    let context = args.cache.context();
    progress::stop_on_interrupt(&context.progress)?;
    let file = study(args)?;
    let folder = folder(args);
    let command = Command {
        args,
        context: &context,
        start,
    };
    if !file.poses.is_empty() {
        return poses::validate(&command, &file, &folder);
    }
    let (outcome, report) = command.study(&file, &folder)?;
    if let Some((report, timings)) = report {
        if args.json {
            say!("{}", serde_json::to_string_pretty(&report)?);
        } else {
            say!("{}", report::markdown(&report, &timings).trim_end());
            say!("\nwrote {}", folder.join("index.html").display());
        }
    }
    Ok(outcome)
}

/// What is asked for: the file's study, or the default one of a scene, with what the flags say.
fn study(args: &ValidateArgs) -> anyhow::Result<StudyFile> {
    let is_toml = args
        .study
        .extension()
        .is_some_and(|extension| extension == "toml");
    let mut file = if is_toml {
        StudyFile::read(&args.study)?
    } else {
        StudyFile::of_scene(&args.study)
    };
    for (key, value) in &args.define {
        file.define.retain(|(name, _)| name != key);
        file.define.push((key.clone(), value.clone()));
    }
    if !args.sensor.is_empty() {
        file.sensors.clone_from(&args.sensor);
    }
    file.margin = args.margin.or(file.margin);
    file.repeats = args.repeats.unwrap_or(file.repeats);
    let given = args
        .candidate
        .iter()
        .map(|(name, sensor, path)| StudyCandidate {
            name: name.clone(),
            sensor: sensor.clone(),
            file: path.clone(),
            seconds: None,
        });
    file.candidates.extend(given);
    for limit in &args.max_error {
        // The command line goes before the study, and what is said last before the rest.
        file.max_error.retain(|other| {
            let is_same = other.place() == limit.place();
            !is_same || other.limit.figure != limit.limit.figure
        });
        file.max_error.push(limit.clone());
    }
    Ok(file)
}

/// Where the report goes.
fn folder(args: &ValidateArgs) -> PathBuf {
    args.output.clone().unwrap_or_else(|| {
        let mut name = args.study.file_stem().unwrap_or_default().to_owned();
        name.push(".report");
        Path::new("out").join(name)
    })
}
