//! Which stage of a technique makes its error?

use std::sync::Arc;

use nephroid::internals::study::attribution::AttributionError;
use nephroid::internals::study::attribution::wanted::{Limits, Wanted};
use pyo3::prelude::*;

use crate::errors;
use crate::film::from_json;
use crate::render::Wish;
use crate::scene::Scene;
use crate::work::work;

/// Shares out the error of the wish's technique among its stages; None if it was stopped. `limits` are those of the
/// truth.
#[pyfunction]
pub fn attribute<'py>(
    py: Python<'py>,
    scene: &Scene,
    wish: Wish,
    limits: Vec<(String, String)>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Option<Bound<'py, PyAny>>> {
    let context = wish.context();
    let (inner, threads) = (Arc::clone(&scene.inner), wish.threads);
    let watched = Arc::clone(&context.progress);
    let done = work(
        py,
        threads,
        &watched,
        progress,
        move || -> Result<_, AttributionError> {
            let limits = Limits::of(&limits.into_iter().collect())?;
            let method = (wish.method.as_deref(), &wish.given());
            let wanted = Wanted::new(&inner, wish.sensor.as_deref(), method, &limits)?;
            wanted.attribute(&inner, &context, &mut |_, _| (), |truth| truth())
        },
    )?;
    let found = done.map_err(|error| match &error {
        AttributionError::Truth(cause) | AttributionError::Approximation(cause) => {
            errors::run_as(py, cause, &error)
        }
        AttributionError::NoStages(..) => errors::setting(py, &error),
        _ => errors::plain(py, &error),
    })?;
    let Some(found) = found else {
        return Ok(None);
    };
    let value = serde_json::to_value(&found).map_err(|error| errors::plain(py, error))?;
    from_json(py, &value).map(Some)
}
