//! The C interface as its users meet it: installed, compiled against by a C and a C++ compiler, shared and static, and misused.

use crate::c_install::{header, home, install};
use crate::shell::{command, exists, root, target};
use anyhow::{Context, Result, ensure};
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A program, and what its output begins with.
struct Program {
    source: &'static str,
    output: &'static str,
}

/// What users are shown.
const EXAMPLES: [Program; 3] = [
    Program {
        source: "examples/c/first.c",
        output: "triangle 0 of geometry 0 at t = 2.5, u = 0.25, v = 0.5, normal (0, 0, 16)\n",
    },
    Program {
        source: "examples/c/many.c",
        output: "693642 of 1000000 rays hit, the same answers together\n",
    },
    Program {
        source: "examples/c/first.cpp",
        output: "triangle 0 at t = 2.5\nnothing\nerror: mesh 1, triangle 0: vertex 4 of 4\n",
    },
];

/// Every mistake that can be noticed.
const MISUSE: Program = Program {
    source: "crates/boxwood-c/tests/c/misuse.c",
    output: "0 failed of ",
};

const WARNINGS: [&str; 6] = ["-O2", "-g", "-Wall", "-Wextra", "-Werror", "-pedantic"];
const SANITIZERS: [&str; 2] = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all"];

/// How a program is linked.
#[derive(Clone, Copy)]
enum Link {
    Shared,
    Static,
    /// Shared, as a user does it.
    PkgConfig,
}

impl Link {
    fn name(self) -> &'static str {
        match self {
            Self::Shared => "shared",
            Self::Static => "static",
            Self::PkgConfig => "by pkg-config",
        }
    }
}

/// `cargo xtask c-test`: the header is current, the examples compile without a warning, print what they should, and misuse does
/// no harm.
pub(crate) fn run(_: &[String]) -> Result<()> {
    header(&["--check".to_owned()])?;
    let prefix = target().join("c-test/prefix");
    if prefix.exists() {
        fs::remove_dir_all(&prefix)?;
    }
    install(&prefix)?;
    let mut links = vec![Link::Shared, Link::Static];
    match exists("pkg-config", &["--version"]) {
        true => links.push(Link::PkgConfig),
        false => println!("pkg-config is not here: what it would say is not tried"),
    }
    for &link in &links {
        for program in EXAMPLES.iter().chain([&MISUSE]) {
            try_out(program, &prefix, link, &[])?;
        }
    }
    match sanitizers_are_there()? {
        true => [Link::Shared, Link::Static]
            .into_iter()
            .try_for_each(|link| try_out(&MISUSE, &prefix, link, &SANITIZERS)),
        false => {
            println!("the C compiler has no AddressSanitizer: leaks are not looked for");
            Ok(())
        }
    }
}

/// Compiles a program, runs it and compares what it prints.
fn try_out(program: &Program, prefix: &Path, link: Link, options: &[&str]) -> Result<()> {
    let source = root().join(program.source);
    let is_cpp = program.source.ends_with(".cpp");
    let (compiler, standard) = if is_cpp {
        ("c++", "-std=c++17")
    } else {
        ("cc", "-std=c11")
    };
    if is_cpp && !exists(compiler, &["--version"]) {
        println!("no C++ compiler is here: {} is not tried", program.source);
        return Ok(());
    }
    let binary = target().join("c-test/program");
    let mut compile = command(compiler, &[standard]);
    compile
        .args(WARNINGS)
        .args(options)
        .arg(&source)
        .arg("-o")
        .arg(&binary);
    compile
        .args(linking(prefix, link)?)
        .args(["-lpthread", "-lm"]);
    let name = [&[program.source, link.name()], options].concat().join(" ");
    let output = finished(&name, compile)?;
    ensure!(output.is_empty(), "{name}: the compiler says\n{output}");
    let mut run = Command::new(&binary);
    run.env("LD_LIBRARY_PATH", prefix.join("lib"));
    let output = finished(&name, run)?;
    ensure!(
        output.starts_with(program.output),
        "{name} prints\n{output}instead of\n{}",
        program.output
    );
    print!("\n{name}:\n{output}");
    Ok(())
}

/// What the compiler is told about the library.
fn linking(prefix: &Path, link: Link) -> Result<Vec<OsString>> {
    let folder = |option: &str, name: &str| {
        let mut flag = OsString::from(option);
        flag.push(prefix.join(name));
        flag
    };
    Ok(match link {
        Link::Shared => vec![
            folder("-I", "include"),
            folder("-L", "lib"),
            "-lboxwood".into(),
        ],
        Link::Static => {
            let mut flags = vec![folder("-I", "include"), folder("", "lib/libboxwood.a")];
            flags.extend(private()?.split_whitespace().map(OsString::from));
            flags
        }
        Link::PkgConfig => {
            let mut ask = command("pkg-config", &["--cflags", "--libs", "boxwood"]);
            ask.env("PKG_CONFIG_PATH", prefix.join("lib/pkgconfig"));
            let flags = finished("pkg-config", ask)?;
            flags.split_whitespace().map(OsString::from).collect()
        }
    })
}

/// What the static library needs, from the place where users find it.
fn private() -> Result<String> {
    let about = fs::read_to_string(home().join("boxwood.pc.in"))?;
    let line = about
        .lines()
        .find_map(|line| line.strip_prefix("Libs.private:"));
    Ok(line
        .context("boxwood.pc.in has no Libs.private")?
        .to_owned())
}

/// Whether a program compiled with them runs.
fn sanitizers_are_there() -> Result<bool> {
    let folder = target().join("c-test");
    let (source, binary): (PathBuf, PathBuf) = (folder.join("empty.c"), folder.join("empty"));
    fs::write(&source, "int main(void) { return 0; }\n")?;
    let compiled = command("cc", &SANITIZERS)
        .arg(&source)
        .arg("-o")
        .arg(&binary)
        .output()?;
    Ok(compiled.status.success() && Command::new(&binary).output()?.status.success())
}

/// Runs a program to its end; what it printed, or that with the error.
fn finished(name: &str, mut command: Command) -> Result<String> {
    let output = command
        .output()
        .with_context(|| format!("{name}: {command:?}"))?;
    let (out, err) = (
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr),
    );
    ensure!(
        output.status.success(),
        "{name}: {command:?} ended with {}\n{out}{err}",
        output.status
    );
    Ok(format!("{out}{err}"))
}
