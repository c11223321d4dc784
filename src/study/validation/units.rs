//! What is made of a study by itself, on any machine, and known by a hash of what it is made from.

use std::path::Path;
use std::sync::Arc;

use super::super::StudyError;
use super::super::file::StudyFile;
use super::super::session::Session;
use super::super::stages::{Part, Stages};
use super::news::Watcher;
use super::poses::store;
use super::runs::{Course, Make, Portion, portions};
use crate::run::Context;
use crate::scene::Scene;

/// What is made of a study by itself: a run, a truth, or a part of an attribution.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unit {
    /// A hash of all that its files are made from, the program's source among it.
    pub key: String,
    /// Keys of units whose files it needs. Without them it is made all the same, and makes them, too.
    pub needs: Vec<String>,
    /// Its files, by their names.
    pub files: Vec<String>,
    /// Larger ones should begin first: truths, on which an attribution waits, then its first run, its other
    /// parts, and runs.
    pub urgency: usize,
    /// True if there is nothing to make.
    pub is_kept: bool,
}

/// The units of a study of a scene whose films are in a folder, which is made if it is missing. A unit comes
/// after those that it needs.
///
/// # Errors
///
/// If the study cannot be planned, or the folder not be written to.
pub fn units(scene: &Arc<Scene>, file: &StudyFile, folder: &Path) -> Result<Vec<Unit>, StudyError> {
    let session = Session::of_scene(Arc::clone(scene), file, store(folder)?)?;
    let all = portions(&session)?.into_iter();
    all.map(|portion| unit(&session, portion)).collect()
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
    for portion in portions(&session)? {
        if self::key(&session, portion)? == key {
            return Course::new(context, watcher).only(&session, portion);
        }
    }
    Err(StudyError::NoUnit)
}

/// The key of a portion.
fn key(session: &Session, portion: Portion) -> Result<String, StudyError> {
    let Portion { plan, make } = portion;
    let of_run = |what: &str, run| -> Result<_, StudyError> {
        let key = session
            .store
            .key(&session.scene, session.sensor(plan)?, run);
        Ok((format!("{what}{}", run.label()), key))
    };
    let (name, key) = match make {
        Make::Truth => of_run("truth, ", &plan.truth)?,
        Make::Run(run) => of_run("", run)?,
        Make::Part(run, part) => {
            let value = Stages::new(session, plan, run)?.place(part);
            (format!("stages of {}", run.label()), value.key)
        }
    };
    // Names are of files, too: the same run of two curves is kept twice.
    let text = format!("{}: {name} {} {key}", plan.sensor, session.plan.repeats);
    Ok(blake3::hash(text.as_bytes()).to_hex().to_string())
}

fn unit(session: &Session, portion: Portion) -> Result<Unit, StudyError> {
    let Portion { plan, make } = portion;
    let sensor = session.sensor(plan)?;
    let of_run = |run| {
        let files = session.store.files(&session.scene, sensor, run);
        (files, session.is_kept(sensor, run))
    };
    let (files, is_kept) = match make {
        Make::Truth => of_run(&plan.truth),
        Make::Run(run) => of_run(run),
        Make::Part(run, part) => {
            let stages = Stages::new(session, plan, run)?;
            (vec![stages.place(part).file()], stages.is_kept(part))
        }
    };
    let needs = needed(make).into_iter();
    let needs = needs.map(|make| key(session, Portion { plan, make }));
    Ok(Unit {
        key: key(session, portion)?,
        needs: needs.collect::<Result<_, StudyError>>()?,
        files,
        urgency: match make {
            Make::Truth => 3,
            Make::Part(_, Part::First) => 2,
            Make::Part(_, Part::Others(_)) => 1,
            Make::Run(_) => 0,
        },
        is_kept,
    })
}

/// What must be there before a portion is made.
fn needed(make: Make<'_>) -> Vec<Make<'_>> {
    match make {
        Make::Truth | Make::Run(_) => Vec::new(),
        Make::Part(_, Part::First) => vec![Make::Truth],
        Make::Part(run, Part::Others(_)) => {
            vec![Make::Truth, Make::Part(run, Part::First)]
        }
    }
}
