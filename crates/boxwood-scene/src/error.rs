//! The one error of this crate: which file, where in it, what is wrong, what to do about it.

use std::fmt;

/// Why a scene was refused.
///
/// It prints as `bunny.ply:118: face refers to vertex 9120 of 8171 (remedy)`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LoadError {
    /// The file as the user named it, or what stands for it (`<stdin>`, `builtin:soup`).
    pub file: String,
    /// Where in the file, if it is known.
    pub place: Option<Place>,
    /// What is wrong, with the numbers that show it.
    pub cause: String,
    /// What the user can do, if there is something.
    pub remedy: Option<String>,
}

/// A place in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// Counted from 1.
    Line(u64),
    /// Counted from 0.
    Byte(u64),
    /// Where in a tree, as in `accessors[3]`.
    Path(String),
}

impl LoadError {
    /// An error about `file` without a place.
    pub fn new(file: impl Into<String>, cause: impl Into<String>) -> Self {
        Self {
            file: file.into(),
            place: None,
            cause: cause.into(),
            remedy: None,
        }
    }

    /// The same error with a way out.
    pub fn with_remedy(mut self, remedy: impl Into<String>) -> Self {
        self.remedy = Some(remedy.into());
        self
    }
}

impl fmt::Display for LoadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Names come from hostile files: control characters must not reach the terminal.
        let plain = |text: &str| -> String {
            text.chars()
                .map(|c| if c.is_control() { '\u{fffd}' } else { c })
                .collect()
        };
        write!(f, "{}", plain(&self.file))?;
        match &self.place {
            Some(Place::Line(line)) => write!(f, ":{line}")?,
            Some(Place::Byte(byte)) => write!(f, ": byte {byte}")?,
            Some(Place::Path(path)) => write!(f, ": {}", plain(path))?,
            None => {}
        }
        write!(f, ": {}", plain(&self.cause))?;
        match &self.remedy {
            Some(remedy) => write!(f, " ({})", plain(remedy)),
            None => Ok(()),
        }
    }
}

impl std::error::Error for LoadError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prints_file_place_cause_and_remedy_in_one_line() {
        let error = LoadError {
            file: "a.ply".into(),
            place: Some(Place::Line(118)),
            cause: "face refers to vertex 9120 of 8171".into(),
            remedy: Some("export it again".into()),
        };
        assert_eq!(
            error.to_string(),
            "a.ply:118: face refers to vertex 9120 of 8171 (export it again)"
        );
        let error = LoadError {
            place: Some(Place::Path("accessors[3]".into())),
            remedy: None,
            ..error
        };
        assert_eq!(
            error.to_string(),
            "a.ply: accessors[3]: face refers to vertex 9120 of 8171"
        );
    }

    #[test]
    fn control_characters_of_a_hostile_name_are_not_printed() {
        assert_eq!(
            LoadError::new("a", "no \x1b[2J\n").to_string(),
            "a: no \u{fffd}[2J\u{fffd}"
        );
    }
}
