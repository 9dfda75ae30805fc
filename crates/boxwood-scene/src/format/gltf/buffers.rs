//! The bytes that a glTF file names: its binary chunk, data URIs, files beside it.

use std::borrow::Cow;
use std::collections::HashMap;

use base64::Engine;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};

use super::Source;
use super::json::Document;
use crate::{Door, LoadError, Place};

/// The contents of all buffers.
pub(super) struct Buffers<'a> {
    contents: Vec<Cow<'a, [u8]>>,
    /// Index into `contents` for each buffer of the document; `None` for a buffer without data.
    of_buffer: Vec<Option<usize>>,
}

impl<'a> Buffers<'a> {
    /// Gets the bytes of each buffer, a file that is named twice only once.
    ///
    /// Makes sure that each has the length that the document states.
    pub(super) fn open(
        document: &Document<'_>,
        binary: Option<&'a [u8]>,
        door: &mut Door,
    ) -> Result<Self, LoadError> {
        let mut buffers = Self {
            contents: Vec::new(),
            of_buffer: Vec::new(),
        };
        let mut known = HashMap::new();
        for (i, buffer) in document.buffers.iter().enumerate() {
            let place = || Some(Place::Path(format!("buffers[{i}]")));
            let content = match (&buffer.uri, binary) {
                (Some(uri), _) => match known.get(uri.as_str()) {
                    Some(&content) => Some(content),
                    None => {
                        let bytes = resolve(uri.as_str(), door).map_err(|error| LoadError {
                            place: error.place.or_else(place),
                            ..error
                        })?;
                        known.insert(uri.as_str(), buffers.contents.len());
                        Some(buffers.add(Cow::Owned(bytes)))
                    }
                },
                (None, Some(binary)) if i == 0 => Some(buffers.add(Cow::Borrowed(binary))),
                (None, _) => None,
            };
            let length = content.map(|content| buffers.contents[content].len() as u64);
            if let Some(length) = length.filter(|&length| length < buffer.byte_length) {
                let cause = format!(
                    "is said to have {} bytes and has {length}",
                    buffer.byte_length
                );
                return Err(door.error(place(), cause));
            }
            buffers.of_buffer.push(content);
        }
        Ok(buffers)
    }

    fn add(&mut self, bytes: Cow<'a, [u8]>) -> usize {
        self.contents.push(bytes);
        self.contents.len() - 1
    }

    /// Total size, to relate what is made of it to.
    pub(super) fn byte_count(&self) -> u64 {
        self.contents
            .iter()
            .map(|content| content.len() as u64)
            .sum()
    }
}

/// The bytes of one buffer view.
pub(super) struct View<'a> {
    pub(super) bytes: &'a [u8],
    /// From one element to the next, if the document says so.
    pub(super) stride: Option<u32>,
}

impl Source<'_> {
    /// The bytes of the buffer view `index`, which `user` (a path) asks for.
    pub(super) fn view(&self, index: u32, user: &str) -> Result<View<'_>, LoadError> {
        let views = &self.document.buffer_views;
        let Some(view) = views.get(index as usize) else {
            return Err(self.fault(
                user,
                format!("refers to buffer view {index} of {}", views.len()),
            ));
        };
        let path = format!("bufferViews[{index}]");
        let count = self.buffers.of_buffer.len();
        let Some(content) = self.buffers.of_buffer.get(view.buffer as usize) else {
            return Err(self.fault(path, format!("refers to buffer {} of {count}", view.buffer)));
        };
        let Some(content) = content.map(|content| &*self.buffers.contents[content]) else {
            let error = self.fault(path, format!("buffer {} has no data", view.buffer));
            return Err(error.with_remedy("is the file compressed? store it without compression"));
        };
        let bytes = slice(content, view.byte_offset, view.byte_length).ok_or_else(|| {
            let cause = format!(
                "{} bytes from {} on, the buffer has {}",
                view.byte_length,
                view.byte_offset,
                content.len()
            );
            self.fault(path, cause)
        })?;
        Ok(View {
            bytes,
            stride: view.byte_stride,
        })
    }
}

/// `length` bytes from `offset` on, if they are there.
pub(super) fn slice(bytes: &[u8], offset: u64, length: u64) -> Option<&[u8]> {
    let end = usize::try_from(offset.checked_add(length)?).ok()?;
    bytes.get(usize::try_from(offset).ok()?..end)
}

/// The bytes that a URI names: its own for `data:`, else those of a file beside the scene.
pub(super) fn resolve(uri: &str, door: &mut Door) -> Result<Vec<u8>, LoadError> {
    let is_data = uri
        .get(..5)
        .is_some_and(|scheme| scheme.eq_ignore_ascii_case("data:"));
    if !is_data {
        return door.beside(uri);
    }
    let Some((head, payload)) = uri.split_once(',') else {
        return Err(door.error(None, "a data URI without a comma"));
    };
    if !head.to_ascii_lowercase().ends_with(";base64") {
        return Err(door.error(None, "a data URI that is not base64"));
    }
    BASE64
        .decode(payload)
        .map_err(|error| door.error(None, format!("a data URI with broken base64: {error}")))
}

/// The usual alphabet; the padding at the end may be missing, as some exporters leave it out.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &base64::alphabet::STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Limits;

    #[test]
    fn data_uris_are_decoded_with_and_without_padding() {
        let mut door = Door::without_files("a.gltf", Limits::default());
        for uri in [
            "data:application/octet-stream;base64,AQID/w==",
            "DATA:;base64,AQID/w",
        ] {
            assert_eq!(resolve(uri, &mut door).unwrap(), [1, 2, 3, 255]);
        }
        for uri in [
            "data:;base64",
            "data:text/plain,abc",
            "data:;base64,A$",
            "x.bin",
            "http://x/y",
        ] {
            assert!(resolve(uri, &mut door).is_err(), "{uri}");
        }
    }

    #[test]
    fn slices_never_wrap_around() {
        assert_eq!(slice(b"abcd", 1, 2), Some(&b"bc"[..]));
        assert_eq!(slice(b"abcd", 4, 0), Some(&b""[..]));
        assert_eq!(slice(b"abcd", u64::MAX, 2), None);
        assert_eq!(slice(b"abcd", 2, u64::MAX - 1), None);
        assert_eq!(slice(b"abcd", 5, 0), None);
    }
}
