//! What is said to whom nothing is given.

use hyper::{Method, StatusCode};

/// Why somebody does not get what they asked for: a status, and a line that says what is wrong and how to mend it.
#[derive(Debug)]
pub struct Refusal {
    /// Of HTTP, 4xx or 5xx.
    pub status: StatusCode,
    /// The line.
    pub what: String,
    /// The methods that the path takes, where another was used.
    pub allow: Option<&'static str>,
}

impl Refusal {
    pub fn new(status: StatusCode, what: impl Into<String>) -> Self {
        Self {
            status,
            what: what.into(),
            allow: None,
        }
    }

    /// Of a method other than those of a path.
    pub fn of_method(method: &Method, allow: &'static str) -> Self {
        let what = format!("{method} is not for this path: it takes {allow}");
        Self {
            allow: Some(allow),
            ..Self::new(StatusCode::METHOD_NOT_ALLOWED, what)
        }
    }
}
