//! Boxwood for Python: what the modules of `boxwood` call.
//!
//! Everything comes as contiguous arrays of one type, which `arrays.py` makes of whatever a user has. They are copied while the
//! interpreter is held, since any thread could change them later; then it is let go while Boxwood works.

mod arrays;
mod ask;
mod file;
mod first;
mod looks;
mod picture;
mod png;
mod pool;
mod rays;
mod scene;

use pyo3::prelude::*;

#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("SHADINGS", picture::shadings())?;
    module.add_class::<scene::NativeScene>()?;
    module.add_class::<looks::NativeLooks>()?;
    module.add_class::<picture::NativeStudio>()?;
    module.add_class::<picture::NativePicture>()?;
    module.add_function(wrap_pyfunction!(png::encode_png, module)?)?;
    module.add_function(wrap_pyfunction!(looks::load, module)?)
}
