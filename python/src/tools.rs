//! Comparison, images, the table of methods.

use std::path::PathBuf;
use std::sync::Arc;

use nephroid::{CompareImage, CompareSettings, Image, Method, compare as compare_images, read_exr};
use numpy::{PyReadonlyArray3, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::errors;
use crate::film::{Film, from_json};
use crate::work::work;

/// A side of a comparison.
#[derive(FromPyObject)]
pub enum Side<'py> {
    /// A film of this module.
    Film(Bound<'py, Film>),
    /// Values of the layer of all light.
    Array(PyReadonlyArray3<'py, f64>),
    /// An EXR.
    Path(PathBuf),
}

impl Side<'_> {
    fn image(&self, name: &str) -> Result<CompareImage, String> {
        match self {
            Self::Film(film) => {
                let film = film.get();
                Ok(CompareImage::new(name, film.rendering.image(&film.scene)))
            }
            Self::Array(array) => Ok(CompareImage::new(name, image(array, "E")?)),
            Self::Path(path) => {
                let image = read_exr(path).map_err(|error| error.to_string())?;
                Ok(CompareImage::new(path.display().to_string(), image))
            }
        }
    }
}

/// An image of one layer, or without one if its name is empty; of one channel or three.
fn image(array: &PyReadonlyArray3<'_, f64>, layer: &str) -> Result<Image, String> {
    let &[height, width, channels] = array.shape() else {
        return Err("an array must have three dimensions".to_owned());
    };
    let mut image = Image::new(width, height);
    let array = array.as_array();
    let names = match channels {
        1 => &["Y"][..],
        3 => &["R", "G", "B"],
        _ => {
            return Err(format!(
                "an array of {channels} channels; 1 and 3 are allowed"
            ));
        }
    };
    for (channel, name) in names.iter().enumerate() {
        let name = match layer {
            "" => (*name).to_owned(),
            layer => format!("{layer}.{name}"),
        };
        let plane = array.index_axis(numpy::ndarray::Axis(2), channel);
        image.add_scalar(name, plane.iter().copied());
    }
    Ok(image)
}

/// Figures of the difference of two images, by name.
#[pyfunction]
pub fn compare<'py>(
    py: Python<'py>,
    a: Side<'py>,
    b: Side<'py>,
    margin: Option<f64>,
) -> PyResult<Bound<'py, PyAny>> {
    let wrong = |message: String| errors::plain(py, message);
    let (a, b) = (a.image("a").map_err(wrong)?, b.image("b").map_err(wrong)?);
    let mut settings = CompareSettings::default();
    if let Some(margin) = margin {
        settings.margin = margin;
    }
    let compared = work(py, None, &Arc::default(), None, move || {
        let report = compare_images(&a, &b, &settings).map_err(|error| error.to_string())?;
        serde_json::to_value(&report).map_err(|error| error.to_string())
    })?;
    from_json(py, &compared.map_err(wrong)?)
}

/// An array of one channel or three as an EXR.
#[pyfunction]
pub fn exr<'py>(
    py: Python<'py>,
    array: PyReadonlyArray3<'py, f64>,
) -> PyResult<Bound<'py, PyBytes>> {
    let wrong = |message: String| errors::plain(py, message);
    let image = image(&array, "").map_err(wrong)?;
    let written = work(py, Some(1), &Arc::default(), None, move || {
        let folder = tempfile::tempdir().map_err(|error| error.to_string())?;
        let path = folder.path().join("array.exr");
        nephroid::internals::film::exr::write(&path, &image).map_err(|error| error.to_string())?;
        std::fs::read(&path).map_err(|error| error.to_string())
    })?;
    Ok(PyBytes::new(py, &written.map_err(wrong)?))
}

/// All methods: name, meaning, whether it is a technique, and rows of settings.
#[pyfunction]
pub fn methods<'py>(py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
    let all = Method::names().into_iter().filter_map(|name| {
        let method = Method::new(name, &Default::default()).ok()?;
        let rows = nephroid::internals::method::table::rows(name);
        let rows: Vec<_> = rows
            .iter()
            .map(|row| {
                serde_json::json!({
                    "name": row.key.replace('-', "_"),
                    "default": row.default.text(),
                    "unit": row.unit,
                    "meaning": row.meaning,
                    "allowed": row.kind.allowed(),
                })
            })
            .collect();
        let about = serde_json::json!({
            "meaning": method.meaning(),
            "technique": method.is_technique(),
            "settings": rows,
        });
        Some((name.to_owned(), about))
    });
    from_json(py, &serde_json::Value::Object(all.collect()))
}
