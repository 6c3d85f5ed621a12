//! The configuration file.

use std::fs;
use std::path::Path;

use anyhow::{Context, bail};
use inbye::base::BaseConfig;
use inbye::runtime::Config;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::changes;
use super::plain_words::plain_words;

/// Longest line of the file that an error shows, characters.
const SHOWN: usize = 60;

/// Settings from the TOML file of a flag, or the defaults. Unknown keys and numbers out of range are errors.
pub fn load(flag: &str, file: Option<&Path>) -> anyhow::Result<Config> {
    read(flag, file, |config: &Config| Ok(config.validate()?))
}

/// Settings of a base and its supervisor, likewise.
pub fn load_base(flag: &str, file: Option<&Path>) -> anyhow::Result<BaseConfig> {
    read(flag, file, |config: &BaseConfig| Ok(config.validate()?))
}

/// A benchmark's settings, changed by a TOML file if there is one. Unknown keys and numbers out of range are errors.
pub fn changed(ours: Config, file: Option<&Path>) -> anyhow::Result<Config> {
    let Some(file) = file else {
        ours.validate()?;
        return Ok(ours);
    };
    let text = fs::read_to_string(file).context("cannot be read as text: check the path");
    text.and_then(|text| parse(&text, &ours, |config| Ok(config.validate()?)))
        .with_context(|| format!("{}", file.display()))
}

/// Settings of any kind from the TOML file of a flag, checked, or the defaults.
fn read<T: Default + Serialize + DeserializeOwned>(
    flag: &str,
    file: Option<&Path>,
    validate: impl Fn(&T) -> anyhow::Result<()>,
) -> anyhow::Result<T> {
    let Some(file) = file else {
        return Ok(T::default());
    };
    let text = fs::read_to_string(file)
        .with_context(|| format!("{flag} {}: cannot be read as text", file.display()))?;
    parse(&text, &T::default(), validate).with_context(|| format!("{}", file.display()))
}

/// Settings of any kind from the text of a TOML file, checked; what it does not name is ours.
pub fn parse<T: Default + Serialize + DeserializeOwned>(
    text: &str,
    ours: &T,
    validate: impl Fn(&T) -> anyhow::Result<()>,
) -> anyhow::Result<T> {
    // Read as it is first: a table of changes knows no lines.
    if let Err(error) = toml::from_str::<T>(text) {
        bail!(one_line::<T>(&error, text));
    }
    // Parts of a table left out must not become the defaults of its type, which may be other than those of its place.
    let settings = changes::onto(ours, text)?;
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
