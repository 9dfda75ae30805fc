//! Pictures from many processes and from killed ones: the bytes are those of one process that was left alone.

#[path = "../common/mod.rs"]
mod common;
mod frames;
mod help;
mod resumed;
mod shares;
