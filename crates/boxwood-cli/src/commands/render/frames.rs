//! Lists of frames, as render farms write them.

use std::str::FromStr;

/// `1-240`, `1-240x2`, `1,5,7-9`, `10-1`, `-5-5`: in this order, each frame once.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct FrameList(pub(super) Vec<i32>);

/// Most frames of a list.
pub(super) const MAX_FRAMES: usize = 1_000_000;

impl FromStr for FrameList {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut frames = Vec::new();
        for part in text.split(',') {
            let range = Range::parse(part.trim())?;
            if range.count() + frames.len() as u64 > MAX_FRAMES as u64 {
                return Err(format!("more than {MAX_FRAMES} frames"));
            }
            frames.extend(range.frames());
        }
        let mut seen = std::collections::HashSet::new();
        frames.retain(|&frame| seen.insert(frame));
        Ok(Self(frames))
    }
}

/// From `first` on by `step` to `last` at most.
#[derive(Clone, Copy, Debug)]
struct Range {
    first: i32,
    last: i32,
    step: i64,
}

impl Range {
    fn parse(text: &str) -> Result<Self, String> {
        if let Some(sign) = text.find([':', 'y', '/']) {
            let sign = &text[sign..=sign];
            return Err(format!(
                "'{sign}' means different things on different farms; a step is written as 1-240x2"
            ));
        }
        let wrong = || {
            format!(
                "'{text}' is no frame and no range; write 7, 1-240 or 1-240x2, with commas between them"
            )
        };
        let (first, rest) = leading_number(text).ok_or_else(wrong)?;
        if rest.is_empty() {
            return Ok(Self {
                first,
                last: first,
                step: 1,
            });
        }
        let rest = rest.strip_prefix('-').ok_or_else(wrong)?;
        let (last, rest) = leading_number(rest).ok_or_else(wrong)?;
        let way: i64 = if last < first { -1 } else { 1 };
        let step = match rest.strip_prefix('x') {
            None if rest.is_empty() => way,
            None => return Err(wrong()),
            Some(step) => i64::from(step.parse::<i32>().map_err(|_| wrong())?),
        };
        match (step, first < last) {
            (0, _) => Err(format!("'{text}': a step of 0 goes nowhere")),
            (..0, true) => Err(format!(
                "'{text}': steps of {step} never get from {first} to {last}"
            )),
            (step, _) => Ok(Self {
                first,
                last,
                step: way * step.abs(),
            }),
        }
    }

    fn count(self) -> u64 {
        (i64::from(self.last) - i64::from(self.first)).unsigned_abs() / self.step.unsigned_abs() + 1
    }

    fn frames(self) -> impl Iterator<Item = i32> {
        (0..self.count() as i64).map(move |k| (i64::from(self.first) + k * self.step) as i32)
    }
}

/// A whole number, maybe negative, and what follows.
fn leading_number(text: &str) -> Option<(i32, &str)> {
    let digits = text.strip_prefix('-').unwrap_or(text);
    let end = digits
        .find(|c: char| !c.is_ascii_digit())
        .unwrap_or(digits.len());
    let end = end + (text.len() - digits.len());
    Some((text[..end].parse().ok()?, &text[end..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_ranges_and_steps_are_read_in_order_each_frame_once() {
        let cases: [(&str, &[i32]); 10] = [
            ("7", &[7]),
            ("1-4", &[1, 2, 3, 4]),
            ("1-8x3", &[1, 4, 7]),
            ("1,5, 7-9", &[1, 5, 7, 8, 9]),
            ("4-1", &[4, 3, 2, 1]),
            ("8-1x3", &[8, 5, 2]),
            ("8-1x-3", &[8, 5, 2]),
            ("-2-1", &[-2, -1, 0, 1]),
            ("-1--3", &[-1, -2, -3]),
            ("1-3,2-4,1", &[1, 2, 3, 4]),
        ];
        for (text, frames) in cases {
            assert_eq!(text.parse::<FrameList>().unwrap().0, frames, "{text}");
        }
    }

    #[test]
    fn other_farms_signs_and_nonsense_are_refused_in_words() {
        let cases = [
            ("", "no frame"),
            ("a", "no frame"),
            ("1-", "no frame"),
            ("1-5x", "no frame"),
            ("1.5", "no frame"),
            ("1 - 5", "no frame"),
            ("1-5x0", "goes nowhere"),
            ("1-5x-1", "never get"),
            ("1-10:2", "1-240x2"),
            ("1-10y2", "different farms"),
            ("1-99999999999", "no frame"),
            ("-2147483648-2147483647", "more than"),
        ];
        for (text, word) in cases {
            let error = text.parse::<FrameList>().unwrap_err();
            assert!(error.contains(word), "{text}: {error}");
        }
    }
}
