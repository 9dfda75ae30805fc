//! **Boxwood for C and C++**: the same answers, by verbs that users of Embree know.
//!
//! The header `include/boxwood.h` is made from this crate by `cargo xtask c-header`, with its comments; `docs/embree.md` puts every
//! call beside Embree's. `api.rs` has the functions that C sees, and they do no more than check pointers (`memory.rs`), keep the
//! caller's floating-point modes out (crate `boxwood-host`), turn errors and panics into codes (`error.rs`) and call the rest, which is
//! safe Rust: `scene.rs` collects and commits, `ask.rs` answers many questions at once, `file.rs`
//! saves and opens.
//!
//! Rust programs use the crate `boxwood` itself; this one is also a Rust library only to be tested.
#![deny(unsafe_op_in_unsafe_fn)]

mod api;
mod ask;
mod error;
mod file;
mod memory;
mod scene;
mod threads;
mod types;

pub use api::*;
pub use error::BwError;
pub use scene::BwScene;
pub use types::*;
