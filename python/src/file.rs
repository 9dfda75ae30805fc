//! Scenes in files and buffers.

use crate::arrays::table;
use crate::pool::interruptible;
use crate::scene::NativeScene;
use boxwood::{AlignedBytes, FileCause, FileError, Scene};
use boxwood_render::{RenderError, save_atomically};
use numpy::{PyArray2, PyReadonlyArray1};
use pyo3::exceptions::{PyOSError, PyValueError};
use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;
use pyo3::types::PyBytes;
use std::path::PathBuf;

#[pymethods]
impl NativeScene {
    /// Writes the file beside `path` and renames it there; gives its hash.
    fn save(&self, py: Python<'_>, path: PathBuf, threads: usize) -> PyResult<String> {
        // Before a file is begun: what cannot be saved is no matter of the disk.
        let hash = interruptible(py, threads, |_| self.0.content_hash())?.map_err(raised)?;
        let write = |to: &mut dyn std::io::Write| {
            let mut to = to;
            let written = self.0.save(&mut to);
            written.map(drop).map_err(|error| RenderError::Encode {
                format: "bwx",
                cause: error.to_string(),
            })
        };
        interruptible(py, threads, |_| save_atomically(&path, write))?
            .map_err(|error| PyOSError::new_err(error.to_string()))?;
        Ok(hash.to_string())
    }

    /// The file as bytes.
    fn to_bytes<'py>(&self, py: Python<'py>, threads: usize) -> PyResult<Bound<'py, PyBytes>> {
        let save = |_: &_| {
            let mut bytes = Vec::new();
            self.0.save(&mut bytes).map(|_| bytes)
        };
        let bytes = interruptible(py, threads, save)?.map_err(raised)?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// The hash of the file, as hexadecimal digits.
    fn content_hash(&self, py: Python<'_>, threads: usize) -> PyResult<String> {
        let hash = interruptible(py, threads, |_| self.0.content_hash())?;
        Ok(hash.map_err(raised)?.to_string())
    }

    /// The scene in a file, mapped or copied.
    #[staticmethod]
    fn open(py: Python<'_>, path: PathBuf, map: bool, threads: usize) -> PyResult<Self> {
        let open = |_: &_| match map {
            true => Scene::open(&path),
            false => Scene::read(&path),
        };
        let opened = interruptible(py, threads, open)?;
        Ok(Self(opened.map_err(raised)?))
    }

    /// The scene in bytes that nobody can change.
    #[staticmethod]
    fn of_bytes(py: Python<'_>, bytes: PyBackedBytes, threads: usize) -> PyResult<Self> {
        let opened = interruptible(py, threads, |_| Scene::open_bytes(bytes))?;
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
        let opened = interruptible(py, threads, |_| Scene::open_bytes(copy))?;
        Ok(Self(opened.map_err(raised)?))
    }

    /// A note of the file.
    fn note<'py>(&self, py: Python<'py>, name: &str) -> Option<Bound<'py, PyBytes>> {
        self.0.note(name).map(|note| PyBytes::new(py, note))
    }

    /// The corners of a mesh's triangles, three rows for each.
    fn corners<'py>(&self, py: Python<'py>, geom: u32) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let corners = py.detach(|| {
            let length = self.0.mesh_len(geom).unwrap_or(0) as u32;
            let triangles = (0..length).filter_map(|prim| self.0.triangle(geom, prim));
            triangles.flat_map(|t| t.0).collect::<Vec<_>>()
        });
        table(py, corners)
    }

    /// The number of triangles of each mesh.
    fn mesh_lengths(&self) -> Vec<usize> {
        (0..).map_while(|geom| self.0.mesh_len(geom)).collect()
    }
}

/// What the system refuses is an `OSError` of its kind, everything else a `ValueError`; calls are named as in Python.
fn raised(error: FileError) -> PyErr {
    let text = error.to_string().replace("Scene::", "Scene.");
    match error.cause {
        FileCause::NoScene => {
            PyValueError::new_err(format!("{text}; a model is read by `Scene.load`"))
        }
        FileCause::System { kind, .. } => std::io::Error::new(kind, text).into(),
        _ => PyValueError::new_err(text),
    }
}
