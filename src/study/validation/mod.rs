//! A study from its file to its report: what `nephroid validate` does.
//!
//! | file | content |
//! |---|---|
//! | `mod.rs` | one study, or one after the other for its poses |
//! | `runs.rs` | the runs of one study, one after the other |
//! | `candidates.rs` | images rendered elsewhere, checked and copied |
//! | `news.rs` | what a study tells of its course |

mod candidates;
mod news;
mod runs;

use std::path::Path;
use std::time::Instant;

use super::StudyError;
use super::file::StudyFile;
use super::report::{Pose, PosesReport, StudyReport, Timings};
use super::session::Session;
use super::store::Store;
use crate::film::atomic;
use crate::run::Context;
pub use news::{Done, Left, News, Task, Watcher};
use runs::Course;

/// How well a study went, the best first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Standing {
    /// All runs are made, and all limits kept.
    Complete,
    /// It was stopped, or its time was over before its end.
    Incomplete,
    /// A figure is above its limit, or the truth cannot tell.
    Exceeded,
}

/// What came of a study.
#[derive(Clone, Debug)]
pub struct Validated {
    /// How well it went.
    pub standing: Standing,
    /// Its figures; `None` if it was stopped.
    pub report: Option<Report>,
}

/// The figures of a study, as they are written into its folder.
#[derive(Clone, Debug)]
pub enum Report {
    /// Of a study of one pose.
    One(Box<(StudyReport, Timings)>),
    /// Over all poses.
    Poses(PosesReport),
}

/// Opens a study with the films that are in its folder, which is made if it is missing.
///
/// # Errors
///
/// If the study cannot be planned, or the folder not be written to.
pub fn open(file: &StudyFile, folder: &Path) -> Result<Session, StudyError> {
    std::fs::create_dir_all(folder).map_err(|cause| StudyError::Folder {
        folder: folder.to_owned(),
        cause,
    })?;
    atomic::check(&folder.join("index.html"))?;
    Session::new(file, Store::open(&folder.join("runs"))?)
}

/// Makes all runs of a study that are not in its folder, and writes its report there. A study with poses is one
/// study after the other, each in a folder of its own, and figures over all of them.
///
/// # Errors
///
/// If the study cannot be planned, a run not be made, or the report not be written.
pub fn validate(
    file: &StudyFile,
    folder: &Path,
    context: &Context,
    watcher: &mut impl Watcher,
) -> Result<Validated, StudyError> {
    let start = Instant::now();
    let mut course = Course {
        context,
        start,
        watcher,
    };
    if file.poses.is_empty() {
        let (standing, found) = course.study(&open(file, folder)?, folder)?;
        let report = found.map(|found| Report::One(Box::new(found)));
        return Ok(Validated { standing, report });
    }
    if let Some(candidate) = file.candidates.first() {
        return Err(StudyError::CandidateOfPoses(candidate.name.clone()));
    }
    let all = file.poses.len();
    let mut standing = Standing::Complete;
    let mut reports = Vec::new();
    for (number, define) in (1..).zip(&file.poses) {
        let is_late = file.time.is_some_and(|time| start.elapsed() >= time);
        if number > 1 && is_late {
            course.watcher.hear(News::PosesLeft(all + 1 - number, all));
            standing = standing.max(Standing::Incomplete);
            break;
        }
        course.watcher.hear(News::Pose(number, all, define));
        let pose = Pose {
            define: define.clone(),
            folder: format!("pose-{number:03}"),
        };
        let own = folder.join(&pose.folder);
        let (of_pose, found) = course.study(&open(&file.of_pose(define), &own)?, &own)?;
        standing = standing.max(of_pose);
        if context.progress.is_stopped() {
            let report = None;
            return Ok(Validated { standing, report });
        }
        reports.extend(found.map(|(report, _)| (pose, report)));
    }
    let report = PosesReport::new(&reports);
    report.write(folder)?;
    let report = Some(Report::Poses(report));
    Ok(Validated { standing, report })
}
