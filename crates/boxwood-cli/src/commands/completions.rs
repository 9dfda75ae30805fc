//! `boxwood completions`: the shell's side of the command line.

use clap::CommandFactory;
use clap_complete::Shell;

use crate::{
    Cli,
    output::{Exit, Output},
};

/// Print the completion script for a shell.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  boxwood completions bash > ~/.local/share/bash-completion/completions/boxwood
  boxwood completions zsh > ~/.zfunc/_boxwood
  boxwood completions fish > ~/.config/fish/completions/boxwood.fish")]
pub(crate) struct Args {
    /// Which shell.
    shell: Shell,
}

/// Prints the script; with `--json` as the field `script`.
pub(crate) fn run(args: &Args, out: &Output) -> anyhow::Result<Exit> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "boxwood", &mut script);
    if out.is_json() {
        let script = String::from_utf8_lossy(&script);
        out.json(&serde_json::json!({ "shell": args.shell.to_string(), "script": script }))?;
    } else {
        out.bytes(&script)?;
    }
    Ok(Exit::Ok)
}
