//! The functions of the header, called as C calls them: the same bits as from Rust, and a code for every mistake.
#![allow(unsafe_code, reason = "the calls are C's")]

mod changes;
mod files;
mod handle;
mod mistakes;
mod questions;
