//! Instructions that safe Rust has no word for. All `unsafe` of the crate is in this module.
#![allow(unsafe_code, reason = "the one module for it")]

mod arena;
mod isa;
mod kept;
#[cfg(feature = "file")]
mod map;
mod prefetch;
mod room;
mod stack;

pub(crate) use arena::{Arena, AxisRows, GRANULE, LeafRows, NodeRows, PlaneRow, Row, Third};
pub use isa::InstructionSet;
pub(crate) use kept::Kept;
#[cfg(feature = "file")]
pub(crate) use kept::{ALIGNMENT, bytes_of};
#[cfg(feature = "file")]
pub(crate) use map::mapped;
pub(crate) use prefetch::{address, fetch_ends, prefetch};
pub(crate) use room::room;
pub(crate) use stack::{RowStack, Stack};
