//! YAML parsing with limits against alias expansion and deep nesting.

use serde::de::DeserializeOwned;
use serde_saphyr::options::NonFiniteFloatPolicy;
use serde_saphyr::{Error, Options, budget, options};

use crate::suggest::in_one_line;

/// Deepest nesting accepted; hand-written files have less than ten levels.
const MAX_DEPTH: usize = 64;

/// A YAML syntax error.
#[derive(Debug)]
pub(crate) struct BadYaml {
    /// Line, from one.
    pub line: usize,
    /// The cause, in one line.
    pub reason: String,
}

/// Parses a text with one document of at most `max_nodes` values after alias expansion. Non-finite numbers become strings.
pub(crate) fn parse<T: DeserializeOwned>(text: &str, max_nodes: usize) -> Result<T, BadYaml> {
    serde_saphyr::from_str_with_options(text, parser_options(max_nodes)).map_err(|error| BadYaml {
        line: error.location().map_or(1, |place| place.line() as usize),
        reason: reason(&error, max_nodes),
    })
}

fn parser_options(max_nodes: usize) -> Options {
    options! {
        budget: budget! { max_nodes: max_nodes, max_depth: MAX_DEPTH },
        non_finite_float_policy: NonFiniteFloatPolicy::AsString,
        with_snippet: false,
    }
}

/// The parser's message, in one line.
fn reason(error: &Error, max_nodes: usize) -> String {
    match error.without_snippet() {
        Error::DuplicateMappingKey { key: Some(key), .. } => {
            format!("duplicate key `{}`", key.escape_debug())
        }
        Error::AliasError { error, .. } => reason(error, max_nodes),
        Error::Budget { .. } => {
            format!("the file is nested too deeply, or expands to more than {max_nodes} values")
        }
        Error::MultipleDocuments { .. } => "a second document".into(),
        error => in_one_line(&error.to_string()),
    }
}
