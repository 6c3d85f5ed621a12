//! A request over HTTP/1.1, read within bounds of size and time.

use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use super::response::Refusal;

/// Longest body, bytes: a problem with all the obstacles that are allowed takes a twentieth of it.
pub const MOST_BODY_BYTES: usize = 65_536;
/// Longest head, bytes.
pub const MOST_HEAD_BYTES: usize = 16_384;
/// Most headers.
const MOST_HEADERS: usize = 64;
/// How long a client may take to send all of a request.
pub const PATIENCE: Duration = Duration::from_secs(5);

/// What somebody asked for.
#[derive(Debug, Default)]
pub struct Request {
    /// As it was sent.
    pub method: String,
    /// Without what follows a question mark.
    pub path: String,
    /// The host that the client believes to talk to.
    pub host: String,
    /// Where the page that asks is from; only browsers say so.
    pub origin: Option<String>,
    /// What the body is said to be.
    pub content_type: String,
    /// The body; nothing where there is none.
    pub body: Vec<u8>,
}

/// Reads a request. None when the client has left without one.
pub fn read(stream: &mut TcpStream) -> Result<Option<Request>, Refusal> {
    let deadline = Instant::now() + PATIENCE;
    let mut bytes = Vec::new();
    loop {
        if let Some((request, head)) = parse(&bytes)? {
            let body = bytes.split_off(head.bytes);
            let body = read_body(stream, deadline, &head, body)?;
            return Ok(Some(Request { body, ..request }));
        }
        if bytes.len() >= MOST_HEAD_BYTES {
            return Err(head_too_large());
        }
        if receive(stream, deadline, &mut bytes, MOST_HEAD_BYTES)? == 0 {
            return if bytes.is_empty() {
                Ok(None)
            } else {
                Err(Refusal::new(400, "the request ends within its head"))
            };
        }
    }
}

/// What the head says of itself and of the body.
struct Head {
    bytes: usize,
    body_bytes: usize,
    is_asked_for: bool,
}

/// The head of a request, once all of it is there.
fn parse(bytes: &[u8]) -> Result<Option<(Request, Head)>, Refusal> {
    let mut headers = [httparse::EMPTY_HEADER; MOST_HEADERS];
    let mut parsed = httparse::Request::new(&mut headers);
    let head_bytes = match parsed.parse(bytes) {
        Ok(httparse::Status::Complete(head_bytes)) => head_bytes,
        Ok(httparse::Status::Partial) => return Ok(None),
        Err(httparse::Error::TooManyHeaders) => return Err(head_too_large()),
        Err(error) => return Err(Refusal::new(400, format!("this is not HTTP/1.1: {error}"))),
    };
    let path = parsed.path.unwrap_or_default();
    let mut request = Request {
        method: parsed.method.unwrap_or_default().to_owned(),
        path: path.split('?').next().unwrap_or_default().to_owned(),
        ..Request::default()
    };
    let mut head = Head {
        bytes: head_bytes,
        body_bytes: 0,
        is_asked_for: false,
    };
    let (mut hosts, mut lengths) = (0, 0);
    for header in parsed.headers {
        let text = || String::from_utf8_lossy(header.value).into_owned();
        match header.name.to_ascii_lowercase().as_str() {
            "host" => {
                hosts += 1;
                request.host = text();
            }
            "origin" => request.origin = Some(text()),
            "content-type" => request.content_type = text(),
            "content-length" => {
                lengths += 1;
                head.body_bytes = body_bytes(&text())?;
            }
            "transfer-encoding" => {
                let mend = "send the body with a Content-Length, not in chunks";
                return Err(Refusal::new(411, mend));
            }
            "expect" => head.is_asked_for = true,
            _ => {}
        }
    }
    if hosts != 1 {
        return Err(Refusal::new(400, "a request names its Host once"));
    }
    if lengths > 1 {
        return Err(Refusal::new(400, "a request has one Content-Length"));
    }
    if request.method == "POST" && lengths == 0 {
        let mend = "a POST needs the Content-Length of its body";
        return Err(Refusal::new(411, mend));
    }
    Ok(Some((request, head)))
}

fn body_bytes(length: &str) -> Result<usize, Refusal> {
    let is_number = !length.is_empty() && length.bytes().all(|byte| byte.is_ascii_digit());
    if !is_number {
        let what = "Content-Length must be a number of bytes";
        return Err(Refusal::new(400, what));
    }
    // More digits than a number has are too many bytes as well.
    let bytes = length.parse().unwrap_or(usize::MAX);
    if bytes > MOST_BODY_BYTES {
        let what = format!("the body has {length} bytes: send at most {MOST_BODY_BYTES}");
        return Err(Refusal::new(413, what));
    }
    Ok(bytes)
}

fn read_body(
    stream: &mut TcpStream,
    deadline: Instant,
    head: &Head,
    mut body: Vec<u8>,
) -> Result<Vec<u8>, Refusal> {
    if head.is_asked_for && body.is_empty() {
        // A client that is gone is noticed below.
        let _ = stream.write_all(b"HTTP/1.1 100 Continue\r\n\r\n");
    }
    while body.len() < head.body_bytes {
        if receive(stream, deadline, &mut body, head.body_bytes)? == 0 {
            let (found, expected) = (body.len(), head.body_bytes);
            let what = format!("the body ends after {found} of {expected} bytes");
            return Err(Refusal::new(400, what));
        }
    }
    // Nothing may follow: the connection is for one request.
    body.truncate(head.body_bytes);
    Ok(body)
}

/// Appends what has come, until there are `most` bytes: so many, or none at the end.
fn receive(
    stream: &mut TcpStream,
    deadline: Instant,
    bytes: &mut Vec<u8>,
    most: usize,
) -> Result<usize, Refusal> {
    let late = || {
        let seconds = PATIENCE.as_secs();
        let what = format!("the request took longer than {seconds} s: send all of it at once");
        Refusal::new(408, what)
    };
    let left = deadline.saturating_duration_since(Instant::now());
    if left.is_zero() {
        return Err(late());
    }
    let mut piece = [0; 4096];
    let room = piece.len().min(most - bytes.len());
    let read = stream
        .set_read_timeout(Some(left))
        .and_then(|()| stream.read(&mut piece[..room]));
    match read {
        Ok(count) => {
            bytes.extend_from_slice(&piece[..count]);
            Ok(count)
        }
        Err(error) => match error.kind() {
            ErrorKind::WouldBlock | ErrorKind::TimedOut => Err(late()),
            ErrorKind::Interrupted => receive(stream, deadline, bytes, most),
            // Whoever broke the line off reads no answer.
            _ => Ok(0),
        },
    }
}

fn head_too_large() -> Refusal {
    let what = format!(
        "the head is too large: at most {MOST_HEAD_BYTES} bytes and {MOST_HEADERS} headers"
    );
    Refusal::new(431, what)
}
