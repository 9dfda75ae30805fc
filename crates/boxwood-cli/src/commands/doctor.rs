//! `boxwood doctor`: the machine as this program sees it.

use boxwood::InstructionSet;
use boxwood_measure::{Machine, short_size};
use serde::Serialize;

use crate::{
    output::{Exit, Output},
    terminal::{self, Show},
};

/// Show what this machine offers: processor, threads, memory pages, terminal.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  boxwood doctor\n  boxwood doctor --json")]
pub(crate) struct Args {}

/// The machine, in the words of the JSON object.
#[derive(Debug, Serialize)]
struct Findings {
    #[serde(flatten)]
    machine: Machine,
    /// Instruction sets that kernels can be had for here, the one in use first.
    kernels: Vec<&'static str>,
    /// Threads that share the work, by option or by environment.
    workers: usize,
    terminal_pictures: Option<&'static str>,
    terminal_columns: u16,
}

/// Prints it.
pub(crate) fn run(_: &Args, out: &Output) -> anyhow::Result<Exit> {
    let findings = Findings::seen();
    if out.is_json() {
        out.json(&findings)?;
    } else {
        out.text(findings.text())?;
    }
    Ok(Exit::Ok)
}

impl Findings {
    fn seen() -> Self {
        let sets = InstructionSet::available().into_iter();
        Self {
            machine: Machine::seen(),
            kernels: sets.map(InstructionSet::name).collect(),
            workers: rayon::current_num_threads(),
            terminal_pictures: Show::of_stdout().map(Show::name),
            terminal_columns: terminal::columns(),
        }
    }

    fn text(&self) -> String {
        let machine = &self.machine;
        let or_unknown = |text: Option<String>| text.unwrap_or_else(|| "not known".to_owned());
        let caches: Vec<_> = machine.caches.iter().flatten().collect();
        let caches: Vec<_> = caches.into_iter().map(|&bytes| short_size(bytes)).collect();
        let lines = [
            ("boxwood", self.program()),
            ("system", machine.system.clone()),
            ("processor", or_unknown(machine.cpu.clone())),
            ("SIMD", self.simd()),
            (
                "threads",
                format!(
                    "{} at work, {} on {} cores",
                    self.workers, machine.threads, machine.cores
                ),
            ),
            (
                "caches",
                or_unknown((!caches.is_empty()).then(|| caches.join(", "))),
            ),
            ("memory", or_unknown(machine.memory.map(short_size))),
            ("huge pages", or_unknown(machine.huge_pages.clone())),
            ("terminal", self.terminal()),
        ];
        lines
            .map(|(name, value)| format!("{name:<11} {value}"))
            .join("\n")
    }

    fn program(&self) -> String {
        let machine = &self.machine;
        let build = if machine.optimised {
            "release"
        } else {
            "debug: slow; build with --release"
        };
        let commit = machine.commit.as_ref();
        let commit = commit.map_or(String::new(), |commit| format!(", commit {commit}"));
        format!("{} ({build}, {}{commit})", machine.version, machine.rustc)
    }

    fn simd(&self) -> String {
        let kernels = self.kernels.first().unwrap_or(&"scalar");
        match &self.machine.simd[..] {
            [] => format!("none; the kernels are {kernels}"),
            simd => format!("{}; the kernels are {kernels}", simd.join(", ")),
        }
    }

    fn terminal(&self) -> String {
        match self.terminal_pictures {
            Some(way) => format!("{} columns, pictures by {way}", self.terminal_columns),
            None => "stdout shows no pictures".to_owned(),
        }
    }
}
