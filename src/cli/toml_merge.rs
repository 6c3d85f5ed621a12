//! Parses TOML settings over defaults: a key that a file does not name keeps its value.

use anyhow::{anyhow, bail};
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::serde_messages::plain_message;

/// Longest quotation of a line in an error, characters.
const MAX_QUOTE: usize = 60;

/// Parses and validates the text of a TOML file; keys that it does not name keep their value in `settings`.
pub fn parse<T: Default + Serialize + DeserializeOwned>(
    text: &str,
    settings: &T,
    validate: impl Fn(&T) -> anyhow::Result<()>,
) -> anyhow::Result<T> {
    // Only an error of the text itself has a line number; a merged table has none.
    if let Err(error) = toml::from_str::<T>(text) {
        bail!(one_line::<T>(&error, text));
    }
    // A table with missing keys must not get the defaults of its type, which may differ from those of its place.
    let settings = merge(settings, text)?;
    validate(&settings)?;
    Ok(settings)
}

fn one_line<T: Default + Serialize>(error: &toml::de::Error, text: &str) -> String {
    let number = error.span().map_or(1, |span| text[..span.start].matches('\n').count() + 1);
    let line = text.lines().nth(number - 1).unwrap_or_default().trim();
    let quote: String = line.chars().take(MAX_QUOTE).collect();
    let message = plain_message(error.message(), table_of::<T>);
    format!("line {number}, `{quote}`: {message}")
}

/// The table that has a key of this name, such as `[robot.limits]`.
fn table_of<T: Default + Serialize>(key: &str) -> Option<String> {
    let defaults = toml::Table::try_from(T::default()).ok()?;
    find(&defaults, key, "")
}

fn find(table: &toml::Table, key: &str, path: &str) -> Option<String> {
    if table.contains_key(key) && !path.is_empty() {
        return Some(format!("[{path}]"));
    }
    table.iter().find_map(|(name, value)| {
        let path = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
        find(value.as_table()?, key, &path)
    })
}

/// Returns settings with the changes of a TOML text applied.
fn merge<T: Serialize + DeserializeOwned>(settings: &T, text: &str) -> anyhow::Result<T> {
    // The first line of the error is its message; the others quote the text.
    let message_only = |error: toml::de::Error| anyhow!("{}", error.message().to_owned());
    let changes: toml::Table = toml::from_str(text).map_err(message_only)?;
    let mut table = toml::Table::try_from(settings)?;
    merge_tables(&mut table, changes);
    table.try_into().map_err(message_only)
}

fn merge_tables(table: &mut toml::Table, changes: toml::Table) {
    for (name, value) in changes {
        match (table.get_mut(&name), value) {
            (Some(toml::Value::Table(inner)), toml::Value::Table(changes))
                if !is_other_variant(inner, &changes) =>
            {
                merge_tables(inner, changes);
            }
            (_, value) => {
                table.insert(name, value);
            }
        }
    }
}

/// Whether two tables are different enum variants, such as `{ theta = { degrees = 30 } }` and `{ normalized = { k = 1 } }`. Such
/// a table has one key and is replaced as a whole.
pub fn is_other_variant(old: &toml::Table, new: &toml::Table) -> bool {
    let only_key = |table: &toml::Table| {
        let name = table.keys().next().cloned();
        name.filter(|_| table.len() == 1)
    };
    only_key(old).is_some_and(|old| only_key(new).is_some_and(|new| new != old))
}
