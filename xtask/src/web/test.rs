//! `cargo xtask web-test`: the page in headless Chromium, against the command line's own numbers.

use super::{build, page, toolchain::Toolchain};
use crate::shell::{command, exists, root, step, target};
use anyhow::{Result, ensure};

/// Builds the page, and with it what it is compared with, and runs `web/tests`. Arguments go to Node: names of tests to run alone.
pub(crate) fn run(args: &[String]) -> Result<()> {
    let toolchain = Toolchain::find()?;
    ensure!(
        exists("node", &["--version"]) && exists(CHROMIUM, &["--version"]) && has_modules(),
        "the page's tests need Node 18, Chromium and two packages: \
         `apt-get install nodejs npm chromium`, then `npm install --no-package-lock --prefix web/tests`"
    );
    build(&toolchain)?;
    let mut node = command(
        "node",
        &["--test", "--test-reporter=spec", "--test-concurrency=1"],
    );
    node.args(args)
        .arg(root().join("web/tests"))
        .env("PAGE", page())
        .env("CHROMIUM", CHROMIUM)
        .env("BOXWOOD", target().join("release/boxwood"))
        .env("EXAMPLES", target().join("release/examples"));
    step("the page in a browser", node)
}

const CHROMIUM: &str = "chromium";

fn has_modules() -> bool {
    let modules = root().join("web/tests/node_modules");
    ["playwright-core", "axe-core"]
        .iter()
        .all(|name| modules.join(name).exists())
}
