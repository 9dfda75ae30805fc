//! Boxwood for the page that teaches (`web/`): what its figures ask, one call each.
//!
//! [`Lab`] holds a scene with the structures built over it and answers with pictures, counts and walks; [`lesson`] has the small
//! worlds of the figures that need no scene; [`hits_hash`] shows that the page's answers are the native ones; [`read`] turns a
//! reader's own file into a model for [`Lab::open`]. On wasm32 the `door`s export all this to JavaScript, the figures' (feature
//! `lab`) and the files' (`files`) as a WebAssembly each; natively the same functions answer the tests. Nothing here knows a clock
//! or a thread.
#![cfg_attr(not(target_arch = "wasm32"), forbid(unsafe_code))]

#[cfg(feature = "lab")]
pub mod lesson;

#[cfg(all(feature = "lab", target_arch = "wasm32"))]
pub mod door;
#[cfg(feature = "files")]
mod files;
#[cfg(feature = "lab")]
mod hash;
#[cfg(feature = "lab")]
mod heat;
#[cfg(feature = "lab")]
mod lab;
#[cfg(feature = "lab")]
mod walk;

#[cfg(feature = "files")]
pub use files::read;
#[cfg(feature = "lab")]
pub use hash::{hash_of_hits, hits_hash};
#[cfg(feature = "lab")]
pub use heat::{HeatScale, heat_codes, heat_scale};
#[cfg(feature = "lab")]
pub use lab::{Built, CameraSeen, Lab, Seen, Shot, structure_names};
#[cfg(feature = "lab")]
pub use walk::WalkAnswer;
