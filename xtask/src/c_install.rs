//! The C interface: its header, and its libraries under the names by which C programs link them.

use crate::shell::{command, exists, root, step, target};
use anyhow::{Context, Result, bail, ensure};
use std::fs;
use std::path::{Path, PathBuf};

/// Where the C interface stands in the repository.
pub(crate) fn home() -> PathBuf {
    root().join("crates/boxwood-c")
}

/// `cargo xtask c-header [--check]`: makes the header of the sources, or compares with it.
pub(crate) fn header(args: &[String]) -> Result<()> {
    let mut make = command("cargo", &["run", "--quiet", "--package", "xtask"]);
    make.args([
        "--profile",
        "tool",
        "--features",
        "header",
        "--bin",
        "c-header",
        "--",
    ])
    .arg(home())
    .args(args);
    step("the C header", make)
}

/// `cargo xtask c-install --prefix FOLDER`: the libraries, the header and what pkg-config asks.
pub(crate) fn run(args: &[String]) -> Result<()> {
    let prefix = match args {
        [option, prefix] if option == "--prefix" => std::path::absolute(prefix)?,
        _ => bail!("cargo xtask c-install --prefix FOLDER, as in --prefix /usr/local"),
    };
    install(&prefix)?;
    println!(
        "\n{} has the library: PKG_CONFIG_PATH={0}/lib/pkgconfig pkg-config --cflags --libs boxwood",
        prefix.display()
    );
    Ok(())
}

/// Builds the libraries and puts them with all that belongs to them under `prefix`.
pub(crate) fn install(prefix: &Path) -> Result<()> {
    ensure!(
        cfg!(target_os = "linux"),
        "only Linux's names of libraries are known here; elsewhere `cargo build --release -p boxwood-c` leaves them in {}",
        target().join("release").display()
    );
    // All libraries, as the tests have them already: a part would be compiled anew, with fewer features.
    let build = command("cargo", &["build", "--release", "--lib"]);
    step("the C libraries", build)?;
    let version = version()?;
    let (lib, include) = (prefix.join("lib"), prefix.join("include"));
    let built = target().join("release");
    place_library(&built.join("libboxwood_c.a"), &lib.join("libboxwood.a"))?;
    place(
        &home().join("include/boxwood.h"),
        &include.join("boxwood.h"),
    )?;
    // The file has the whole version, programs ask for the part that says what fits (build.rs), the linker for none.
    let file = format!("libboxwood.so.{version}");
    place_library(&built.join("libboxwood_c.so"), &lib.join(&file))?;
    let (fits, _) = file.rsplit_once('.').context("a version has dots")?;
    link(&file, &lib.join(fits))?;
    link(fits, &lib.join("libboxwood.so"))?;
    let about = fs::read_to_string(home().join("boxwood.pc.in"))?
        .replace("@PREFIX@", &prefix.display().to_string())
        .replace("@URL@", env!("CARGO_PKG_REPOSITORY"))
        .replace("@VERSION@", &version);
    write(&lib.join("pkgconfig/boxwood.pc"), about.as_bytes())
}

/// That of `boxwood-c`.
fn version() -> Result<String> {
    let id = command("cargo", &["pkgid", "--package", "boxwood-c"]).output()?;
    let id = String::from_utf8(id.stdout)?;
    let version = id.trim().rsplit(['#', '@']).next();
    version
        .filter(|version| !version.is_empty())
        .map(str::to_owned)
        .context("cargo knows no version of boxwood-c")
}

fn place(from: &Path, to: &Path) -> Result<()> {
    write(
        to,
        &fs::read(from).with_context(|| from.display().to_string())?,
    )
}

/// Without the tables that say which line an instruction is of: they are most of the bytes. As it is where `strip` is not.
fn place_library(from: &Path, to: &Path) -> Result<()> {
    if !exists("strip", &["--version"]) {
        return place(from, to);
    }
    let stripped = from.with_extension("stripped");
    let mut strip = command("strip", &["--strip-debug", "-o"]);
    strip.arg(&stripped).arg(from);
    step("without debug information", strip)?;
    place(&stripped, to)
}

/// Beside it first, then renamed: programs that run on the old library keep it.
fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    let beside = beside(path)?;
    fs::write(&beside, bytes)
        .and_then(|()| fs::rename(&beside, path))
        .with_context(|| format!("{} cannot be written", path.display()))?;
    println!("{} has {} bytes", path.display(), bytes.len());
    Ok(())
}

#[cfg(unix)]
fn link(to: &str, path: &Path) -> Result<()> {
    let beside = beside(path)?;
    std::os::unix::fs::symlink(to, &beside)?;
    fs::rename(&beside, path)?;
    println!("{} is {to}", path.display());
    Ok(())
}

#[cfg(not(unix))]
fn link(_: &str, _: &Path) -> Result<()> {
    bail!("no symbolic links here")
}

/// A free name in the same folder, which is made.
fn beside(path: &Path) -> Result<PathBuf> {
    let folder = path.parent().context("a file stands in a folder")?;
    fs::create_dir_all(folder).with_context(|| format!("{} cannot be made", folder.display()))?;
    let mut name = path.file_name().context("a file has a name")?.to_owned();
    name.push(".new");
    let beside = path.with_file_name(name);
    match fs::remove_file(&beside) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(error.into()),
        _ => Ok(beside),
    }
}
