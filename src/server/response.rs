//! HTTP responses and error responses.

use http_body_util::Full;
use hyper::body::Bytes;
use hyper::header::{ALLOW, CONTENT_SECURITY_POLICY, CONTENT_TYPE, HeaderName, HeaderValue};
use hyper::{Method, StatusCode};
use serde_json::{Value, json};

/// A response.
pub type Response = hyper::Response<Full<Bytes>>;

/// The content security policy: a response loads only resources of this server, and no inline script or style.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; frame-src 'self'; \
    img-src 'self' data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
/// The policy of a page that states the rest of its policy itself. Only pages of this server may show it in a frame.
const PAGE_POLICY: &str = "base-uri 'none'; form-action 'none'; frame-ancestors 'self'";

/// Headers of every response.
const HEADERS: [(&str, &str); 6] = [
    ("cache-control", "no-store"),
    ("x-content-type-options", "nosniff"),
    ("referrer-policy", "no-referrer"),
    ("cross-origin-opener-policy", "same-origin"),
    ("cross-origin-embedder-policy", "require-corp"),
    ("cross-origin-resource-policy", "same-origin"),
];

/// A successful response.
pub fn ok(content_type: &'static str, body: impl Into<Bytes>) -> Response {
    with_policy(POLICY, content_type, body)
}

/// A page with its own content security policy.
pub fn page(html: String) -> Response {
    with_policy(PAGE_POLICY, "text/html; charset=utf-8", html)
}

fn with_policy(
    policy: &'static str,
    content_type: &'static str,
    body: impl Into<Bytes>,
) -> Response {
    let mut response = Response::new(Full::new(body.into()));
    let headers = response.headers_mut();
    headers.insert(CONTENT_TYPE, HeaderValue::from_static(content_type));
    headers.insert(CONTENT_SECURITY_POLICY, HeaderValue::from_static(policy));
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
