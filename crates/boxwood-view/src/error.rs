//! Why the viewer cannot go on.

use std::path::Path;

use boxwood_render::RenderError;

/// What is wrong, and what to do about it where that can be said here.
#[derive(Clone, Debug, thiserror::Error, PartialEq, Eq)]
#[error("{cause}{}", tail(.remedy))]
pub struct ViewError {
    /// Whose matter it is.
    pub kind: Matter,
    /// With the name of the file, where there is one.
    pub cause: String,
    /// The way out.
    pub remedy: Option<String>,
}

/// What a [`ViewError`] is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Matter {
    /// There is no screen, or none that can be used.
    Window,
    /// A scene that cannot be read, built or shown.
    Scene,
    /// A file that is no state of a viewer.
    State,
    /// The user aimed a camera that shows nothing.
    Camera,
    /// A script that cannot be followed.
    Script,
    /// A file that cannot be written.
    Output,
}

impl ViewError {
    pub(crate) fn new(kind: Matter, cause: impl Into<String>) -> Self {
        Self {
            kind,
            cause: cause.into(),
            remedy: None,
        }
    }

    pub(crate) fn with_remedy(self, remedy: impl Into<String>) -> Self {
        Self {
            remedy: Some(remedy.into()),
            ..self
        }
    }

    /// The file at `path` cannot be written.
    pub(crate) fn output(path: &Path, error: RenderError) -> Self {
        let (cause, remedy) = match error {
            RenderError::Save { cause, remedy, .. } => (cause.to_string(), remedy),
            other => (other.to_string(), "choose another place and try again"),
        };
        Self::new(Matter::Output, format!("{}: {cause}", path.display())).with_remedy(remedy)
    }
}

/// The end of the sentence.
fn tail(remedy: &Option<String>) -> String {
    let remedy = remedy.as_ref();
    remedy.map_or(String::new(), |remedy| format!("; {remedy}"))
}
