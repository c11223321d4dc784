//! A study of several poses: one study after the other, and the figures over all of them.

use std::path::Path;

use super::work::Command;
use crate::cli::outcome::Outcome;
use crate::study::StudyFile;
use crate::study::report::{Pose, PosesReport, parameters};

/// Makes the study of each pose in a folder of its own, and writes what it comes to.
///
/// # Errors
///
/// As for each study, and if the study has candidates: an image shows one pose.
pub fn validate(command: &Command, file: &StudyFile, folder: &Path) -> anyhow::Result<Outcome> {
    if let Some(candidate) = file.candidates.first() {
        anyhow::bail!(
            "candidate \"{}\" and poses: an image shows one pose; allowed are candidates of studies without poses",
            candidate.name
        );
    }
    let all = file.poses.len();
    let mut outcome = Outcome::Complete;
    let mut reports = Vec::new();
    for (number, define) in (1..).zip(&file.poses) {
        let is_late = file
            .time
            .is_some_and(|time| command.start.elapsed() >= time);
        if number > 1 && is_late {
            eprintln!(
                "{} of {all} poses were not begun: the study's time was over",
                all + 1 - number
            );
            outcome = outcome.worse(Outcome::Incomplete);
            break;
        }
        eprintln!("pose {number} of {all}: {}", parameters(define));
        let pose = Pose {
            define: define.clone(),
            folder: format!("pose-{number:03}"),
        };
        let (of_pose, report) = command.study(&file.of_pose(define), &folder.join(&pose.folder))?;
        outcome = outcome.worse(of_pose);
        if command.context.progress.is_stopped() {
            return Ok(outcome);
        }
        reports.extend(report.map(|(report, _)| (pose, report)));
    }
    if command.args.list {
        return Ok(outcome);
    }
    let report = PosesReport::new(&reports);
    report.write(folder)?;
    if command.args.json {
        say!("{}", serde_json::to_string_pretty(&report)?);
    } else {
        say!("{}", report.markdown().trim_end());
        say!("\nwrote {}", folder.join("poses.md").display());
    }
    Ok(outcome)
}
