//! The viewer's window, tried as a user would: on a virtual screen (Xvfb), by real keys and the pointer (xdotool).

use std::{
    fs,
    io::{BufRead, BufReader, Read},
    path::Path,
    process::{Child, Command, Stdio},
    thread,
    time::{Duration, Instant},
};

use anyhow::{Context, Result, bail, ensure};

use crate::shell::{command, exists, step, target};

/// Programs that this needs, and an argument that shows that they are there.
const NEEDED: [(&str, &str); 3] = [
    ("Xvfb", "-help"),
    ("xdotool", "--version"),
    ("import", "-version"),
];
const PATIENCE: Duration = Duration::from_secs(30);

/// Tries the viewer, or says why it is not tried. Pictures go to `target/view-test`.
pub(crate) fn run(_: &[String]) -> Result<()> {
    for (program, argument) in NEEDED {
        if !exists(program, &[argument]) {
            println!(
                "\n=== view-test: skipped, {program} is not here (apt-get install xvfb xdotool imagemagick)"
            );
            return Ok(());
        }
    }
    step("viewer", command("cargo", &["build", "--release"]))?;
    let binary = target().join("release/boxwood");
    let folder = target().join("view-test");
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder)?;
    without_a_screen(&binary)?;
    let screen = Screen::start()?;
    by_keys_and_pointer(&binary, &folder, &screen)?;
    println!("=== view-test: passed; pictures in {}", folder.display());
    Ok(())
}

/// The error names the way out, and the exit code says that the command line is at fault.
fn without_a_screen(binary: &Path) -> Result<()> {
    let output = Command::new(binary)
        .args(["view", "builtin:cornell"])
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("WAYLAND_SOCKET")
        .output()?;
    let text = String::from_utf8_lossy(&output.stderr);
    ensure!(
        output.status.code() == Some(2),
        "without a screen it ends with {}",
        output.status
    );
    ensure!(
        text.contains("boxwood render"),
        "without a screen it says: {text}"
    );
    Ok(())
}

/// Orbits, switches, picks, saves, quits.
fn by_keys_and_pointer(binary: &Path, folder: &Path, screen: &Screen) -> Result<()> {
    let mesh = folder.join("mesh.obj");
    fs::write(&mesh, "v 0 0 0\nv 2 0 0\nv 0 3 0.5\nf 1 2 3\n")?;
    let mut viewer = Command::new(binary);
    viewer
        .args([
            "view",
            "mesh.obj",
            "--size",
            "640x480",
            "--state",
            "state.json",
        ])
        .current_dir(folder)
        .env("DISPLAY", &screen.display)
        .env_remove("WAYLAND_DISPLAY")
        .stdout(Stdio::piped());
    let mut viewer = Running(viewer.spawn()?);
    let window = screen.wait_for_window("mesh.obj")?;
    screen.xdotool(&["windowfocus", "--sync", &window])?;
    screen.xdotool(&["mousemove", "300", "240"])?;
    screen.keys(&["c", "F5", "4", "b", "p", "period", "g"])?;
    wait_until("a picture is grabbed", || {
        folder.join("boxwood-view-1.png").exists()
    })?;
    screen.grab(&folder.join("window.png"))?;
    screen.xdotool(&["mousedown", "1", "mousemove", "400", "260", "mouseup", "1"])?;
    screen.keys(&["c"])?;
    // A triangle more: the file is read again.
    fs::write(
        &mesh,
        "v 0 0 0\nv 2 0 0\nv 0 3 0.5\nv 3 3 1\nf 1 2 3\nf 2 4 3\n",
    )?;
    thread::sleep(Duration::from_secs(2));
    screen.keys(&["p", "g"])?;
    wait_until("another picture is grabbed", || {
        folder.join("boxwood-view-2.png").exists()
    })?;
    screen.keys(&["h"])?;
    thread::sleep(Duration::from_millis(500));
    screen.grab(&folder.join("sheet.png"))?;
    screen.keys(&["q"])?;
    let (status, printed) = viewer.finish()?;
    ensure!(status, "the viewer failed");
    check(folder, &printed)
}

