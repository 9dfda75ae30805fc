//! A static server on 127.0.0.1 for the page, and for the one model that it is to open.
//!
//! Answers requests that name this machine as their host, and no others: a page from elsewhere cannot have its name lead here
//! and read the model.

use std::{
    fs::File,
    io::{self, BufRead, BufReader, Read, Write},
    net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream},
    path::PathBuf,
    sync::Arc,
    thread,
    time::Duration,
};

use super::Page;

/// Longest request head that is read.
const MAX_HEAD: u64 = 16 << 10;
/// Silence after which a browser is given up.
const PATIENCE: Duration = Duration::from_secs(30);
/// The address of the model.
const MODEL: &str = "model";

/// Bound to its port, and not yet at work.
#[derive(Debug)]
pub(crate) struct Server {
    listener: TcpListener,
    address: SocketAddr,
    files: Arc<Files>,
}

#[derive(Debug)]
struct Files {
    page: Page,
    /// Read anew for each request, so that a reload shows what has changed.
    model: Option<PathBuf>,
    hosts: [String; 2],
}

impl Server {
    /// Takes `port` of 127.0.0.1; 0 is any that is free.
    pub(crate) fn bind(page: Page, model: Option<PathBuf>, port: u16) -> io::Result<Self> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))?;
        let address = listener.local_addr()?;
        let hosts = ["127.0.0.1", "localhost"].map(|name| format!("{name}:{}", address.port()));
        let files = Arc::new(Files { page, model, hosts });
        Ok(Self {
            listener,
            address,
            files,
        })
    }

    /// `http://127.0.0.1:8080/`.
    pub(crate) fn url(&self) -> String {
        format!("http://{}/", self.address)
    }

    /// For ever, or until the listener breaks.
    pub(crate) fn run(self) -> io::Result<()> {
        loop {
            let (stream, _) = self.listener.accept()?;
            let files = Arc::clone(&self.files);
            // A reader who hangs up, or a machine without a thread to spare, is no error of ours.
            let _ = thread::Builder::new().spawn(move || files.answer(&stream));
        }
    }
}

/// What is sent.
struct Reply {
    status: &'static str,
    kind: &'static str,
    length: u64,
    body: Box<dyn Read>,
}

impl Files {
    fn answer(&self, mut stream: &TcpStream) -> io::Result<()> {
        stream.set_read_timeout(Some(PATIENCE))?;
        stream.set_write_timeout(Some(PATIENCE))?;
        let mut request = String::new();
        let mut host = String::new();
        // The head must be read to its end, else closing would reset the connection.
        for line in BufReader::new(stream.take(MAX_HEAD)).lines() {
            let line = line?;
            if line.is_empty() {
                break;
            }
            match line.split_once(':') {
                _ if request.is_empty() => request = line,
                Some((name, value)) if name.eq_ignore_ascii_case("host") => {
                    value.trim().clone_into(&mut host);
                }
                _ => {}
            }
        }
        let is_ours = self
            .hosts
            .iter()
            .any(|ours| host.eq_ignore_ascii_case(ours));
        let found = is_ours.then(|| self.find(&request)).flatten();
        let mut reply = found.unwrap_or_else(Reply::not_here);
        write!(
            stream,
            "HTTP/1.1 {}\r\nContent-Type: {}\r\nContent-Length: {}\r\nX-Content-Type-Options: nosniff\r\n\
             Cross-Origin-Resource-Policy: same-origin\r\nCache-Control: no-store\r\nConnection: close\r\n\r\n",
            reply.status, reply.kind, reply.length
        )?;
        io::copy(&mut reply.body, &mut stream)?;
        Ok(())
    }

    /// What `GET /path` asks for: the model, or a plain name of the page.
    fn find(&self, request: &str) -> Option<Reply> {
        let target = request.strip_prefix("GET /")?.split([' ', '?']).next()?;
        if target == MODEL {
            let file = File::open(self.model.as_ref()?).ok()?;
            let length = file.metadata().ok().filter(|about| about.is_file())?.len();
            // It may grow while it is sent.
            let body = Box::new(file.take(length));
            return Some(Reply {
                status: "200 OK",
                kind: "application/octet-stream",
                length,
                body,
            });
        }
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
        let kind = kind(target.rsplit_once('.')?.1);
        let bytes = self.page.read(target)?;
        Some(Reply {
            status: "200 OK",
            kind,
            length: bytes.len() as u64,
            body: Box::new(io::Cursor::new(bytes)),
        })
    }
}

impl Reply {
    fn not_here() -> Self {
        let body = &b"not here\n"[..];
        Self {
            status: "404 Not Found",
            kind: "text/plain",
            length: body.len() as u64,
            body: Box::new(body),
        }
    }
}

/// The type of a file by its extension.
fn kind(extension: &str) -> &'static str {
    match extension {
        "html" => "text/html; charset=utf-8",
        "css" => "text/css; charset=utf-8",
        "js" => "text/javascript; charset=utf-8",
        "wasm" => "application/wasm",
        "json" => "application/json",
        "svg" => "image/svg+xml",
        "png" => "image/png",
        _ => "application/octet-stream",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn asked(url: &str, request: &str, host: Option<&str>) -> String {
        let address = url.trim_start_matches("http://").trim_end_matches('/');
        let mut stream = TcpStream::connect(address).unwrap();
        write!(
            stream,
            "{request} HTTP/1.1\r\nHost: {}\r\n\r\n",
            host.unwrap_or(address)
        )
        .unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        answer
    }

    /// Serves this folder, with `Cargo.toml` as the model.
    fn served() -> String {
        let here = Path::new(env!("CARGO_MANIFEST_DIR"));
        let page = Page::Folder(here.join("src/page"));
        let server = Server::bind(page, Some(here.join("Cargo.toml")), 0).unwrap();
        let url = server.url();
        thread::spawn(|| server.run());
        url
    }

    #[test]
    fn files_of_the_page_and_the_model_are_served_and_nothing_else() {
        let url = served();
        let found = asked(&url, "GET /serve.rs?v=1", None);
        assert!(found.starts_with("HTTP/1.1 200 OK") && found.contains("nothing_else"));
        assert!(asked(&url, "GET /model", None).contains("boxwood-cli"));
        for request in [
            "GET /../Cargo.toml",
            "GET /.hidden",
            "GET //etc/passwd",
            "GET /a%2fb",
            "POST /serve.rs",
            "GET /none.js",
            "",
        ] {
            assert!(asked(&url, request, None).contains("404"), "{request}");
        }
    }

    #[test]
    fn whoever_calls_this_machine_by_another_name_gets_nothing() {
        let url = served();
        for host in ["evil.example", "127.0.0.1", ""] {
            assert!(
                asked(&url, "GET /model", Some(host)).contains("404"),
                "{host}"
            );
        }
        let port = url
            .trim_end_matches('/')
            .rsplit(':')
            .next()
            .unwrap()
            .to_owned();
        assert!(asked(&url, "GET /model", Some(&format!("LocalHost:{port}"))).contains("200 OK"));
    }
}
