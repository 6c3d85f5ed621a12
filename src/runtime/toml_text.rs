//! Parses TOML settings over defaults: a key that a file does not name keeps its value. Errors are for users who do not write
//! Rust.

use core::fmt::Display;

use serde::Serialize;
use serde::de::DeserializeOwned;
use toml::{Table, Value};

use super::{Config, renamed_keys};
use crate::settings::{KeyError, line_in_toml, read_table, read_toml};
use crate::suggest::{MAX_POINTS, closest_name, in_one_line, without_rust_types};

/// Longest quotation of a line in an error, characters.
const MAX_QUOTE: usize = 60;

/// What is wrong with a text of settings, on one line: the place if it is known, and how to correct it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct TomlError {
    message: String,
    /// Path of the key, for an error without a line.
    key: Option<String>,
}

impl TomlError {
    fn new(error: impl Display) -> Self {
        Self { message: error.to_string(), key: None }
    }

    pub(crate) fn of_key(error: &impl KeyError) -> Self {
        Self { message: error.to_string(), key: error.key_path() }
    }

    /// The error with the line of its key, if it names one that the text has.
    #[doc(hidden)]
    #[must_use]
    pub fn in_text(error: &impl KeyError, text: &str) -> Self {
        let message = error.to_string();
        let number = error.key_path().and_then(|path| line_in_toml(&path, text));
        Self::new(number.map_or_else(|| message.clone(), |number| in_line(number, text, &message)))
    }
}

impl KeyError for TomlError {
    fn key_path(&self) -> Option<String> {
        self.key.clone()
    }
}

impl Config {
    /// The settings with the changes of a text, TOML. Keys that it does not name keep their values.
    ///
    /// # Errors
    /// The text is no TOML, names an unknown key, or gives a value that is out of range.
    pub fn with_changes(&self, toml: &str) -> Result<Self, TomlError> {
        parse_toml(toml, self, Self::validate)
    }

    /// As [`Self::with_changes`], of a table in another file: errors name the key, but no line.
    #[cfg(feature = "experiment")]
    pub(crate) fn with_table(&self, changes: &Table) -> Result<Self, TomlError> {
        merged(changes, self, Self::validate)
    }
}

/// Parses and validates the text of a TOML file; keys that it does not name keep their value in `settings`.
///
/// # Errors
/// As [`Config::with_changes`].
pub fn parse_toml<T: Default + Serialize + DeserializeOwned, E: KeyError>(
    text: &str,
    settings: &T,
    validate: impl Fn(&T) -> Result<(), E>,
) -> Result<T, TomlError> {
    // Only an error of the text itself has a line number; a merged table has none.
    if let Err(error) = read_toml::<T>(text) {
        let message = plain_message(error.message(), table_of::<T>);
        let number = error.span().map_or(1, |span| text[..span.start].matches('\n').count() + 1);
        let has_comma = text.lines().nth(number - 1).is_some_and(has_decimal_comma);
        let hint = if has_comma { ": write a number with a point, such as 0.5" } else { "" };
        let message = message + hint;
        return Err(TomlError::new(in_line(number, text, &message)));
    }
    let changes = toml::from_str(text).map_err(|error| TomlError::new(error.message()))?;
    merged(&changes, settings, validate).map_err(|error| TomlError::in_text(&error, text))
}

/// Merges and validates a table of changes; keys that it does not name keep their value in `settings`.
fn merged<T: Default + Serialize + DeserializeOwned, E: KeyError>(
    changes: &Table,
    settings: &T,
    validate: impl Fn(&T) -> Result<(), E>,
) -> Result<T, TomlError> {
    // A table with missing keys must not get the defaults of its type, which may differ from those of its place.
    // The first line of the error is its message; the others quote the text.
    let table = Table::try_from(settings).map_err(TomlError::new)?;
    let read = |changes: &Table| {
        let mut table = table.clone();
        merge_tables(&mut table, changes.clone());
        read_table::<T>(table)
    };
    let settings = read(changes).map_err(|error| TomlError {
        key: unreadable_key(changes, &|changes| read(changes).is_err()),
        ..TomlError::new(plain_message(error.message(), table_of::<T>))
    })?;
    validate(&settings).map_err(|error| TomlError::of_key(&error))?;
    Ok(settings)
}

/// Whether the value of a line is a number with a comma for its point.
fn has_decimal_comma(line: &str) -> bool {
    let is_whole = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    let value = line.split_once('=').map_or("", |(_, value)| value.trim());
    let value = value.trim_start_matches(['+', '-']);
    value.split_once(',').is_some_and(|(whole, rest)| is_whole(whole) && is_whole(rest.trim()))
}

/// The path of the first key that cannot be read, alone in its tables.
fn unreadable_key(changes: &Table, is_unreadable: &dyn Fn(&Table) -> bool) -> Option<String> {
    let alone = |name: &String, value: &Value| Table::from_iter([(name.clone(), value.clone())]);
    let (name, value) = changes.iter().find(|(name, value)| is_unreadable(&alone(name, value)))?;
    let inner = value.as_table().and_then(|inner| {
        unreadable_key(inner, &|inner| is_unreadable(&alone(name, &Value::Table(inner.clone()))))
    });
    Some(inner.map_or_else(|| name.clone(), |inner| format!("{name}.{inner}")))
}

