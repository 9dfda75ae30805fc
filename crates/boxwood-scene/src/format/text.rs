//! Lines, words and numbers of text formats. All are bytes, since names need not be UTF-8.

use std::borrow::Cow;

/// One line without its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Line<'a> {
    /// Counted from 1.
    pub(crate) number: u64,
    /// What stands between two line ends.
    pub(crate) bytes: &'a [u8],
}

/// The lines of a text. A line ends with LF, CR LF or CR, the last one also with the text.
#[derive(Clone, Debug)]
pub(crate) struct Lines<'a> {
    rest: &'a [u8],
    number: u64,
}

impl<'a> Lines<'a> {
    pub(crate) fn new(text: &'a [u8]) -> Self {
        Self {
            rest: text,
            number: 0,
        }
    }

    /// All after the last line that was given.
    pub(crate) fn rest(&self) -> &'a [u8] {
        self.rest
    }

    /// The number of the last line that was given.
    pub(crate) fn number(&self) -> u64 {
        self.number
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = Line<'a>;

    fn next(&mut self) -> Option<Line<'a>> {
        if self.rest.is_empty() {
            return None;
        }
        let end = self
            .rest
            .iter()
            .position(|&byte| byte == b'\n' || byte == b'\r')
            .unwrap_or(self.rest.len());
        let (bytes, tail) = self.rest.split_at(end);
        self.rest = match tail {
            [b'\r', b'\n', rest @ ..] | [_, rest @ ..] => rest,
            [] => &[],
        };
        self.number += 1;
        Some(Line {
            number: self.number,
            bytes,
        })
    }
}

/// The words of a line, separated by blanks of any kind.
pub(crate) fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(|byte| is_blank(*byte))
        .filter(|word| !word.is_empty())
}

/// The first word of a line, and what follows it without blanks at either end.
pub(crate) fn keyword(line: &[u8]) -> (&[u8], &[u8]) {
    let line = trimmed(line);
    let end = line
        .iter()
        .position(|&byte| is_blank(byte))
        .unwrap_or(line.len());
    let (word, rest) = line.split_at(end);
    (word, trimmed(rest))
}

/// Without blanks at either end.
pub(crate) fn trimmed(mut text: &[u8]) -> &[u8] {
    while let [first, rest @ ..] = text
        && is_blank(*first)
    {
        text = rest;
    }
    while let [rest @ .., last] = text
        && is_blank(*last)
    {
        text = rest;
    }
    text
}

fn is_blank(byte: u8) -> bool {
    byte == b' ' || (b'\t'..=b'\r').contains(&byte)
}

/// A word as a finite number, correctly rounded; else the cause of an error.
pub(crate) fn number(word: &[u8]) -> Result<f32, String> {
    match any_number(word) {
        Some(value) if value.is_finite() => Ok(value),
        Some(_) => Err(format!("\"{}\" is not a finite number", shown(word))),
        None => Err(format!("\"{}\" is not a number", shown(word))),
    }
}

/// A word as a number, NaN and infinities included. A number too large for f32 is infinite.
pub(crate) fn any_number(word: &[u8]) -> Option<f32> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// A word as text for messages and names: bytes which are not UTF-8 are replaced, what is long is cut.
pub(crate) fn shown(word: &[u8]) -> Cow<'_, str> {
    const MAX: usize = 200;
    if word.len() > MAX {
        return Cow::Owned(format!("{}...", String::from_utf8_lossy(&word[..MAX])));
    }
    String::from_utf8_lossy(word)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_end_with_lf_crlf_or_cr() {
        let lines: Vec<_> = Lines::new(b"a\r\nb\rc\n\nd")
            .map(|line| (line.number, line.bytes))
            .collect();
        assert_eq!(
            lines,
            [(1, &b"a"[..]), (2, b"b"), (3, b"c"), (4, b""), (5, b"d")]
        );
        assert_eq!(Lines::new(b"").count(), 0);
        assert_eq!(Lines::new(b"\n").count(), 1);
    }

    #[test]
    fn words_are_separated_by_any_blanks() {
        assert_eq!(
            words(b" v\t1  2\x0b3 ").collect::<Vec<_>>(),
            [&b"v"[..], b"1", b"2", b"3"]
        );
        assert_eq!(
            keyword(b"  usemtl  red brick \r"),
            (&b"usemtl"[..], &b"red brick"[..])
        );
        assert_eq!(keyword(b" \t"), (&b""[..], &b""[..]));
    }

    #[test]
    fn numbers_are_finite_or_refused() {
        assert_eq!(number(b"-1.5e-3"), Ok(-1.5e-3));
        assert_eq!(number(b"5e29"), Ok(5e29));
        for bad in [&b"nan"[..], b"-inf", b"1e39", b"1,5", b"", b"\xff", b"0x10"] {
            assert!(number(bad).is_err(), "{bad:?}");
        }
    }
}
