//! Boxwood's viewer: look at a scene, move through it at frame rate on the processor alone, see what its rays cost, and
//! follow one of them.
//!
//! [`App`] is the viewer without its window: events in, frames out; scripts and tests run it like that. [`run_window`] puts
//! a window around it. Pictures come from [`boxwood_render`]; resolution gives way while the camera moves, and fills in
//! when it stands still.
#![forbid(unsafe_code)]

mod app;
mod canvas;
mod error;
mod event;
mod keys;
mod navigate;
mod overlay;
mod pace;
mod picture;
mod project;
mod script;
mod state;
mod subject;
mod walk;
mod watch;
#[cfg(feature = "window")]
mod window;
mod workshop;

pub use app::{App, MAX_PIXELS, Options, Rest};
pub use error::{Matter, ViewError};
pub use event::{Button, Event, Wish};
pub use keys::Key;
pub use script::{Report, Row, Script, run_headless};
pub use state::State;
pub use subject::{Aim, Open, open};
#[cfg(feature = "window")]
pub use window::run_window;
pub use workshop::Wake;
