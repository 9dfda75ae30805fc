//! The two containers: JSON by itself, and GLB, which carries JSON and a binary chunk.

use crate::{Door, LoadError, Place};

/// The parts of a file.
pub(super) struct Container<'a> {
    pub(super) json: &'a [u8],
    pub(super) binary: Option<&'a [u8]>,
}

/// Splits a file into its parts. GLB: twelve bytes (magic, version, length), then chunks (length, kind, bytes).
pub(super) fn open<'a>(bytes: &'a [u8], door: &mut Door) -> Result<Container<'a>, LoadError> {
    if !bytes.starts_with(b"glTF") {
        let json = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        return Ok(Container { json, binary: None });
    }
    let fault = |at: usize, cause: String| door.error(Some(Place::Byte(at as u64)), cause);
    let (Some(version), Some(length)) = (word(bytes, 4), word(bytes, 8)) else {
        return Err(fault(
            0,
            format!("a GLB header has 12 bytes, the file has {}", bytes.len()),
        ));
    };
    if version != 2 {
        return Err(fault(4, format!("GLB version {version} is not 2"))
            .with_remedy("convert it to glTF 2.0"));
    }
    let length = usize::try_from(length).unwrap_or(usize::MAX);
    if length > bytes.len() {
        let cause = format!(
            "the header promises {length} bytes, the file has {}",
            bytes.len()
        );
        return Err(fault(8, cause).with_remedy("it is cut off: copy or download it again"));
    }

    let mut parts = Container {
        json: &[],
        binary: None,
    };
    let mut rest = bytes[..length].get(12..).unwrap_or_default();
    while !rest.is_empty() {
        let at = length - rest.len();
        let (Some(size), Some(kind)) = (word(rest, 0), word(rest, 4)) else {
            return Err(fault(
                at,
                format!("a chunk header has 8 bytes, {} are left", rest.len()),
            ));
        };
        let size = usize::try_from(size).unwrap_or(usize::MAX);
        let Some((chunk, tail)) = rest[8..].split_at_checked(size) else {
            return Err(fault(
                at,
                format!("a chunk of {size} bytes, {} are left", rest.len() - 8),
            ));
        };
        match &kind.to_le_bytes() {
            b"JSON" if parts.json.is_empty() => parts.json = chunk,
            b"BIN\0" if parts.binary.is_none() => parts.binary = Some(chunk),
            // Other kinds are extensions; the specification says to skip them.
            _ => {}
        }
        rest = tail;
    }
    if parts.json.is_empty() {
        return Err(fault(12, "has no JSON chunk".into()));
    }
    Ok(parts)
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(*bytes.get(at..)?.first_chunk()?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Limits;

    fn glb(chunks: &[(&[u8; 4], &[u8])]) -> Vec<u8> {
        let mut bytes = b"glTF\x02\0\0\0\0\0\0\0".to_vec();
        for (kind, content) in chunks {
            bytes.extend((content.len() as u32).to_le_bytes());
            bytes.extend(*kind);
            bytes.extend(*content);
        }
        let length = bytes.len() as u32;
        bytes[8..12].copy_from_slice(&length.to_le_bytes());
        bytes
    }

    fn refusal(bytes: &[u8]) -> String {
        let mut door = Door::without_files("a.glb", Limits::default());
        open(bytes, &mut door).err().expect("an error").to_string()
    }

    #[test]
    fn finds_both_chunks_and_skips_unknown_ones() {
        let bytes = glb(&[(b"JSON", b"{} "), (b"what", b"x"), (b"BIN\0", b"1234")]);
        let mut door = Door::without_files("a.glb", Limits::default());
        let parts = open(&bytes, &mut door).unwrap();
        assert_eq!(
            (parts.json, parts.binary),
            (&b"{} "[..], Some(&b"1234"[..]))
        );
    }

    #[test]
    fn every_lying_length_is_an_error() {
        let good = glb(&[(b"JSON", b"{} "), (b"BIN\0", b"1234")]);
        for cut in 4..good.len() {
            let error = refusal(&good[..cut]);
            assert!(
                error.contains("promises") || error.contains("12 bytes"),
                "{cut}: {error}"
            );
        }
        for (at, value) in [
            (8, 11_u32),
            (8, 0),
            (8, 13),
            (12, 1000),
            (12, u32::MAX),
            (12, 4),
        ] {
            let mut bad = good.clone();
            bad[at..at + 4].copy_from_slice(&value.to_le_bytes());
            assert!(!refusal(&bad).is_empty(), "{value} at {at}");
        }
        assert!(refusal(b"glTF\x01\0\0\0\x0c\0\0\0").contains("version 1 is not 2"));
    }
}
