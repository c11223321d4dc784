//! `nephroid validate`: what error costs, as a report.

mod args;
mod list;
mod told;

use std::path::{Path, PathBuf};

use super::outcome::Outcome;
use super::progress;
use super::render::set_threads;
use crate::reference::shard::Shard;
use crate::study::StudyFile;
use crate::study::file::{StudyWishes, report_folder};
use crate::study::report::{PosesReport, StudyReport, Timings, markdown};
use crate::study::validation::{self, Report};
pub use args::ValidateArgs;
use list::list;
use told::Teller;

/// Runs the command.
///
/// # Errors
///
/// If the study cannot be read, a run not be made, or the report not be written.
pub fn validate(args: &ValidateArgs) -> anyhow::Result<Outcome> {
    set_threads(args.threads)?;
    let context = args.cache.context();
    progress::stop_on_interrupt(&context.progress)?;
    let file = StudyFile::wanted(&args.study, &wishes(args))?;
    let folder = folder(args);
    if args.list {
        list(&file, &folder)?;
        return Ok(Outcome::Complete);
    }
    if let Some(shard) = args.shard {
        let teller = &mut Teller::default();
        let is_complete = validation::validate_shard(&file, shard, &folder, &context, teller)?;
        if !is_complete {
            return Ok(Outcome::Incomplete);
        }
        let Shard { index, count } = shard;
        say!(
            "part {} of {count} is in {}; the command without --shard writes the report",
            index + 1,
            folder.display()
        );
        return Ok(Outcome::Complete);
    }
    let validated = validation::validate(&file, &folder, &context, &mut Teller::default())?;
    match validated.report {
        Some(Report::One(found)) => print(args, &found.0, &found.1, &folder)?,
        Some(Report::Poses(found)) => print_poses(args, &found, &folder)?,
        None => (),
    }
    Ok(match (validated.is_kept, validated.is_complete) {
        (false, _) => Outcome::Apart,
        (true, false) => Outcome::Incomplete,
        (true, true) => Outcome::Complete,
    })
}

fn print(
    args: &ValidateArgs,
    report: &StudyReport,
    timings: &Timings,
    folder: &Path,
) -> anyhow::Result<()> {
    if args.json {
        say!("{}", serde_json::to_string_pretty(report)?);
    } else {
        say!("{}", markdown(report, timings).trim_end());
        say!("\nwrote {}", folder.join("index.html").display());
    }
    Ok(())
}

fn print_poses(args: &ValidateArgs, report: &PosesReport, folder: &Path) -> anyhow::Result<()> {
    if args.json {
        say!("{}", serde_json::to_string_pretty(report)?);
    } else {
        say!("{}", report.markdown().trim_end());
        say!("\nwrote {}", folder.join("poses.md").display());
    }
    Ok(())
}

/// What the flags ask for.
fn wishes(args: &ValidateArgs) -> StudyWishes {
    StudyWishes {
        define: args.define.clone(),
        sensors: args.sensor.clone(),
        candidates: args.candidate.clone(),
        max_error: args.max_error.clone(),
        margin: args.margin,
        repeats: args.repeats,
    }
}

/// Where the report goes.
fn folder(args: &ValidateArgs) -> PathBuf {
    args.output
        .clone()
        .unwrap_or_else(|| report_folder(&args.study))
}
