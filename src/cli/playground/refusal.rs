//! What is said to whom nothing is given.

/// Why somebody does not get what they asked for: a status, and a line that says what is wrong and how to mend it.
#[derive(Debug)]
pub struct Refusal {
    /// Of HTTP, 4xx or 5xx.
    pub status: u16,
    /// The line.
    pub what: String,
    /// The methods that the path takes, where another was used.
    pub allow: Option<&'static str>,
}

impl Refusal {
    pub fn new(status: u16, what: impl Into<String>) -> Self {
        Self {
            status,
            what: what.into(),
            allow: None,
        }
    }

    /// Of a method other than those of a path.
    pub fn of_method(method: &str, allow: &'static str) -> Self {
        let what = format!("{method} is not for this path: it takes {allow}");
        Self {
            allow: Some(allow),
            ..Self::new(405, what)
        }
    }
}
