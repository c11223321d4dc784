//! Runs, shards, and their sum.

use std::io::Cursor;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use nephroid::internals::method::wanted::{Chosen, Wanted};
use nephroid::internals::reference::parts::{
    GatherError, Gathered, Next, Part, Shards, Step, Wanted as WantedStep,
};
use nephroid::internals::reference::shard::Shard;
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

/// Traces part `index` of `count` of a run, both from 1 on; None if it was stopped.
#[pyfunction]
pub fn shard<'py>(
    py: Python<'py>,
    scene: &Scene,
    index: u32,
    count: u32,
    wish: Wish,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Option<Bound<'py, PyBytes>>> {
    let part = checked_shard(py, index, count)?;
    let context = wish.context();
    let (inner, threads) = (Arc::clone(&scene.inner), wish.threads);
    let watched = Arc::clone(&context.progress);
    let done = work(py, threads, &watched, progress, move || {
        let chosen = wish.choose(&inner, true).map_err(GatherError::from)?;
        chosen
            .method
            .run_shard(&inner, &chosen.sensor, part, &context)
    })?;
    let file = done.map_err(|error: GatherError| errors::merge(py, &error))?;
    Ok(file.map(|file| PyBytes::new(py, &file)))
}

fn checked_shard(py: Python<'_>, index: u32, count: u32) -> PyResult<Shard> {
    if !(1..=count).contains(&index) {
        let message = format!("index is {index} of {count}; allowed are 1..={count}");
        return Err(errors::setting(py, message));
    }
    let index = index - 1;
    Ok(Shard { index, count })
}

fn written<'py>(py: Python<'py>, part: &Part) -> PyResult<Bound<'py, PyBytes>> {
    let bytes = py.detach(|| {
        let mut bytes = Vec::new();
        part.write_to(&mut bytes).map(|()| bytes)
    });
    let bytes = bytes.map_err(|error| errors::plain(py, error))?;
    Ok(PyBytes::new(py, &bytes))
}

/// Puts the parts of a run together: the bits of the run in one piece.
#[pyfunction]
pub fn merge(
    py: Python<'_>,
    scene: &Scene,
    parts: Vec<PyBackedBytes>,
    mut wish: Wish,
) -> PyResult<Film> {
    let start = Instant::now();
    let mut shards = Shards::default();
    for (part, number) in parts.into_iter().zip(1..) {
        let opened = shards.open(format!("part {number}"), Box::new(Cursor::new(part)));
        opened.map_err(|error| errors::plain(py, error))?;
    }
    wish.method = shards.method().map(str::to_owned);
    let context = wish.context();
    let (inner, threads) = (Arc::clone(&scene.inner), wish.threads);
    let watched = Arc::clone(&context.progress);
    let done = work(py, threads, &watched, None, move || {
        let chosen = wish.choose(&inner, true).map_err(GatherError::from)?;
        let Chosen { sensor, method, .. } = &chosen;
        let rendering = method.merge(&inner, sensor, &mut shards, &context)?;
        Ok((chosen, rendering))
    })?;
    let (chosen, rendering) = done.map_err(|error: GatherError| errors::merge(py, &error))?;
    Ok(film(scene, chosen, rendering, start))
}

/// Traces part `index` of `count` of a step of a run, both from 1 on; None if it was stopped.
#[pyfunction]
pub fn part<'py>(
    py: Python<'py>,
    scene: &Scene,
    step: &str,
    index: u32,
    count: u32,
    wish: Wish,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Option<Bound<'py, PyBytes>>> {
    let shard = checked_shard(py, index, count)?;
    let step: Step = serde_json::from_str(step)
        .map_err(|error| errors::plain(py, format!("the step is none of a run: {error}")))?;
    let context = wish.context();
    let (inner, threads) = (Arc::clone(&scene.inner), wish.threads);
    let watched = Arc::clone(&context.progress);
    let done = work(py, threads, &watched, progress, move || {
        let Chosen { sensor, method, .. } = wish.choose(&inner, true)?;
        method.run_part(&inner, &sensor, &step, shard, &context)
    })?;
    let part = done.map_err(|error| errors::run(py, &error))?;
    part.map(|part| written(py, &part)).transpose()
}

