//! What can be said of a scene without a film: its contents, and the light at one point.

use std::sync::Arc;
use std::time::Instant;

use nephroid::internals::method::inspection::{Advice, Inspection};
use nephroid::internals::method::sensors::choose_sensor;
use nephroid::internals::reference::probe::{ProbeError, ProbeReport, ProbeSettings};
use nephroid::{Error, Method, Progress};
use pyo3::prelude::*;
use serde_json::Value;

use crate::errors;
use crate::film::from_json;
use crate::render::Wish;
use crate::scene::Scene;
use crate::work::work;

/// Contents and requirements of a scene, and what the methods cost; of the wish's method, if it has one, what a pilot
/// advises, too.
#[pyfunction]
pub fn inspect<'py>(py: Python<'py>, scene: &Scene, wish: Wish) -> PyResult<Bound<'py, PyAny>> {
    let (inner, threads) = (Arc::clone(&scene.inner), wish.threads);
    let done = work(py, threads, &Arc::default(), None, move || {
        let mut found = Inspection::of(&inner);
        if let Some(name) = &wish.method {
            let method = Method::new(name, &wish.given())?;
            // What Python takes is the caller's: nothing of it is the method's.
            let advice = Advice::of(&method, &inner, wish.sensor.as_deref(), || 0)?;
            found.advice = Some(advice);
        }
        Ok(serde_json::to_value(&found))
    })?;
    let found = done.map_err(|error: Error| errors::run(py, &error))?;
    from_json(py, &found.map_err(|error| errors::plain(py, error))?)
}

/// Why there are no paths to a point.
enum NotProbed {
    Run(Error),
    Probe(ProbeError),
    Json(serde_json::Error),
}

impl NotProbed {
    fn raised(&self, py: Python<'_>) -> PyErr {
        match self {
            Self::Run(error) => errors::run(py, error),
            Self::Probe(error @ (ProbeError::OffReceiver(_) | ProbeError::Depth(_))) => {
                errors::setting(py, error)
            }
            Self::Probe(error) => errors::refused(py, error),
            Self::Json(error) => errors::plain(py, error),
        }
    }
}

/// All specular paths to the point (u, v) of the surface that the wish's sensor measures. The wish's settings are those
/// of the search.
#[pyfunction]
pub fn probe<'py>(
    py: Python<'py>,
    scene: &Scene,
    at: (f64, f64),
    wish: Wish,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let start = Instant::now();
    let (inner, threads) = (Arc::clone(&scene.inner), wish.threads);
    let watched = Arc::new(Progress::default());
    let heard = Arc::clone(&watched);
    let done = work(
        py,
        threads,
        &watched,
        progress,
        move || -> Result<Value, NotProbed> {
            let (settings, time) =
                ProbeSettings::of(&wish.given()).map_err(|error| NotProbed::Run(error.into()))?;
            let sensor = choose_sensor(&inner, wish.sensor.as_deref())
                .map_err(|refusal| NotProbed::Run(refusal.into()))?;
            let deadline = time.and_then(|time| start.checked_add(time));
            let report =
                ProbeReport::search((&inner, sensor), at.into(), settings, (deadline, &heard))
                    .map_err(NotProbed::Probe)?;
            serde_json::to_value(&report).map_err(NotProbed::Json)
        },
    )?;
    from_json(py, &done.map_err(|error| error.raised(py))?)
}
