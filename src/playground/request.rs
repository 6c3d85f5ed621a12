//! Receives a request within limits of size and time.

use std::time::Duration;

use http_body_util::BodyExt as _;
use hyper::body::{Body as _, Bytes, Incoming};
use hyper::header::{CONTENT_LENGTH, HOST, TRANSFER_ENCODING};
use hyper::http::request::Parts;
use hyper::{Method, Request, StatusCode};
use tokio::time::{Instant, timeout_at};

use super::response::HttpError;

/// Longest body, bytes. A problem with the maximum number of obstacles has a twentieth of it.
pub const MAX_BODY_BYTES: u64 = 65_536;
/// Longest request line and headers, bytes.
pub const MAX_HEAD_BYTES: usize = 16_384;
/// Maximum number of headers.
pub const MAX_HEADERS: usize = 64;
/// Time within which the client must send the whole request.
pub const REQUEST_TIMEOUT: Duration = Duration::from_secs(5);

/// Returns the request with its whole body.
pub async fn receive(
    request: Request<Incoming>,
    deadline: Instant,
) -> Result<Request<Bytes>, HttpError> {
    let (head, body) = request.into_parts();
    // The lower bound is the Content-Length: chunked bodies are rejected.
    check(&head, body.size_hint().lower())?;
    let received = timeout_at(deadline, body.collect()).await;
    let body = received
        .map_err(|_| timed_out())?
        .map_err(|error| HttpError::bad_request(format!("the body is incomplete: {error}")))?;
    Ok(Request::from_parts(head, body.to_bytes()))
}

fn check(head: &Parts, body_bytes: u64) -> Result<(), HttpError> {
    if head.headers.get_all(HOST).iter().count() != 1 {
        return Err(HttpError::bad_request("a request has exactly one Host"));
    }
    if head.headers.contains_key(TRANSFER_ENCODING) {
        let cure = "send the body with a Content-Length, not in chunks";
        return Err(HttpError::new(StatusCode::LENGTH_REQUIRED, cure));
    }
    if head.method == Method::POST && !head.headers.contains_key(CONTENT_LENGTH) {
        let cure = "a POST needs the Content-Length of its body";
        return Err(HttpError::new(StatusCode::LENGTH_REQUIRED, cure));
    }
    if body_bytes > MAX_BODY_BYTES {
        let message = format!("the body has {body_bytes} bytes: send at most {MAX_BODY_BYTES}");
        return Err(HttpError::new(StatusCode::PAYLOAD_TOO_LARGE, message));
    }
    Ok(())
}

/// The error for a request that exceeds [`REQUEST_TIMEOUT`].
pub fn timed_out() -> HttpError {
    let seconds = REQUEST_TIMEOUT.as_secs();
    let message = format!("the request took longer than {seconds} s: send all of it at once");
    HttpError::new(StatusCode::REQUEST_TIMEOUT, message)
}

/// The error for a request line and headers beyond the limits.
pub fn head_too_large() -> HttpError {
    let message =
        format!("the head is too large: at most {MAX_HEAD_BYTES} bytes and {MAX_HEADERS} headers");
    HttpError::new(StatusCode::REQUEST_HEADER_FIELDS_TOO_LARGE, message)
}
