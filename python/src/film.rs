//! A result, with its maps as arrays.

use std::path::PathBuf;
use std::sync::Arc;

use nephroid::internals::film::Grid;
use nephroid::internals::film::picture::{self, Content, PictureSpec, Scale};
use nephroid::internals::run::account::LedgerSummary;
use nephroid::{Rendering, Rgb};
use numpy::PyArray3;
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::errors;
use crate::view;

/// Python's value of a JSON text.
pub fn from_json<'py>(py: Python<'py>, value: &serde_json::Value) -> PyResult<Bound<'py, PyAny>> {
    py.import("json")?
        .call_method1("loads", (value.to_string(),))
}

/// A map of irradiance or radiance with its error bars, layer by layer.
#[pyclass(frozen, module = "nephroid", mapping)]
pub struct Film {
    pub rendering: Rendering,
    pub scene: Arc<nephroid::Scene>,
    pub sensor: String,
    pub method: &'static str,
    pub notice: Option<String>,
    pub seconds: f64,
}

/// A map of one kind of light. It shares the film's memory.
#[pyclass(frozen, module = "nephroid")]
pub struct Layer {
    film: Py<Film>,
    /// 0 is the sum of all layers.
    index: usize,
}

type Map<'py> = Bound<'py, PyArray3<f64>>;

/// The maps of a layer, in the order in which files have them.
#[derive(Clone, Copy)]
enum Part {
    Value,
    Low,
    High,
    Error,
}

impl Film {
    fn layer(&self, index: usize) -> &nephroid::Layer {
        let estimate = &self.rendering.estimate;
        match index {
            0 => &estimate.total,
            _ => &estimate.layers[index - 1],
        }
    }

    fn name(&self, index: usize) -> String {
        self.layer(index).name.of(self.rendering.estimate.quantity)
    }

    fn index(&self, name: &str) -> Option<usize> {
        (0..=self.rendering.estimate.layers.len()).find(|index| self.name(*index) == name)
    }

    /// A map of a layer, as files have it; `None` if the method does not know it.
    fn part(&self, index: usize, part: Part) -> Option<&[Rgb]> {
        let layer = self.layer(index);
        let bounds = layer.interval.as_ref().or(layer.sampling.as_ref());
        match part {
            Part::Value => Some(&layer.values),
            Part::Low => bounds.map(|bounds| &bounds.low[..]),
            Part::High => bounds.map(|bounds| &bounds.high[..]),
            Part::Error => {
                // Deterministic methods have bounds of their own alone.
                let errors = &layer.standard_error;
                let is_random = || errors.iter().any(|error| *error != Rgb::BLACK);
                (layer.interval.is_none() || is_random()).then_some(&errors[..])
            }
        }
    }
}

/// The array of a map.
fn map<'py>(film: &Bound<'py, Film>, index: usize, part: Part) -> PyResult<Option<Map<'py>>> {
    let inner = film.get();
    let estimate = &inner.rendering.estimate;
    let values = inner.part(index, part);
    values
        .map(|values| view::array(film, values, estimate.width, estimate.height))
        .transpose()
}

