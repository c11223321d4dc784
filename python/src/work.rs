//! Work on a thread of its own, in a pool of its own, while the caller listens for Ctrl-C.
//!
//! Rayon's global pool is never started: a process that was forked would wait for its threads, which it does not have.
//! No signal handler is installed. Python's own notes the signal, and the caller asks for it every 100 ms.

use std::sync::{Arc, Mutex, PoisonError, mpsc};
use std::thread;
use std::time::{Duration, Instant};

use pyo3::prelude::*;
use pyo3::{PyClass, PyClassInitializer};

use crate::errors;

/// Time between two looks at signals, and two calls of a callback.
const PERIOD: Duration = Duration::from_millis(100);

/// Time that work has to end once it is stopped by an exception. What goes on longer ends by itself, unheard.
const GRACE: Duration = Duration::from_millis(300);

/// Stack of a thread, that of a program's first thread: files may nest deeply.
const STACK: usize = 8 << 20;

/// How far a run is.
#[pyclass(frozen, module = "nephroid")]
#[derive(Clone)]
pub struct Progress {
    /// Work done, in the unit.
    #[pyo3(get)]
    done: u64,
    /// The number that `done` is expected to come to; None while unknown.
    #[pyo3(get)]
    expected: Option<u64>,
    /// The unit of work: photons, paths, texels or patches.
    #[pyo3(get)]
    unit: &'static str,
    /// The pass of beams, from 1; None for other methods.
    #[pyo3(get)]
    number: Option<u64>,
    /// The relative error so far; None while unknown.
    #[pyo3(get)]
    relative_error: Option<f64>,
    /// Seconds that the run is likely to take; None while unknown.
    #[pyo3(get)]
    forecast: Option<f64>,
    /// Seconds since its start.
    #[pyo3(get)]
    pub seconds: f64,
}

#[pymethods]
impl Progress {
    fn __repr__(&self) -> String {
        let expected = self
            .expected
            .map_or_else(|| "?".to_owned(), |n| n.to_string());
        format!(
            "<nephroid.Progress {} of {expected} {} after {:.1} s>",
            self.done, self.unit, self.seconds
        )
    }
}

impl Progress {
    fn of(progress: &nephroid::Progress, start: Instant) -> Self {
        Self {
            done: progress.done(),
            expected: progress.expected(),
            unit: progress.unit(),
            number: progress.pass(),
            relative_error: progress.relative_error(),
            forecast: progress.forecast().map(|time| time.as_secs_f64()),
            seconds: start.elapsed().as_secs_f64(),
        }
    }
}

/// Does `job` without Python's lock, on so many threads (all cores if none are asked for), and returns what it returns.
///
/// `callback` is told of `progress`; it stops the run by returning False.
///
/// # Errors
///
/// The exception of a signal's handler or of the callback, as it is, and an error if the threads cannot be started.
pub fn work<T: Send + 'static>(
    py: Python<'_>,
    threads: Option<usize>,
    progress: &Arc<nephroid::Progress>,
    callback: Option<&Bound<'_, PyAny>>,
    job: impl FnOnce() -> T + Send + 'static,
) -> PyResult<T> {
    work_told(py, threads, progress, callback, Ok, job)
}

/// As [`work`]; the callback is told what `told` makes of the progress.
///
/// # Errors
///
/// As [`work`].
pub fn work_told<T: Send + 'static, P: PyClass + Into<PyClassInitializer<P>>>(
    py: Python<'_>,
    threads: Option<usize>,
    progress: &Arc<nephroid::Progress>,
    callback: Option<&Bound<'_, PyAny>>,
    told: impl Fn(Progress) -> PyResult<P>,
    job: impl FnOnce() -> T + Send + 'static,
) -> PyResult<T> {
    let start = Instant::now();
    let (sender, receiver) = mpsc::channel();
    thread::Builder::new()
        .name("nephroid".to_owned())
        .stack_size(STACK)
        .spawn(move || {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads.unwrap_or(0))
                .stack_size(STACK)
                .build();
            // Whoever was interrupted does not listen any more.
            let _ = sender.send(pool.map(|pool| pool.install(job)));
        })?;
    let receiver = Mutex::new(receiver);
    let wait = |time: Duration| {
        py.detach(|| {
            let receiver = receiver.lock().unwrap_or_else(PoisonError::into_inner);
            receiver.recv_timeout(time)
        })
    };
    let tell = || -> PyResult<()> {
        let Some(callback) = callback else {
            return Ok(());
        };
        let told = Py::new(py, told(Progress::of(progress, start))?)?;
        let said = callback.call1((told,))?;
        if said.extract::<bool>().is_ok_and(|goes_on| !goes_on) {
            progress.stop();
        }
        Ok(())
    };
    loop {
        match wait(PERIOD) {
            Ok(done) => {
                tell()?;
                return done.map_err(|error| {
                    errors::plain(py, format!("cannot start the threads: {error}"))
                });
            }
            Err(mpsc::RecvTimeoutError::Timeout) => (),
            Err(mpsc::RecvTimeoutError::Disconnected) => {
                let message = "a mistake in nephroid ended the run; standard error has its place";
                return Err(errors::plain(py, message));
            }
        }
        if let Err(exception) = py.check_signals().and_then(|()| tell()) {
            progress.stop();
            let _ = wait(GRACE);
            return Err(exception);
        }
    }
}
