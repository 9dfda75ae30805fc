//! The project's own chores, the same at home and in CI: `cargo xtask` lists them.
#![forbid(unsafe_code)]

mod asm;
mod c_install;
mod c_test;
mod ci;
mod farm;
mod figures;
mod fuzz;
mod python;
mod shell;
mod view_test;
mod web;

use anyhow::{Result, bail};

/// A chore: its name, what it does, and the doing.
type Chore = (&'static str, &'static str, fn(&[String]) -> Result<()>);

/// Every chore. Add a line here.
const CHORES: &[Chore] = &[
    (
        "ci",
        "everything that must hold before a change lands",
        ci::run,
    ),
    (
        "fuzz",
        "each file format's fuzz target, for SECONDS (default 60) each",
        fuzz::run,
    ),
    (
        "asm",
        "the hot loops of the kernels: they call nothing and spill no more than is known",
        asm::run,
    ),
    (
        "view-test",
        "the viewer's window on a virtual screen, by real keys and the pointer",
        view_test::run,
    ),
    (
        "figures",
        "the pictures of the README, drawn by the project itself",
        figures::run,
    ),
    (
        "web",
        "the page, with Boxwood as WebAssembly; `boxwood view --web` shows it",
        web::run,
    ),
    (
        "web-test",
        "the page's tests in headless Chromium",
        web::test,
    ),
    (
        "python-test",
        "the wheel of the Python package in a fresh environment, and its tests",
        python::test,
    ),
    (
        "c-header",
        "the C header, made of its sources; --check compares it with them",
        c_install::header,
    ),
    (
        "c-install",
        "the C libraries and what belongs to them, in --prefix FOLDER",
        c_install::run,
    ),
    (
        "c-test",
        "C and C++ programs against the installed libraries, and misuse of these",
        c_test::run,
    ),
    (
        "farm-test",
        "the render farm: its Open Job Description template run by openjd-cli, and a hundred kills",
        farm::test,
    ),
];

fn main() -> Result<()> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let Some((name, rest)) = args.split_first() else {
        for (name, about, _) in CHORES {
            println!("cargo xtask {name:<11} {about}");
        }
        return Ok(());
    };
    match CHORES.iter().find(|chore| chore.0 == name) {
        Some((_, _, chore)) => chore(rest),
        None => bail!("no chore is called '{name}'; `cargo xtask` lists them"),
    }
}
