//! A static server on 127.0.0.1 for the page, and for the one model that it is to open.
//!
//! Answers requests that name this machine as their host, and no others: a page from elsewhere cannot have its name lead here
//! and read the model.

mod request;

use std::{
    fs::File,
    io::{self, Read, Write},
    net::{Ipv4Addr, Shutdown, SocketAddr, TcpListener, TcpStream},
    sync::Arc,
    thread,
    time::{Duration, Instant},
};

use super::{Page, Source};
use request::{Head, Method, Request};

/// Time for a request to arrive, and for each part of the reply to be taken.
const PATIENCE: Duration = Duration::from_secs(30);
/// Connections at a time; a browser opens about six.
const MOST: usize = 64;
/// Before the listener is asked again after an error.
const BREATH: Duration = Duration::from_millis(100);
/// A listener that gives nothing but errors for so long is broken.
const BROKEN: Duration = Duration::from_secs(120);
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
    model: Option<Source>,
    hosts: [String; 2],
}

impl Server {
    /// Takes `port` of 127.0.0.1; 0 is any that is free.
    pub(crate) fn bind(page: Page, model: Option<Source>, port: u16) -> io::Result<Self> {
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
        // Counts the connections: each holds one more.
        let seat = Arc::new(());
        loop {
            let (stream, _) = patiently(BROKEN, || self.listener.accept())?;
            if Arc::strong_count(&seat) > MOST {
                continue;
            }
            let (files, seat) = (Arc::clone(&self.files), Arc::clone(&seat));
            // A reader who hangs up, or a machine without a thread to spare, is no error of ours.
            let _ = thread::Builder::new().spawn(move || {
                let _ = files.answer(&stream);
                drop(seat);
            });
        }
    }
}

/// What `accept` gives. Errors of single connections, and of a process that has no descriptors left, pass: it is asked again,
/// until it has given nothing else `for_long`.
fn patiently<T>(for_long: Duration, mut accept: impl FnMut() -> io::Result<T>) -> io::Result<T> {
    let start = Instant::now();
    loop {
        match accept() {
            Err(error) if start.elapsed() >= for_long => return Err(error),
            Err(_) => thread::sleep(BREATH),
            accepted => return accepted,
        }
    }
}

/// What is sent.
struct Reply {
    status: &'static str,
    kind: &'static str,
    /// A line of the head.
    more: &'static str,
    length: u64,
    body: Box<dyn Read>,
}

impl Files {
    fn answer(&self, mut stream: &TcpStream) -> io::Result<()> {
        stream.set_write_timeout(Some(PATIENCE))?;
        let head = Head::read(stream, PATIENCE)?;
        let mut reply = match &head {
            Head::Whole(head) => self.reply(head),
            Head::TooLong => Reply::refusal("431 Request Header Fields Too Large"),
            Head::Nothing => return Ok(()),
        };
        write!(
            stream,
            "HTTP/1.1 {}\r\nContent-Type: {}\r\nContent-Length: {}\r\n{}X-Content-Type-Options: nosniff\r\n\
             Cross-Origin-Resource-Policy: same-origin\r\nCache-Control: no-store\r\nConnection: close\r\n\r\n",
            reply.status, reply.kind, reply.length, reply.more
        )?;
        io::copy(&mut reply.body, &mut stream)?;
        linger(stream)
    }

    fn reply(&self, head: &[u8]) -> Reply {
        let Some(request) = Request::parse(head) else {
            return Reply::refusal("400 Bad Request");
        };
        let mut hosts = self.hosts.iter();
        let is_ours = hosts.any(|ours| request.host.eq_ignore_ascii_case(ours));
        let reply = match request.method {
            _ if !is_ours => Reply::not_here(),
            Method::Get | Method::Head => self.find(request.target).unwrap_or_else(Reply::not_here),
            Method::Other => Reply {
                more: "Allow: GET, HEAD\r\n",
                ..Reply::refusal("405 Method Not Allowed")
            },
        };
        match request.method {
            Method::Head => Reply {
                body: Box::new(io::empty()),
                ..reply
            },
            _ => reply,
        }
    }

    /// What `/path` is: the model, or a plain name of the page.
    fn find(&self, target: &str) -> Option<Reply> {
        let target = target.strip_prefix('/')?.split('?').next()?;
        if target == MODEL {
            return self.model.as_ref()?.reply();
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
        Some(Reply::of_bytes("200 OK", kind, self.page.read(target)?))
    }
}

impl Source {
    fn reply(&self) -> Option<Reply> {
        let kind = kind("");
        let path = match self {
            Self::Bytes(bytes) => return Some(Reply::of_bytes("200 OK", kind, Arc::clone(bytes))),
            Self::File(path) => path,
        };
        let file = File::open(path).ok()?;
        let length = file.metadata().ok().filter(|about| about.is_file())?.len();
        Some(Reply {
            status: "200 OK",
            kind,
            more: "",
            length,
            // It may grow while it is sent.
            body: Box::new(file.take(length)),
        })
    }
}

impl Reply {
    fn of_bytes(
        status: &'static str,
        kind: &'static str,
        bytes: impl AsRef<[u8]> + 'static,
    ) -> Self {
        Self {
            status,
            kind,
            more: "",
            length: bytes.as_ref().len() as u64,
            body: Box::new(io::Cursor::new(bytes)),
        }
    }

    fn not_here() -> Self {
        Self::of_bytes("404 Not Found", "text/plain", b"not here\n")
    }

