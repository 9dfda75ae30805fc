//! What a command says, and how it ends.
//!
//! Results go to stdout: text for people, or with `--json` one object for programs. Warnings and errors go to stderr.
//! Every JSON object begins with `{"boxwood": 1, "command": NAME, ...}`: the 1 is the version of the schema. New fields may
//! come within a version; a field that goes or changes its meaning makes a new one.

pub(crate) use boxwood_trace::{counted, grouped};
use std::{
    fmt,
    io::{self, IsTerminal, Write},
};

use anyhow::Context;
use boxwood::BuildError;
use boxwood_measure::MeasureError;
use boxwood_render::RenderError;
use boxwood_scene::LoadError;
use serde::Serialize;

/// In errors about it.
pub(crate) const STDOUT: &str = "standard output";
/// Version of the JSON objects.
const SCHEMA: u32 = 1;

/// How the process ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Exit {
    /// All well.
    Ok = 0,
    /// Compared things differ.
    Difference = 1,
    /// The command line cannot be followed, or the output cannot be written.
    Usage = 2,
    /// An input cannot be used.
    Input = 3,
    /// Interrupted, with what was done saved, or sent away by a process that makes the same: to be tried again.
    Interrupted = 4,
}

/// An error of the command line itself, with a way out. (Errors of the libraries bring their own.)
#[derive(Debug)]
pub(crate) struct Trouble {
    exit: Exit,
    cause: String,
    help: Option<String>,
}

impl Trouble {
    /// The user asked for something that cannot be done.
    pub(crate) fn usage(cause: impl Into<String>, help: impl Into<String>) -> Self {
        Self {
            exit: Exit::Usage,
            cause: cause.into(),
            help: Some(help.into()),
        }
    }

    /// The user gave something that cannot be used.
    pub(crate) fn input(cause: impl Into<String>, help: impl Into<String>) -> Self {
        Self {
            exit: Exit::Input,
            cause: cause.into(),
            help: Some(help.into()),
        }
    }

    /// From the error of a library.
    fn of(error: &anyhow::Error) -> Self {
        for cause in error.chain() {
            if let Some(Self { exit, cause, help }) = cause.downcast_ref() {
                return Self {
                    exit: *exit,
                    cause: cause.clone(),
                    help: help.clone(),
                };
            }
            if let Some(load) = cause.downcast_ref::<LoadError>() {
                let bare = LoadError {
                    remedy: None,
                    ..load.clone()
                };
                return Self {
                    exit: Exit::Input,
                    cause: bare.to_string(),
                    help: load.remedy.clone(),
                };
            }
            if let Some(build) = cause.downcast_ref::<BuildError>() {
                let exit = if matches!(build, BuildError::UnknownName { .. }) {
                    Exit::Usage
                } else {
                    Exit::Input
                };
                return Self {
                    exit,
                    cause: build.to_string(),
                    help: None,
                };
            }
            if let Some(RenderError::File { remedy, .. }) = cause.downcast_ref() {
                let (text, remedy) = (format!("{error:#}"), remedy.clone());
                let bare = text.strip_suffix(&format!("; {remedy}"));
                return Self {
                    exit: Exit::Input,
                    cause: bare.unwrap_or(&text).to_owned(),
                    help: Some(remedy),
                };
            }
            if let Some(render) = cause.downcast_ref::<RenderError>() {
                let exit = match render {
                    RenderError::Decode { .. } | RenderError::SizesDiffer { .. } => Exit::Input,
                    RenderError::Busy { .. } => Exit::Interrupted,
                    _ => Exit::Usage,
                };
                return Self::with_remedy(error, exit);
            }
            if let Some(measure) = cause.downcast_ref::<MeasureError>() {
                let exit = match measure {
                    MeasureError::Build(_)
                    | MeasureError::NoTriangles
                    | MeasureError::Report { .. } => Exit::Input,
                    _ => Exit::Usage,
                };
                return Self::with_remedy(error, exit);
            }
        }
        Self {
            exit: Exit::Usage,
            cause: format!("{error:#}"),
            help: None,
        }
    }

    /// From an error whose message ends with the remedy, as in "cause; remedy".
    fn with_remedy(error: &anyhow::Error, exit: Exit) -> Self {
        let text = format!("{error:#}");
        let (cause, help) = text
            .rsplit_once("; ")
            .map_or((&*text, None), |(c, h)| (c, Some(h.to_owned())));
        Self {
            exit,
            cause: cause.to_owned(),
            help,
        }
    }
}

impl fmt::Display for Trouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.cause)
    }
}

