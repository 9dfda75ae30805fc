//! The numbers behind a PLY header, one after the other, in each of the three codings.
//!
//! All numbers are given as f64, which holds every value of every type.

use super::header::{Element, Kind, Property};
use crate::Place;
use crate::format::text::{Lines, keyword, shown, trimmed};

/// A stream of numbers, cut in rows.
pub(crate) trait Values {
    /// Must be called before the first number of a row.
    fn begin_row(&mut self) -> Result<(), String>;
    /// Must be called after the last number of a row.
    fn end_row(&mut self) -> Result<(), String>;
    /// The next number.
    fn number(&mut self, kind: Kind) -> Result<f64, String>;
    /// Steps over `count` numbers in time that does not depend on `count` alone.
    fn skip(&mut self, kind: Kind, count: u64) -> Result<(), String>;
    /// Bytes that are not read yet.
    fn bytes_left(&self) -> usize {
        self.rest().len()
    }
    /// What is not read yet.
    fn rest(&self) -> &[u8];
    /// The fewest bytes that a number takes.
    fn least_size(&self, kind: Kind) -> usize;
    /// Where the row is that was begun last.
    fn place(&self) -> Place;

    /// The length of a list.
    fn length(&mut self, kind: Kind) -> Result<u64, String> {
        let value = self.number(kind)?;
        if value < 0.0 || value.fract() != 0.0 || value > f64::from(u32::MAX) {
            return Err(format!("a list can't have the length {value}"));
        }
        Ok(value as u64)
    }

    /// Steps over a number or a list.
    fn skip_property(&mut self, property: &Property) -> Result<(), String> {
        let count = match property.list_count {
            None => 1,
            Some(count) => self.length(count)?,
        };
        self.skip(property.kind, count)
    }

    /// The fewest bytes that a row takes: all its lists may be empty.
    fn least_row(&self, element: &Element) -> usize {
        element
            .properties
            .iter()
            .map(|p| self.least_size(p.list_count.unwrap_or(p.kind)))
            .sum()
    }
}

/// Numbers as words, a row a line.
pub(crate) struct Ascii<'a> {
    lines: Lines<'a>,
    row: &'a [u8],
    lines_before: u64,
}

impl<'a> Ascii<'a> {
    /// `body` begins after `lines_before` lines of header.
    pub(crate) fn new(body: &'a [u8], lines_before: u64) -> Self {
        Self {
            lines: Lines::new(body),
            row: &[],
            lines_before,
        }
    }

    fn word(&mut self) -> Result<&'a [u8], String> {
        let (word, rest) = keyword(self.row);
        if word.is_empty() {
            return Err("the row has fewer numbers than the header says".to_owned());
        }
        self.row = rest;
        Ok(word)
    }
}

impl Values for Ascii<'_> {
    fn begin_row(&mut self) -> Result<(), String> {
        for line in &mut self.lines {
            self.row = trimmed(line.bytes);
            if !self.row.is_empty() {
                return Ok(());
            }
        }
        Err("the file ends before the rows that the header promises".to_owned())
    }

    fn end_row(&mut self) -> Result<(), String> {
        match self.row {
            [] => Ok(()),
            rest => Err(format!(
                "the row has more numbers than the header says: \"{}\"",
                shown(rest)
            )),
        }
    }

    fn number(&mut self, kind: Kind) -> Result<f64, String> {
        let word = self.word()?;
        let text = std::str::from_utf8(word).ok();
        let value = match kind {
            // Straight to float: by way of double it could be rounded twice.
            Kind::F32 => text
                .and_then(|text| text.parse::<f32>().ok())
                .map(f64::from),
            _ => text.and_then(|text| text.parse().ok()),
        };
        value.ok_or_else(|| format!("\"{}\" is not a number", shown(word)))
    }

    fn skip(&mut self, _kind: Kind, count: u64) -> Result<(), String> {
        // Ends with the row, however large the count.
        (0..count).try_for_each(|_| self.word().map(|_| ()))
    }

    fn rest(&self) -> &[u8] {
        self.lines.rest()
    }

    fn least_size(&self, _kind: Kind) -> usize {
        // A digit and a blank.
        2
    }

    fn place(&self) -> Place {
        Place::Line(self.lines_before + self.lines.number())
    }
}

/// Numbers as bytes.
pub(crate) struct Binary<'a, const BIG_ENDIAN: bool> {
    rest: &'a [u8],
    end: usize,
    row: usize,
}

impl<'a, const BIG_ENDIAN: bool> Binary<'a, BIG_ENDIAN> {
    /// `body` begins after `bytes_before` bytes of header.
    pub(crate) fn new(body: &'a [u8], bytes_before: usize) -> Self {
        Self {
            rest: body,
            end: bytes_before + body.len(),
            row: bytes_before,
        }
    }

    #[inline]
    fn take<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let Some((bytes, rest)) = self.rest.split_first_chunk::<N>() else {
            return Err(ends_early());
        };
        self.rest = rest;
        let mut bytes = *bytes;
        if BIG_ENDIAN {
            bytes.reverse();
        }
        Ok(bytes)
    }
}

fn ends_early() -> String {
    "the file ends within the data that the header promises".to_owned()
}

impl<const BIG_ENDIAN: bool> Values for Binary<'_, BIG_ENDIAN> {
    #[inline]
    fn begin_row(&mut self) -> Result<(), String> {
        self.row = self.end - self.rest.len();
        Ok(())
    }

    #[inline]
    fn end_row(&mut self) -> Result<(), String> {
        Ok(())
    }

    #[inline]
    fn number(&mut self, kind: Kind) -> Result<f64, String> {
        Ok(match kind {
            Kind::I8 => f64::from(i8::from_le_bytes(self.take()?)),
            Kind::U8 => f64::from(u8::from_le_bytes(self.take()?)),
            Kind::I16 => f64::from(i16::from_le_bytes(self.take()?)),
            Kind::U16 => f64::from(u16::from_le_bytes(self.take()?)),
            Kind::I32 => f64::from(i32::from_le_bytes(self.take()?)),
            Kind::U32 => f64::from(u32::from_le_bytes(self.take()?)),
            Kind::F32 => f64::from(f32::from_le_bytes(self.take()?)),
            Kind::F64 => f64::from_le_bytes(self.take()?),
        })
    }

    fn skip(&mut self, kind: Kind, count: u64) -> Result<(), String> {
        let bytes = count.saturating_mul(kind.size() as u64);
        let rest = usize::try_from(bytes)
            .ok()
            .and_then(|bytes| self.rest.get(bytes..));
        self.rest = rest.ok_or_else(ends_early)?;
        Ok(())
    }

    fn rest(&self) -> &[u8] {
        self.rest
    }

    fn least_size(&self, kind: Kind) -> usize {
        kind.size()
    }

    fn place(&self) -> Place {
        Place::Byte(self.row as u64)
    }
}
