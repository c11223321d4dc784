//! A scene, and how it was read.

use std::io;
use std::path::PathBuf;
use std::sync::Arc;

use nephroid::LoadError;
use nephroid::internals::mitsuba;
use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;
use pyo3::types::{PyBytes, PyDict};

use crate::errors;
use crate::work::work;

/// A file in memory.
type HeldFile = (PathBuf, Vec<u8>);

/// What a scene was read from; enough to read it again in another process.
struct Source {
    path: PathBuf,
    parameters: Vec<(String, String)>,
    held: Vec<HeldFile>,
    is_lenient: bool,
    /// All files read, those in memory among them.
    files: Vec<PathBuf>,
}

impl Source {
    /// The contents of all files, or the one that cannot be read.
    fn contents(&self) -> Result<Vec<HeldFile>, (PathBuf, io::Error)> {
        let mut files = self.held.clone();
        for path in &self.files {
            if files.iter().all(|(held, _)| held != path) {
                let bytes = std::fs::read(path).map_err(|error| (path.clone(), error))?;
                files.push((path.clone(), bytes));
            }
        }
        Ok(files)
    }
}

/// A scene that is ready to be measured. Made by `load_file`, `load_string` or `load_dict`.
#[pyclass(frozen, module = "nephroid")]
pub struct Scene {
    pub inner: Arc<nephroid::Scene>,
    source: Source,
}

impl Scene {
    /// The values of `$name` with which it was read.
    pub fn parameters(&self) -> &[(String, String)] {
        &self.source.parameters
    }

    /// A scene from a file of the disk.
    ///
    /// # Errors
    ///
    /// If it cannot be read.
    pub fn read(path: PathBuf, parameters: &[(String, String)]) -> Result<Self, LoadError> {
        Self::read_held(path, parameters.to_vec(), Vec::new(), false)
    }

    fn read_held(
        path: PathBuf,
        parameters: Vec<(String, String)>,
        held: Vec<HeldFile>,
        is_lenient: bool,
    ) -> Result<Self, LoadError> {
        let (scene, files) = mitsuba::load_held(&path, &parameters, &held, is_lenient)?;
        let source = Source {
            path,
            parameters,
            held,
            is_lenient,
            files,
        };
        Ok(Self {
            inner: Arc::new(scene),
            source,
        })
    }
}

/// The arguments of `load`.
type Arguments<'py> = (
    PathBuf,
    Vec<(String, String)>,
    Vec<(PathBuf, Bound<'py, PyBytes>)>,
    bool,
);

/// What pickle asks for: a function, and its arguments.
type Reduced<'py> = (Bound<'py, PyAny>, Arguments<'py>);

impl Scene {
    fn arguments<'a, 'py>(
        &self,
        py: Python<'py>,
        held: impl Iterator<Item = &'a HeldFile>,
    ) -> Arguments<'py> {
        let held = held.map(|(path, bytes)| (path.clone(), PyBytes::new(py, bytes)));
        let source = &self.source;
        (
            source.path.clone(),
            source.parameters.clone(),
            held.collect(),
            source.is_lenient,
        )
    }
}

#[pymethods]
impl Scene {
    /// The file that it was read from.
    #[getter]
    fn path(&self) -> String {
        self.inner.path().display().to_string()
    }

    /// A hash of all contents and parameters.
    #[getter]
    fn content_hash(&self) -> &str {
        self.inner.content_hash()
    }

    /// Ids of all sensors.
    #[getter]
    fn sensors(&self) -> Vec<String> {
        let sensors = self.inner.sensors().iter();
        sensors.map(|sensor| sensor.id.clone()).collect()
    }

    /// Oddities of the scene.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        let warnings = self.inner.warnings().iter();
        warnings.map(ToString::to_string).collect()
    }

    /// Rows and columns of a sensor's film.
    fn size(&self, py: Python<'_>, sensor: &str) -> PyResult<(usize, usize)> {
        let mut sensors = self.inner.sensors().iter();
        let found = sensors.find(|one| one.id == sensor);
        let [width, height] = found
            .ok_or_else(|| {
                let there = self.sensors().join(", ");
                let message = format!("no sensor is called \"{sensor}\"; there are {there}");
                errors::setting(py, message)
            })?
            .size();
        Ok((height, width))
    }

    /// Contents, requirements and costs, as the function of the same name tells them.
    #[pyo3(signature = (method = None, sensor = None, **settings))]
    fn inspect<'py>(
        slf: &Bound<'py, Self>,
        method: Option<Bound<'py, PyAny>>,
        sensor: Option<Bound<'py, PyAny>>,
        settings: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let module = slf.py().import("nephroid._about")?;
        module
            .getattr("inspect")?
            .call((slf, method, sensor), settings)
    }

    fn __repr__(&self) -> String {
        format!("<nephroid.Scene {}>", self.path())
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        let arguments = self.arguments(py, self.source.held.iter());
        Ok((py.import("nephroid._nephroid")?.getattr("load")?, arguments))
    }

    /// The arguments by which `load` reads the same scene where its files are not: all of them come along.
    fn _packed<'py>(&self, py: Python<'py>) -> PyResult<Arguments<'py>> {
        let files = py.detach(|| self.source.contents());
        let files = files.map_err(|(path, error)| {
            errors::load_one(py, format!("cannot be read: {error}"), &path, (0, 0))
        })?;
        Ok(self.arguments(py, files.iter()))
    }
}

/// Reads a scene: `held` are files in memory, which win over the disk.
#[pyfunction]
pub fn load(
    py: Python<'_>,
    path: PathBuf,
    parameters: Vec<(String, String)>,
    held: Vec<(PathBuf, PyBackedBytes)>,
    lenient: bool,
) -> PyResult<Scene> {
    let held: Vec<HeldFile> = held
        .into_iter()
        .map(|(path, bytes)| (path, bytes.to_vec()))
        .collect();
    let read = work(py, None, &Arc::default(), None, move || {
        Scene::read_held(path, parameters, held, lenient)
    })?;
    read.map_err(|error| errors::load(py, &error))
}
