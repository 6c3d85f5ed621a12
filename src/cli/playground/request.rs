//! What a request must be before anybody looks for what it asks for.

use std::time::Duration;

use http_body_util::BodyExt as _;
use hyper::body::{Body as _, Bytes, Incoming};
use hyper::header::{CONTENT_LENGTH, HOST, TRANSFER_ENCODING};
use hyper::http::request::Parts;
use hyper::{Method, Request, StatusCode};
use tokio::time::{Instant, timeout_at};

use super::refusal::Refusal;

/// Longest body, bytes: a problem with all the obstacles that are allowed takes a twentieth of it.
pub const MOST_BODY_BYTES: u64 = 65_536;
/// Longest head, bytes.
pub const MOST_HEAD_BYTES: usize = 16_384;
/// Most headers.
pub const MOST_HEADERS: usize = 64;
/// How long a client may take to send all of a request.
pub const PATIENCE: Duration = Duration::from_secs(5);

/// The request with all of its body.
pub async fn receive(
    request: Request<Incoming>,
    deadline: Instant,
) -> Result<Request<Bytes>, Refusal> {
    let (head, body) = request.into_parts();
    // The Content-Length, or none: there are no others.
    check(&head, body.size_hint().lower())?;
    let received = timeout_at(deadline, body.collect()).await;
    let body = received.map_err(|_| late())?.map_err(|error| {
        let what = format!("the body does not come to its end: {error}");
        Refusal::new(StatusCode::BAD_REQUEST, what)
    })?;
    Ok(Request::from_parts(head, body.to_bytes()))
}

fn check(head: &Parts, body_bytes: u64) -> Result<(), Refusal> {
    if head.headers.get_all(HOST).iter().count() != 1 {
        let what = "a request names its Host once";
        return Err(Refusal::new(StatusCode::BAD_REQUEST, what));
    }
    if head.headers.contains_key(TRANSFER_ENCODING) {
        let mend = "send the body with a Content-Length, not in chunks";
        return Err(Refusal::new(StatusCode::LENGTH_REQUIRED, mend));
    }
    if head.method == Method::POST && !head.headers.contains_key(CONTENT_LENGTH) {
        let mend = "a POST needs the Content-Length of its body";
        return Err(Refusal::new(StatusCode::LENGTH_REQUIRED, mend));
    }
    if body_bytes > MOST_BODY_BYTES {
        let what = format!("the body has {body_bytes} bytes: send at most {MOST_BODY_BYTES}");
        return Err(Refusal::new(StatusCode::PAYLOAD_TOO_LARGE, what));
    }
    Ok(())
}

/// For a request that is not there in time.
pub fn late() -> Refusal {
    let seconds = PATIENCE.as_secs();
    let what = format!("the request took longer than {seconds} s: send all of it at once");
    Refusal::new(StatusCode::REQUEST_TIMEOUT, what)
}

/// For a head beyond the bounds.
pub fn head_too_large() -> Refusal {
    let what = format!(
        "the head is too large: at most {MOST_HEAD_BYTES} bytes and {MOST_HEADERS} headers"
    );
    Refusal::new(StatusCode::REQUEST_HEADER_FIELDS_TOO_LARGE, what)
}
