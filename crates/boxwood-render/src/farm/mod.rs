//! Pictures made by many processes, or by one that may be killed: camera paths, files of tiles, and their merging.

mod header;
mod log;
mod merge;
mod path;
mod record;
mod scene_hash;
mod shard;

/// Files may be hostile: control characters of what they say must not reach the terminal.
fn plain(text: &str) -> String {
    text.chars()
        .map(|c| if c.is_control() { '\u{fffd}' } else { c })
        .collect()
}

pub use self::{
    header::{Difference, PartHeader, read_header},
    log::{Resumed, TileLog},
    merge::{Merged, merge},
    path::CameraPath,
    scene_hash::scene_hash,
    shard::Shard,
};