/// What the viewer printed and wrote.
fn check(folder: &Path, printed: &str) -> Result<()> {
    let mut cameras: Vec<&str> = printed
        .lines()
        .filter(|line| line.starts_with("--vp "))
        .collect();
    // On a busy machine a key may come twice.
    cameras.dedup();
    ensure!(
        cameras.len() == 2,
        "two cameras were to be printed, before and after dragging, not: {printed}"
    );
    let state = fs::read_to_string(folder.join("state.json")).context("state.json")?;
    for part in ["\"normal\"", "\"wide\"", "mesh.obj"] {
        ensure!(state.contains(part), "the state file lacks {part}: {state}");
    }
    let colours: Vec<usize> = [
        "window.png",
        "sheet.png",
        "boxwood-view-1.png",
        "boxwood-view-2.png",
    ]
    .into_iter()
    .map(|name| colours(&folder.join(name)))
    .collect::<Result<_>>()?;
    ensure!(
        colours.iter().all(|&n| n > 40),
        "a picture is empty: {colours:?} colours"
    );
    Ok(())
}

/// How many different colours a picture has.
fn colours(path: &Path) -> Result<usize> {
    let output = Command::new("identify")
        .args(["-format", "%k"])
        .arg(path)
        .output()?;
    let text = String::from_utf8_lossy(&output.stdout);
    text.trim()
        .parse()
        .with_context(|| format!("{} is no picture", path.display()))
}

fn wait_until(what: &str, mut is_so: impl FnMut() -> bool) -> Result<()> {
    let start = Instant::now();
    while !is_so() {
        ensure!(start.elapsed() < PATIENCE, "in vain: {what}");
        thread::sleep(Duration::from_millis(50));
    }
    Ok(())
}

/// A process that does not outlive the test.
struct Running(Child);

impl Running {
    /// Waits for the end; whether all was well, and what was printed.
    fn finish(&mut self) -> Result<(bool, String)> {
        let start = Instant::now();
        while self.0.try_wait()?.is_none() {
            ensure!(start.elapsed() < PATIENCE, "the viewer does not end");
            thread::sleep(Duration::from_millis(50));
        }
        let mut printed = String::new();
        if let Some(mut stdout) = self.0.stdout.take() {
            stdout.read_to_string(&mut printed)?;
        }
        Ok((self.0.wait()?.success(), printed))
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A virtual screen.
struct Screen {
    _server: Running,
    /// As in `DISPLAY`.
    display: String,
}

impl Screen {
    /// On a number that is free.
    fn start() -> Result<Self> {
        let mut server = Command::new("Xvfb")
            .args([
                "-displayfd",
                "1",
                "-screen",
                "0",
                "1280x1024x24",
                "-nolisten",
                "tcp",
                // Keys that a busy machine lets go late are not repeated.
                "-r",
            ])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()?;
        let mut number = String::new();
        if let Some(stdout) = server.stdout.take() {
            BufReader::new(stdout).read_line(&mut number)?;
        }
        let server = Running(server);
        if number.trim().is_empty() {
            bail!("Xvfb does not start");
        }
        Ok(Self {
            _server: server,
            display: format!(":{}", number.trim()),
        })
    }

    fn xdotool(&self, args: &[&str]) -> Result<String> {
        let output = Command::new("xdotool")
            .args(args)
            .env("DISPLAY", &self.display)
            .output()?;
        ensure!(
            output.status.success(),
            "xdotool {args:?}: {}",
            String::from_utf8_lossy(&output.stderr)
        );
        Ok(String::from_utf8_lossy(&output.stdout).trim().to_owned())
    }

    /// One after the other, with time for a frame between.
    fn keys(&self, keys: &[&str]) -> Result<()> {
        for key in keys {
            self.xdotool(&["key", key])?;
            thread::sleep(Duration::from_millis(200));
        }
        Ok(())
    }

    /// The window that has `title` in its name, once it has it.
    fn wait_for_window(&self, title: &str) -> Result<String> {
        let mut window = String::new();
        wait_until("the window opens", || {
            window = self
                .xdotool(&["search", "--onlyvisible", "--name", title])
                .unwrap_or_default();
            !window.is_empty()
        })?;
        Ok(window.lines().next().unwrap_or_default().to_owned())
    }

    /// The whole screen as PNG.
    fn grab(&self, path: &Path) -> Result<()> {
        let status = Command::new("import")
            .args(["-window", "root"])
            .arg(path)
            .env("DISPLAY", &self.display)
            .status()?;
        ensure!(status.success(), "the screen cannot be grabbed");
        Ok(())
    }
}
