//! A request, received within bounds of size and time.

use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use super::head::{Head, MOST_HEAD_BYTES, Request, head_too_large, parse};
use super::refusal::Refusal;

/// How long a client may take to send all of a request.
pub const PATIENCE: Duration = Duration::from_secs(5);

/// Reads a request. None when the client has left, or has not begun in time.
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
        let received = receive(stream, deadline, &mut bytes, MOST_HEAD_BYTES);
        if bytes.is_empty() {
            // Browsers open connections before they know whether they need them.
            return Ok(None);
        }
        if received? == 0 {
            return Err(Refusal::new(400, "the request ends within its head"));
        }
    }
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
