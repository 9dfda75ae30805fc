//! Tells the crate by what it was compiled and from which commit, so that every report can say so.
#![allow(missing_docs, reason = "a build script has no API")]

use std::path::Path;
use std::process::Command;

fn main() {
    let rustc = std::env::var("RUSTC").unwrap_or_else(|_| "rustc".to_owned());
    let version = output(&rustc, &["--version"]).unwrap_or_else(|| "rustc, unknown".to_owned());
    println!("cargo::rustc-env=BOXWOOD_RUSTC={version}");
    println!("cargo::rerun-if-changed=build.rs");
    // Outside of a repository (a published crate) there is no commit, and that is fine.
    let commit = output("git", &["describe", "--always", "--dirty", "--abbrev=12"]);
    println!(
        "cargo::rustc-env=BOXWOOD_COMMIT={}",
        commit.unwrap_or_default()
    );
    // It grows with each commit and each checkout, also where `.git` is a file.
    if let Some(log) = output("git", &["rev-parse", "--git-path", "logs/HEAD"])
        && Path::new(&log).exists()
    {
        println!("cargo::rerun-if-changed={log}");
    }
}

/// What a program prints, if it is there and succeeds.
fn output(program: &str, args: &[&str]) -> Option<String> {
    let output = Command::new(program).args(args).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?.trim().to_owned();
    (output.status.success() && !text.is_empty()).then_some(text)
}
