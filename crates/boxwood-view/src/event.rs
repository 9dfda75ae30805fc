//! What happens to the viewer, and what it asks of whoever runs it.

use std::path::PathBuf;

use crate::Key;

/// Something happened. Places are in pixels of the window, from its upper left corner.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// A key goes down; also again and again while it is held.
    Press(Key),
    /// A key comes up.
    Release(Key),
    /// The shift key is down from now on, or up.
    Shift(bool),
    /// A button of the pointer goes down.
    ButtonDown(Button),
    /// All of them are up.
    ButtonsUp,
    /// The pointer is there.
    Pointer([f32; 2]),
    /// Notches of the wheel, away from the user positive.
    Wheel(f32),
    /// The window's inner size is width x height now.
    Resize([u32; 2]),
    /// A file was dropped onto the window.
    Drop(PathBuf),
    /// Nobody looks at the window any more: keys that are down come up unseen.
    FocusLost,
}

/// Of the pointer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Button {
    /// Orbits.
    Left,
    /// Pans.
    Other,
}

/// What the viewer wants done outside.
#[derive(Clone, Debug, PartialEq)]
pub enum Wish {
    /// A line for standard output.
    Print(String),
    /// A line for standard error.
    Warn(String),
    /// Fill the screen, or no longer.
    ToggleFullScreen,
    /// The end.
    Quit,
}
