//! The frame of a file: a header, a table of sections, and the sections, each at a cache line of its own.
//!
//! There is one way to write a frame: sections stand in the order of the table, one behind the other, and all bytes between are zero.

use super::error::{FileCause, FileError};
use crate::scene::ContentHash;
use crate::simd::{ALIGNMENT, Kept};
use std::io::Write;
use std::ops::Range;

/// First bytes of a file. Like PNG's they show whether it was sent as text.
const MAGIC: [u8; 8] = *b"\x89BWX\r\n\x1a\n";
/// Raised when the frame or a section changes.
const VERSION: u32 = 1;
/// Raised when nodes and leaves of the tree change.
const LAYOUT: u32 = 1;
/// Reads otherwise where bytes go the other way.
const ENDIAN: u32 = 0x0102_0304;

/// Magic, version, endianness, layout, sections, length; hash.
pub(super) const HEADER: usize = 64;
const HASH: Range<usize> = 32..64;
/// Name; offset, length.
const ENTRY: usize = 64;
const NAME: usize = 48;

/// Where the next section may begin.
fn aligned(at: u64) -> Option<u64> {
    at.checked_next_multiple_of(ALIGNMENT as u64)
}

/// A section to be written.
pub(super) struct Section<'a> {
    pub(super) name: String,
    pub(super) bytes: &'a [u8],
}

/// All of a file but the hash, piece by piece.
fn pieces<'a>(head: &'a [u8], sections: &'a [Section<'a>]) -> impl Iterator<Item = &'a [u8]> {
    const ZEROS: [u8; ALIGNMENT] = [0; ALIGNMENT];
    let padded = |section: &Section<'a>| {
        let rest = section.bytes.len().next_multiple_of(ALIGNMENT) - section.bytes.len();
        [section.bytes, &ZEROS[..rest]]
    };
    std::iter::once(head).chain(sections.iter().flat_map(padded))
}