#[pymethods]
impl Film {
    /// Texel averages of all light, (rows, columns, 3).
    #[getter]
    fn value<'py>(slf: &Bound<'py, Self>) -> PyResult<Option<Map<'py>>> {
        map(slf, 0, Part::Value)
    }

    /// Lower bounds; None if the method has none.
    #[getter]
    fn lo<'py>(slf: &Bound<'py, Self>) -> PyResult<Option<Map<'py>>> {
        map(slf, 0, Part::Low)
    }

    /// Upper bounds; None if the method has none.
    #[getter]
    fn hi<'py>(slf: &Bound<'py, Self>) -> PyResult<Option<Map<'py>>> {
        map(slf, 0, Part::High)
    }

    /// Standard errors; None of methods that draw nothing at random.
    #[getter]
    fn stderr<'py>(slf: &Bound<'py, Self>) -> PyResult<Option<Map<'py>>> {
        map(slf, 0, Part::Error)
    }

    /// Rows, columns, channels.
    #[getter]
    fn shape(&self) -> (usize, usize, usize) {
        let estimate = &self.rendering.estimate;
        (estimate.height, estimate.width, 3)
    }

    /// Names of all layers, the sum of all light first.
    #[getter]
    fn layers(&self) -> Vec<String> {
        let count = self.rendering.estimate.layers.len();
        (0..=count).map(|index| self.name(index)).collect()
    }

    fn keys(&self) -> Vec<String> {
        self.layers()
    }

    fn __len__(&self) -> usize {
        1 + self.rendering.estimate.layers.len()
    }

    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.layers().into_pyobject(py)?.call_method0("__iter__")
    }

    fn __contains__(&self, name: &Bound<'_, PyAny>) -> bool {
        name.extract::<String>()
            .is_ok_and(|name| self.index(&name).is_some())
    }

    fn __getitem__(slf: &Bound<'_, Self>, name: &str) -> PyResult<Layer> {
        let film = slf.get();
        let index = film.index(name).ok_or_else(|| {
            let there = film.layers().join(", ");
            PyKeyError::new_err(format!("no layer is called \"{name}\"; there are {there}"))
        })?;
        Ok(Layer {
            film: slf.clone().unbind(),
            index,
        })
    }

    /// The method's name.
    #[getter]
    fn method(&self) -> &'static str {
        self.method
    }

    /// The sensor's id.
    #[getter]
    fn sensor(&self) -> &str {
        &self.sensor
    }

    /// `irradiance` or `radiance`.
    #[getter]
    fn quantity(&self) -> &'static str {
        self.rendering.estimate.quantity.name()
    }

    /// The unit of all values.
    #[getter]
    fn unit(&self) -> &'static str {
        self.rendering.estimate.quantity.unit()
    }

    /// True if the run used its whole budget.
    #[getter]
    fn complete(&self) -> bool {
        !self.rendering.estimate.incomplete
    }

    /// Oddities of the scene and the run.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.rendering.all_warnings(&self.scene)
    }

    /// Why the method is not what one would expect, if it is not.
    #[getter]
    fn notice(&self) -> Option<&str> {
        self.notice.as_deref()
    }

    /// The error of the specular layers' sum, relative; None where it is not known.
    #[getter]
    fn relative_error(&self) -> Option<f64> {
        self.rendering.estimate.relative_error
    }

    /// Time of the run.
    #[getter]
    fn seconds(&self) -> f64 {
        self.seconds
    }

    /// The end of all traced flux [W]; None if the method does not know it.
    #[getter]
    fn ledger<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let ledger = LedgerSummary::of(&self.rendering.estimate).map(|ledger| {
            let mut value = serde_json::to_value(ledger).unwrap_or_default();
            // Rows by name rather than as pairs.
            if let Some(rows) = value["rows"].as_array() {
                let named = rows.iter();
                let named = named.filter_map(|row| Some((row[0].as_str()?.into(), row[1].clone())));
                value["rows"] = serde_json::Value::Object(named.collect());
            }
            value
        });
        from_json(py, &ledger.unwrap_or_default())
    }

    /// Method, sensor, all settings, and the method's own report.
    #[getter]
    fn report<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        from_json(
            py,
            &serde_json::Value::Object(self.rendering.report.clone()),
        )
    }

    /// All settings of the run.
    #[getter]
    fn settings<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let settings = self.rendering.report.get("settings");
        from_json(py, settings.unwrap_or(&serde_json::Value::Null))
    }

    /// Writes an EXR with all layers, whole or not at all.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        py.detach(|| self.rendering.write_exr(&self.scene, &path))
            .map_err(|error| errors::plain(py, error))
    }

    /// The sum of all light as a `mitsuba.Bitmap` of 32-bit floats.
    fn bitmap<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let py = slf.py();
        let values = map(slf, 0, Part::Value)?;
        let numbers = values
            .into_pyobject(py)?
            .call_method1("astype", ("float32",))?;
        py.import("mitsuba")?.getattr("Bitmap")?.call1((numbers,))
    }

    /// The sum of all light in false colours, as a PNG.
    fn png<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = py.detach(|| self.picture());
        Ok(PyBytes::new(
            py,
            &bytes.map_err(|message| errors::plain(py, message))?,
        ))
    }

    fn _repr_png_<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        self.png(py)
    }

    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let module = slf.py().import("nephroid._html")?;
        module.call_method1("film", (slf,))
    }

    /// Smallest, mean and largest texel of a layer, means of channels; and its relative error.
    fn range(&self, name: &str) -> Option<(f64, f64, f64, Option<f64>)> {
        let layer = self.layer(self.index(name)?);
        let range = layer.range();
        Some((range.min, range.mean, range.max, layer.relative_error()))
    }

    /// The address of a layer's values, for tests.
    fn _address(&self, name: &str) -> Option<usize> {
        Some(self.layer(self.index(name)?).values.as_ptr() as usize)
    }

    fn __repr__(&self) -> String {
        let (height, width, _) = self.shape();
        let state = if self.complete() { "" } else { ", incomplete" };
        format!(
            "<nephroid.Film {width} x {height}, {} [{}] by {}{state}: {}>",
            self.quantity(),
            self.unit(),
            self.method,
            self.layers().join(" ")
        )
    }
}