impl std::error::Error for Trouble {}

/// The mouth of a command.
#[derive(Debug)]
pub(crate) struct Output {
    command: &'static str,
    json: bool,
}

/// The frame around every JSON object.
#[derive(Serialize)]
struct Envelope<'a, T: Serialize> {
    boxwood: u32,
    command: &'a str,
    #[serde(flatten)]
    body: &'a T,
}

impl Output {
    /// For one run of `command`.
    pub(crate) fn new(command: &'static str, json: bool) -> Self {
        Self { command, json }
    }

    /// Whether the result is wanted as JSON; then nothing else may go to stdout.
    pub(crate) fn is_json(&self) -> bool {
        self.json
    }

    /// Prints the result as JSON: `body`'s fields within the versioned frame.
    pub(crate) fn json<T: Serialize>(&self, body: &T) -> anyhow::Result<()> {
        let envelope = Envelope {
            boxwood: SCHEMA,
            command: self.command,
            body,
        };
        self.text(serde_json::to_string_pretty(&envelope)?)
    }

    /// Prints text and a line end on stdout, at once.
    pub(crate) fn text(&self, text: impl fmt::Display) -> anyhow::Result<()> {
        let mut stdout = io::stdout().lock();
        writeln!(stdout, "{text}")
            .and_then(|()| stdout.flush())
            .context(STDOUT)
    }

    /// Prints bytes on stdout.
    pub(crate) fn bytes(&self, bytes: &[u8]) -> anyhow::Result<()> {
        let mut stdout = io::stdout().lock();
        stdout
            .write_all(bytes)
            .and_then(|()| stdout.flush())
            .context(STDOUT)
    }

    /// A line on stderr for people who look on; nothing where stderr is no terminal.
    pub(crate) fn note(&self, text: impl fmt::Display) {
        if io::stderr().is_terminal() {
            let _ = writeln!(io::stderr(), "{text}");
        }
    }

    /// Something that the user should know of, on stderr.
    pub(crate) fn warn(&self, text: impl fmt::Display) {
        let _ = writeln!(io::stderr(), "warning: {text}");
    }

    /// Says on stderr why the command failed, and chooses the exit code. A reader who has left (`| head`) is no failure.
    pub(crate) fn failed(&self, error: &anyhow::Error) -> Exit {
        let is_broken_pipe = |cause: &(dyn std::error::Error + 'static)| {
            cause
                .downcast_ref::<io::Error>()
                .is_some_and(|error| error.kind() == io::ErrorKind::BrokenPipe)
        };
        if error.chain().any(is_broken_pipe) {
            return Exit::Ok;
        }
        let Trouble { exit, cause, help } = Trouble::of(error);
        let mut text = format!("error: {cause}");
        if let Some(help) = help {
            text += &format!("\nhelp: {help}");
        }
        let _ = writeln!(io::stderr(), "{text}");
        exit
    }
}

/// A table for people: the first column to the left, numbers to the right.
#[derive(Clone, Debug, Default)]
pub(crate) struct Table {
    rows: Vec<Vec<String>>,
}

impl Table {
    /// With these column titles.
    pub(crate) fn new<S: Into<String>>(titles: impl IntoIterator<Item = S>) -> Self {
        Self {
            rows: vec![titles.into_iter().map(Into::into).collect()],
        }
    }

    /// Adds a row.
    pub(crate) fn row<S: Into<String>>(&mut self, cells: impl IntoIterator<Item = S>) {
        self.rows.push(cells.into_iter().map(Into::into).collect());
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width_of = |column: usize| {
            self.rows
                .iter()
                .filter_map(|row| row.get(column))
                .map(|c| c.chars().count())
                .max()
        };
        let widths: Vec<usize> = (0..).map_while(width_of).collect();
        let mut lines = Vec::new();
        for row in &self.rows {
            let cells = row
                .iter()
                .zip(&widths)
                .enumerate()
                .map(|(column, (cell, &width))| match column {
                    0 => format!("{cell:<width$}"),
                    _ => format!("{cell:>width$}"),
                });
            lines.push(cells.collect::<Vec<_>>().join("  ").trim_end().to_owned());
        }
        if let Some(titles) = lines.first().cloned() {
            lines.insert(
                1,
                "-".repeat(widths.iter().sum::<usize>() + 2 * widths.len().saturating_sub(1)),
            );
            lines[0] = titles;
        }
        f.write_str(&lines.join("\n"))
    }
}

