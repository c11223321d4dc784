//! Studies: what does less error cost?

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use nephroid::Context;
use nephroid::internals::study::attribution::AttributionError;
use nephroid::internals::study::file::{FileError, StudyCandidate, StudyWishes, report_folder};
use nephroid::internals::study::limit::{self, StudyLimit};
use nephroid::internals::study::plan::PlanError;
use nephroid::internals::study::validation::{
    self as validation, News, Report, Watcher, validate, validate_scene,
};
use nephroid::internals::study::{StudyError, StudyFile};
use pyo3::prelude::*;

use crate::errors;
use crate::scene::Scene;
use crate::work::{Progress, work, work_told};

/// The subject of a study.
#[derive(FromPyObject)]
pub enum Subject<'py> {
    /// A scene that is read already.
    Scene(PyRef<'py, Scene>),
    /// The file of a scene or a study.
    Path(PathBuf),
}

/// A wish for a study, as Python tells it.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct StudyWish {
    define: Vec<(String, String)>,
    sensors: Vec<String>,
    candidates: Vec<(String, PathBuf)>,
    max_error: Vec<(String, String)>,
    margin: Option<f64>,
    repeats: Option<u32>,
    threads: Option<usize>,
    cache: Option<PathBuf>,
    /// The text of the study's file, if the study is none.
    study: Option<String>,
}

impl StudyWish {
    fn wishes(&self, py: Python<'_>) -> PyResult<StudyWishes> {
        let candidates = self.candidates.iter().map(|(name, file)| {
            StudyCandidate::named(name, file).ok_or_else(|| {
                let message = format!(
                    "no candidate can be called \"{name}\"; allowed are NAME and NAME@SENSOR"
                );
                errors::setting(py, message)
            })
        });
        let max_error = self.max_error.iter().map(|(name, value)| {
            StudyLimit::parse(name, value).ok_or_else(|| {
                let message = format!(
                    "max_error is {name}={value}; allowed are {}",
                    limit::ALLOWED
                );
                errors::setting(py, message)
            })
        });
        Ok(StudyWishes {
            define: self.define.clone(),
            sensors: self.sensors.clone(),
            candidates: candidates.collect::<PyResult<_>>()?,
            max_error: max_error.collect::<PyResult<_>>()?,
            margin: self.margin,
            repeats: self.repeats,
        })
    }
}

/// How far a study is.
#[pyclass(frozen, module = "nephroid")]
pub struct StudyProgress {
    /// Runs that are done, those kept from before among them.
    #[pyo3(get)]
    done: usize,
    /// All runs; None until they are planned.
    #[pyo3(get)]
    expected: Option<usize>,
    /// `runs`.
    #[pyo3(get)]
    unit: &'static str,
    /// What is made now, as `truth, beams`.
    #[pyo3(get)]
    name: String,
    /// The pose that is studied, from 1; None of studies without poses.
    #[pyo3(get)]
    pose: Option<usize>,
    /// How far the run under way is.
    #[pyo3(get)]
    run: Py<Progress>,
    /// Seconds since its start.
    #[pyo3(get)]
    seconds: f64,
}

#[pymethods]
impl StudyProgress {
    fn __repr__(&self) -> String {
        let expected = self
            .expected
            .map_or_else(|| "?".to_owned(), |n| n.to_string());
        format!(
            "<nephroid.StudyProgress {} of {expected} runs after {:.1} s: {}>",
            self.done, self.seconds, self.name
        )
    }
}

/// Where a study is, by the last news of it.
#[derive(Clone, Default)]
struct Place {
    done: usize,
    all: Option<usize>,
    name: String,
    pose: Option<usize>,
}

/// Notes where a study is.
#[derive(Clone, Default)]
struct Note(Arc<Mutex<Place>>);

impl Note {
    fn place(&self) -> Place {
        self.0
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .clone()
    }
}

impl Watcher for Note {
    fn hear(&mut self, news: News) {
        let mut place = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        match news {
            News::Pose(number, ..) => place.pose = Some(number),
            News::Planned(plan, _) => {
                place.all = Some(plan.count());
                place.done = 0;
            }
            News::Begins(task) => {
                place.done = task.number - 1;
                place.name.clone_from(&task.name);
            }
            News::Done(task, ..) => place.done = task.number,
            News::Judges(_, _, label) => place.name = format!("judging {label}"),
            News::PosesLeft(..)
            | News::RunsLeft(..)
            | News::Counts(..)
            | News::Judged(_)
            | News::Stopped(..) => (),
        }
    }
}

