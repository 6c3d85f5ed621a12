//! The configuration file.

use std::fs;
use std::path::Path;

use anyhow::{Context, anyhow};
use inbye::sim::Config;

use super::plain_words::plain_words;

/// Longest line of the file that an error shows, characters.
const SHOWN: usize = 60;

/// Settings from a TOML file, or the defaults. Unknown keys and numbers out of range are errors.
pub fn load(file: Option<&Path>) -> anyhow::Result<Config> {
    let Some(file) = file else {
        return Ok(Config::default());
    };
    let place = || format!("{}", file.display());
    let text = fs::read_to_string(file)
        .with_context(|| format!("--config {}: cannot be read as text", file.display()))?;
    let config: Config = toml::from_str(&text)
        .map_err(|error| anyhow!(one_line(&error, &text)))
        .with_context(place)?;
    config.validate().with_context(place)?;
    Ok(config)
}

fn one_line(error: &toml::de::Error, text: &str) -> String {
    let number = error
        .span()
        .map_or(1, |span| text[..span.start].matches('\n').count() + 1);
    let line = text.lines().nth(number - 1).unwrap_or_default().trim();
    let shown: String = line.chars().take(SHOWN).collect();
    let message = plain_words(error.message(), home);
    format!("line {number}, `{shown}`: {message}")
}

/// The table that has a key of this name, as in `[robot.limits]`.
fn home(key: &str) -> Option<String> {
    let defaults = toml::Table::try_from(Config::default()).ok()?;
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
