//! The Python package: its wheel, built into a fresh environment, and its tests there.

use crate::shell::{command, root, step, target};
use anyhow::{Context, Result, ensure};
use std::fs;
use std::path::{Path, PathBuf};

/// What the tests need besides the wheel: the examples draw with matplotlib.
const TOOLS: [&str; 6] = [
    "maturin>=1.9,<2",
    "pytest>=8",
    "trimesh>=4",
    "matplotlib>=3.8",
    "mypy>=1.18",
    "dask[array,distributed]>=2025.1",
];
/// Largest wheel, in bytes.
const MAX_WHEEL: u64 = 3_000_000;

/// `cargo xtask python-test`: builds the wheel, installs it where nothing else is, checks its types and runs its tests.
pub(crate) fn test(args: &[String]) -> Result<()> {
    let manifest = "python/Cargo.toml";
    let format = command("cargo", &["fmt", "--check", "--manifest-path", manifest]);
    step("the package's format", format)?;
    let home = target().join("python");
    let python = environment(&home.join("venv"))?;
    let wheel = wheel(&python, &home.join("wheels"))?;
    let mut install = command(
        &python,
        &["-m", "pip", "install", "--quiet", "--force-reinstall"],
    );
    install.arg(&wheel);
    step("the wheel installed", install)?;
    let types = command(&python, &["-m", "mypy", "--strict", "python/boxwood"]);
    step("the package's types", types)?;
    let mut tests = command(&python, &["-m", "pytest", "--quiet", "python/tests"]);
    // Not from the folder, where the package has no native part.
    tests.args(args).env("PYTHONSAFEPATH", "1");
    step("the package's tests", tests)
}

/// A fresh environment with the tools; returns its Python.
fn environment(folder: &Path) -> Result<String> {
    if folder.exists() {
        fs::remove_dir_all(folder)?;
    }
    let mut venv = command("python3", &["-m", "venv"]);
    venv.arg(folder);
    step("a fresh Python environment", venv)?;
    let python = folder.join("bin/python").display().to_string();
    let mut install = command(&python, &["-m", "pip", "install", "--quiet"]);
    install.args(TOOLS);
    step("its tools", install)?;
    Ok(python)
}

/// Builds the wheel; returns its path.
fn wheel(python: &str, folder: &Path) -> Result<PathBuf> {
    if folder.exists() {
        fs::remove_dir_all(folder)?;
    }
    let mut build = command(python, &["-m", "maturin", "build", "--release", "--out"]);
    build
        .arg(folder)
        .arg("--manifest-path")
        .arg(root().join("python/Cargo.toml"))
        .arg("--target-dir")
        .arg(target().join("python/cargo"));
    step("the wheel", build)?;
    let entry = fs::read_dir(folder)?
        .next()
        .context("maturin left no wheel")??;
    let bytes = entry.metadata()?.len();
    println!("{} has {bytes} bytes", entry.path().display());
    ensure!(
        bytes <= MAX_WHEEL,
        "the wheel is larger than {MAX_WHEEL} bytes"
    );
    Ok(entry.path())
}
