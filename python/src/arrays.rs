//! Arrays in and out.

use bytemuck::Zeroable;
use numpy::ndarray::{Array1, Array2, Array3};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArray3, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::{PyMemoryError, PyValueError};
use pyo3::prelude::*;

/// A copy of the rows of an array of `N` columns.
pub(crate) fn rows<T: numpy::Element + Copy + Default, const N: usize>(
    array: &PyReadonlyArray2<'_, T>,
    what: &str,
) -> PyResult<Vec<[T; N]>> {
    if array.shape()[1] != N {
        return Err(PyValueError::new_err(format!(
            "{what} must have {N} columns, not {}",
            array.shape()[1]
        )));
    }
    let slice = array
        .as_slice()
        .map_err(|_| PyValueError::new_err(format!("{what} must be contiguous")))?;
    Ok(slice.as_chunks::<N>().0.to_vec())
}

/// Room for so many, if the system has it; in the memory of what is spare.
pub(crate) fn room<T>(mut spare: Vec<T>, count: usize) -> PyResult<Vec<T>> {
    spare.clear();
    spare
        .try_reserve_exact(count)
        .map_err(|_| no_memory::<T>(count))?;
    Ok(spare)
}

/// So many zeros, which the system lays out only where they are touched.
pub(crate) fn zeroed<T: Zeroable>(count: usize) -> PyResult<Vec<T>> {
    bytemuck::try_zeroed_vec(count).map_err(|()| no_memory::<T>(count))
}

fn no_memory<T>(count: usize) -> PyErr {
    let bytes = count.saturating_mul(size_of::<T>());
    PyMemoryError::new_err(format!("no {bytes} bytes of memory for {count} answers"))
}

/// A vector as an array, without a copy.
pub(crate) fn column<T: numpy::Element>(py: Python<'_>, values: Vec<T>) -> Bound<'_, PyArray1<T>> {
    Array1::from_vec(values).into_pyarray(py)
}

/// Rows as an array, without a copy.
pub(crate) fn table<T: numpy::Element, const N: usize>(
    py: Python<'_>,
    rows: Vec<[T; N]>,
) -> PyResult<Bound<'_, PyArray2<T>>> {
    let count = rows.len();
    let array = Array2::from_shape_vec((count, N), rows.into_flattened())
        .map_err(|error| PyValueError::new_err(error.to_string()))?;
    Ok(array.into_pyarray(py))
}

/// Pixels as an array (height, width, channels), without a copy.
pub(crate) fn array3<T: numpy::Element, const N: usize>(
    py: Python<'_>,
    pixels: Vec<[T; N]>,
    [height, width]: [usize; 2],
) -> PyResult<Bound<'_, PyArray3<T>>> {
    let array = Array3::from_shape_vec((height, width, N), pixels.into_flattened())
        .map_err(|error| PyValueError::new_err(error.to_string()))?;
    Ok(array.into_pyarray(py))
}