impl Film {
    fn picture(&self) -> Result<Vec<u8>, String> {
        let estimate = &self.rendering.estimate;
        let means = estimate.total.values.iter();
        let means = means.map(|value| value.mean() as f32).collect();
        let values = Grid::from_vec(estimate.width, estimate.height, means)
            .ok_or("the film does not fill its grid")?;
        let title = format!("{} · {}", self.sensor, self.quantity());
        let spec = PictureSpec {
            title: &title,
            unit: self.unit(),
            content: Content::FalseColour {
                values: &values,
                scale: Scale::Logarithmic,
            },
            range: None,
        };
        let folder = tempfile::tempdir().map_err(|error| error.to_string())?;
        let path = folder.path().join("film.png");
        picture::write(&path, &spec).map_err(|error| error.to_string())?;
        std::fs::read(&path).map_err(|error| error.to_string())
    }
}

#[pymethods]
impl Layer {
    /// The name: `E` or `L` of all light, else a signature or a class.
    #[getter]
    fn name(&self) -> String {
        self.film.get().name(self.index)
    }

    /// Texel averages, (rows, columns, 3).
    #[getter]
    fn value<'py>(&self, py: Python<'py>) -> PyResult<Option<Map<'py>>> {
        map(self.film.bind(py), self.index, Part::Value)
    }

    /// Lower bounds; None if the method has none.
    #[getter]
    fn lo<'py>(&self, py: Python<'py>) -> PyResult<Option<Map<'py>>> {
        map(self.film.bind(py), self.index, Part::Low)
    }

    /// Upper bounds; None if the method has none.
    #[getter]
    fn hi<'py>(&self, py: Python<'py>) -> PyResult<Option<Map<'py>>> {
        map(self.film.bind(py), self.index, Part::High)
    }

    /// Standard errors; None of methods that draw nothing at random.
    #[getter]
    fn stderr<'py>(&self, py: Python<'py>) -> PyResult<Option<Map<'py>>> {
        map(self.film.bind(py), self.index, Part::Error)
    }

    /// The layer's relative error; None where it is not known.
    #[getter]
    fn relative_error(&self) -> Option<f64> {
        self.film.get().layer(self.index).relative_error()
    }

    fn __repr__(&self) -> String {
        format!("<nephroid.Layer {}>", self.name())
    }
}