/// A run whose parts come from elsewhere, in any order.
#[pyclass(frozen, module = "nephroid._nephroid")]
pub struct Gathering {
    scene: Py<Scene>,
    chosen: Chosen,
    context: Context,
    threads: Option<usize>,
    start: Instant,
    gathered: Arc<Mutex<Gathered>>,
    /// The step that it needs; none before the first question.
    wanted: Mutex<Option<WantedStep>>,
}

#[pymethods]
impl Gathering {
    #[new]
    fn new(py: Python<'_>, scene: Py<Scene>, wish: Wish) -> PyResult<Self> {
        let chosen = wish.choose(&scene.get().inner, true);
        Ok(Self {
            chosen: chosen.map_err(|error| errors::run(py, &error))?,
            scene,
            context: wish.context(),
            threads: wish.threads,
            start: Instant::now(),
            gathered: Arc::default(),
            wanted: Mutex::default(),
        })
    }

    /// Adds part `index` of `count` of the step that `next` told, both from 1 on.
    fn add(&self, py: Python<'_>, part: PyBackedBytes, index: u32, count: u32) -> PyResult<()> {
        let shard = checked_shard(py, index, count)?;
        // The lock is not to be held on the way without the interpreter: another thread that adds waits with it.
        let wanted = {
            let wanted = self.wanted.lock().unwrap_or_else(PoisonError::into_inner);
            wanted.clone()
        };
        let Some(wanted) = wanted else {
            return Err(errors::plain(py, "the run needs no part"));
        };
        let added = py.detach(|| {
            let part = Part::read_from(&part[..])?;
            let mut gathered = self.gathered.lock().unwrap_or_else(PoisonError::into_inner);
            gathered.add(&wanted, shard, part)
        });
        added.map_err(|error| errors::plain(py, error))
    }

    /// The step that the run needs next, with the key of its contents, its work in photons, paths or rays,
    /// the most parts that it has and the most work that may follow; or the film, if none is needed.
    /// `callback` is told meanwhile, and stops the run by returning False: then it is None.
    fn next<'py>(
        &self,
        py: Python<'py>,
        callback: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let scene = self.scene.get();
        let (inner, gathered) = (Arc::clone(&scene.inner), Arc::clone(&self.gathered));
        let (chosen, context) = (self.chosen.clone(), self.context.clone());
        let progress = Arc::clone(&context.progress);
        let found = work(py, self.threads, &progress, callback, move || {
            let gathered = gathered.lock().unwrap_or_else(PoisonError::into_inner);
            let Chosen { sensor, method, .. } = chosen;
            method.next(&inner, &sensor, &gathered, &context)
        })?;
        if self.context.progress.is_stopped() {
            // Whatever it has found by then, it may have found less than it needs.
            return Ok(py.None().into_bound(py));
        }
        match found.map_err(|error| errors::merge(py, &error))? {
            Next::Step(wanted) => {
                let step = serde_json::to_string(&wanted.step)
                    .map_err(|error| errors::plain(py, error))?;
                let (work, most, left) = (wanted.work, wanted.most_parts, wanted.left);
                let told = (step, wanted.key.clone(), work, most, left);
                *self.wanted.lock().unwrap_or_else(PoisonError::into_inner) = Some(*wanted);
                Ok(told.into_pyobject(py)?.into_any())
            }
            Next::Done(rendering) => {
                let film = film(scene, self.chosen.clone(), *rendering, self.start);
                Ok(Py::new(py, film)?.into_bound(py).into_any())
            }
        }
    }

    /// The error of all rounds that are whole; None while it is not known.
    #[getter]
    fn relative_error(&self) -> Option<f64> {
        self.context.progress.relative_error()
    }
}
