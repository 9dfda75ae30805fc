//! The table of commands. A new one is a file with `Args` and `run`, a `mod` line, and a line in the table.

mod bench;
mod bounds;
mod build;
mod check;
mod completions;
mod cost;
mod demo;
mod diff;
mod doctor;
mod explain;
mod inspect;
mod list;
mod man;
mod merge;
mod race;
mod render;
mod simplify;
#[cfg(feature = "view")]
mod view;

use crate::output::{Exit, Output};

macro_rules! commands {
    ($($(#[$when:meta])? $Command:ident => $module:ident,)*) => {
        /// Every command with its arguments; their help is the doc comment of `Args`.
        #[derive(Debug, clap::Subcommand)]
        pub(crate) enum Command {
            $($(#[$when])? #[allow(missing_docs, reason = "said at Args")] $Command($module::Args),)*
        }

        impl Command {
            /// As typed.
            pub(crate) fn name(&self) -> &'static str {
                match self { $($(#[$when])? Self::$Command(_) => stringify!($module),)* }
            }

            /// Does the work.
            pub(crate) fn run(&self, out: &Output) -> anyhow::Result<Exit> {
                match self { $($(#[$when])? Self::$Command(args) => $module::run(args, out),)* }
            }
        }
    };
}

// In the order in which help lists them.
commands! {
    Demo => demo,
    Render => render,
    Merge => merge,
    #[cfg(feature = "view")]
    View => view,
    Inspect => inspect,
    Cost => cost,
    Bounds => bounds,
    Race => race,
    Bench => bench,
    Check => check,
    Build => build,
    Explain => explain,
    Simplify => simplify,
    Diff => diff,
    List => list,
    Doctor => doctor,
    Completions => completions,
    Man => man,
}

impl Default for Command {
    fn default() -> Self {
        Self::Demo(demo::Args::default())
    }
}
