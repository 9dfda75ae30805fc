//! The one table of keys: what they do, and the cheat sheet that says so.

use boxwood::STRUCTURES;

/// A key, as the viewer knows it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Key {
    /// Lower case.
    Char(char),
    /// F1 to F12.
    F(u8),
    /// Arrow.
    Left,
    /// Arrow.
    Right,
    /// Arrow.
    Up,
    /// Arrow.
    Down,
    /// Esc.
    Escape,
}

/// What a key does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Action {
    /// Shows the scene so; the same key again shows the next of the list.
    Look(&'static [&'static str]),
    /// Sixteen frames against the clock.
    Benchmark,
    /// The heat map of all tests: darker, brighter.
    Brightness,
    Logarithm,
    /// Moves while the key is held.
    Fly,
    /// Turns while the key is held.
    Turn,
    /// The first nine of the table of structures.
    Structure,
    Split,
    Boxes,
    /// Of the boxes: less, more.
    Depth,
    Pick,
    /// Of the picked ray: back, on.
    Step,
    Camera,
    Screenshot,
    Reset,
    Numbers,
    Graph,
    Help,
    FullScreen,
    Quit,
}

/// Keys with the same meaning; [`Action`] tells them apart by their place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Binding {
    pub(crate) keys: &'static [Key],
    pub(crate) action: Action,
    /// For the cheat sheet.
    pub(crate) about: &'static str,
}

/// The name of the look that is drawn frame by frame: sun and shadow.
pub(crate) const SUN: &str = "sun";

const fn bind(keys: &'static [Key], action: Action, about: &'static str) -> Binding {
    Binding {
        keys,
        action,
        about,
    }
}

const fn look(
    keys: &'static [Key],
    looks: &'static [&'static str],
    about: &'static str,
) -> Binding {
    bind(keys, Action::Look(looks), about)
}

use Key::{Char, F};

/// Every key, in the order of the cheat sheet.
pub(crate) const BINDINGS: &[Binding] = &[
    look(
        &[F(1)],
        &[SUN, "whitted", "path"],
        "sun and shadow; again: mirrors, path tracing",
    ),
    look(&[F(2)], &["eyelight"], "eye light"),
    look(&[F(3)], &["ao"], "ambient occlusion"),
    look(&[F(4)], &["uv"], "texture coordinates"),
    look(&[F(5)], &["normal"], "normals"),
    look(&[F(6)], &["part"], "a colour for each part of the scene"),
    look(&[F(7)], &["prim"], "a colour for each triangle"),
    bind(&[F(8)], Action::Benchmark, "benchmark: 16 frames"),
    bind(
        &[F(9), F(10)],
        Action::Brightness,
        "cost of each pixel: darker, brighter",
    ),
    look(&[F(11)], &["heat-boxes"], "cost: box tests alone"),
    look(&[F(12)], &["heat-prims"], "cost: triangle tests alone"),
    look(&[Char('z')], &["depth"], "depth"),
    bind(&[Char('l')], Action::Logarithm, "cost by the logarithm"),
    bind(
        &[
            Char('1'),
            Char('2'),
            Char('3'),
            Char('4'),
            Char('5'),
            Char('6'),
            Char('7'),
            Char('8'),
            Char('9'),
        ],
        Action::Structure,
        "",
    ),
    bind(
        &[Char('v')],
        Action::Split,
        "split: costs in two structures, the last two shown",
    ),
    bind(&[Char('b')], Action::Boxes, "boxes of the structure"),
    bind(
        &[Char('['), Char(']')],
        Action::Depth,
        "their depth: less, more",
    ),
    bind(
        &[Char('p')],
        Action::Pick,
        "pick the ray under the pointer; again: let go",
    ),
    bind(
        &[Char(','), Char('.')],
        Action::Step,
        "its walk: a step back, on",
    ),
    bind(
        &[Char('w'), Char('a'), Char('s'), Char('d')],
        Action::Fly,
        "fly: ahead, left, back, right",
    ),
    bind(
        &[Key::Left, Key::Right, Key::Up, Key::Down],
        Action::Turn,
        "look around",
    ),
    bind(&[Char('r')], Action::Reset, "the first camera again"),
    bind(
        &[Char('c')],
        Action::Camera,
        "print the camera as arguments",
    ),
    bind(&[Char('g')], Action::Screenshot, "grab the picture as PNG"),
    bind(&[Char('i')], Action::Numbers, "numbers"),
    bind(&[Char('t')], Action::Graph, "times of the last frames"),
    bind(&[Char('f')], Action::FullScreen, "full screen"),
    bind(&[Char('h')], Action::Help, "this sheet"),
    bind(&[Char('q'), Key::Escape], Action::Quit, "quit"),
];