/// The folder of a study's report if none is named.
#[pyfunction]
pub fn default_folder(study: PathBuf) -> PathBuf {
    report_folder(&study)
}

/// Makes a study, and writes its report into a folder. Tells whether it is complete, and whether it is of several poses;
/// None if it was stopped.
#[pyfunction(name = "validate")]
pub fn validate_study(
    py: Python<'_>,
    subject: Subject<'_>,
    folder: PathBuf,
    wish: StudyWish,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Option<(bool, bool)>> {
    let mut wishes = wish.wishes(py)?;
    let context = Context {
        cache: wish.cache.clone(),
        ..Context::default()
    };
    let (scene, path) = match subject {
        Subject::Scene(scene) => {
            wishes.define = scene.parameters().to_vec();
            (
                Some(Arc::clone(&scene.inner)),
                scene.inner.path().to_owned(),
            )
        }
        Subject::Path(path) => (None, path),
    };
    let watched = Arc::clone(&context.progress);
    let mut note = Note::default();
    let noted = note.clone();
    let told = |run: Progress| -> PyResult<StudyProgress> {
        let place = noted.place();
        Ok(StudyProgress {
            done: place.done,
            expected: place.all,
            unit: "runs",
            name: place.name,
            pose: place.pose,
            seconds: run.seconds,
            run: Py::new(py, run)?,
        })
    };
    let text = wish.study;
    let done = work_told(py, wish.threads, &watched, progress, told, move || {
        let file = study_file(&path, text.as_deref(), scene.is_some(), &wishes)?;
        match scene {
            Some(scene) => validate_scene(scene, &file, &folder, &context, &mut note),
            None => validate(&file, &folder, &context, &mut note),
        }
    })?;
    let found = done.map_err(|error| raised(py, &error))?;
    let is_complete = found.is_complete;
    Ok(found
        .report
        .map(|report| (is_complete, matches!(report, Report::Poses(_)))))
}

/// What is asked for: a study from its text, from its file, or of a scene; of a scene that is read already, if
/// `is_read`.
fn study_file(
    path: &Path,
    text: Option<&str>,
    is_read: bool,
    wishes: &StudyWishes,
) -> Result<StudyFile, StudyError> {
    let file = match text {
        // The text has no file: paths in it are relative to the working folder.
        Some(text) => StudyFile::parse("<study>".as_ref(), text)?,
        None if is_read => StudyFile::of_scene(""),
        None => return Ok(StudyFile::wanted(path, wishes)?),
    };
    let file = file.with(wishes);
    Ok(if is_read {
        let scene = path.to_owned();
        StudyFile { scene, ..file }
    } else {
        file
    })
}

/// A unit of a study as Python knows it: key, keys of those that it needs, files, urgency, and whether it is
/// kept.
type UnitRow = (String, Vec<String>, Vec<String>, usize, bool);

/// A study without poses, or one of a pose: the pose's number, the folder of films, the scene, and the units.
type PoseRow = (Option<usize>, PathBuf, Py<Scene>, Vec<UnitRow>);

/// The studies of a study's poses, or the study itself; before them the text of its file, if it has one.
#[pyfunction]
pub fn units(
    py: Python<'_>,
    subject: Subject<'_>,
    folder: PathBuf,
    wish: StudyWish,
) -> PyResult<(Option<String>, Vec<PoseRow>)> {
    let mut wishes = wish.wishes(py)?;
    let (read, path) = match subject {
        Subject::Scene(scene) => {
            wishes.define = scene.parameters().to_vec();
            let path = scene.inner.path().to_owned();
            (Some(Py::from(scene)), path)
        }
        Subject::Path(path) => (None, path),
    };
    let inner = read.as_ref().map(|scene| Arc::clone(&scene.get().inner));
    let given = wish.study;
    let found = work(py, wish.threads, &Arc::default(), None, move || {
        let is_file = given.is_none() && inner.is_none() && StudyFile::is_study(&path);
        let (text, file) = if is_file {
            let text = StudyFile::text(&path)?;
            let file = StudyFile::parse(&path, &text)?.with(&wishes);
            (Some(text), file)
        } else {
            let file = study_file(&path, given.as_deref(), inner.is_some(), &wishes)?;
            (given, file)
        };
        if file.time.is_some() {
            return Ok(None);
        }
        let found = match inner {
            Some(scene) => vec![(
                None,
                folder.join("runs"),
                None,
                rows(&scene, &file, &folder)?,
            )],
            None => rows_of_poses(&file, &folder)?,
        };
        Ok(Some((text, found)))
    })?;
    let Some((text, found)) = found.map_err(|error: StudyError| raised(py, &error))? else {
        let message =
            "the time of a study limits when its last run begins on one machine; leave it out";
        return Err(errors::setting(py, message));
    };
    let found = found.into_iter().map(|(pose, runs, scene, rows)| {
        let scene = match (scene, &read) {
            (Some(scene), _) => Py::new(py, scene)?,
            (None, Some(scene)) => scene.clone_ref(py),
            (None, None) => return Err(errors::plain(py, "a study without a scene")),
        };
        Ok((pose, runs, scene, rows))
    });
    Ok((text, found.collect::<PyResult<_>>()?))
}

/// A [`PoseRow`] before Python has it; without a scene that is there already.
type FoundRow = (Option<usize>, PathBuf, Option<Scene>, Vec<UnitRow>);

fn rows_of_poses(file: &StudyFile, folder: &Path) -> Result<Vec<FoundRow>, StudyError> {
    let poses = validation::of_poses(file, folder)?.into_iter();
    let rows = poses.map(|(pose, file, folder)| {
        let scene = Scene::read(file.scene.clone(), &file.define)?;
        let rows = rows(&scene.inner, &file, &folder)?;
        Ok((pose, folder.join("runs"), Some(scene), rows))
    });
    rows.collect()
}

fn rows(
    scene: &Arc<nephroid::Scene>,
    file: &StudyFile,
    folder: &Path,
) -> Result<Vec<UnitRow>, StudyError> {
    let units = validation::units(scene, file, folder)?.into_iter();
    let rows = units.map(|one| (one.key, one.needs, one.files, one.urgency, one.is_kept));
    Ok(rows.collect())
}

/// Makes the unit of a key in a folder of its own. False if it was stopped.
#[pyfunction]
pub fn unit(
    py: Python<'_>,
    scene: &Scene,
    key: String,
    folder: PathBuf,
    wish: StudyWish,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<bool> {
    let mut wishes = wish.wishes(py)?;
    wishes.define = scene.parameters().to_vec();
    let context = Context {
        cache: wish.cache.clone(),
        ..Context::default()
    };
    let watched = Arc::clone(&context.progress);
    let (inner, text) = (Arc::clone(&scene.inner), wish.study);
    let done = work(py, wish.threads, &watched, progress, move || {
        let file = study_file(inner.path(), text.as_deref(), true, &wishes)?;
        let note = &mut Note::default();
        validation::validate_unit(Arc::clone(&inner), &file, &key, &folder, &context, note)
    })?;
    done.map_err(|error| raised(py, &error))
}

fn raised(py: Python<'_>, error: &StudyError) -> PyErr {
    match error {
        StudyError::File(FileError::Read { path, cause }) => {
            errors::load_one(py, format!("cannot read it: {cause}"), path, (0, 0))
        }
        StudyError::File(FileError::Content {
            path,
            line,
            column,
            message,
        }) => errors::load_one(py, message.clone(), path, (*line, *column)),
        StudyError::Scene(error) => errors::load(py, error),
        StudyError::NoSensor(_)
        | StudyError::Plan(PlanError::Sensor { .. } | PlanError::NotACamera { .. }) => {
            errors::refused(py, error)
        }
        StudyError::Plan(_) | StudyError::CandidateOfPoses(_) => errors::setting(py, error),
        StudyError::Method { cause, .. } => errors::run_as(py, cause, error),
        StudyError::Attribution { cause, .. } => match &**cause {
            AttributionError::Truth(cause) | AttributionError::Approximation(cause) => {
                errors::run_as(py, cause, error)
            }
            _ => errors::plain(py, error),
        },
        _ => errors::plain(py, error),
    }
}
