//! Renders that are started, and what they leave.

use crate::common::{command, expect, text};
use std::fs;
use std::path::Path;
use std::process::Child;
use std::process::Stdio;

/// Shadings with noise, with a scale over the whole picture, and with a measured exposure; both formats.
pub(crate) const LOOKS: [(&str, &str); 4] = [
    ("builtin:bush", "--shading=ao --spp=2"),
    ("builtin:stadium", "--shading=heat-tests"),
    ("builtin:cornell", "--shading=path --spp=2"),
    ("builtin:sphere", "--shading=depth --crop=7,5,90,50"),
];
/// Not a whole number of tiles.
pub(crate) const SIZE: &str = "--size=109x67";

pub(crate) fn words<'a>(scene: &'a str, look: &'a str, output: &'a str) -> Vec<&'a str> {
    let mut words = vec!["render", scene, SIZE, "-o", output];
    words.extend(look.split(' '));
    words
}

pub(crate) fn spawn(folder: &Path, args: &[&str]) -> Child {
    let mut command = command(folder);
    command.args(args).stdout(Stdio::null());
    command
        .stderr(Stdio::null())
        .spawn()
        .expect("the binary runs")
}

pub(crate) fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries
        .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

#[track_caller]
pub(crate) fn refusal(folder: &Path, args: &[&str], code: i32) -> String {
    text(&expect(folder, args, code).stderr)
}
