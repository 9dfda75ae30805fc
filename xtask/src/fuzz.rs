//! Fuzzing on stable Rust: the steps of `fuzz/README.md`.

use crate::shell::{command, exists, root, step, target};
use anyhow::{Context, Result};

const TARGETS: &[&str] = &["obj", "ply", "stl", "gltf", "bwx"];
const TRIPLE: &str = "x86_64-unknown-linux-gnu";

/// Coverage counters for every crate but the build scripts, which `--target` spares.
const FLAGS: &str = "--cfg fuzzing -Ccodegen-units=1 -Cpasses=sancov-module \
    -Cllvm-args=-sanitizer-coverage-level=4 -Cllvm-args=-sanitizer-coverage-inline-8bit-counters \
    -Cllvm-args=-sanitizer-coverage-pc-table -Cllvm-args=-sanitizer-coverage-trace-compares";

/// Fuzzes each format for the given number of seconds, from fresh seeds. A crash fails, and lies in `fuzz/artifacts`.
pub(crate) fn run(args: &[String]) -> Result<()> {
    let seconds: u32 = args
        .first()
        .map_or(Ok(60), |s| s.parse())
        .context("SECONDS is a whole number")?;
    build(3)?;
    look(seconds)
}

/// Fuzzes each format for so long with what is built, two at a time: each keeps one core busy.
pub(crate) fn look(seconds: u32) -> Result<()> {
    if !is_possible() {
        println!("\n=== fuzz: skipped, it wants Linux on x86-64 and a C++ compiler");
        return Ok(());
    }
    // With all crates, so that nothing is compiled anew with fewer features.
    let examples = ["build", "--release", "--examples"];
    step("fuzz seeds, build", command("cargo", &examples))?;
    let seeds = target().join("release/examples/fuzz_seeds");
    step("fuzz seeds", {
        let mut seeds = command(&seeds.to_string_lossy(), &[]);
        seeds.arg("fuzz/corpus");
        seeds
    })?;
    TARGETS.chunks(2).try_for_each(|formats| {
        std::thread::scope(|scope| {
            let looks: Vec<_> = formats
                .iter()
                .map(|format| scope.spawn(|| fuzz(format, seconds)))
                .collect();
            looks.into_iter().try_for_each(|look| {
                look.join()
                    .unwrap_or_else(|panic| std::panic::resume_unwind(panic))
            })
        })
    })
}

/// Compiles the fuzzer, where that is possible, at this level of optimisation: for a look 1 will do.
pub(crate) fn build(optimisation: u8) -> Result<()> {
    if !is_possible() {
        return Ok(());
    }
    let mut build = command(
        "cargo",
        &["build", "--release", "--target", TRIPLE, "--bins"],
    );
    build
        .current_dir(root().join("fuzz"))
        .env("RUSTFLAGS", FLAGS)
        .env("CARGO_PROFILE_RELEASE_OPT_LEVEL", optimisation.to_string());
    step("fuzz build", build)
}

fn is_possible() -> bool {
    cfg!(all(target_arch = "x86_64", target_os = "linux")) && exists("c++", &["--version"])
}

/// Fuzzes one format.
fn fuzz(format: &str, seconds: u32) -> Result<()> {
    let artifacts = root().join("fuzz/artifacts").join(format);
    std::fs::create_dir_all(&artifacts).with_context(|| format!("{}", artifacts.display()))?;
    let mut fuzz = command(&format!("fuzz/target/{TRIPLE}/release/{format}"), &[]);
    fuzz.arg(format!("fuzz/corpus/{format}"))
        .arg("-dict=fuzz/dictionary.txt")
        .arg(format!("-max_total_time={seconds}"))
        .arg(format!("-artifact_prefix={}/", artifacts.display()))
        .args([
            "-timeout=2",
            "-rss_limit_mb=512",
            "-malloc_limit_mb=128",
            "-max_len=8192",
        ])
        .args(["-verbosity=0", "-print_final_stats=1"]);
    step(&format!("fuzz {format}"), fuzz)
}
