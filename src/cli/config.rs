//! The configuration file.

use std::fs;
use std::path::Path;

use anyhow::{Context, anyhow};
use inbye::sim::Config;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::plain_words::plain_words;

/// Longest line of the file that an error shows, characters.
const SHOWN: usize = 60;

/// Settings from a TOML file, or the defaults. Unknown keys and numbers out of range are errors.
pub fn load(file: Option<&Path>) -> anyhow::Result<Config> {
    read("--config", file, |config: &Config| Ok(config.validate()?))
}

/// Settings of any kind from the TOML file of a flag, checked, or the defaults.
pub fn read<T: Default + Serialize + DeserializeOwned>(
    flag: &str,
    file: Option<&Path>,
    validate: impl Fn(&T) -> anyhow::Result<()>,
) -> anyhow::Result<T> {
    let Some(file) = file else {
        return Ok(T::default());
    };
    let text = fs::read_to_string(file)
        .with_context(|| format!("{flag} {}: cannot be read as text", file.display()))?;
    parse(&text, validate).with_context(|| format!("{}", file.display()))
}

/// Settings of any kind from the text of a TOML file, checked.
pub fn parse<T: Default + Serialize + DeserializeOwned>(
    text: &str,
    validate: impl Fn(&T) -> anyhow::Result<()>,
) -> anyhow::Result<T> {
    let settings: T = toml::from_str(text).map_err(|error| anyhow!(one_line::<T>(&error, text)))?;
    validate(&settings)?;
    Ok(settings)
}

fn one_line<T: Default + Serialize>(error: &toml::de::Error, text: &str) -> String {
    let number = error
        .span()
        .map_or(1, |span| text[..span.start].matches('\n').count() + 1);
    let line = text.lines().nth(number - 1).unwrap_or_default().trim();
    let shown: String = line.chars().take(SHOWN).collect();
    let message = plain_words(error.message(), home::<T>);
    format!("line {number}, `{shown}`: {message}")
}

/// The table that has a key of this name, as in `[robot.limits]`.
fn home<T: Default + Serialize>(key: &str) -> Option<String> {
    let defaults = toml::Table::try_from(T::default()).ok()?;
    find(&defaults, key, "")
}

fn find(table: &toml::Table, key: &str, path: &str) -> Option<String> {
    if table.contains_key(key) && !path.is_empty() {
        return Some(format!("[{path}]"));
    }
    table.iter().find_map(|(name, value)| {
        let below = if path.is_empty() {
            name.clone()
        } else {
            format!("{path}.{name}")
        };
        find(value.as_table()?, key, &below)
    })
}
