//! Scenes for Boxwood: meshes in, one plain [`Model`] out.
//!
//! ```no_run
//! let model = boxwood_scene::open("bunny.obj")?;
//! for warning in &model.warnings {
//!     eprintln!("{warning}");
//! }
//! # Ok::<(), boxwood_scene::LoadError>(())
//! ```
//!
//! Files are hostile until proven otherwise: all reading goes through one guarded [`Door`], every count is checked
//! against the bytes that are there before memory is asked for, and what can't be read is a [`LoadError`] with file,
//! place and cause. No function here panics on data, prints, or reads a file that the user did not name, or that does
//! not lie beside the named one.
//!
//! The feature `files` (usual) reads files, `saved` (usual) Boxwood's own saved scenes; without them there are the built-in scenes. The feature `serde` gives a [`Model`] the
//! traits of that crate.
#![forbid(unsafe_code)]

mod builtin;
mod check;
mod door;
mod error;
mod flatten;
mod fold;
#[cfg(feature = "files")]
mod format;
mod model;
#[cfg(all(test, feature = "files"))]
#[path = "../tests/support/mutate.rs"]
mod mutate;
mod simplify;
#[cfg(feature = "files")]
mod texture;
mod write;

pub use builtin::{BUILTINS, Builtin, MAX_TRIANGLES, Params, Size, builtin};
pub use door::{Door, Limits};
pub use error::{LoadError, Place};
pub use flatten::Bounds;
pub use fold::Folded;
#[cfg(feature = "saved")]
pub use format::with_vertices;
#[cfg(feature = "files")]
pub use format::{FORMATS, Format, load, load_bytes, load_with, open};
pub use model::{Camera, FlatMesh, Instance, Material, Mesh, Model, Texture};
pub use simplify::simplify;
pub use write::{write_obj, write_ply};
