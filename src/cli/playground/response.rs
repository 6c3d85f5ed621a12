//! An answer, and what every one of them forbids.

use http_body_util::Full;
use hyper::body::Bytes;
use hyper::header::{ALLOW, CONTENT_TYPE, HeaderName, HeaderValue};
use serde_json::{Value, json};

use super::refusal::Refusal;

/// An answer.
pub type Response = hyper::Response<Full<Bytes>>;

/// What a page may load: nothing but what this server sends, and no script or style within the page itself.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src 'self' data:; \
    base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// Sent with every answer.
const HEADERS: [(&str, &str); 7] = [
    ("cache-control", "no-store"),
    ("content-security-policy", POLICY),
    ("x-content-type-options", "nosniff"),
    ("referrer-policy", "no-referrer"),
    ("cross-origin-opener-policy", "same-origin"),
    ("cross-origin-embedder-policy", "require-corp"),
    ("cross-origin-resource-policy", "same-origin"),
];

/// What was asked for.
pub fn of(content_type: &'static str, body: impl Into<Bytes>) -> Response {
    let mut response = Response::new(Full::new(body.into()));
    let headers = response.headers_mut();
    headers.insert(CONTENT_TYPE, HeaderValue::from_static(content_type));
    headers.extend(HEADERS.map(|(name, value)| {
        let name = HeaderName::from_static(name);
        (name, HeaderValue::from_static(value))
    }));
    response
}

/// An object.
pub fn json(value: &Value) -> Response {
    of("application/json", value.to_string())
}

impl From<Refusal> for Response {
    fn from(refusal: Refusal) -> Self {
        let mut response = json(&json!({ "error": refusal.what }));
        *response.status_mut() = refusal.status;
        let allow = refusal.allow.map(HeaderValue::from_static);
        let allow = allow.map(|methods| (ALLOW, methods));
        response.headers_mut().extend(allow);
        response
    }
}
