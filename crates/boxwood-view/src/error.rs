//! Why the viewer cannot go on.

use std::{fmt::Display, path::Path};

/// Each says what is wrong and what to do about it.
#[derive(Clone, Debug, thiserror::Error, PartialEq, Eq)]
pub enum ViewError {
    /// There is no screen, or none that can be used.
    #[error("no window can be opened: {0}")]
    NoWindow(String),
    /// A file that is not a scene.
    #[error("{0}")]
    File(String),
    /// A script that cannot be followed.
    #[error("{0}")]
    Script(String),
}

impl ViewError {
    pub(crate) fn file(path: &Path, cause: impl Display) -> Self {
        Self::File(format!("{}: {cause}", path.display()))
    }
}
