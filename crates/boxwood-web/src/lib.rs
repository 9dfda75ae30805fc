//! Boxwood for the page that teaches (`web/`): what its figures ask, one call each.
//!
//! [`Lab`] holds a scene with the structures built over it and answers with pictures, counts and walks; [`lesson`] has the small
//! worlds of the figures that need no scene; [`hits_hash`] shows that the page's answers are the native ones. On wasm32 `door`
//! exports all this to JavaScript; natively the same functions answer the tests. Nothing here knows a clock or a thread.
#![cfg_attr(not(target_arch = "wasm32"), forbid(unsafe_code))]

pub mod lesson;

#[cfg(target_arch = "wasm32")]
pub mod door;
mod hash;
mod heat;
mod lab;
mod walk;

pub use hash::{hash_of_hits, hits_hash};
pub use heat::{HeatScale, heat_codes, heat_scale};
pub use lab::{Built, CameraSeen, Lab, Seen, Shot, structure_names};
pub use walk::WalkAnswer;
