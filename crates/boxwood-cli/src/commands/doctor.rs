//! `boxwood doctor`: the machine as this program sees it.

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
struct Machine {
    version: &'static str,
    system: String,
    cpu: Option<String>,
    simd: Vec<&'static str>,
    threads: usize,
    cores: usize,
    memory_mib: Option<u64>,
    huge_pages: Option<String>,
    terminal_pictures: Option<&'static str>,
    terminal_columns: u16,
    build: &'static str,
}

/// Prints it.
pub(crate) fn run(_: &Args, out: &Output) -> anyhow::Result<Exit> {
    let machine = Machine::seen();
    if out.is_json() {
        out.json(&machine)?;
    } else {
        out.text(machine.text())?;
    }
    Ok(Exit::Ok)
}

impl Machine {
    fn seen() -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION"),
            system: format!("{} on {}", std::env::consts::OS, std::env::consts::ARCH),
            cpu: value_of("/proc/cpuinfo", "model name"),
            simd: simd(),
            threads: rayon::current_num_threads(),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            memory_mib: value_of("/proc/meminfo", "MemTotal")
                .and_then(|kib| kibibytes(&kib))
                .map(|kib| kib / 1024),
            huge_pages: huge_pages(),
            terminal_pictures: Show::of_stdout().map(Show::name),
            terminal_columns: terminal::columns(),
            build: if cfg!(debug_assertions) {
                "debug: slow; build with --release"
            } else {
                "release"
            },
        }
    }

    fn text(&self) -> String {
        let unknown = || "not known".to_owned();
        let simd = if self.simd.is_empty() {
            "none".to_owned()
        } else {
            self.simd.join(", ")
        };
        let lines = [
            ("boxwood", format!("{} ({})", self.version, self.build)),
            ("system", self.system.clone()),
            ("processor", self.cpu.clone().unwrap_or_else(unknown)),
            (
                "SIMD",
                format!("{simd} (the kernels of this version are scalar)"),
            ),
            (
                "threads",
                format!("{} of {} cores", self.threads, self.cores),
            ),
            (
                "memory",
                self.memory_mib
                    .map_or_else(unknown, |mib| format!("{:.1} GiB", mib as f64 / 1024.0)),
            ),
            (
                "huge pages",
                self.huge_pages.clone().unwrap_or_else(unknown),
            ),
            ("terminal", self.terminal()),
        ];
        lines
            .map(|(name, value)| format!("{name:<11} {value}"))
            .join("\n")
    }

    fn terminal(&self) -> String {
        match self.terminal_pictures {
            Some(way) => format!("{} columns, pictures by {way}", self.terminal_columns),
            None => "stdout shows no pictures".to_owned(),
        }
    }
}

/// The SIMD instruction sets of the processor, least first.
pub(crate) fn simd() -> Vec<&'static str> {
    let mut found = Vec::new();
    #[cfg(target_arch = "x86_64")]
    {
        let sets = [
            ("SSE2", true),
            ("SSE4.2", std::is_x86_feature_detected!("sse4.2")),
            (
                "AVX2",
                std::is_x86_feature_detected!("avx2") && std::is_x86_feature_detected!("fma"),
            ),
            (
                "AVX-512",
                std::is_x86_feature_detected!("avx512f")
                    && std::is_x86_feature_detected!("avx512vl"),
            ),
        ];
        found.extend(
            sets.into_iter()
                .filter(|(_, is_there)| *is_there)
                .map(|(name, _)| name),
        );
    }
    #[cfg(target_arch = "aarch64")]
    found.push("NEON");
    found
}

/// The first value of `key` in a Linux file of lines `key : value`.
fn value_of(path: &str, key: &str) -> Option<String> {
    let text = std::fs::read_to_string(path).ok()?;
    let pairs = text.lines().filter_map(|line| line.split_once(':'));
    pairs
        .filter(|(name, _)| name.trim() == key)
        .map(|(_, value)| value.trim().to_owned())
        .next()
}

/// `16384 kB`.
fn kibibytes(text: &str) -> Option<u64> {
    text.strip_suffix("kB")?.trim().parse().ok()
}

/// `madvise`: the choice in brackets of Linux's transparent huge pages.
fn huge_pages() -> Option<String> {
    let text = std::fs::read_to_string("/sys/kernel/mm/transparent_hugepage/enabled").ok()?;
    let (_, rest) = text.split_once('[')?;
    Some(rest.split_once(']')?.0.to_owned())
}
