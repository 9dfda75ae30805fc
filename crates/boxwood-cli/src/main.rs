//! The `boxwood` command: from what the user typed to one call into the libraries.
//!
//! [`commands`] holds one file per command, [`args`] what several of them ask for, [`output`] what all of them say and how
//! they end.
#![forbid(unsafe_code)]

mod args;
mod commands;
mod contest;
mod frame_rate;
mod measure;
mod memory;
mod output;
#[cfg(feature = "view")]
mod page;
mod progress;
mod save;
mod terminal;
mod warnings;

use std::process::ExitCode;

use clap::Parser;

use crate::{
    commands::Command,
    output::{Exit, Output},
};

/// What does this ray hit? Exact ray queries over bounding volume hierarchies and grids.
///
/// Without a command: a demonstration, about ten seconds long.
#[derive(Debug, Parser)]
#[command(name = "boxwood", version, after_help = AFTER_HELP, disable_help_subcommand = true, args_override_self = true)]
pub(crate) struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    /// Print one JSON object on stdout instead of text.
    #[arg(long, global = true, help_heading = "Everywhere")]
    json: bool,
    /// How many threads to use. [default: one per core]
    #[arg(long, global = true, value_name = "N", allow_negative_numbers = true, help_heading = "Everywhere", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
}

const AFTER_HELP: &str = "\
Wherever a FILE is taken, `builtin:NAME` is one of the built-in scenes (`boxwood list`) and `-` is standard input.

Exit codes: 0 all well, 1 a difference was found, 2 wrong usage or output that cannot be written, 3 an input was refused,
4 interrupted with a part saved, or another process is at work on the same: try again.

Examples:
  boxwood                                       the demonstration
  boxwood render builtin:cornell -o cornell.png
  boxwood race builtin:stadium
  boxwood inspect bunny.obj --json";

fn main() -> ExitCode {
    let cli = Cli::parse();
    let command = cli.command.unwrap_or_default();
    let out = Output::new(command.name(), cli.json);
    let result = match cli.threads {
        Some(threads) => args::use_threads(threads).and_then(|()| command.run(&out)),
        None => command.run(&out),
    };
    let exit = result.unwrap_or_else(|error| out.failed(&error));
    ExitCode::from(exit as u8)
}

impl Exit {
    /// 1 if there is a difference.
    pub(crate) fn from_difference(found: bool) -> Self {
        if found { Self::Difference } else { Self::Ok }
    }
}
