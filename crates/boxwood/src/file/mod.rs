//! Scenes in files: saved as they are, and opened again without a build.
//!
//! A file is the scene's own memory: the wide tree's arena, the triangles, the numbers of meshes, and notes. It is read in place,
//! so that all processes of a machine that map one file share one copy. Nothing in it is believed: `sections` takes the frame apart, `scene`
//! checks the numbers, `structure/wide/saved` the tree. ARCHITECTURE.md has the layout.

mod error;
mod parts;
mod sections;

pub use error::{FileCause, FileError};

use crate::scene::{ContentHash, Scene};
use crate::simd::{Arena, Kept, mapped};
use std::fs::File;
use std::io::{Read, Seek, Write};
use std::path::Path;

impl Scene {
    /// Writes the scene as a file (`.bwx`) that [`Scene::open`] opens without a build, with the notes on it
    /// ([`Scene::with_note`]). Some 90 bytes a triangle. The same scene gives the same bytes on every machine, for every number of threads and
    /// instruction set; an opened scene those that it was opened from.
    ///
    /// Write beside the place where the file is to be, and rename it there: whoever has the old one mapped keeps it, and nobody sees a half.
    ///
    /// # Errors
    /// If the scene is not of triangles in the structure `wide`, on big-endian machines, and those of `to`.
    pub fn save(&self, to: &mut impl Write) -> Result<ContentHash, FileError> {
        let saved = parts::Saved::of(self)?;
        let hash = sections::write(&saved.sections(), to)?;
        Ok(*self.all_notes().hash.get_or_init(|| hash))
    }

    /// The hash that [`Scene::save`] gives: that of the file of an opened scene; computed once of a built one.
    ///
    /// # Errors
    /// As [`Scene::save`].
    pub fn content_hash(&self) -> Result<ContentHash, FileError> {
        if let Some(hash) = self.all_notes().hash.get() {
            return Ok(*hash);
        }
        let hash = sections::hash(&parts::Saved::of(self)?.sections());
        Ok(*self.all_notes().hash.get_or_init(|| hash))
    }

    /// The scene in a file, which becomes memory (`mmap`) and is read in place: all processes that open it share one copy, and
    /// a second one opens it from the system's cache. All of it is read and checked first, in a fraction of the time of a build.
    ///
    /// **The file must stay as it is while the scene lives.** Whoever renames a new file to its place, as saving should, may
    /// do so at any time. But memory that another program changes under a reader is outside of what Rust promises anything about: the call is
    /// safe to write and unsound then. What happens in practice is that a program that writes into the file in place makes its readers give
    /// wrong answers, panic or never end, and one that cuts it short ends them by a signal (SIGBUS on Unix). Where others may do that,
    /// take [`Scene::read`], which is safe whatever becomes of the file.
    ///
    /// # Errors
    /// If it cannot be read, is no scene, is of another version, or is damaged in any way.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, FileError> {
        Self::at(path.as_ref(), |file, _| Ok(Kept::new(mapped(file)?)))
    }

    /// The scene in a file, which is copied into memory of the scene's own, on huge pages where the system has them: what becomes of the file
    /// afterwards does not matter.
    ///
    /// # Errors
    /// As [`Scene::open`].
    pub fn read(path: impl AsRef<Path>) -> Result<Self, FileError> {
        Self::at(path.as_ref(), |mut file, len| {
            let fill = |copy: &mut [u8]| file.read_exact(copy);
            Ok(Kept::new(AlignedBytes::filled(len, fill)?))
        })
    }

    /// The scene in bytes that someone has. They are read in place if they are aligned to 64 bytes, else copied first. They must stay as
    /// they are while the scene lives, as those of every `AsRef` do.
    ///
    /// # Errors
    /// As [`Scene::open`].
    pub fn open_bytes(owner: impl AsRef<[u8]> + Send + Sync + 'static) -> Result<Self, FileError> {
        Self::of_bytes(&Kept::new(owner))
    }

    fn at(
        path: &Path,
        bytes: impl FnOnce(&File, usize) -> Result<Kept<u8>, FileError>,
    ) -> Result<Self, FileError> {
        promising(path)
            .and_then(|(file, len)| bytes(&file, len))
            .and_then(|bytes| Self::of_bytes(&bytes))
            .map_err(|error| error.of(path))
    }

    fn of_bytes(bytes: &Kept<u8>) -> Result<Self, FileError> {
        if bytes.is_aligned() {
            return parts::opened(bytes);
        }
        parts::opened(&Kept::new(AlignedBytes::copy(bytes)?))
    }
}

/// Bytes that lie as [`Scene::open_bytes`] reads them in place, on huge pages where the system has them.
pub struct AlignedBytes {
    memory: Arena,
    len: usize,
}

impl AlignedBytes {
    /// A copy.
    ///
    /// # Errors
    /// If there is no memory.
    pub fn copy(bytes: &[u8]) -> Result<Self, FileError> {
        Self::filled(bytes.len(), |copy| {
            copy.copy_from_slice(bytes);
            Ok(())
        })
    }

    fn filled(
        len: usize,
        fill: impl FnOnce(&mut [u8]) -> std::io::Result<()>,
    ) -> Result<Self, FileError> {
        let mut memory = Arena::new(len).ok_or(FileError::out_of_memory(len as u64))?;
        fill(&mut memory.bytes_mut()[..len])?;
        Ok(Self { memory, len })
    }
}

impl AsRef<[u8]> for AlignedBytes {
    fn as_ref(&self) -> &[u8] {
        &self.memory.bytes()[..self.len]
    }
}

impl std::fmt::Debug for AlignedBytes {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("AlignedBytes")
            .field("len", &self.len)
            .finish_non_exhaustive()
    }
}

/// The file at `path`, if it begins like a scene, and its length. Nothing else is asked for all of its bytes.
fn promising(path: &Path) -> Result<(File, usize), FileError> {
    // Before it is opened: that may wait for somebody to write.
    if !std::fs::metadata(path)?.is_file() {
        return Err(FileError::new(FileCause::NoScene));
    }
    let mut file = File::open(path)?;
    let len = file.metadata()?.len();
    let mut head = Vec::new();
    Read::by_ref(&mut file)
        .take(sections::HEADER as u64)
        .read_to_end(&mut head)?;
    sections::header(&head, len)?;
    file.rewind()?;
    let len = usize::try_from(len).map_err(|_| FileError::out_of_memory(len))?;
    Ok((file, len))
}
