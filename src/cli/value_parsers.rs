//! Parsers of argument values.

use std::ffi::OsStr;

use clap::builder::{PossibleValue, TypedValueParser};
use clap::{Arg, Command, Error};
use inbye::base::Protocol;
use inbye::local::EngineChoice;
use inbye::map::UnknownPolicy;

/// Parses a value by a function and lists keywords for the help and for shell completion.
#[derive(Clone)]
pub struct KeywordParser<T> {
    keywords: Vec<&'static str>,
    parse: fn(&str) -> Result<T, String>,
}

/// Parses an engine: `auto`, `cpu`, `gpu`, or `gpu:` with part of an adapter's name.
pub fn engine() -> KeywordParser<EngineChoice> {
    KeywordParser::new(["auto", "cpu", "gpu"], str::parse)
}

/// Parses a base's protocol.
pub fn protocol() -> KeywordParser<Protocol> {
    KeywordParser::new(Protocol::ALL.map(Protocol::name), str::parse)
}

/// Parses the policy for unknown cells.
pub fn unknown() -> KeywordParser<UnknownPolicy> {
    KeywordParser::new(["blocked", "free"], |text| match text {
        "blocked" => Ok(UnknownPolicy::Blocked),
        "free" => Ok(UnknownPolicy::Free),
        _ => Err(format!("`{text}` is neither blocked nor free")),
    })
}

impl<T> KeywordParser<T> {
    fn new(
        keywords: impl IntoIterator<Item = &'static str>,
        parse: fn(&str) -> Result<T, String>,
    ) -> Self {
        let keywords = keywords.into_iter().collect();
        Self { keywords, parse }
    }
}

impl<T: Clone + Send + Sync + 'static> TypedValueParser for KeywordParser<T> {
    type Value = T;

    fn parse_ref(
        &self,
        command: &Command,
        argument: Option<&Arg>,
        value: &OsStr,
    ) -> Result<T, Error> {
        let parse = self.parse;
        let parse = move |text: &str| parse(text);
        TypedValueParser::parse_ref(&parse, command, argument, value)
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        Some(Box::new(self.keywords.iter().map(PossibleValue::new)))
    }
}
