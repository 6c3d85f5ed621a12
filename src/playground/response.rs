//! HTTP responses and error responses.

use http_body_util::Full;
use hyper::body::Bytes;
use hyper::header::{ALLOW, CONTENT_TYPE, HeaderName, HeaderValue};
use hyper::{Method, StatusCode};
use serde_json::{Value, json};

use crate::local::EngineError;

/// A response.
pub type Response = hyper::Response<Full<Bytes>>;

/// The content security policy: the page loads only resources of this server, and no inline script or style.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src 'self' data:; \
    base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// Headers of every response.
const HEADERS: [(&str, &str); 7] = [
    ("cache-control", "no-store"),
    ("content-security-policy", POLICY),
    ("x-content-type-options", "nosniff"),
    ("referrer-policy", "no-referrer"),
    ("cross-origin-opener-policy", "same-origin"),
    ("cross-origin-embedder-policy", "require-corp"),
    ("cross-origin-resource-policy", "same-origin"),
];

/// A successful response.
pub fn ok(content_type: &'static str, body: impl Into<Bytes>) -> Response {
    let mut response = Response::new(Full::new(body.into()));
    let headers = response.headers_mut();
    headers.insert(CONTENT_TYPE, HeaderValue::from_static(content_type));
    headers.extend(HEADERS.map(|(name, value)| {
        let name = HeaderName::from_static(name);
        (name, HeaderValue::from_static(value))
    }));
    response
}

/// A successful JSON response.
pub fn json(value: &Value) -> Response {
    ok("application/json", value.to_string())
}

/// An error response: a status 4xx or 5xx and a line with the cause and the cure.
#[derive(Debug)]
pub struct HttpError {
    status: StatusCode,
    message: String,
    /// The methods that the path supports, if the request used another.
    allow: Option<&'static str>,
}

impl HttpError {
    pub fn new(status: StatusCode, message: impl Into<String>) -> Self {
        Self { status, message: message.into(), allow: None }
    }

    /// An error response with status 400.
    pub fn bad_request(message: impl Into<String>) -> Self {
        Self::new(StatusCode::BAD_REQUEST, message)
    }

    /// The error for a method that the path does not support.
    pub fn method_not_allowed(method: &Method, allow: &'static str) -> Self {
        let message = format!("this path does not support {method}: use {allow}");
        Self { allow: Some(allow), ..Self::new(StatusCode::METHOD_NOT_ALLOWED, message) }
    }
}

impl From<EngineError> for HttpError {
    fn from(error: EngineError) -> Self {
        Self::new(StatusCode::INTERNAL_SERVER_ERROR, error.to_string())
    }
}

impl From<HttpError> for Response {
    fn from(error: HttpError) -> Self {
        let mut response = json(&json!({ "error": error.message }));
        *response.status_mut() = error.status;
        let allow = error.allow.map(HeaderValue::from_static);
        let allow = allow.map(|methods| (ALLOW, methods));
        response.headers_mut().extend(allow);
        response
    }
}
