//! PNG files of pixels that were put together elsewhere.

use crate::picture::{raised, texts};
use boxwood_render::{Image, Shading, write_png};
use numpy::{PyReadonlyArray3, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

/// Pixels (h, w, 3) as the bytes of the file that a whole picture of this shading gives, if it has no legend.
#[pyfunction]
pub(crate) fn encode_png<'py>(
    py: Python<'py>,
    pixels: PyReadonlyArray3<'py, u8>,
    shading: &str,
) -> PyResult<Bound<'py, PyBytes>> {
    let [height, width, depth] = <[usize; 3]>::try_from(pixels.shape())?;
    if depth != 3 {
        return Err(PyValueError::new_err("pixels have three channels"));
    }
    let side = |n: usize| u32::try_from(n).map_err(|_| PyValueError::new_err("too many pixels"));
    let (rgb, _) = pixels.as_slice()?.as_chunks::<3>();
    let image = Image {
        width: side(width)?,
        height: side(height)?,
        rgb: rgb.to_vec(),
    };
    let texts = texts(Shading::named(shading).map_err(raised)?);
    let bytes = py.detach(|| {
        let mut bytes = Vec::new();
        write_png(&image, &texts, &mut bytes).map(|()| bytes)
    });
    Ok(PyBytes::new(py, &bytes.map_err(raised)?))
}
