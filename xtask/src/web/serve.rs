//! A static server on 127.0.0.1, for the page and its tests. Reads files of one folder, and nothing else.

use anyhow::{Context, Result};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::thread::{self, JoinHandle};
use std::time::Duration;

/// Longest request head that is read.
const MAX_HEAD: u64 = 16 << 10;

/// A server at work, until the program ends.
pub(super) struct Server {
    /// Where it listens.
    pub(super) address: SocketAddr,
    worker: JoinHandle<()>,
}

impl Server {
    /// For ever.
    pub(super) fn wait(self) {
        // A panic of the worker has told its story already.
        let _ = self.worker.join();
    }
}

/// Serves `folder` on `port` of 127.0.0.1; 0 takes a free one.
pub(super) fn start(folder: PathBuf, port: u16) -> Result<Server> {
    let listener = TcpListener::bind(("127.0.0.1", port))
        .with_context(|| format!("port {port} of 127.0.0.1 cannot be listened to"))?;
    let address = listener.local_addr()?;
    let worker = thread::spawn(move || {
        for stream in listener.incoming().flatten() {
            let folder = folder.clone();
            // A reader who hangs up is no error of ours.
            thread::spawn(move || drop(answer(&stream, &folder)));
        }
    });
    Ok(Server { address, worker })
}

fn answer(mut stream: &TcpStream, folder: &Path) -> Result<()> {
    stream.set_read_timeout(Some(Duration::from_secs(10)))?;
    let mut head = BufReader::new(stream.take(MAX_HEAD)).lines();
    let request = head.next().context("no request")??;
    // The rest of the head must be read, else closing would reset the connection.
    for line in head {
        if line?.is_empty() {
            break;
        }
    }
    let (status, kind, body) = match file(&request, folder) {
        Some((kind, body)) => ("200 OK", kind, body),
        None => ("404 Not Found", "text/plain", b"not here\n".to_vec()),
    };
    write!(
        stream,
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\nCache-Control: no-store\r\nConnection: close\r\n\r\n",
        body.len()
    )?;
    stream.write_all(&body)?;
    Ok(())
}

/// The kind and bytes of what `GET /path` asks for: plain names below the folder only.
fn file(request: &str, folder: &Path) -> Option<(&'static str, Vec<u8>)> {
    let target = request.strip_prefix("GET /")?.split([' ', '?']).next()?;
    let target = if target.is_empty() {
        "index.html"
    } else {
        target
    };
    let is_plain = |part: &str| {
        let letter = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
        !part.is_empty() && !part.starts_with('.') && part.chars().all(letter)
    };
    if !target.split('/').all(is_plain) {
        return None;
    }
    let kind = match target.rsplit_once('.')?.1 {
        "html" => "text/html; charset=utf-8",
        "css" => "text/css; charset=utf-8",
        "js" => "text/javascript; charset=utf-8",
        "wasm" => "application/wasm",
        "json" => "application/json",
        "svg" => "image/svg+xml",
        "png" => "image/png",
        _ => "application/octet-stream",
    };
    Some((kind, std::fs::read(folder.join(target)).ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asked(server: &Server, request: &str) -> String {
        let mut stream = TcpStream::connect(server.address).unwrap();
        write!(stream, "{request} HTTP/1.1\r\nHost: here\r\n\r\n").unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        answer
    }

    #[test]
    fn files_of_the_folder_are_served_and_nothing_above_it() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
        let server = start(folder, 0).unwrap();
        let found = asked(&server, "GET /web/serve.rs?v=1");
        assert!(found.starts_with("HTTP/1.1 200 OK") && found.contains("nothing above it"));
        for request in [
            "GET /../Cargo.toml",
            "GET /.hidden",
            "GET //etc/passwd",
            "GET /a%2fb",
            "POST /main.rs",
        ] {
            assert!(asked(&server, request).contains("404"), "{request}");
        }
    }
}
