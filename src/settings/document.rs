//! What a declaration of settings gives to people and editors: commented TOML, a list of keys, and a JSON Schema.

use serde::Serialize;
use serde_json::Value;

use super::{Field, Range, Setting, description};

/// Longest line of a comment, characters.
const WIDTH: usize = 118;

/// Text before the example of a key without a default.
const EXAMPLE: &str = "such as ";

/// JSON Schema (draft 2020-12) of a configuration.
pub(crate) fn schema<T: Setting + Default + Serialize>(title: &str) -> Value {
    let mut schema = T::schema();
    set_defaults(&mut schema, &defaults::<T>());
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema".into();
    schema["title"] = title.into();
    schema
}

/// Enters the default of each key in a schema.
fn set_defaults(schema: &mut Value, defaults: &Value) {
    // A value of several parts, all of them required, has one default.
    let is_table = schema.get("required").is_none();
    let properties = schema.get_mut("properties").filter(|_| is_table);
    let Some(properties) = properties.and_then(Value::as_object_mut) else {
        schema["default"] = defaults.clone();
        return;
    };
    for (key, property) in properties {
        if let Some(default) = defaults.get(key).filter(|default| !default.is_null()) {
            set_defaults(property, default);
        }
    }
}

fn defaults<T: Default + Serialize>() -> Value {
    serde_json::to_value(T::default()).unwrap_or_default()
}

/// TOML of a configuration with every key, its default and a comment. A key without a default is commented out, with the
/// example of its text. A list of tables needs one in the defaults, which shows the defaults of its keys.
pub(crate) fn commented_toml<T: Setting + Serialize>(heading: &str, defaults: &T) -> String {
    let defaults = toml::Table::try_from(defaults).unwrap_or_default();
    let mut text = comment(heading);
    write_table(T::FIELDS, "", &defaults, &mut text);
    text
}

fn write_table(fields: &[Field], path: &str, defaults: &toml::Table, text: &mut String) {
    for field in fields.iter().filter(|field| field.fields.is_empty()) {
        let description = description(field);
        let line = match defaults.get(field.name) {
            Some(value) => format!("{} = {value}", field.name),
            None => format!("# {} = {}", field.name, example(&description)),
        };
        *text += &["\n", &comment(&description), &line, "\n"].concat();
    }
    for field in fields.iter().filter(|field| !field.fields.is_empty()) {
        let path = join(path, field.name);
        let (header, values) = match defaults.get(field.name) {
            Some(toml::Value::Array(tables)) => (format!("[[{path}]]"), tables.first()),
            value => (format!("[{path}]"), value),
        };
        let empty = toml::Table::new();
        let values = values.and_then(toml::Value::as_table).unwrap_or(&empty);
        *text += &["\n", &comment(field.doc), &header, "\n"].concat();
        write_table(field.fields, &path, values, text);
    }
}

/// A key of a configuration.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct KeyDescription {
    /// Path from the root, such as `robot.limits.max_vel_x`.
    pub key: String,
    /// The default; none for a key that has none.
    pub default: Option<Value>,
    /// Meaning, unit and range.
    pub description: String,
    /// Unit of a number; empty for none.
    pub unit: &'static str,
    /// Range of a number.
    pub range: Option<Range>,
}

/// Every key of a configuration in the order of the declarations, tables after plain keys.
pub(crate) fn keys<T: Setting + Default + Serialize>() -> Vec<KeyDescription> {
    let mut found = Vec::new();
    collect_keys(T::FIELDS, "", &defaults::<T>(), &mut found);
    found
}

fn collect_keys(fields: &[Field], path: &str, defaults: &Value, found: &mut Vec<KeyDescription>) {
    for field in fields.iter().filter(|field| field.fields.is_empty()) {
        let default = defaults.get(field.name);
        found.push(KeyDescription {
            key: join(path, field.name),
            default: default.filter(|default| !default.is_null()).cloned(),
            description: description(field),
            unit: field.unit,
            range: field.range,
        });
    }
    for field in fields.iter().filter(|field| !field.fields.is_empty()) {
        let values = defaults.get(field.name).unwrap_or(&Value::Null);
        collect_keys(field.fields, &join(path, field.name), values, found);
    }
}

fn join(path: &str, key: &str) -> String {
    if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") }
}

fn example(description: &str) -> &str {
    let after = description.split_once(EXAMPLE).map_or("", |(_, after)| after);
    let word = after.split_whitespace().next().unwrap_or_default();
    word.trim_end_matches([',', ';', ':', '.'])
}

fn comment(text: &str) -> String {
    let mut lines = String::new();
    let mut line = String::from("#");
    for word in text.split_whitespace() {
        if line.chars().count() + 1 + word.chars().count() > WIDTH {
            lines += &line;
            lines += "\n";
            line = String::from("#");
        }
        line += " ";
        line += word;
    }
    lines + &line + "\n"
}
