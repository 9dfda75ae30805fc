//! Instructions that safe Rust has no word for. All `unsafe` of the crate is in this module.
#![allow(unsafe_code, reason = "the one module for it")]

mod prefetch;

pub(crate) use prefetch::prefetch;
