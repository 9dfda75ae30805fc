//! Arrays in and out.

use numpy::ndarray::{Array1, Array2, Array3};
use numpy::{
    Element, IntoPyArray, PyArray1, PyArray2, PyArray3, PyArrayDyn, PyArrayMethods,
    PyReadonlyArray2, PyReadwriteArrayDyn, PyUntypedArrayMethods, dtype,
};
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

fn no_memory<T>(count: usize) -> PyErr {
    let bytes = count.saturating_mul(size_of::<T>());
    PyMemoryError::new_err(format!("no {bytes} bytes of memory for {count} rows"))
}

/// An array that answers are written to. Its memory is numpy's own, who asks the system for large pages: laying out small ones, of
/// which a million answers take ten thousand, took a tenth of the time of the answers.
pub(crate) struct Answers<'py, T: Element>(PyReadwriteArrayDyn<'py, T>);

impl<'py, T: Element> Answers<'py, T> {
    /// Zeros: one for each row.
    pub(crate) fn column(py: Python<'py>, rows: usize) -> PyResult<Self> {
        Self::zeros(py, (rows,))
    }

    /// Zeros: so many for each row.
    pub(crate) fn table(py: Python<'py>, rows: usize, columns: usize) -> PyResult<Self> {
        Self::zeros(py, (rows, columns))
    }

    /// By the name that Python calls it, since there a lack of memory is an error.
    fn zeros(py: Python<'py>, shape: impl IntoPyObject<'py>) -> PyResult<Self> {
        let zeros = py.import("numpy")?.getattr("zeros")?;
        let array = zeros.call1((shape, dtype::<T>(py)))?;
        Ok(Self(array.cast_into::<PyArrayDyn<T>>()?.try_readwrite()?))
    }

    pub(crate) fn numbers(&mut self) -> PyResult<&mut [T]> {
        Ok(self.0.as_slice_mut()?)
    }

    pub(crate) fn rows<const N: usize>(&mut self) -> PyResult<&mut [[T; N]]> {
        Ok(self.0.as_slice_mut()?.as_chunks_mut().0)
    }

    pub(crate) fn array(self) -> Array<'py, T> {
        (**self.0).clone()
    }
}

/// Of any shape.
pub(crate) type Array<'py, T> = Bound<'py, PyArrayDyn<T>>;

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
