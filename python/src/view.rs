//! Arrays that look at a film's memory: the only `unsafe` lines.

use nephroid::Rgb;
use numpy::ndarray::ArrayView3;
use numpy::{PyArray3, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::film::Film;

/// A map as an array (rows, columns, 3) that cannot be written to. It shares the film's memory and keeps the film.
///
/// `values` are a map of `film`: nothing else may own them.
#[allow(unsafe_code)]
pub fn array<'py>(
    film: &Bound<'py, Film>,
    values: &[Rgb],
    width: usize,
    height: usize,
) -> PyResult<Bound<'py, PyArray3<f64>>> {
    // SAFETY: `Rgb` is a transparent wrapper of `[f64; 3]`, so that the slice is 3 n numbers without padding.
    let numbers =
        unsafe { std::slice::from_raw_parts(values.as_ptr().cast::<f64>(), 3 * values.len()) };
    let view = ArrayView3::from_shape((height, width, 3), numbers)
        .map_err(|error| PyValueError::new_err(error.to_string()))?;
    // SAFETY: the film is frozen and never gives its maps away, so that their memory stays as it is, where it is,
    // for as long as the array, which owns a reference to the film. The array is made unwritable before anyone sees it;
    // NumPy lets nobody undo that, since the owner has no buffer that could be written to.
    let array = unsafe { PyArray3::borrow_from_array(&view, film.clone().into_any()) };
    array.call_method1("setflags", (false,))?;
    debug_assert_eq!(array.data().cast_const(), numbers.as_ptr());
    Ok(array)
}
