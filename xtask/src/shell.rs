//! Running other programs from the root of the repository.

use anyhow::{Context, Result, ensure};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

/// The root of the repository.
pub(crate) fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .unwrap_or(Path::new("."))
        .to_owned()
}

/// Where cargo builds.
pub(crate) fn target() -> PathBuf {
    let named = std::env::var_os("CARGO_TARGET_DIR").map(PathBuf::from);
    root().join(named.unwrap_or_else(|| "target".into()))
}

/// A program to be run in the root.
pub(crate) fn command(program: &str, args: &[&str]) -> Command {
    let mut command = Command::new(program);
    command.args(args).current_dir(root());
    command
}

/// Runs a step, says what it is and how long it took, and fails if it does.
pub(crate) fn step(name: &str, mut command: Command) -> Result<()> {
    println!("\n=== {name}: {command:?}");
    let start = Instant::now();
    let status = command
        .status()
        .with_context(|| format!("{name}: {command:?} could not be started"))?;
    println!("=== {name}: {:.0} s", start.elapsed().as_secs_f64());
    ensure!(status.success(), "{name} failed with {status}: {command:?}");
    Ok(())
}

/// True if the program answers to `--version`.
pub(crate) fn exists(program: &str, args: &[&str]) -> bool {
    command(program, args)
        .output()
        .is_ok_and(|output| output.status.success())
}
