//! Runs that are made by themselves, each on any machine, and known by a hash of what they are made from.

use std::path::Path;
use std::sync::Arc;

use super::super::StudyError;
use super::super::file::StudyFile;
use super::super::session::Session;
use super::news::Watcher;
use super::poses::store;
use super::runs::{Course, Portion, portions};

use crate::run::Context;
use crate::scene::Scene;

/// Runs of a study that are made by themselves: one run; or a truth and the attributions that need its film.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unit {
    /// A hash of all that its files are made from, the program's source among it.
    pub key: String,
    /// What is made, as `truth, beams`.
    pub name: String,
    /// True of truths, which take longest.
    pub is_truth: bool,
    /// True if there is nothing to make.
    pub is_kept: bool,
}

/// The units of a study of a scene whose films are in a folder, which is made if it is missing.
///
/// # Errors
///
/// If the study cannot be planned, or the folder not be written to.
pub fn units(scene: &Arc<Scene>, file: &StudyFile, folder: &Path) -> Result<Vec<Unit>, StudyError> {
    let session = Session::of_scene(Arc::clone(scene), file, store(folder)?)?;
    let all = portions(&session.plan);
    all.into_iter()
        .map(|portion| unit(&session, portion))
        .collect()
}

/// Makes the unit of a key in a folder of its own. False if it was stopped. Candidates are not looked at.
///
/// # Errors
///
/// If the study has no such unit, as another version of the program may find, or its runs cannot be made.
pub fn validate_unit(
    scene: Arc<Scene>,
    file: &StudyFile,
    key: &str,
    folder: &Path,
    context: &Context,
    watcher: &mut impl Watcher,
) -> Result<bool, StudyError> {
    let session = Session::of_scene(scene, file, store(folder)?)?;
    for portion in portions(&session.plan) {
        if unit(&session, portion)?.key == key {
            return Course::new(context, watcher).only(&session, portion);
        }
    }
    Err(StudyError::NoUnit)
}

fn unit(session: &Session, portion: Portion) -> Result<Unit, StudyError> {
    let Portion { plan, run } = portion;
    let sensor = session.sensor(plan)?;
    let is_truth = run.is_none();
    let run = run.unwrap_or(&plan.truth);
    let what = if is_truth { "truth, " } else { "" };
    let name = format!("{}: {what}{}", plan.sensor, run.label());
    let mut hasher = blake3::Hasher::new();
    // Names are of files, too: the same run of two curves is kept twice.
    hasher.update(format!("{name} {}", session.plan.repeats).as_bytes());
    let mut is_kept = session.is_kept(sensor, run);
    hasher.update(session.store.key(&session.scene, sensor, run).as_bytes());
    for run in plan.attributed.iter().filter(|_| is_truth) {
        is_kept &= session.kept_attribution(plan, run)?.is_some();
        let key = session.store.key(&session.scene, sensor, run);
        hasher.update(format!("{} {key}", run.label()).as_bytes());
    }
    Ok(Unit {
        key: hasher.finalize().to_hex().to_string(),
        name,
        is_truth,
        is_kept,
    })
}
