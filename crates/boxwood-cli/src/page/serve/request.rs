//! What a browser asks, as far as a static server must know.

use std::{
    io::{self, Read},
    net::TcpStream,
    time::{Duration, Instant},
};

/// Longest head that is read.
const MAX_HEAD: usize = 16 << 10;

/// The lines before the empty one.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Head {
    /// To its end, or as far as it was sent.
    Whole(Vec<u8>),
    /// Over the limit.
    TooLong,
    /// The other side has left without a word.
    Nothing,
}

impl Head {
    /// Reads it within `patience` as a whole, however slowly its parts come.
    pub(super) fn read(mut stream: &TcpStream, patience: Duration) -> io::Result<Self> {
        let start = Instant::now();
        let (mut head, mut part) = (Vec::new(), [0; 1024]);
        loop {
            let left = patience.saturating_sub(start.elapsed());
            if left.is_zero() {
                return Err(io::ErrorKind::TimedOut.into());
            }
            stream.set_read_timeout(Some(left))?;
            let count = match stream.read(&mut part) {
                Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
                read => read?,
            };
            // The end may have begun in the part before.
            let from = head.len().saturating_sub(2);
            head.extend(&part[..count]);
            if count == 0 && head.is_empty() {
                return Ok(Self::Nothing);
            }
            let is_whole = count == 0 || holds_end(&head[from..]);
            if head.len() > MAX_HEAD {
                return Ok(Self::TooLong);
            }
            if is_whole {
                return Ok(Self::Whole(head));
            }
        }
    }
}

/// An empty line, also of those who end lines without a carriage return.
fn holds_end(bytes: &[u8]) -> bool {
    let windows = |end: &'static [u8]| bytes.windows(end.len()).any(|part| part == end);
    windows(b"\n\r\n") || windows(b"\n\n")
}

/// A request by its head.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Request<'a> {
    pub(super) method: Method,
    /// As in `/path?query`.
    pub(super) target: &'a str,
    /// Empty if it is not said.
    pub(super) host: &'a str,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Method {
    Get,
    Head,
    Other,
}

impl<'a> Request<'a> {
    /// None if it is no request, or names two hosts.
    pub(super) fn parse(head: &'a [u8]) -> Option<Self> {
        let mut lines = std::str::from_utf8(head).ok()?.lines();
        let mut words = lines.next()?.split(' ');
        let method = match words.next()? {
            "GET" => Method::Get,
            "HEAD" => Method::Head,
            word if !word.is_empty() => Method::Other,
            _ => return None,
        };
        let target = words.next().filter(|target| !target.is_empty())?;
        let version = words.next()?;
        if !version.starts_with("HTTP/1.") || words.next().is_some() {
            return None;
        }
        let fields = lines
            .take_while(|line| !line.is_empty())
            .filter_map(|line| line.split_once(':'));
        let mut hosts = fields.filter(|(name, _)| name.eq_ignore_ascii_case("host"));
        let host = hosts.next().map_or("", |(_, value)| value.trim());
        if hosts.next().is_some() {
            return None;
        }
        Some(Self {
            method,
            target,
            host,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::{io::Write, net::TcpListener, thread};

    #[test]
    fn a_request_is_a_method_a_target_and_one_host() {
        let parsed = Request::parse(b"GET /a?b HTTP/1.1\r\nAccept: */*\r\nhost:  me:80 \r\n\r\n");
        let expected = Request {
            method: Method::Get,
            target: "/a?b",
            host: "me:80",
        };
        assert_eq!(parsed, Some(expected));
        for wrong in [
            &b""[..],
            b"\r\n\r\n",
            b"GET /\r\n\r\n",
            b"GET / SPDY/3\r\n\r\n",
            b"GET / HTTP/1.1 more\r\n\r\n",
            b" / HTTP/1.1\r\n\r\n",
            b"GET / HTTP/1.1\r\nHost: a\r\nHost: a\r\n\r\n",
            b"GET / HTTP/1.1\r\nX: \xff\r\n\r\n",
        ] {
            assert_eq!(Request::parse(wrong), None, "{wrong:?}");
        }
    }

    /// What is made of a head that `send` writes.
    fn head_of(send: impl FnOnce(TcpStream) + Send + 'static) -> io::Result<Head> {
        let listener = TcpListener::bind(("127.0.0.1", 0)).unwrap();
        let address = listener.local_addr().unwrap();
        let sender = thread::spawn(move || send(TcpStream::connect(address).unwrap()));
        let (stream, _) = listener.accept().unwrap();
        let head = Head::read(&stream, Duration::from_millis(500));
        drop(stream);
        sender.join().unwrap();
        head
    }

    #[test]
    fn a_head_that_comes_byte_by_byte_is_given_up_in_time() {
        let head = head_of(|mut stream| {
            // Ten seconds, if nobody hangs up.
            for _ in 0..200 {
                if stream.write_all(b"x").is_err() {
                    return;
                }
                thread::sleep(Duration::from_millis(50));
            }
        });
        assert!(head.is_err(), "{head:?}");
    }

    #[test]
    fn a_head_ends_with_an_empty_line_wherever_it_is_cut() {
        let text = b"GET / HTTP/1.1\r\nHost: a\r\n\r\n";
        for cut in 1..text.len() {
            let head = head_of(move |mut stream| {
                stream.set_nodelay(true).unwrap();
                stream.write_all(&text[..cut]).unwrap();
                thread::sleep(Duration::from_millis(2));
                stream.write_all(&text[cut..]).unwrap();
                // The end of the head is known before the end of the connection.
                let _ = stream.read(&mut [0]);
            });
            assert_eq!(head.unwrap(), Head::Whole(text.to_vec()));
        }
    }

    #[test]
    fn a_head_beyond_the_limit_is_too_long_and_silence_is_nothing() {
        let long = head_of(|mut stream| {
            let _ = stream.write_all(&vec![b'x'; MAX_HEAD + 1]);
        });
        assert_eq!(long.unwrap(), Head::TooLong);
        assert_eq!(head_of(drop).unwrap(), Head::Nothing);
    }
}