/// A message after the number and the beginning of the line that it is about.
fn in_line(number: usize, text: &str, message: &str) -> String {
    let line = text.lines().nth(number - 1).unwrap_or_default().trim();
    let quote: String = line.chars().take(MAX_QUOTE).collect();
    format!("line {number}, `{quote}`: {message}")
}

/// The table that has a key of this name, such as `[robot.limits]`.
fn table_of<T: Default + Serialize>(key: &str) -> Option<String> {
    let defaults = Table::try_from(T::default()).ok()?;
    find(&defaults, key, "")
}

/// The path of the nested table that has a key.
fn find(table: &Table, key: &str, path: &str) -> Option<String> {
    if table.contains_key(key) && !path.is_empty() {
        return Some(format!("[{path}]"));
    }
    table.iter().find_map(|(name, value)| {
        let path = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
        find(value.as_table()?, key, &path)
    })
}

/// Replaces the values that a table of changes has, also in nested tables.
pub(crate) fn merge_tables(table: &mut Table, changes: Table) {
    for (name, value) in changes {
        match (table.get_mut(&name), value) {
            (Some(Value::Table(inner)), Value::Table(changes))
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
#[must_use]
pub fn is_other_variant(old: &Table, new: &Table) -> bool {
    old.len() == 1 && new.len() == 1 && old.keys().ne(new.keys())
}

/// Returns a message on one line without Rust type names. For an unknown key or value it suggests the closest known one.
/// `table_of` names the table of a key that exists elsewhere.
#[must_use]
pub fn plain_message(message: &str, table_of: impl Fn(&str) -> Option<String>) -> String {
    // A quoted key may contain line breaks.
    let message = in_one_line(message);
    let plain = without_rust_types(&message);
    match suggestion(&message, table_of) {
        Some(suggestion) => format!("{plain}: {suggestion}"),
        None => plain,
    }
}

fn suggestion(message: &str, table_of: impl Fn(&str) -> Option<String>) -> Option<String> {
    if !message.starts_with("unknown ") {
        return None;
    }
    let mut quoted = message.split('`').skip(1).step_by(2);
    let given = quoted.next()?;
    if let Some((_, now)) = renamed_keys().find(|(old, _)| *old == given) {
        return Some(format!("`{given}` is now `{now}`"));
    }
    if given == MAX_POINTS.0 && quoted.clone().any(|known| known == "min_points") {
        return Some(MAX_POINTS.1.to_owned());
    }
    if let Some(table) = table_of(given) {
        return Some(format!("`{given}` belongs in {table}"));
    }
    let known = closest_name(given, quoted)?;
    Some(format!("did you mean `{known}`?"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimal_comma_is_named() {
        let error = |text: &str| Config::default().with_changes(text).expect_err(text).to_string();
        assert!(
            error("local.sim_time_s = 3,0").ends_with("write a number with a point, such as 0.5")
        );
        assert!(!error("local.sim_time_s = 3 0").contains("point"));
    }

    #[test]
    fn unreadable_key_is_named_with_its_tables() {
        let error = |text: &str| {
            let changes = text.parse().expect("TOML");
            merged(&changes, &Config::default(), Config::validate).expect_err(text)
        };
        let key = |text| error(text).key_path();
        let text = "local.sim_time_s = 2.0\nlocal.weights.path = \"x\"\nrobot.limits = []\n";
        assert_eq!(key(text).as_deref(), Some("local.weights.path"));
        assert_eq!(key("robot.limits = [0.0]").as_deref(), Some("robot.limits"));
        assert_eq!(key("local.nothing = 1").as_deref(), Some("local.nothing"));
    }

    #[test]
    fn suggestion_names_similar_key_only() {
        let message =
            |key| format!("unknown field `{key}`, expected one of `max_vel_x`, `min_vel_x`");
        let suggested = |key| suggestion(&message(key), |_| None);
        assert_eq!(suggested("max_vel").as_deref(), Some("did you mean `max_vel_x`?"));
        assert_eq!(suggested("mxa_vel_x").as_deref(), Some("did you mean `max_vel_x`?"));
        assert_eq!(suggested("colour"), None);
        let zone = "unknown field `max_points`, expected one of `name`, `points`, `min_points`";
        let hint = "`max_points = N` of older versions of Nav2 is `min_points = N + 1`";
        assert_eq!(suggestion(zone, |_| None).as_deref(), Some(hint));
        assert_eq!(suggested("max_points"), None);
        let elsewhere = suggestion(&message("beams"), |_| Some("[lidar]".to_owned()));
        assert_eq!(elsewhere.as_deref(), Some("`beams` belongs in [lidar]"));
    }

    #[test]
    fn plain_message_replaces_type_names() {
        let plain = plain_message("invalid type: string `u32`, expected u32", |_| None);
        assert_eq!(plain, "invalid type: string `u32`, expected a whole number, at least 0");
    }
}