/// What the pointer does.
const POINTER: &[(&str, &str)] = &[
    ("left drag", "orbit"),
    ("right, middle, shift drag", "pan"),
    ("wheel", "zoom"),
    ("drop a file", "show it"),
];

/// What `key` does, and which of the keys with that meaning it is.
pub(crate) fn action_of(key: Key) -> Option<(Action, usize)> {
    BINDINGS.iter().find_map(|binding| {
        let place = binding.keys.iter().position(|&k| k == key)?;
        Some((binding.action, place))
    })
}

/// A line for each binding and each thing that the pointer does: keys, and what they do.
pub(crate) fn cheat_sheet() -> Vec<(String, String)> {
    let of_keys = BINDINGS.iter().map(|binding| match binding.action {
        Action::Structure => structures(binding),
        _ => {
            let keys: Vec<String> = binding.keys.iter().map(|key| key.name()).collect();
            (keys.join(" "), binding.about.to_owned())
        }
    });
    let of_pointer = POINTER
        .iter()
        .map(|&(what, about)| (what.to_owned(), about.to_owned()));
    of_keys.chain(of_pointer).collect()
}

/// `1 .. 6` and the names.
fn structures(binding: &Binding) -> (String, String) {
    let names: Vec<&str> = STRUCTURES
        .iter()
        .map(|s| s.name)
        .take(binding.keys.len())
        .collect();
    (format!("1 .. {}", names.len()), names.join(", "))
}

impl Key {
    /// As on the cheat sheet.
    pub(crate) fn name(self) -> String {
        match self {
            Self::Char(letter) => letter.to_string(),
            F(number) => format!("F{number}"),
            Self::Left => "Left".to_owned(),
            Self::Right => "Right".to_owned(),
            Self::Up => "Up".to_owned(),
            Self::Down => "Down".to_owned(),
            Self::Escape => "Esc".to_owned(),
        }
    }

    /// True if it is pressed again and again while it is held.
    pub fn repeats(self) -> bool {
        let action = action_of(self).map(|(action, _)| action);
        matches!(
            action,
            Some(Action::Step | Action::Depth | Action::Brightness)
        )
    }

    /// The key with that name.
    pub(crate) fn named(name: &str) -> Option<Self> {
        let keys = BINDINGS.iter().flat_map(|binding| binding.keys);
        keys.copied().find(|key| key.name() == name)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use boxwood_render::Shading;

    use super::*;

    #[test]
    fn no_key_has_two_meanings_and_each_finds_its_own() {
        let mut seen = HashSet::new();
        for binding in BINDINGS {
            for (place, &key) in binding.keys.iter().enumerate() {
                assert!(seen.insert(key.name()), "{key:?} is bound twice");
                assert_eq!(action_of(key), Some((binding.action, place)));
                assert_eq!(Key::named(&key.name()), Some(key));
            }
        }
        assert_eq!(action_of(Char('k')), None);
    }

    #[test]
    fn every_look_is_in_the_table_of_shadings() {
        for binding in BINDINGS {
            let Action::Look(looks) = binding.action else {
                continue;
            };
            for look in looks.iter().filter(|look| **look != SUN) {
                assert!(Shading::named(look).is_ok(), "{look}");
            }
        }
    }

    #[test]
    fn the_sheet_names_every_key_and_every_structure() {
        let sheet = cheat_sheet();
        assert_eq!(sheet.len(), BINDINGS.len() + POINTER.len());
        assert!(
            sheet
                .iter()
                .all(|(keys, about)| !keys.is_empty() && !about.is_empty())
        );
        let structures = &sheet
            .iter()
            .find(|(keys, _)| keys.starts_with("1 .."))
            .unwrap()
            .1;
        assert!(STRUCTURES.iter().all(|s| structures.contains(s.name)));
    }
}
