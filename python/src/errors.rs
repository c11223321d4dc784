//! Errors of the library become the module's exceptions, which are written in Python (`nephroid/_errors.py`).

use std::path::Path;

use nephroid::internals::reference::parts::GatherError;
use nephroid::{Error, LoadError};
use pyo3::call::PyCallArgs;
use pyo3::prelude::*;

/// An exception of the module, by the name of its class.
fn raised<'py>(py: Python<'py>, class: &str, arguments: impl PyCallArgs<'py>) -> PyErr {
    let made = py
        .import("nephroid._errors")
        .and_then(|module| module.getattr(class)?.call1(arguments));
    match made {
        Ok(exception) => PyErr::from_value(exception),
        Err(error) => error,
    }
}

/// An error without a kind of its own.
pub fn plain(py: Python<'_>, message: impl ToString) -> PyErr {
    raised(py, "Error", (message.to_string(),))
}

/// A name that does not exist, or a value that cannot be.
pub fn setting(py: Python<'_>, message: impl ToString) -> PyErr {
    raised(py, "SettingError", (message.to_string(),))
}

/// A scene or a sensor that cannot be worked on.
pub fn refused(py: Python<'_>, message: impl ToString) -> PyErr {
    raised(py, "RefusedError", (message.to_string(),))
}

/// An error that ended a run.
pub fn run(py: Python<'_>, error: &Error) -> PyErr {
    run_as(py, error, error)
}

/// An error that ended a run, in other words.
pub fn run_as(py: Python<'_>, error: &Error, message: impl ToString) -> PyErr {
    match error {
        Error::Setting(_) => setting(py, message),
        Error::Refused(_) => refused(py, message),
        _ => plain(py, message),
    }
}

/// An error that ended a merge.
pub fn merge(py: Python<'_>, error: &GatherError) -> PyErr {
    match error {
        GatherError::Run(error) => run(py, error),
        GatherError::Shard(error) => plain(py, error),
    }
}

/// A file that cannot be read, or has a mistake at a line and a column.
pub fn load_one(
    py: Python<'_>,
    message: String,
    file: &Path,
    (line, column): (usize, usize),
) -> PyErr {
    let problem = (message, file.display().to_string(), line, column);
    raised(py, "LoadError", (vec![problem],))
}

/// A file that does not become a scene: all of its problems, the first in the attributes.
pub fn load(py: Python<'_>, error: &LoadError) -> PyErr {
    let all: Vec<_> = error
        .all()
        .map(|one| {
            let file = one.at.file.display().to_string();
            (one.message.clone(), file, one.at.line, one.at.column)
        })
        .collect();
    raised(py, "LoadError", (all,))
}
