//! The binary itself, run in a folder of its own.

use std::{
    path::Path,
    process::{Child, Command, Output, Stdio},
};

use serde_json::Value;

#[allow(dead_code, reason = "not every test draws")]
pub(crate) const SMALL: &str = "--size=48x27";

pub(crate) fn command(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_boxwood"));
    command.current_dir(folder).stdin(Stdio::null());
    command
}

#[track_caller]
fn run(folder: &Path, args: &[&str]) -> Output {
    command(folder)
        .args(args)
        .output()
        .expect("the binary runs")
}

pub(crate) fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a folder for the test")
}

pub(crate) fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Runs, and says everything if the exit code is another.
#[track_caller]
pub(crate) fn expect(folder: &Path, args: &[&str], code: i32) -> Output {
    let output = run(folder, args);
    let (out, err) = (text(&output.stdout), text(&output.stderr));
    assert_eq!(
        output.status.code(),
        Some(code),
        "boxwood {}\n{out}\n{err}",
        args.join(" ")
    );
    output
}

#[allow(dead_code, reason = "not every test asks for JSON")]
#[track_caller]
pub(crate) fn json(folder: &Path, args: &[&str], code: i32) -> Value {
    let mut with_json = args.to_vec();
    with_json.push("--json");
    let output = expect(folder, &with_json, code);
    serde_json::from_slice(&output.stdout)
        .unwrap_or_else(|e| panic!("{args:?}: {e}\n{}", text(&output.stdout)))
}

/// Under `nohup`, which ignores hangups, the program leaves signals as they are.
#[allow(dead_code, reason = "not every test sends signals")]
pub(crate) fn is_under_nohup() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status
        .lines()
        .find_map(|line| line.strip_prefix("SigIgn:"))
        .and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    let is = ignored.is_some_and(|mask| mask & 1 == 1);
    if is {
        println!("skipped: under nohup signals end the program as ever");
    }
    is
}

/// Sends a signal by the name that `kill` has for it, such as `INT`.
#[allow(dead_code, reason = "not every test sends signals")]
#[track_caller]
pub(crate) fn send(signal: &str, child: &Child) {
    let killed = Command::new("kill")
        .args(["-s", signal, &child.id().to_string()])
        .status();
    assert!(
        killed.is_ok_and(|status| status.success()),
        "there is a `kill`, and the process is there"
    );
}
