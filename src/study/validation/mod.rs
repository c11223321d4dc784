//! A study from its file to its report: what `nephroid validate` does.
//!
//! | file | content |
//! |---|---|
//! | `mod.rs` | one study, or one after the other for its poses |
//! | `runs.rs` | the runs of one study, one after the other |
//! | `poses.rs` | studies of poses, and the folders of studies |
//! | `units.rs` | what is made by itself, on any machine |
//! | `candidates.rs` | images rendered elsewhere, checked and copied |
//! | `news.rs` | what a study tells of its course |
//! | `validated.rs` | what came of a study |

mod candidates;
mod news;
mod poses;
mod runs;
mod units;
mod validated;

use std::path::Path;
use std::sync::Arc;

use super::StudyError;
use super::file::StudyFile;
use super::report::{Pose, PosesReport};
use super::session::Session;
use crate::reference::shard::Shard;
use crate::run::Context;
use crate::scene::Scene;
pub use news::{Done, Left, News, Task, Watcher};
pub use poses::{of_poses, pose_folder};
use poses::{store, without_candidates};
use runs::{Course, Deal};
pub use units::{Unit, units, validate_unit};
pub use validated::{Report, Validated};

impl<W: Watcher> Course<'_, W> {
    /// A study of one pose.
    fn one(&mut self, session: &Session, folder: &Path) -> Result<Validated, StudyError> {
        let (is_complete, found) = self.study(session, folder)?;
        let is_kept = found.as_ref().is_none_or(|(report, _)| report.is_kept());
        let report = found.map(|found| Report::One(Box::new(found)));
        Ok(Validated {
            is_complete,
            is_kept,
            report,
        })
    }
}

/// Opens a study with the films that are in its folder, which is made if it is missing.
///
/// # Errors
///
/// If the study cannot be planned, or the folder not be written to.
pub fn open(file: &StudyFile, folder: &Path) -> Result<Session, StudyError> {
    Session::new(file, store(folder)?)
}

/// Makes those runs of a study that are dealt to a shard, and no report: [`validate`] writes it once all
/// shards are done, with the same folder. False if it was stopped, or its time was over before its end.
///
/// # Errors
///
/// As [`validate`].
pub fn validate_shard(
    file: &StudyFile,
    shard: Shard,
    folder: &Path,
    context: &Context,
    watcher: &mut impl Watcher,
) -> Result<bool, StudyError> {
    let mut course = Course::new(context, watcher);
    let mut deal = Deal::new(shard);
    if file.poses.is_empty() {
        return course.share(&open(file, folder)?, folder, &mut deal);
    }
    without_candidates(file)?;
    let all = file.poses.len();
    let mut is_complete = true;
    for (number, define) in (1..).zip(&file.poses) {
        course.watcher.hear(News::Pose(number, all, define));
        let own = folder.join(pose_folder(number));
        let session = open(&file.of_pose(define), &own)?;
        is_complete &= course.share(&session, &own, &mut deal)?;
        if context.progress.is_stopped() {
            break;
        }
    }
    Ok(is_complete)
}

/// As [`validate`], of a scene that is read already: the study's parameters and poses, which are of files, do
/// not count.
///
/// # Errors
///
/// As [`validate`].
pub fn validate_scene(
    scene: Arc<Scene>,
    file: &StudyFile,
    folder: &Path,
    context: &Context,
    watcher: &mut impl Watcher,
) -> Result<Validated, StudyError> {
    let mut course = Course::new(context, watcher);
    course.one(&Session::of_scene(scene, file, store(folder)?)?, folder)
}

/// Makes all runs of a study that are not in its folder, and writes its report there. A study with poses is
/// one study after the other, each in a folder of its own, and figures over all of them.
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
    let mut course = Course::new(context, watcher);
    if file.poses.is_empty() {
        return course.one(&open(file, folder)?, folder);
    }
    without_candidates(file)?;
    let all = file.poses.len();
    let (mut is_complete, mut is_kept) = (true, true);
    let mut reports = Vec::new();
    for (number, define) in (1..).zip(&file.poses) {
        let is_late = file.time.is_some_and(|time| course.start.elapsed() >= time);
        if number > 1 && is_late {
            course.watcher.hear(News::PosesLeft(all + 1 - number, all));
            is_complete = false;
            break;
        }
        course.watcher.hear(News::Pose(number, all, define));
        let pose = Pose {
            define: define.clone(),
            folder: pose_folder(number),
        };
        let own = folder.join(&pose.folder);
        let (is_whole, found) = course.study(&open(&file.of_pose(define), &own)?, &own)?;
        is_complete &= is_whole;
        let Some((report, _)) = found else {
            let report = None;
            return Ok(Validated {
                is_complete,
                is_kept,
                report,
            });
        };
        is_kept &= report.is_kept();
        reports.push((pose, report));
    }
    let report = PosesReport::new(&reports);
    report.write(folder)?;
    let report = Some(Report::Poses(report));
    Ok(Validated {
        is_complete,
        is_kept,
        report,
    })
}
