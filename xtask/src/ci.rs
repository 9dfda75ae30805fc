//! Everything that must hold before a change lands and needs Rust alone; `.ci/run` calls it, and what needs C, Python, a screen or a browser.

use crate::shell::{command, exists, step};
use crate::{asm, figures, fuzz};
use anyhow::Result;

/// Runs all checks, the quick ones first.
pub(crate) fn run(_: &[String]) -> Result<()> {
    cargo("format", &["fmt", "--all", "--check"])?;
    cargo(
        "lints",
        &[
            "clippy",
            "--workspace",
            "--all-targets",
            "--",
            "-D",
            "warnings",
        ],
    )?;
    // The README's own command, as a user types it.
    cargo("tests", &["test", "--release"])?;
    cargo(
        "core without threads",
        &[
            "test",
            "--release",
            "-p",
            "boxwood",
            "--no-default-features",
            "--features",
            "shapes,volumes",
            "--lib",
        ],
    )?;
    // In release, sums that overflow go on; users build with checks. The longest tests are left out.
    cargo(
        "core with overflow checks",
        &[
            "test",
            "-p",
            "boxwood",
            "--test",
            "build_errors",
            "--test",
            "explain_build",
            "--test",
            "robustness",
            "--test",
            "underflow",
        ],
    )?;
    let mut doc = command("cargo", &["doc", "--workspace", "--no-deps"]);
    doc.env("RUSTDOCFLAGS", "-D warnings");
    step("documentation", doc)?;
    let plugin = "bench/plugin/Cargo.toml";
    cargo(
        "measurement plugin",
        &[
            "clippy",
            "--release",
            "--manifest-path",
            plugin,
            "--",
            "-D",
            "warnings",
        ],
    )?;
    cargo("chores", &["test", "-p", "xtask"])?;
    figures::check()?;
    dependencies()?;
    compiled_on_one_core()?;
    // A look at each format; longer ones are made by hand: `cargo xtask fuzz 600`.
    fuzz::look(10)
}

/// The kernels' assembly and the fuzzer: both are one piece of code to the compiler, which one core makes, so they go side by side.
fn compiled_on_one_core() -> Result<()> {
    std::thread::scope(|scope| {
        let listing = scope.spawn(|| asm::run(&[]));
        let built = fuzz::build(1);
        listing
            .join()
            .unwrap_or_else(|panic| std::panic::resume_unwind(panic))
            .and(built)
    })
}

fn cargo(name: &str, args: &[&str]) -> Result<()> {
    step(name, command("cargo", args))
}

/// Licences, bans and sources. The tool takes minutes to compile, so it is used where it is there.
fn dependencies() -> Result<()> {
    if exists("cargo", &["deny", "--version"]) {
        return cargo(
            "dependencies",
            &["deny", "check", "bans", "licenses", "sources"],
        );
    }
    println!(
        "\n=== dependencies: skipped, cargo-deny is not installed (cargo install cargo-deny --locked)"
    );
    Ok(())
}
