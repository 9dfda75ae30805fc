//! Names of files with the frame in them.

/// `shot.{frame:04}.png`, or `shot.####.png`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Template {
    pieces: Vec<Piece>,
}

#[derive(Clone, Debug, PartialEq, Eq)]
enum Piece {
    Text(String),
    /// With at least so many digits.
    Frame(usize),
}

/// Most digits of a frame.
const MAX_DIGITS: usize = 20;

impl Template {
    /// `#` stands for a digit of the frame, unless the name says `{frame}` anywhere. The error says what is wrong.
    pub(super) fn parse(name: &str) -> Result<Self, String> {
        let braced = name.contains("{frame");
        let mut pieces = Vec::new();
        let mut rest = name;
        while !rest.is_empty() {
            let length = rest
                .find(|c| c == '{' || (c == '#' && !braced))
                .unwrap_or(rest.len());
            let (text, special) = rest.split_at(length);
            if !text.is_empty() {
                pieces.push(Piece::Text(text.to_owned()));
            }
            rest = match special.chars().next() {
                Some('{') => {
                    let end = special.find('}').ok_or("a { without its }")?;
                    pieces.push(Piece::Frame(digits(&special[1..end])?));
                    &special[end + 1..]
                }
                Some(_) => {
                    let after = special.trim_start_matches('#');
                    let digits = special.len() - after.len();
                    pieces.push(Piece::Frame(digits.min(MAX_DIGITS)));
                    after
                }
                None => "",
            };
        }
        Ok(Self { pieces })
    }

    /// Whether frames get names of their own.
    pub(super) fn has_frame(&self) -> bool {
        self.pieces
            .iter()
            .any(|piece| matches!(piece, Piece::Frame(_)))
    }

    /// The name of a frame's file.
    pub(super) fn name(&self, frame: i32) -> String {
        let show = |piece: &Piece| match piece {
            Piece::Text(text) => text.clone(),
            Piece::Frame(digits) => format!("{frame:0digits$}"),
        };
        self.pieces.iter().map(show).collect()
    }
}

/// Of what stands between braces.
fn digits(inside: &str) -> Result<usize, String> {
    let unknown = || format!("{{{inside}}} is not known: write {{frame}}, {{frame:04}} or ####");
    match inside.strip_prefix("frame").ok_or_else(unknown)? {
        "" => Ok(1),
        format => {
            let digits = format
                .strip_prefix(':')
                .and_then(|digits| digits.parse().ok());
            digits
                .filter(|digits| (1..=MAX_DIGITS).contains(digits))
                .ok_or_else(unknown)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_get_names_with_as_many_digits_as_asked_for() {
        let cases = [
            ("shot.{frame:04}.png", 7, "shot.0007.png"),
            ("shot.{frame}.png", 7, "shot.7.png"),
            ("shot.####.exr", 12345, "shot.12345.exr"),
            ("shot.####.exr", -5, "shot.-005.exr"),
            ("take#2/{frame:03}_{frame}.png", 8, "take#2/008_8.png"),
            ("#.png", 3, "3.png"),
            ("still.png", 3, "still.png"),
        ];
        for (template, frame, name) in cases {
            let template = Template::parse(template).unwrap();
            assert_eq!(template.name(frame), name);
            assert_eq!(template.has_frame(), name != "still.png");
        }
    }

    #[test]
    fn what_stands_between_braces_is_known_or_refused() {
        for wrong in [
            "{scene}.png",
            "{frame:x}.png",
            "{frame:0}.png",
            "{frame:99}.png",
            "a{frame.png",
            "{}.png",
        ] {
            assert!(Template::parse(wrong).is_err(), "{wrong}");
        }
    }
}