/// Three digits that count: `0`, `0.0123`, `4.56`, `78.9`, `1,235`.
pub(crate) fn short(number: f64) -> String {
    match number.abs() {
        x if !x.is_finite() || x == 0.0 => number.to_string(),
        x if x >= 1000.0 && number > 0.0 => grouped(number.round() as u64),
        x if x >= 100.0 => format!("{number:.0}"),
        x if x >= 10.0 => format!("{number:.1}"),
        x if x >= 1.0 => format!("{number:.2}"),
        x => format!(
            "{number:.*}",
            (2 - x.log10().floor() as i32).clamp(3, 9) as usize
        ),
    }
}

/// A number of a file as it is, but beyond ten millions and below a hundred-thousandth with an exponent: `0.25`, `-5e29`.
pub(crate) fn coordinate(x: f32) -> String {
    match x.abs() {
        0.0 => "0".to_owned(),
        size if (1e-5..1e7).contains(&size) => x.to_string(),
        _ => format!("{x:e}"),
    }
}

/// `12.3 MiB`, `4.56 KiB`, `789 bytes`.
pub(crate) fn size(bytes: usize) -> String {
    match bytes {
        0..0x400 => counted(bytes, "byte"),
        0x400..0x10_0000 => format!("{} KiB", short(bytes as f64 / 1024.0)),
        _ => format!("{} MiB", mebibytes(bytes)),
    }
}

/// `12.3`.
pub(crate) fn mebibytes(bytes: usize) -> String {
    short(bytes as f64 / f64::from(1 << 20))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_grouped_by_thousands() {
        for (number, text) in [
            (0, "0"),
            (27, "27"),
            (921_600, "921,600"),
            (995_328_000_000, "995,328,000,000"),
        ] {
            assert_eq!(grouped(number), text);
        }
    }

    #[test]
    fn short_numbers_keep_three_digits() {
        let cases = [
            (0.0, "0"),
            (0.012_34, "0.0123"),
            (4.556, "4.56"),
            (78.94, "78.9"),
            (123.4, "123"),
            (1234.6, "1,235"),
        ];
        for (number, text) in cases {
            assert_eq!(short(number), text);
        }
        assert_eq!(short(f64::INFINITY), "inf");
    }

    #[test]
    fn coordinates_and_sizes_have_few_digits() {
        let cases = [
            (0.0, "0"),
            (-0.25, "-0.25"),
            (-5e29, "-5e29"),
            (1e-30, "1e-30"),
        ];
        for (x, text) in cases {
            assert_eq!(coordinate(x), text);
        }
        assert_eq!(coordinate(1_234_567.0), "1234567");
        assert_eq!(
            [1, 789, 4670, 12_900_000].map(size),
            ["1 byte", "789 bytes", "4.56 KiB", "12.3 MiB"]
        );
    }

    #[test]
    fn a_table_is_aligned_left_then_right() {
        let mut table = Table::new(["name", "ms"]);
        table.row(["list", "0.12"]);
        table.row(["a-long-name", "7"]);
        let expected = "name           ms\n-----------------\nlist         0.12\na-long-name     7";
        assert_eq!(table.to_string(), expected);
    }

    #[test]
    fn each_kind_of_error_has_its_exit_code_and_remedy() {
        let load = LoadError::new("a.ply", "is cut short").with_remedy("copy it again");
        let cases: [(anyhow::Error, Exit, &str, Option<&str>); 4] = [
            (
                load.into(),
                Exit::Input,
                "a.ply: is cut short",
                Some("copy it again"),
            ),
            (
                Trouble::usage("no", "yes").into(),
                Exit::Usage,
                "no",
                Some("yes"),
            ),
            (
                anyhow::Error::from(RenderError::Decode {
                    cause: "bad".into(),
                    remedy: "redo it",
                })
                .context("a.png"),
                Exit::Input,
                "a.png: cannot read the picture: bad",
                Some("redo it"),
            ),
            (
                BuildError::MixedPrimitives.into(),
                Exit::Input,
                "a scene holds one kind",
                None,
            ),
        ];
        for (error, exit, cause, help) in cases {
            let found = Trouble::of(&error);
            assert_eq!((found.exit, found.help.as_deref()), (exit, help));
            assert!(found.cause.starts_with(cause), "{}", found.cause);
        }
    }

    #[test]
    fn a_reader_who_left_is_no_failure() {
        let error =
            anyhow::Error::from(io::Error::from(io::ErrorKind::BrokenPipe)).context("stdout");
        assert_eq!(Output::new("list", false).failed(&error), Exit::Ok);
    }
}
