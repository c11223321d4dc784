//! Runs, shards, and their sum.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use nephroid::internals::method::shards::MergeError;
use nephroid::internals::method::wanted::{Chosen, Wanted};
use nephroid::internals::reference::photons::Shard;
use nephroid::internals::reference::photons::shard::Part;
use nephroid::internals::scene::ReconstructionFilter;
use nephroid::internals::setting::Given;
use nephroid::{Budget, Context, Error, Rendering};
use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;
use pyo3::types::PyBytes;

use crate::errors;
use crate::film::Film;
use crate::scene::Scene;
use crate::work::work;

/// A wish for a run, as Python tells it.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Wish {
    pub sensor: Option<String>,
    pub method: Option<String>,
    /// Settings as text.
    settings: Vec<(String, String)>,
    /// True for a box filter instead of the scene's.
    is_box: bool,
    pub threads: Option<usize>,
    cache: Option<PathBuf>,
    memory: Option<u64>,
}

impl Wish {
    /// Its settings by key.
    pub fn given(&self) -> Given {
        self.settings.iter().cloned().collect()
    }

    fn choose(&self, scene: &nephroid::Scene, is_shard: bool) -> Result<Chosen, Error> {
        let given = self.given();
        let wanted = Wanted {
            sensor: self.sensor.as_deref(),
            method: self.method.as_deref(),
            given: &given,
            is_shard,
            filter: self.is_box.then_some(ReconstructionFilter::Box),
        };
        wanted.choose(scene, &str::to_owned)
    }

    /// Without a number of threads, which a pool of its own has.
    pub fn context(&self) -> Context {
        Context {
            cache: self.cache.clone(),
            memory_limit: self.memory,
            ..Context::default()
        }
    }
}

/// The film of a run that began at `start`.
fn film(scene: &Scene, chosen: Chosen, rendering: Rendering, start: Instant) -> Film {
    Film {
        rendering,
        scene: Arc::clone(&scene.inner),
        sensor: chosen.sensor.id,
        method: chosen.method.name(),
        notice: chosen.notice,
        seconds: start.elapsed().as_secs_f64(),
    }
}

/// Fills a sensor.
#[pyfunction]
pub fn render(
    py: Python<'_>,
    scene: &Scene,
    wish: Wish,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Film> {
    let start = Instant::now();
    let context = wish.context();
    let (inner, threads) = (Arc::clone(&scene.inner), wish.threads);
    let watched = Arc::clone(&context.progress);
    let done = work(py, threads, &watched, progress, move || {
        let chosen = wish.choose(&inner, false)?;
        let Chosen { sensor, method, .. } = &chosen;
        let rendering = method.run(&inner, sensor, &Budget::default(), &context)?;
        Ok((chosen, rendering))
    })?;
    let (chosen, rendering) = done.map_err(|error: Error| errors::run(py, &error))?;
    Ok(film(scene, chosen, rendering, start))
}

/// Traces part `index` of `count` of a run of photons, both from 1 on; None if it was stopped.
#[pyfunction]
pub fn shard<'py>(
    py: Python<'py>,
    scene: &Scene,
    index: u32,
    count: u32,
    wish: Wish,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Option<Bound<'py, PyBytes>>> {
    if !(1..=count).contains(&index) {
        let message = format!("index is {index} of {count}; allowed are 1..={count}");
        return Err(errors::setting(py, message));
    }
    let part = Shard {
        index: index - 1,
        count,
    };
    let context = wish.context();
    let (inner, threads) = (Arc::clone(&scene.inner), wish.threads);
    let watched = Arc::clone(&context.progress);
    let done = work(py, threads, &watched, progress, move || {
        let chosen = wish.choose(&inner, true)?;
        chosen
            .method
            .run_shard(&inner, &chosen.sensor, part, &context)
    })?;
    let Some(part) = done.map_err(|error| errors::run(py, &error))? else {
        return Ok(None);
    };
    let mut bytes = Vec::new();
    part.write_to(&mut bytes)
        .map_err(|error| errors::plain(py, error))?;
    Ok(Some(PyBytes::new(py, &bytes)))
}

/// Puts the parts of a run together: the bits of the run in one piece.
#[pyfunction]
pub fn merge(
    py: Python<'_>,
    scene: &Scene,
    parts: Vec<PyBackedBytes>,
    wish: Wish,
) -> PyResult<Film> {
    let start = Instant::now();
    let read = parts.iter().map(|part| Part::read_from(&part[..]));
    let parts: Vec<Part> = read
        .collect::<Result<_, _>>()
        .map_err(|error| errors::plain(py, error))?;
    let context = wish.context();
    let (inner, threads) = (Arc::clone(&scene.inner), wish.threads);
    let watched = Arc::clone(&context.progress);
    let done = work(py, threads, &watched, None, move || {
        let chosen = wish.choose(&inner, true).map_err(MergeError::from)?;
        let Chosen { sensor, method, .. } = &chosen;
        let rendering = method.merge(&inner, sensor, parts, &context)?;
        Ok((chosen, rendering))
    })?;
    let (chosen, rendering) = done.map_err(|error: MergeError| errors::merge(py, &error))?;
    Ok(film(scene, chosen, rendering, start))
}
