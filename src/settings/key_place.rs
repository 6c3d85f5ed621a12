//! Finds the place of a key in a text, for errors that are found after the text is parsed.

use core::fmt::{self, Display, Formatter};

use serde::de::{DeserializeSeed, Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor};

use super::SettingError;

/// An error of a value, which names the key of the value.
#[doc(hidden)]
pub trait KeyError: Display {
    /// The path of the key: names, and indices in lists, with dots between them. None for an error of something else.
    fn key_path(&self) -> Option<String>;
}

impl KeyError for SettingError {
    fn key_path(&self) -> Option<String> {
        let separator = if self.table.is_empty() { "" } else { "." };
        Some([&self.table, separator, self.name].concat())
    }
}

/// Deserializes nothing and stops with an error at a key. Each format adds the place to its errors, so that one search serves all.
#[derive(Clone, Copy)]
struct StopAt<'p>(&'p str);

/// The line, from one, of a key in a valid TOML text, or of its table if the text does not have the key.
#[must_use]
pub fn line_in_toml(path: &str, text: &str) -> Option<usize> {
    let parse = |stop: StopAt| stop.deserialize(toml::Deserializer::parse(text)?);
    let place = StopAt::find(path, parse)?.span()?;
    Some(text[..place.start].matches('\n').count() + 1)
}

/// The line, from one, of a key in a valid JSON text, or of its object if the text does not have the key.
#[must_use]
pub fn line_in_json(path: &str, text: &str) -> Option<usize> {
    let parse = |stop: StopAt| stop.deserialize(&mut serde_json::Deserializer::from_str(text));
    Some(StopAt::find(path, parse)?.line())
}

impl StopAt<'_> {
    /// Returns the error of `parse` at a key; at its table or list if the text does not have the key.
    fn find<E>(path: &str, parse: impl Fn(StopAt) -> Result<(), E>) -> Option<E> {
        let dots = path.rmatch_indices('.').map(|(dot, _)| dot);
        [path.len()].into_iter().chain(dots).find_map(|end| parse(StopAt(&path[..end])).err())
    }

    /// What is left of the path below a key. A key may contain dots.
    fn below(self, key: &str) -> Option<Self> {
        let rest = self.0.strip_prefix(key)?;
        if rest.is_empty() { Some(Self(rest)) } else { rest.strip_prefix('.').map(Self) }
    }
}

impl<'de> DeserializeSeed<'de> for StopAt<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        if self.0.is_empty() {
            // The visitor accepts no option: the error is at the start of the value.
            deserializer.deserialize_option(self)
        } else {
            deserializer.deserialize_any(self)
        }
    }
}

/// A number or a text that stands where the path goes on is an error too.
impl<'de> Visitor<'de> for StopAt<'_> {
    type Value = ();

    fn expecting(&self, out: &mut Formatter) -> fmt::Result {
        out.write_str("no value")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        while let Some(key) = map.next_key::<String>()? {
            match self.below(&key) {
                Some(rest) => map.next_value_seed(rest)?,
                None => drop(map.next_value::<IgnoredAny>()?),
            }
        }
        Ok(())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<(), A::Error> {
        for index in 0_usize.. {
            let rest = self.below(&index.to_string());
            let found = match rest {
                Some(rest) => list.next_element_seed(rest)?,
                None => list.next_element::<IgnoredAny>()?.map(drop),
            };
            if found.is_none() {
                break;
            }
        }
        Ok(())
    }
}
