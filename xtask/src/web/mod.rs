//! The page: Boxwood as WebAssembly beside plain files, and its tests in a browser.

mod test;
mod toolchain;

use crate::shell::{command, root, step, target};
use anyhow::Result;
use std::{panic::resume_unwind, path::PathBuf, process::Command, thread};
use toolchain::Toolchain;

pub(crate) use test::run as test;

/// What is compiled for one kind of browser, in a folder of its own: there the standard library is compiled once.
struct Folder {
    name: &'static str,
    flags: &'static str,
    forms: &'static [Form],
}

/// A WebAssembly of the page: the feature of `boxwood-web` that it is, and the crates that are to be fast rather than small.
struct Form {
    name: &'static str,
    feature: &'static str,
    fast: &'static [&'static str],
}

/// What the figures ask is there twice: the page takes the first that the browser can run.
const FOLDERS: [Folder; 2] = [
    Folder {
        name: "simd",
        flags: "-Ctarget-feature=+simd128",
        forms: &[Form {
            name: "simd",
            feature: "lab",
            fast: &["boxwood", "boxwood-render"],
        }],
    },
    Folder {
        name: "plain",
        flags: "",
        forms: &[
            Form {
                name: "files",
                feature: "files",
                fast: &[],
            },
            // For old browsers, that read it once and run it slowly anyway: small.
            Form {
                name: "plain",
                feature: "lab",
                fast: &[],
            },
        ],
    },
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

/// Compiles all forms and packs them with the files of `web/`.
fn build(toolchain: &Toolchain) -> Result<()> {
    draw_stills()?;
    let mut pack = packer("run");
    pack.arg("--").args([
        root().join("web"),
        stills(),
        page(),
        page().with_file_name("boxwood-web.zip"),
    ]);
    // Each form ends in one long pass of one thread, so the folders are compiled side by side; the first is ready long before
    // the second, and leaves its core to the packer.
    let (simd, ready, plain) = thread::scope(|scope| {
        let [simd, plain] = FOLDERS.map(|folder| scope.spawn(move || compile(toolchain, &folder)));
        let simd = simd.join().unwrap_or_else(|panic| resume_unwind(panic));
        let ready = step("the packer", packer("build"));
        let plain = plain.join().unwrap_or_else(|panic| resume_unwind(panic));
        (simd, ready, plain)
    });
    ready?;
    for (name, wasm) in simd?.into_iter().chain(plain?) {
        pack.arg(wasm).arg(name);
    }
    step("the page", pack)
}

/// What writes the page's folder: `src/bin/web_pack.rs`, to be built or run.
fn packer(verb: &str) -> Command {
    let mut cargo = command("cargo", &[verb, "--quiet", "--package", "xtask"]);
    cargo.args([
        "--profile",
        "tool",
        "--features",
        "pack",
        "--bin",
        "web-pack",
    ]);
    cargo
}

/// Compiles the forms of a folder, one after the other; returns their names and files.
fn compile(toolchain: &Toolchain, folder: &Folder) -> Result<Vec<(&'static str, PathBuf)>> {
    let path = target().join("wasm").join(folder.name);
    let one = |form: &Form| {
        let mut cargo = toolchain.cargo();
        cargo
            .args(["build", "--profile", "web", "--package", "boxwood-web"])
            .args(["--no-default-features", "--features", form.feature])
            .args(["--target", toolchain::TARGET, "--target-dir"])
            .arg(&path)
            .args(toolchain.standard_library())
            .env("RUSTFLAGS", folder.flags);
        for name in form.fast {
            let level = format!("profile.web.package.{name}.opt-level=3");
            cargo.args(["--config", &level]);
        }
        step(&format!("boxwood-web, {}", form.name), cargo)?;
        // The next form of the folder has the same file.
        let wasm = path.join(form.name).with_extension("wasm");
        std::fs::copy(
            path.join(toolchain::TARGET).join("web/boxwood_web.wasm"),
            &wasm,
        )?;
        Ok((form.name, wasm))
    };
    folder.forms.iter().map(one).collect()
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
