//! Why a scene was not saved or opened.

use std::fmt;
use std::path::{Path, PathBuf};

/// Which file, where in it, what is wrong, what to do about it.
///
/// It prints as `a.bwx: tree, byte 1024: no node refers to what stands here (the file is damaged: save the scene again)`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileError {
    /// The file, if it was opened by its path.
    pub file: Option<PathBuf>,
    /// Section and byte in it, if that is known.
    pub place: Option<(&'static str, u64)>,
    /// What is wrong.
    pub cause: FileCause,
}

/// What is wrong with a scene's file.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FileCause {
    /// Only triangles in the structure `wide` are saved, and this is something else.
    NotSaved {
        /// `structure grid`, `instances`.
        what: String,
    },
    /// The system refused to read or write.
    System {
        /// What kind of refusal.
        kind: std::io::ErrorKind,
        /// Its words.
        message: String,
    },
    /// It does not begin like a scene.
    NoScene,
    /// It is of a version or layout that this one does not read.
    OtherVersion {
        /// Version and layout of the file.
        found: [u32; 2],
        /// Those that are read.
        known: [u32; 2],
    },
    /// Its numbers, or this machine's, are not little-endian.
    OtherMachine,
    /// It is shorter or longer than it says.
    WrongLength {
        /// As it says.
        expected: u64,
        /// As it is.
        found: u64,
    },
    /// Its content is not what was saved.
    WrongHash,
    /// It breaks a rule of the format.
    Broken {
        /// The rule.
        rule: &'static str,
    },
    /// The system did not grant the memory.
    OutOfMemory {
        /// What was asked for.
        bytes: u64,
    },
}

impl FileError {
    pub(super) fn new(cause: FileCause) -> Self {
        Self {
            file: None,
            place: None,
            cause,
        }
    }

    pub(super) fn broken(section: &'static str, byte: u64, rule: &'static str) -> Self {
        Self {
            place: Some((section, byte)),
            ..Self::new(FileCause::Broken { rule })
        }
    }

    pub(super) fn out_of_memory(bytes: u64) -> Self {
        Self::new(FileCause::OutOfMemory { bytes })
    }

    pub(super) fn of(self, path: &Path) -> Self {
        Self {
            file: Some(path.to_owned()),
            ..self
        }
    }
}

impl From<std::io::Error> for FileError {
    fn from(error: std::io::Error) -> Self {
        let (kind, message) = (error.kind(), error.to_string());
        Self::new(FileCause::System { kind, message })
    }
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(file) = &self.file {
            write!(f, "{}: ", file.display())?;
        }
        if let Some((section, byte)) = self.place {
            write!(f, "{section}, byte {byte}: ")?;
        }
        write!(f, "{}", self.cause)
    }
}

impl fmt::Display for FileCause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotSaved { what } => write!(
                f,
                "a scene of {what} is not saved (build triangles with the structure wide)"
            ),
            Self::System { message, .. } => write!(f, "{message}"),
            Self::NoScene => write!(
                f,
                "is no saved scene (such a file is written by `Scene::save` and `boxwood build FILE -o scene.bwx`)"
            ),
            Self::OtherVersion { found, known } => write!(
                f,
                "is of version {}.{}, this Boxwood reads {}.{} (save the scene again with this version)",
                found[0], found[1], known[0], known[1]
            ),
            Self::OtherMachine => write!(
                f,
                "saved scenes are little-endian, and file and machine must be (build the scene anew)"
            ),
            Self::WrongLength { expected, found } => write!(
                f,
                "has {found} bytes and says that it has {expected} (it was cut off or added to: copy it again)"
            ),
            Self::WrongHash => write!(
                f,
                "the content is not what was saved (the file is damaged: copy it or save the scene again)"
            ),
            Self::Broken { rule } => {
                write!(f, "{rule} (the file is damaged: save the scene again)")
            }
            Self::OutOfMemory { bytes } => {
                write!(
                    f,
                    "{bytes} bytes of memory were refused by the system (make room; the least is needed where the file is mapped, by `Scene::open`)"
                )
            }
        }
    }
}

impl std::error::Error for FileError {}
