//! The header of a PLY file: what follows, in which order and coding.

use std::borrow::Cow;

use crate::Place;
use crate::format::text::{Lines, shown, words};

/// How numbers are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// The type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Kind {
    fn of(word: &[u8]) -> Result<Self, String> {
        Ok(match word {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return Err(format!("\"{}\" is no type of PLY", shown(word))),
        })
    }

    /// Bytes of one number in binary files.
    pub(crate) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

/// A column of an element; a list if it has a type for the length.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Property {
    pub(crate) name: Vec<u8>,
    pub(crate) kind: Kind,
    pub(crate) list_count: Option<Kind>,
}

/// A table of the file. `count` is what the header says, not to be trusted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Element {
    pub(crate) name: Vec<u8>,
    pub(crate) count: u64,
    pub(crate) properties: Vec<Property>,
}

impl Element {
    pub(crate) fn shown_name(&self) -> Cow<'_, str> {
        shown(&self.name)
    }
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Header {
    pub(crate) encoding: Encoding,
    pub(crate) elements: Vec<Element>,
    /// Bytes up to the data.
    pub(crate) length: usize,
    /// Lines up to the data.
    pub(crate) lines: u64,
}

impl Header {
    /// Reads up to `end_header`.
    pub(crate) fn read(bytes: &[u8]) -> Result<Self, (Place, String)> {
        let mut lines = Lines::new(bytes);
        if lines
            .next()
            .is_none_or(|line| line.bytes.trim_ascii() != b"ply")
        {
            return Err((
                Place::Line(1),
                "a PLY file begins with the line \"ply\"".to_owned(),
            ));
        }
        let mut encoding = None;
        let mut elements: Vec<Element> = Vec::new();
        while let Some(line) = lines.next() {
            let at = |cause: String| (Place::Line(line.number), cause);
            let mut words = words(line.bytes);
            let mut word = || words.next().unwrap_or_default();
            match word() {
                b"format" => encoding = Some(encoding_of(word()).map_err(at)?),
                b"element" => elements.push(element(word(), word()).map_err(at)?),
                b"property" => match elements.last_mut() {
                    Some(element) => element.properties.push(property(word).map_err(at)?),
                    None => {
                        return Err(at("a property stands before the first element".to_owned()));
                    }
                },
                b"comment" | b"obj_info" | b"" => {}
                b"end_header" => {
                    let Some(encoding) = encoding else {
                        return Err(at("no line \"format\"".to_owned()));
                    };
                    let length = bytes.len() - lines.rest().len();
                    return Ok(Self {
                        encoding,
                        elements,
                        length,
                        lines: lines.number(),
                    });
                }
                other => {
                    return Err(at(format!(
                        "\"{}\" is no word of a PLY header",
                        shown(other)
                    )));
                }
            }
        }
        Err((
            Place::Line(lines.number()),
            "the header has no \"end_header\"".to_owned(),
        ))
    }
}

fn encoding_of(word: &[u8]) -> Result<Encoding, String> {
    match word {
        b"ascii" => Ok(Encoding::Ascii),
        b"binary_little_endian" => Ok(Encoding::LittleEndian),
        b"binary_big_endian" => Ok(Encoding::BigEndian),
        _ => Err(format!("unknown format \"{}\"", shown(word))),
    }
}

fn element(name: &[u8], count: &[u8]) -> Result<Element, String> {
    let parsed = std::str::from_utf8(count)
        .ok()
        .and_then(|count| count.parse().ok());
    match parsed {
        Some(count) if !name.is_empty() => Ok(Element {
            name: name.to_vec(),
            count,
            properties: Vec::new(),
        }),
        _ => Err(format!(
            "element \"{}\" has no count but \"{}\"",
            shown(name),
            shown(count)
        )),
    }
}

fn property<'a>(mut word: impl FnMut() -> &'a [u8]) -> Result<Property, String> {
    let first = word();
    let (list_count, kind) = match first {
        b"list" => (Some(Kind::of(word())?), Kind::of(word())?),
        _ => (None, Kind::of(first)?),
    };
    match word() {
        b"" => Err("a property has no name".to_owned()),
        name => Ok(Property {
            name: name.to_vec(),
            kind,
            list_count,
        }),
    }
}