/// Header and table; the hash is still zero.
fn head(sections: &[Section<'_>]) -> Vec<u8> {
    let mut table = Vec::new();
    let mut end = (HEADER + ENTRY * sections.len()) as u64;
    for Section { name, bytes } in sections {
        let mut entry = [0; ENTRY];
        entry[..name.len()].copy_from_slice(name.as_bytes());
        entry[NAME..NAME + 8].copy_from_slice(&end.to_le_bytes());
        entry[NAME + 8..].copy_from_slice(&(bytes.len() as u64).to_le_bytes());
        table.extend(entry);
        end += (bytes.len() as u64).next_multiple_of(ALIGNMENT as u64);
    }
    let mut head = MAGIC.to_vec();
    for number in [VERSION, ENDIAN, LAYOUT, sections.len() as u32] {
        head.extend(number.to_le_bytes());
    }
    head.extend(end.to_le_bytes());
    head.extend([0; 32]);
    head.extend(table);
    head
}

/// The hash of a file: of all its bytes but the hash's own.
fn add(hasher: &mut blake3::Hasher, bytes: &[u8]) {
    #[cfg(feature = "rayon")]
    hasher.update_rayon(bytes);
    #[cfg(not(feature = "rayon"))]
    hasher.update(bytes);
}

/// Hash and head of a file.
fn sealed(sections: &[Section<'_>]) -> (ContentHash, Vec<u8>) {
    let mut head = head(sections);
    let mut hasher = blake3::Hasher::new();
    hasher.update(&head[..HASH.start]);
    for piece in pieces(&head[HASH.end..], sections) {
        add(&mut hasher, piece);
    }
    let hash = ContentHash(*hasher.finalize().as_bytes());
    head[HASH].copy_from_slice(&hash.0);
    (hash, head)
}

/// The hash that [`write`] would give.
pub(super) fn hash(sections: &[Section<'_>]) -> ContentHash {
    sealed(sections).0
}

/// Writes a file.
pub(super) fn write(sections: &[Section<'_>], to: &mut impl Write) -> std::io::Result<ContentHash> {
    let (hash, head) = sealed(sections);
    pieces(&head, sections).try_for_each(|piece| to.write_all(piece))?;
    to.flush()?;
    Ok(hash)
}

/// The sections of a file, of which nothing is known but where they are and that they are what was saved.
#[derive(Debug)]
pub(super) struct Read {
    pub(super) hash: ContentHash,
    /// By name, in the order of the file.
    pub(super) sections: Vec<(String, Kept<u8>)>,
}

/// Takes a file apart.
pub(super) fn read(bytes: &Kept<u8>) -> Result<Read, FileError> {
    let count = header(bytes, bytes.len() as u64)?;
    let hash = ContentHash(bytes[HASH].try_into().unwrap_or_default());
    let mut hasher = blake3::Hasher::new();
    hasher.update(&bytes[..HASH.start]);
    add(&mut hasher, &bytes[HASH.end..]);
    if *hasher.finalize().as_bytes() != hash.0 {
        return Err(FileError::new(FileCause::WrongHash));
    }
    let sections = table(bytes, count)?;
    Ok(Read { hash, sections })
}

fn u32_at(bytes: &[u8], at: usize) -> u32 {
    bytes[at..]
        .first_chunk()
        .map_or(0, |b| u32::from_le_bytes(*b))
}

fn u64_at(bytes: &[u8], at: usize) -> u64 {
    bytes[at..]
        .first_chunk()
        .map_or(0, |b| u64::from_le_bytes(*b))
}

/// Checks the header of a file of `found` bytes that begins with `bytes`; gives the number of sections.
pub(super) fn header(bytes: &[u8], found: u64) -> Result<usize, FileError> {
    let error = |cause| Err(FileError::new(cause));
    if !bytes.starts_with(&MAGIC[..bytes.len().min(MAGIC.len())]) || bytes.is_empty() {
        return error(FileCause::NoScene);
    }
    if bytes.len() < HEADER {
        let expected = HEADER as u64;
        return error(FileCause::WrongLength { expected, found });
    }
    let [version, endian, layout, count] = [8, 12, 16, 20].map(|at| u32_at(bytes, at));
    if endian != ENDIAN || cfg!(target_endian = "big") {
        return error(FileCause::OtherMachine);
    }
    let known = [VERSION, LAYOUT];
    if [version, layout] != known {
        let found = [version, layout];
        return error(FileCause::OtherVersion { found, known });
    }
    let expected = u64_at(bytes, 24);
    if expected != found {
        return error(FileCause::WrongLength { expected, found });
    }
    match u64::from(count) <= (found - HEADER as u64) / ENTRY as u64 {
        true => Ok(count as usize),
        false => Err(FileError::broken(
            "header",
            20,
            "more sections than there is room for",
        )),
    }
}

/// The sections of the table.
fn table(bytes: &Kept<u8>, count: usize) -> Result<Vec<(String, Kept<u8>)>, FileError> {
    let mut sections = Vec::new();
    let mut end = HEADER + ENTRY * count;
    for number in 0..count {
        let at = HEADER + ENTRY * number;
        let broken = |rule| FileError::broken("table", (ENTRY * number) as u64, rule);
        let entry = &bytes[at..at + ENTRY];
        let [offset, length] = [NAME, NAME + 8].map(|at| u64_at(entry, at));
        let begin = aligned(end as u64).filter(|begin| *begin == offset);
        let begin = begin.ok_or(broken("a section does not begin where the one before ends"))?;
        let to = begin
            .checked_add(length)
            .and_then(|to| usize::try_from(to).ok());
        let section = to.and_then(|to| bytes.part(begin as usize..to));
        let section = section.ok_or(broken("a section goes beyond the end of the file"))?;
        zeros(bytes, end, begin as usize)?;
        let name = name(&entry[..NAME]).ok_or(broken("a section has no name"))?;
        end = begin as usize + section.len();
        sections.push((name.to_owned(), section));
    }
    if aligned(end as u64) != Some(bytes.len() as u64) {
        return Err(FileError::broken(
            "table",
            0,
            "the file goes on behind its sections",
        ));
    }
    zeros(bytes, end, bytes.len())?;
    Ok(sections)
}

/// Letters, then zeros.
fn name(bytes: &[u8]) -> Option<&str> {
    let len = bytes
        .iter()
        .position(|byte| *byte == 0)
        .unwrap_or(bytes.len());
    let rest_is_zero = bytes[len..].iter().all(|byte| *byte == 0);
    let name = std::str::from_utf8(&bytes[..len]).ok()?;
    (rest_is_zero && !name.is_empty()).then_some(name)
}

fn zeros(bytes: &[u8], from: usize, to: usize) -> Result<(), FileError> {
    match bytes[from..to].iter().all(|byte| *byte == 0) {
        true => Ok(()),
        false => Err(FileError::broken(
            "file",
            from as u64,
            "what is unused is not zero",
        )),
    }
}
