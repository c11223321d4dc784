//! `nephroid validate --list`: the runs of a study, and which of them are done.

use std::path::Path;

use crate::study::report::parameters;
use crate::study::stages::Stages;
use crate::study::validation::{open, pose_folder};
use crate::study::{Session, StudyError, StudyFile, attribution};

/// Lists the runs of a study, pose by pose.
///
/// # Errors
///
/// If the study cannot be planned, or the folder not be made.
pub fn list(file: &StudyFile, folder: &Path) -> Result<(), StudyError> {
    if file.poses.is_empty() {
        return runs(&open(file, folder)?);
    }
    let all = file.poses.len();
    for (number, define) in (1..).zip(&file.poses) {
        eprintln!("pose {number} of {all}: {}", parameters(define));
        let own = folder.join(pose_folder(number));
        runs(&open(&file.of_pose(define), &own)?)?;
    }
    Ok(())
}

fn runs(session: &Session) -> Result<(), StudyError> {
    for plan in &session.plan.sensors {
        let sensor = session.sensor(plan)?;
        let all = [(&plan.truth, "truth, ")]
            .into_iter()
            .chain(plan.runs.iter().map(|run| (run, "")));
        for (run, what) in all {
            let kept = session.store.find(&session.scene, sensor, run);
            let state = kept.map_or("to do", |_| "kept");
            say!("{state:<6} {}: {what}{}", plan.sensor, run.label());
        }
        for run in &plan.attributed {
            let kept = Stages::new(session, plan, run)?.kept();
            let state = kept.map_or("to do", |_| "kept");
            let runs = attribution::count(&run.method);
            say!(
                "{state:<6} {}: stages of {}, {runs} runs",
                plan.sensor,
                run.label()
            );
        }
    }
    Ok(())
}
