//! What can go wrong when a picture is made, written or read: place, cause, remedy.

use std::{
    io,
    path::{Path, PathBuf},
};

/// Why no picture came of it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// The camera describes no view.
    #[error("camera: {what}; {remedy}")]
    Camera {
        /// The value that is wrong.
        what: String,
        /// What to give instead.
        remedy: &'static str,
    },
    /// A size, a crop or a number of samples out of its range.
    #[error("{what}; {remedy}")]
    Size {
        /// The value that is wrong.
        what: String,
        /// What to give instead.
        remedy: &'static str,
    },
    /// The system refuses the memory that a picture takes.
    #[error("{what} takes {gib:.1} GiB of memory, which the system refuses; {remedy}")]
    Memory {
        /// What is too large.
        what: String,
        /// How much it takes.
        gib: f64,
        /// What to give instead.
        remedy: &'static str,
    },
    /// No shading of this name.
    #[error("there is no shading '{name}'; choose one of {known}")]
    Shading {
        /// What was asked for.
        name: String,
        /// The names of the table.
        known: String,
    },
    /// A file could not be written. What stood at `path` before still stands there.
    #[error("{}: {cause}; {remedy}", path.display())]
    Save {
        /// Where the picture was to go.
        path: PathBuf,
        /// What the system said.
        cause: io::Error,
        /// What to do about it.
        remedy: &'static str,
    },
    /// Encoding failed before or while bytes were written.
    #[error("cannot write the {format} picture: {cause}")]
    Encode {
        /// `PNG` or `EXR`.
        format: &'static str,
        /// What the encoder or the system said.
        cause: String,
    },
    /// The bytes are not a picture that we read.
    #[error("cannot read the picture: {cause}; {remedy}")]
    Decode {
        /// What the decoder said.
        cause: String,
        /// What to do about it.
        remedy: &'static str,
    },
    /// A camera path, or a file of tiles, that cannot be used.
    #[error("{}: {what}; {remedy}", located(path, *place))]
    File {
        /// As the user named it.
        path: PathBuf,
        /// Line and column of a text, from 1.
        place: Option<[usize; 2]>,
        /// What is wrong with it.
        what: String,
        /// What to do about it; may have several lines.
        remedy: String,
    },
    /// Another process has locked the file. Later it may be free.
    #[error("{}: another process is at work on it; let it finish, or end it, and try again", path.display())]
    Busy {
        /// The file of tiles.
        path: PathBuf,
    },
    /// Two pictures of different size have no difference.
    #[error("the pictures differ in size: {}x{} and {}x{}; render both with the same --size", .a[0], .a[1], .b[0], .b[1])]
    SizesDiffer {
        /// Width and height of the first.
        a: [u32; 2],
        /// Width and height of the second.
        b: [u32; 2],
    },
}

/// `cam.json:7:14`.
fn located(path: &Path, place: Option<[usize; 2]>) -> String {
    match place {
        Some([line, column]) => format!("{}:{line}:{column}", path.display()),
        None => path.display().to_string(),
    }
}
