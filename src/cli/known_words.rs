//! Values that are one of a few words, or begin with one: the words are told to the shell's completions and to the help.

use std::ffi::OsStr;

use clap::builder::{PossibleValue, TypedValueParser};
use clap::{Arg, Command, Error};
use inbye::base::Protocol;
use inbye::local::EngineChoice;
use inbye::map::UnknownPolicy;

/// Reads a value by its own rule, and knows the words to offer.
#[derive(Clone)]
pub struct KnownWords<T> {
    words: Vec<&'static str>,
    read: fn(&str) -> Result<T, String>,
}

/// Engines. An adapter's name may follow `gpu:`.
pub fn engine() -> KnownWords<EngineChoice> {
    KnownWords::new(["auto", "cpu", "gpu"], str::parse)
}

/// Protocols of bases.
pub fn protocol() -> KnownWords<Protocol> {
    KnownWords::new(Protocol::ALL.map(Protocol::name), str::parse)
}

/// What unknown ground counts as.
pub fn unknown() -> KnownWords<UnknownPolicy> {
    KnownWords::new(["blocked", "free"], |text| match text {
        "blocked" => Ok(UnknownPolicy::Blocked),
        "free" => Ok(UnknownPolicy::Free),
        _ => Err(format!("`{text}` is neither blocked nor free")),
    })
}

impl<T> KnownWords<T> {
    fn new(
        words: impl IntoIterator<Item = &'static str>,
        read: fn(&str) -> Result<T, String>,
    ) -> Self {
        let words = words.into_iter().collect();
        Self { words, read }
    }
}

impl<T: Clone + Send + Sync + 'static> TypedValueParser for KnownWords<T> {
    type Value = T;

    fn parse_ref(
        &self,
        command: &Command,
        argument: Option<&Arg>,
        value: &OsStr,
    ) -> Result<T, Error> {
        let read = self.read;
        let read = move |text: &str| read(text);
        TypedValueParser::parse_ref(&read, command, argument, value)
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        Some(Box::new(self.words.iter().map(PossibleValue::new)))
    }
}
