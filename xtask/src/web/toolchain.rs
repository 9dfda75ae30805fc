//! Which compiler makes WebAssembly here.
//!
//! The code generator is part of every Rust compiler; what may be missing is the standard library for the target. Installed
//! by rustup, it is used as it is. Debian has none, but a current compiler with the library's source (it builds browsers with
//! them): then the library is compiled first, which takes a minute.

use crate::shell::command;
use anyhow::{Result, bail};
use std::path::{Path, PathBuf};
use std::process::Command;

/// What a browser runs.
pub(super) const TARGET: &str = "wasm32-unknown-unknown";

/// A way to compile for [`TARGET`].
#[derive(Debug)]
pub(super) enum Toolchain {
    /// The usual compiler, with the target's standard library.
    Installed,
    /// Debian's compiler with the library's source, and a linker for it.
    Debian { linker: PathBuf },
}

const CARGO: &str = "/usr/bin/cargo";
const RUSTC: &str = "/usr/bin/rustc";

impl Toolchain {
    /// The one that is here.
    pub(super) fn find() -> Result<Self> {
        if is_installed() {
            return Ok(Self::Installed);
        }
        if has_source()
            && let Some(linker) = linker()
        {
            return Ok(Self::Debian { linker });
        }
        bail!(
            "the page needs a compiler for {TARGET}: `rustup target add {TARGET}`, or on Debian \
             `apt-get install --no-install-recommends rustc-web cargo-web rust-web-src`"
        )
    }

    /// Cargo, with the compiler that belongs to it.
    pub(super) fn cargo(&self) -> Command {
        match self {
            Self::Installed => command("cargo", &[]),
            Self::Debian { linker } => {
                let mut cargo = command(CARGO, &[]);
                cargo
                    .env("RUSTC", RUSTC)
                    // To build the standard library is not stable.
                    .env("RUSTC_BOOTSTRAP", "1")
                    .env("CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER", linker);
                cargo
            }
        }
    }

    /// The arguments that make cargo build the standard library, where it is not there.
    pub(super) fn standard_library(&self) -> &'static [&'static str] {
        match self {
            Self::Installed => &[],
            Self::Debian { .. } => &["-Zbuild-std=std,panic_abort"],
        }
    }
}

fn is_installed() -> bool {
    asked("rustc", &["--print", "target-libdir", "--target", TARGET])
        .is_some_and(|folder| folder.is_dir())
}

/// Of the standard library, beside Debian's compiler.
fn has_source() -> bool {
    let library = "lib/rustlib/src/rust/library/std/Cargo.toml";
    Path::new(CARGO).exists()
        && asked(RUSTC, &["--print", "sysroot"])
            .is_some_and(|sysroot| sysroot.join(library).exists())
}

/// That of the usual toolchain, else one of Debian's: they have the version in their names.
fn linker() -> Option<PathBuf> {
    let host = asked("rustc", &["--print", "target-libdir"])?;
    let bundled = host.with_file_name("bin").join("rust-lld");
    let named = |folder: &str| {
        let entries = std::fs::read_dir(folder).ok()?.flatten();
        let mut found: Vec<_> = entries.map(|entry| entry.path()).collect();
        found.retain(|path| {
            let name = path.file_name().and_then(|name| name.to_str());
            name.is_some_and(|name| name.starts_with("wasm-ld"))
        });
        found.sort();
        found.pop()
    };
    bundled
        .exists()
        .then_some(bundled)
        .or_else(|| named("/usr/bin"))
}

/// The path that a compiler answers with.
fn asked(rustc: &str, args: &[&str]) -> Option<PathBuf> {
    let answer = command(rustc, args).output().ok()?;
    let path = String::from_utf8(answer.stdout).ok()?;
    answer.status.success().then(|| PathBuf::from(path.trim()))
}
