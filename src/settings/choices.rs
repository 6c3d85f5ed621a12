//! The words of enums of plain words, which serde knows.

use serde::de::value::StrDeserializer;
use serde::de::{self, DeserializeOwned};
use serde_json::{Value, json};

/// JSON Schema of an enum of plain words. The words are those that serde reads.
#[doc(hidden)]
#[must_use]
pub fn choices<T: DeserializeOwned>() -> Value {
    let read = T::deserialize(StrDeserializer::new(""));
    json!({ "enum": read.err().map_or(&[][..], |Words(words)| words) })
}

/// Reads a word of an enum of plain words.
///
/// # Errors
/// Lists the words, for a text that is not `kind`, such as "a protocol".
#[cfg(feature = "sim")]
pub(crate) fn parse_choice<T: DeserializeOwned>(kind: &str, text: &str) -> Result<T, String> {
    T::deserialize(StrDeserializer::new(text)).map_err(|Words(words)| {
        format!("`{}` is not {kind}: use one of {}", text.escape_debug(), words.join(", "))
    })
}

/// The words of an enum, from the error of one that is none of them.
#[derive(Debug, thiserror::Error)]
#[error("{0:?}")]
struct Words(&'static [&'static str]);

impl de::Error for Words {
    fn custom<M: core::fmt::Display>(_: M) -> Self {
        Self(&[])
    }

    fn unknown_variant(_: &str, words: &'static [&'static str]) -> Self {
        Self(words)
    }
}
