//! The page: Boxwood as WebAssembly beside plain files, and its tests in a browser.

mod test;
mod toolchain;

use crate::shell::{command, root, step, target};
use anyhow::Result;
use std::{panic::resume_unwind, path::PathBuf, thread};
use toolchain::Toolchain;

pub(crate) use test::run as test;

/// The two forms of the same library, and the compiler's flags for each. The page takes the first that the browser can run.
const FORMS: [(&str, &str, &str); 2] = [
    ("simd", "-Ctarget-feature=+simd128", "3"),
    // For old browsers, that read it once and run it slowly anyway: small.
    ("plain", "", "s"),
];

/// `cargo xtask web`: builds the page into `target/web`, and `target/boxwood-web.zip`.
pub(crate) fn run(_: &[String]) -> Result<()> {
    build(&Toolchain::find()?)?;
    println!(
        "\n{} is the page: `boxwood view --web` shows it, as any static server does",
        page().display()
    );
    Ok(())
}

/// Compiles both forms and packs them with the files of `web/`.
fn build(toolchain: &Toolchain) -> Result<()> {
    draw_stills()?;
    let mut pack = command("cargo", &["run", "--quiet", "--package", "xtask"]);
    pack.args(["--features", "pack", "--bin", "web-pack", "--"]);
    pack.args([
        root().join("web"),
        stills(),
        page(),
        page().with_file_name("boxwood-web.zip"),
    ]);
    // Each is one long pass of one thread.
    let compile = |form| move || compile(toolchain, form);
    let packed = thread::scope(|scope| {
        let forms = FORMS.map(|form| scope.spawn(compile(form)));
        forms.map(|form| form.join().unwrap_or_else(|panic| resume_unwind(panic)))
    });
    for (wasm, (name, ..)) in packed.into_iter().zip(FORMS) {
        pack.arg(wasm?).arg(name);
    }
    step("the page", pack)
}

/// Compiles one form; returns the file that it is.
fn compile(toolchain: &Toolchain, (name, flags, opt_level): (&str, &str, &str)) -> Result<PathBuf> {
    let folder = target().join("wasm").join(name);
    let mut cargo = toolchain.cargo();
    cargo
        .args(["build", "--profile", "web", "--package", "boxwood-web"])
        .args(["--target", toolchain::TARGET, "--target-dir"])
        .arg(&folder)
        .args(toolchain.standard_library())
        .env("RUSTFLAGS", flags)
        .env("CARGO_PROFILE_WEB_OPT_LEVEL", opt_level);
    step(&format!("boxwood-web, {name}"), cargo)?;
    Ok(folder.join(toolchain::TARGET).join("web/boxwood_web.wasm"))
}

/// Pictures for readers whose browser cannot run the figures.
const STILLS: [(&str, &[&str]); 3] = [
    ("bush", &["builtin:bush"]),
    (
        "stadium-grid",
        &[
            "builtin:stadium",
            "--shading",
            "heat-prims",
            "--structure",
            "grid",
        ],
    ),
    (
        "stadium-bvh2",
        &[
            "builtin:stadium",
            "--shading",
            "heat-prims",
            "--structure",
            "bvh2",
        ],
    ),
];

/// Draws them with the command line, as the captions say.
fn draw_stills() -> Result<()> {
    // All crates, as the tests are built: with fewer, cargo would compile them anew with fewer features.
    let build = ["build", "--release", "--bins", "--examples"];
    step("the command line", command("cargo", &build))?;
    let boxwood = target().join("release/boxwood");
    std::fs::create_dir_all(stills())?;
    for (name, args) in STILLS {
        let mut render = command(&boxwood.to_string_lossy(), &["render"]);
        render
            .args(args)
            .args(["--size", "480x270", "-o"])
            .arg(stills().join(name).with_extension("png"));
        step(&format!("picture of {name}"), render)?;
    }
    Ok(())
}

fn stills() -> PathBuf {
    target().join("web-stills")
}

/// Where the page is built.
fn page() -> PathBuf {
    target().join("web")
}
