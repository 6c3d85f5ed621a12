//! An answer over HTTP/1.1: one for each connection, which is closed then.

use std::io::{self, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::sync::Arc;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use super::refusal::Refusal;

/// What a page may load: nothing but what this server sends, and no script or style within the page itself.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src 'self' data:; \
    base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// How long a client may take to read an answer.
const PATIENCE: Duration = Duration::from_secs(20);
/// Written between two looks at the clock, bytes.
const PIECE: usize = 1 << 16;
/// Most that is read of what a client sends on, bytes.
const MOST_DRAINED: usize = 1 << 22;

/// Bytes of an answer.
pub enum Body {
    /// A part of the program.
    Fixed(&'static [u8]),
    /// Made for this answer.
    Own(Vec<u8>),
    /// Made once for many.
    Shared(Arc<[u8]>),
}

impl Body {
    fn bytes(&self) -> &[u8] {
        match self {
            Self::Fixed(bytes) => bytes,
            Self::Own(bytes) => bytes,
            Self::Shared(bytes) => bytes,
        }
    }
}

/// An answer.
pub struct Response {
    pub status: u16,
    content_type: &'static str,
    body: Body,
    allow: Option<&'static str>,
    /// Whether only the head is sent, which tells of the body all the same.
    is_head: bool,
}

impl Response {
    /// What was asked for.
    pub const fn new(content_type: &'static str, body: Body) -> Self {
        Self {
            status: 200,
            content_type,
            body,
            allow: None,
            is_head: false,
        }
    }

    /// An object.
    pub fn json(value: &Value) -> Self {
        Self::new(
            "application/json",
            Body::Own(value.to_string().into_bytes()),
        )
    }

    /// As the method wants it: who asks for the head alone gets no body.
    pub fn in_answer_to(self, method: &str) -> Self {
        Self {
            is_head: method == "HEAD",
            ..self
        }
    }

    /// Sends it and closes the connection. A client that is gone, or does not read, is no error of ours.
    ///
    /// What a client still sends is read for so long, since a connection closed on unread bytes loses the answer as well.
    pub fn send(&self, mut stream: TcpStream, farewell: Duration) {
        if self.write(&mut stream).is_ok() {
            drain(&mut stream, farewell);
        }
    }

    fn write(&self, stream: &mut TcpStream) -> io::Result<()> {
        let bytes = self.body.bytes();
        let allow = self
            .allow
            .map_or_else(String::new, |methods| format!("Allow: {methods}\r\n"));
        let head = format!(
            "HTTP/1.1 {} {}\r\nContent-Type: {}\r\nContent-Length: {}\r\nConnection: close\r\nCache-Control: no-store\r\n\
             Content-Security-Policy: {POLICY}\r\nX-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\n\
             Cross-Origin-Opener-Policy: same-origin\r\nCross-Origin-Embedder-Policy: require-corp\r\n\
             Cross-Origin-Resource-Policy: same-origin\r\n{allow}\r\n",
            self.status,
            phrase(self.status),
            self.content_type,
            bytes.len(),
        );
        let mut all = head.into_bytes();
        // The first piece goes with the head, in one packet where it fits.
        let sent = if self.is_head { &[] } else { bytes };
        let (first, rest) = sent.split_at(sent.len().min(PIECE));
        all.extend_from_slice(first);
        let deadline = Instant::now() + PATIENCE;
        for piece in std::iter::once(all.as_slice()).chain(rest.chunks(PIECE)) {
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Err(io::ErrorKind::TimedOut.into());
            }
            stream.set_write_timeout(Some(left))?;
            stream.write_all(piece)?;
        }
        stream.shutdown(Shutdown::Write)
    }
}

fn drain(stream: &mut TcpStream, farewell: Duration) {
    let deadline = Instant::now() + farewell;
    let (mut piece, mut drained) = ([0; 4096], 0);
    while drained < MOST_DRAINED {
        let left = deadline.saturating_duration_since(Instant::now());
        if left.is_zero() || stream.set_read_timeout(Some(left)).is_err() {
            return;
        }
        match stream.read(&mut piece) {
            Ok(count) if count > 0 => drained += count,
            _ => return,
        }
    }
}

impl From<Refusal> for Response {
    fn from(refusal: Refusal) -> Self {
        Self {
            status: refusal.status,
            allow: refusal.allow,
            ..Self::json(&json!({ "error": refusal.what }))
        }
    }
}

const fn phrase(status: u16) -> &'static str {
    match status {
        200 => "OK",
        400 => "Bad Request",
        403 => "Forbidden",
        404 => "Not Found",
        405 => "Method Not Allowed",
        408 => "Request Timeout",
        411 => "Length Required",
        413 => "Content Too Large",
        415 => "Unsupported Media Type",
        500 => "Internal Server Error",
        431 => "Request Header Fields Too Large",
        503 => "Service Unavailable",
        _ => "Error",
    }
}
