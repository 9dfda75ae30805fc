//! `boxwood man`: manual pages from the same source as `--help`.

use clap::CommandFactory;

use crate::{
    Cli,
    output::{Exit, Output, Trouble},
};

/// Print a manual page.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  boxwood man > boxwood.1
  boxwood man render > boxwood-render.1")]
pub(crate) struct Args {
    /// The command whose page is wanted. [default: that of boxwood itself]
    command: Option<String>,
}

/// Prints the page in roff; with `--json` as the field `page`.
pub(crate) fn run(args: &Args, out: &Output) -> anyhow::Result<Exit> {
    let page = page(args.command.as_deref())?;
    if out.is_json() {
        out.json(
            &serde_json::json!({ "name": args.command, "page": String::from_utf8_lossy(&page) }),
        )?;
    } else {
        out.bytes(&page)?;
    }
    Ok(Exit::Ok)
}

fn page(name: Option<&str>) -> anyhow::Result<Vec<u8>> {
    let mut root = Cli::command();
    // Makes the options that stand everywhere known to each command, and names the pages: boxwood-render.
    root.build();
    let command = match name {
        None => root,
        Some(name) => {
            let known: Vec<&str> = root
                .get_subcommands()
                .map(clap::Command::get_name)
                .collect();
            let unknown = || {
                Trouble::usage(
                    format!("there is no command '{name}'"),
                    format!("known: {}", known.join(", ")),
                )
            };
            root.find_subcommand(name).ok_or_else(unknown)?.clone()
        }
    };
    let mut page = Vec::new();
    clap_mangen::Man::new(command).render(&mut page)?;
    Ok(page)
}
