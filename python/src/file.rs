//! Scenes in files and buffers.

use crate::pool::on_threads;
use crate::scene::NativeScene;
use boxwood::{AlignedBytes, FileCause, FileError, Scene};
use boxwood_render::{RenderError, save_atomically};
use numpy::PyReadonlyArray1;
use pyo3::exceptions::{PyOSError, PyValueError};
use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;
use pyo3::types::PyBytes;
use std::path::PathBuf;

#[pymethods]
impl NativeScene {
    /// Writes the file beside `path` and renames it there; gives its hash.
    fn save(&self, py: Python<'_>, path: PathBuf, threads: usize) -> PyResult<String> {
        py.detach(|| {
            // Before a file is begun: what cannot be saved is no matter of the disk.
            let hash = on_threads(threads, || self.0.content_hash())?.map_err(raised)?;
            let write = |to: &mut dyn std::io::Write| {
                let mut to = to;
                let written = self.0.save(&mut to);
                written.map(drop).map_err(|error| RenderError::Encode {
                    format: "bwx",
                    cause: error.to_string(),
                })
            };
            on_threads(threads, || save_atomically(&path, write))?
                .map_err(|error| PyOSError::new_err(error.to_string()))?;
            Ok(hash.to_string())
        })
    }

    /// The file as bytes.
    fn to_bytes<'py>(&self, py: Python<'py>, threads: usize) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = py.detach(|| {
            let mut bytes = Vec::new();
            on_threads(threads, || self.0.save(&mut bytes))?.map_err(raised)?;
            PyResult::Ok(bytes)
        })?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// The hash of the file, as hexadecimal digits.
    fn content_hash(&self, py: Python<'_>, threads: usize) -> PyResult<String> {
        let hash = py.detach(|| on_threads(threads, || self.0.content_hash()))?;
        Ok(hash.map_err(raised)?.to_string())
    }

    /// The scene in a file, mapped or copied.
    #[staticmethod]
    fn open(py: Python<'_>, path: PathBuf, map: bool, threads: usize) -> PyResult<Self> {
        let open = || match map {
            true => Scene::open(&path),
            false => Scene::read(&path),
        };
        let opened = py.detach(|| on_threads(threads, open))?;
        Ok(Self(opened.map_err(raised)?))
    }

    /// The scene in bytes that nobody can change.
    #[staticmethod]
    fn of_bytes(py: Python<'_>, bytes: PyBackedBytes, threads: usize) -> PyResult<Self> {
        let opened = py.detach(|| on_threads(threads, || Scene::open_bytes(bytes)))?;
        Ok(Self(opened.map_err(raised)?))
    }

    /// The scene in an array, which is copied first.
    #[staticmethod]
    fn of_array(py: Python<'_>, bytes: PyReadonlyArray1<'_, u8>, threads: usize) -> PyResult<Self> {
        let slice = bytes
            .as_slice()
            .map_err(|_| PyValueError::new_err("the buffer must be contiguous"))?;
        let copy = AlignedBytes::copy(slice).map_err(raised)?;
        drop(bytes);
        let opened = py.detach(|| on_threads(threads, || Scene::open_bytes(copy)))?;
        Ok(Self(opened.map_err(raised)?))
    }

    /// A note of the file.
    fn note<'py>(&self, py: Python<'py>, name: &str) -> Option<Bound<'py, PyBytes>> {
        self.0.note(name).map(|note| PyBytes::new(py, note))
    }

    /// The number of triangles of each mesh.
    fn mesh_lengths(&self) -> Vec<usize> {
        (0..).map_while(|geom| self.0.mesh_len(geom)).collect()
    }
}

/// What the system refuses is an `OSError` of its kind, everything else a `ValueError`.
fn raised(error: FileError) -> PyErr {
    let text = error.to_string();
    match error.cause {
        FileCause::System { kind, .. } => std::io::Error::new(kind, text).into(),
        _ => PyValueError::new_err(text),
    }
}