    /// With its status as the text.
    fn refusal(status: &'static str) -> Self {
        Self::of_bytes(status, "text/plain", format!("{status}\n").into_bytes())
    }
}

/// Takes what the other side still sends, shortly: closing with bytes unread would reset the connection, and the reply be lost.
fn linger(mut stream: &TcpStream) -> io::Result<()> {
    const SHORTLY: Duration = Duration::from_secs(1);
    const MOST_BYTES: usize = 1 << 20;
    stream.shutdown(Shutdown::Write)?;
    let (start, mut part, mut taken) = (Instant::now(), [0; 4096], 0);
    while taken < MOST_BYTES {
        let left = SHORTLY.saturating_sub(start.elapsed());
        if left.is_zero() {
            break;
        }
        stream.set_read_timeout(Some(left))?;
        match stream.read(&mut part)? {
            0 => break,
            count => taken += count,
        }
    }
    Ok(())
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

    fn connected(url: &str) -> TcpStream {
        let address = url.trim_start_matches("http://").trim_end_matches('/');
        TcpStream::connect(address).unwrap()
    }

    /// The reply to these bytes.
    fn told(url: &str, request: &[u8]) -> String {
        let mut stream = connected(url);
        stream.write_all(request).unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        answer
    }

    fn asked(url: &str, request: &str, host: Option<&str>) -> String {
        let address = url.trim_start_matches("http://").trim_end_matches('/');
        let host = host.unwrap_or(address);
        told(
            url,
            format!("{request} HTTP/1.1\r\nHost: {host}\r\n\r\n").as_bytes(),
        )
    }

    /// Serves this folder, with `Cargo.toml` as the model.
    fn served() -> String {
        let here = Path::new(env!("CARGO_MANIFEST_DIR"));
        let page = Page::Folder(here.join("src/page"));
        let model = Source::File(here.join("Cargo.toml"));
        let server = Server::bind(page, Some(model), 0).unwrap();
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
            "GET /none.js",
            "GET *",
        ] {
            assert!(asked(&url, request, None).contains("404"), "{request}");
        }
    }

    #[test]
    fn the_bytes_of_standard_input_are_served_as_the_model() {
        let model = Source::Bytes(b"v 0 0 0\n"[..].into());
        let server = Server::bind(Page::Folder("no/page".into()), Some(model), 0).unwrap();
        let url = server.url();
        thread::spawn(|| server.run());
        assert!(asked(&url, "GET /model", None).ends_with("\r\n\r\nv 0 0 0\n"));
    }

    #[test]
    fn a_head_is_asked_for_alone_and_other_methods_are_refused() {
        let url = served();
        let head = asked(&url, "HEAD /serve.rs", None);
        assert!(head.starts_with("HTTP/1.1 200 OK") && head.ends_with("\r\n\r\n"));
        let refused = asked(&url, "POST /serve.rs", None);
        assert!(
            refused.starts_with("HTTP/1.1 405 ") && refused.contains("\r\nAllow: GET, HEAD\r\n")
        );
    }

    #[test]
    fn what_is_no_request_is_told_so() {
        let url = served();
        let address = url.trim_start_matches("http://").trim_end_matches('/');
        let bad = [
            b"\r\n\r\n".to_vec(),
            b"GET\r\n\r\n".to_vec(),
            b"GET /\xff HTTP/1.1\r\n\r\n".to_vec(),
            format!("GET /model HTTP/1.1\r\nHost: {address}\r\nHost: {address}\r\n\r\n")
                .into_bytes(),
        ];
        for request in bad {
            let reply = told(&url, &request);
            assert!(reply.starts_with("HTTP/1.1 400 "), "{request:?}: {reply}");
        }
        let long = format!("GET / HTTP/1.1\r\nX: {}\r\n\r\n", "x".repeat(20 << 10));
        let reply = told(&url, long.as_bytes());
        assert!(reply.starts_with("HTTP/1.1 431 "), "{reply}");
    }

    #[test]
    fn a_crowd_is_turned_away_until_there_is_room() {
        let url = served();
        let crowd: Vec<TcpStream> = (0..MOST).map(|_| connected(&url)).collect();
        let mut late = connected(&url);
        // The end, or a reset.
        assert!(late.read(&mut [0]).map_or(true, |count| count == 0));
        drop(crowd);
        let start = Instant::now();
        loop {
            let mut stream = connected(&url);
            let host = url.trim_start_matches("http://").trim_end_matches('/');
            let _ = write!(stream, "GET /serve.rs HTTP/1.1\r\nHost: {host}\r\n\r\n");
            let mut reply = String::new();
            let _ = stream.read_to_string(&mut reply);
            if reply.contains("200 OK") {
                return;
            }
            assert!(start.elapsed() < PATIENCE / 2, "the seats stay taken");
        }
    }

    #[test]
    fn an_error_of_the_listener_passes_unless_it_stays() {
        // "Too many open files".
        let full = || io::Error::from_raw_os_error(24);
        let mut answers = vec![Ok(7), Err(full()), Err(full())];
        assert_eq!(patiently(BROKEN, || answers.pop().unwrap()).unwrap(), 7);
        let stays = patiently(Duration::ZERO, || Err::<(), _>(full()));
        assert_eq!(stays.unwrap_err().raw_os_error(), Some(24));
    }

    #[test]
    fn whoever_calls_this_machine_by_another_name_gets_nothing() {
        let url = served();
        for host in ["evil.example", "127.0.0.1", ""] {
            for method in ["GET", "HEAD", "POST"] {
                let reply = asked(&url, &format!("{method} /model"), Some(host));
                assert!(reply.contains("404"), "{method} {host}");
            }
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
