//! `boxwood view --web`: what is served, and what is refused before.
#![cfg(feature = "view")]

mod common;

use std::{
    fs,
    io::{BufRead, BufReader, Read, Write},
    net::TcpStream,
    path::Path,
    process::{Child, Command, Stdio},
    time::{Duration, Instant},
};

use common::{command, expect, folder, text};

/// A server, which ends with the test.
struct Served {
    child: Child,
    /// `http://127.0.0.1:8080/?open=NAME`.
    url: String,
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Served {
    /// Serves a page of nothing, with what `command` says besides.
    fn new(folder: &Path, mut command: Command, args: &[&str], stdin: &[u8]) -> Self {
        fs::write(folder.join("index.html"), "nothing\n").unwrap();
        command.args(["view", "--web", "--page", "."]).args(args);
        command.current_dir(folder);
        command.stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut child = command.stderr(Stdio::piped()).spawn().unwrap();
        child.stdin.take().unwrap().write_all(stdin).unwrap();
        let mut line = String::new();
        let mut told = BufReader::new(child.stdout.take().unwrap());
        told.read_line(&mut line).unwrap();
        let url = line.split(' ').find(|word| word.starts_with("http://"));
        let url = url.unwrap_or_default().to_owned();
        Self { child, url }
    }

    fn address(&self) -> &str {
        let rest = self.url.trim_start_matches("http://");
        rest.split('/').next().unwrap()
    }

    fn get(&self, path: &str) -> String {
        let mut stream = TcpStream::connect(self.address()).unwrap();
        let address = self.address();
        let _ = write!(stream, "GET {path} HTTP/1.1\r\nHost: {address}\r\n\r\n");
        let mut reply = Vec::new();
        let _ = stream.read_to_end(&mut reply);
        text(&reply)
    }

    /// What it said on stderr.
    fn end(mut self) -> String {
        let _ = self.child.kill();
        let mut said = String::new();
        let mut stderr = self.child.stderr.take().unwrap();
        stderr.read_to_string(&mut said).unwrap();
        said
    }
}

const TRIANGLE: &str = "v 0 0 0\nv 2 0 0\nv 0 3 0.5\nf 1 2 3\n";

#[test]
fn a_scene_that_cannot_be_read_is_not_served() {
    let folder = folder();
    let at = folder.path();
    fs::write(at.join("index.html"), "nothing\n").unwrap();
    fs::write(at.join("empty.gltf"), "").unwrap();
    fs::write(at.join("broken.obj"), "f 1 2 9\n").unwrap();
    for name in [
        "builtin:nosuch",
        "gone.obj",
        "empty.gltf",
        "broken.obj",
        "-",
    ] {
        let said = text(&expect(at, &["view", "--web", "--page", ".", name], 3).stderr);
        let name = name.replace('-', "<stdin>");
        assert!(said.contains(&format!("error: {name}")), "{said}");
    }
}

#[test]
fn the_page_gets_standard_input_and_files_that_are_called_as_built_in_scenes() {
    let folder = folder();
    let own = || command(folder.path());
    let served = Served::new(folder.path(), own(), &["-"], TRIANGLE.as_bytes());
    assert!(served.url.ends_with("?open=%3Cstdin%3E"), "{}", served.url);
    assert!(served.get("/model").ends_with(TRIANGLE));
    assert_eq!(served.end(), "");
    if cfg!(windows) {
        return;
    }
    fs::write(folder.path().join("builtin:cornell"), TRIANGLE).unwrap();
    let served = Served::new(folder.path(), own(), &["./builtin:cornell"], b"");
    assert!(
        served.url.ends_with("?open=.%2Fbuiltin:cornell"),
        "{}",
        served.url
    );
    assert!(served.get("/model").ends_with(TRIANGLE));
    let served = Served::new(folder.path(), own(), &["builtin:cornell"], b"");
    assert!(served.get("/model").contains("404"), "the page has it");
}

#[test]
fn parts_that_the_page_cannot_have_are_told_with_the_remedy() {
    let folder = folder();
    let at = folder.path();
    fs::write(at.join("a.obj"), format!("mtllib a.mtl\n{TRIANGLE}")).unwrap();
    fs::write(at.join("a.mtl"), "newmtl red\nKd 1 0 0\n").unwrap();
    let served = Served::new(at, command(at), &["a.obj"], b"");
    assert!(served.get("/").contains("nothing"));
    let said = served.end();
    assert_eq!(said.lines().count(), 1, "{said}");
    assert!(
        said.contains("warning: a.obj: ") && said.contains(".glb"),
        "{said}"
    );
}

#[cfg(unix)]
#[test]
fn a_server_without_descriptors_goes_on_when_there_are_some() {
    let folder = folder();
    let mut shell = Command::new("sh");
    let program = env!("CARGO_BIN_EXE_boxwood");
    shell.args(["-c", "ulimit -n 16; exec \"$0\" \"$@\"", program]);
    let served = Served::new(folder.path(), shell, &[], b"");
    let address = served.address().to_owned();
    let crowd: Vec<TcpStream> = (0..40)
        .map(|_| TcpStream::connect(&address).unwrap())
        .collect();
    std::thread::sleep(Duration::from_millis(300));
    drop(crowd);
    let start = Instant::now();
    while !served.get("/").contains("nothing") {
        assert!(start.elapsed() < Duration::from_secs(10), "it has ended");
        std::thread::sleep(Duration::from_millis(50));
    }
}
