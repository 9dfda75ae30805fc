//! What a scene carries beside its surfaces into its file: notes, and the hash of it all.

use super::Scene;
use crate::simd::Kept;
use std::fmt;
use std::sync::OnceLock;

/// The hash (BLAKE3, 256 bits) of a scene's file: equal scenes have equal hashes, on every machine.
///
/// It prints as 64 hexadecimal digits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ContentHash(pub [u8; 32]);

impl fmt::Display for ContentHash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

/// Notes by name, ascending.
#[derive(Clone, Debug, Default)]
pub(crate) struct Notes {
    pub(crate) by_name: Vec<(String, Kept<u8>)>,
    pub(crate) hash: OnceLock<ContentHash>,
}

impl Notes {
    /// Longest name, in bytes.
    pub(crate) const LONGEST_NAME: usize = 40;

    /// True for what a note may be called.
    pub(crate) fn is_name(name: &str) -> bool {
        let is_plain = |c: u8| c.is_ascii_lowercase() || c.is_ascii_digit() || b"._-".contains(&c);
        (1..=Self::LONGEST_NAME).contains(&name.len()) && name.bytes().all(is_plain)
    }
}

impl Scene {
    /// The scene with something written on it that [`Scene::save`] puts into the file as it is: units, the indices of vertices, where
    /// the scene came from. It takes the place of a note of the same name. Notes change no answer; scenes that are made from this
    /// one ([`Scene::with_mesh`]) have none.
    ///
    /// # Panics
    /// If the name is not 1 to 40 of lower case letters, digits, `.`, `_` and `-`.
    #[must_use]
    pub fn with_note(mut self, name: &str, content: impl Into<Vec<u8>>) -> Self {
        assert!(
            Notes::is_name(name),
            "{name:?} cannot be the name of a note"
        );
        let (notes, content) = (&mut self.notes.by_name, Kept::from(content.into()));
        match notes.binary_search_by(|(known, _)| known.as_str().cmp(name)) {
            Ok(at) => notes[at].1 = content,
            Err(at) => notes.insert(at, (name.to_owned(), content)),
        }
        self.notes.hash = OnceLock::new();
        self
    }

    /// What was written on the scene under a name.
    pub fn note(&self, name: &str) -> Option<&[u8]> {
        let notes = &self.notes.by_name;
        let at = notes.binary_search_by(|(known, _)| known.as_str().cmp(name));
        at.ok().map(|at| &*notes[at].1)
    }

    /// The names of all notes, ascending.
    pub fn notes(&self) -> impl Iterator<Item = &str> {
        self.notes.by_name.iter().map(|(name, _)| name.as_str())
    }

    pub(crate) fn all_notes(&self) -> &Notes {
        &self.notes
    }

    pub(crate) fn with_notes(self, notes: Notes) -> Self {
        Self { notes, ..self }
    }
}
