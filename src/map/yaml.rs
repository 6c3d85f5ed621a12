//! YAML within bounds: aliases can make a few lines into billions of values.

use serde::de::DeserializeOwned;
use serde_saphyr::options::NonFiniteFloatPolicy;
use serde_saphyr::{Error, Options, budget, options};

/// Deepest nesting accepted; a file for people has less than ten levels.
const MAX_DEPTH: usize = 64;

/// Text that is no YAML of the kind that is read.
#[derive(Debug)]
pub(crate) struct BadYaml {
    /// Line, from one.
    pub line: usize,
    /// What is wrong, in one line.
    pub reason: String,
}

/// Reads the one document of a text that unfolds to at most so many values. Numbers that are not finite come as text.
pub(crate) fn parse<T: DeserializeOwned>(text: &str, max_nodes: usize) -> Result<T, BadYaml> {
    serde_saphyr::from_str_with_options(text, reading(max_nodes)).map_err(|error| BadYaml {
        line: error.location().map_or(1, |place| place.line() as usize),
        reason: reason(&error, max_nodes),
    })
}

fn reading(max_nodes: usize) -> Options {
    options! {
        budget: budget! { max_nodes: max_nodes, max_depth: MAX_DEPTH },
        non_finite_float_policy: NonFiniteFloatPolicy::AsString,
        with_snippet: false,
    }
}

/// What the YAML reader says, in one line.
fn reason(error: &Error, max_nodes: usize) -> String {
    match error.without_snippet() {
        Error::DuplicateMappingKey { key: Some(key), .. } => {
            format!("key `{}` once more", key.escape_debug())
        }
        Error::AliasError { error, .. } => reason(error, max_nodes),
        Error::Budget { .. } => {
            format!("the file is nested too deeply, or unfolds to more than {max_nodes} values")
        }
        Error::MultipleDocuments { .. } => "a second document".into(),
        error => {
            let words = error.to_string();
            words.split_whitespace().collect::<Vec<_>>().join(" ")
        }
    }
}
