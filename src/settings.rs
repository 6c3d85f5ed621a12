//! Settings that are declared once: default, unit, range and meaning of a key stand together.
//!
//! The macro `settings!` turns a declaration into the struct with its documentation, its `Default`, the check of its ranges, and
//! the table from which the commented TOML and the JSON Schema are written. Rules between keys are code of the module.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::Serialize;
use serde::de::{self, DeserializeOwned, Visitor};
use serde_json::{Map, Value, json};

/// Longest line of a comment, characters.
const WIDTH: usize = 118;

/// Text before the example of a key without a default.
const EXAMPLE: &str = "such as ";

/// Permitted values of a number. A number has to be finite in any case.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Range {
    /// Lower bound; minus infinity for none.
    pub min: f64,
    /// Whether the lower bound itself is outside.
    pub is_min_open: bool,
    /// Upper bound; infinity for none.
    pub max: f64,
    /// Whether the upper bound itself is outside.
    pub is_max_open: bool,
    /// The range in words.
    pub text: &'static str,
}

impl Range {
    pub(crate) const fn new(
        (min, is_min_open): (f64, bool),
        (max, is_max_open): (f64, bool),
        text: &'static str,
    ) -> Self {
        Self {
            min,
            is_min_open,
            max,
            is_max_open,
            text,
        }
    }

    /// Whether a value is permitted.
    #[must_use]
    pub fn contains(&self, value: f64) -> bool {
        let is_above = if self.is_min_open {
            value > self.min
        } else {
            value >= self.min
        };
        let is_below = if self.is_max_open {
            value < self.max
        } else {
            value <= self.max
        };
        value.is_finite() && is_above && is_below
    }
}

/// A number out of its range.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{name} is {value}: it must be {expected}")]
#[non_exhaustive]
pub struct SettingError {
    /// The key.
    pub name: &'static str,
    /// The value.
    pub value: f64,
    /// The permitted range in words.
    pub expected: &'static str,
}

impl SettingError {
    pub(crate) const fn new(name: &'static str, value: f64, expected: &'static str) -> Self {
        Self {
            name,
            value,
            expected,
        }
    }
}

/// Checks a rule between settings.
pub(crate) const fn require(
    is_valid: bool,
    name: &'static str,
    value: f64,
    expected: &'static str,
) -> Result<(), SettingError> {
    if is_valid {
        Ok(())
    } else {
        Err(SettingError::new(name, value, expected))
    }
}

/// One key of a settings struct.
pub(crate) struct Field {
    pub name: &'static str,
    pub doc: &'static str,
    pub unit: &'static str,
    pub range: Option<Range>,
    /// The keys of the table, for a key that is a table of settings.
    pub fields: &'static [Field],
    pub schema: fn() -> Value,
}

/// A type of which settings are made.
pub(crate) trait Setting {
    /// The keys, for a table of settings.
    const FIELDS: &'static [Field] = &[];

    /// JSON Schema of the type without unit, range and default.
    fn schema() -> Value;

    /// Checks the range of each number of a table, not those of its tables.
    fn check_ranges(&self) -> Result<(), SettingError> {
        Ok(())
    }

    /// Checks the numbers of one key.
    fn check(&self, _name: &'static str, _range: &Range) -> Result<(), SettingError> {
        Ok(())
    }
}

macro_rules! numbers {
    ($kind:literal: $($type:ty)+) => {$(
        impl Setting for $type {
            fn schema() -> Value {
                json!({ "type": $kind })
            }

            fn check(&self, name: &'static str, range: &Range) -> Result<(), SettingError> {
                let value = *self as f64;
                if range.contains(value) {
                    return Ok(());
                }
                Err(SettingError::new(name, value, range.text))
            }
        }
    )+};
}
numbers!("number": f64);
numbers!("integer": u8 u32 u64 usize);

impl<T: Setting> Setting for Vec<T> {
    const FIELDS: &'static [Field] = T::FIELDS;

    fn schema() -> Value {
        json!({ "type": "array", "items": T::schema() })
    }
}

impl<T: Setting> Setting for BTreeMap<String, T> {
    fn schema() -> Value {
        json!({ "type": "object", "additionalProperties": T::schema() })
    }
}

impl<T: Setting> Setting for Option<T> {
    fn schema() -> Value {
        T::schema()
    }

    fn check(&self, name: &'static str, range: &Range) -> Result<(), SettingError> {
        self.as_ref()
            .map_or(Ok(()), |value| value.check(name, range))
    }
}

/// Implements [`Setting`] for types with a fixed schema.
macro_rules! setting_schema {
    ($($type:ty: $schema:expr;)+) => {$(
        impl $crate::settings::Setting for $type {
            fn schema() -> serde_json::Value {
                $schema
            }
        }
    )+};
}
pub(crate) use setting_schema;

setting_schema! {
    bool: json!({ "type": "boolean" });
    String: json!({ "type": "string" });
    PathBuf: json!({ "type": "string" });
    toml::Table: json!({ "type": "object" });
}

/// JSON Schema of an enum of plain words. The words are those that serde reads.
pub(crate) fn choices<T: DeserializeOwned>() -> Value {
    json!({ "enum": T::deserialize(Variants).err().map_or(&[][..], |Words(words)| words) })
}

/// A deserializer that reads nothing and returns the words of an enum as its error.
struct Variants;

#[derive(Debug)]
struct Words(&'static [&'static str]);

impl core::fmt::Display for Words {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{:?}", self.0)
    }
}

impl core::error::Error for Words {}

impl de::Error for Words {
    fn custom<M: core::fmt::Display>(_: M) -> Self {
        Self(&[])
    }
}

impl<'de> de::Deserializer<'de> for Variants {
    type Error = Words;

    fn deserialize_any<V: Visitor<'de>>(self, _: V) -> Result<V::Value, Words> {
        Err(Words(&[]))
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        words: &'static [&'static str],
        _: V,
    ) -> Result<V::Value, Words> {
        Err(Words(words))
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf option unit unit_struct
        newtype_struct seq tuple tuple_struct map struct identifier ignored_any
    }
}

/// A range as it is declared: `above 0`, `at_least 0`, `below 0`, `finite`, `0 to 1`, `above 0 to 1`, `above 0 to pi`, or `above 0 to tau`.
macro_rules! range {
    (finite) => {
        $crate::settings::range!(@ f64::NEG_INFINITY, true, f64::INFINITY, "finite")
    };
    (above 0) => {
        $crate::settings::range!(@ 0.0, true, f64::INFINITY, "finite and above zero")
    };
    (above $min:literal) => {
        $crate::settings::range!(@ $min, true, f64::INFINITY, concat!("finite and above ", $min))
    };
    (above 0 to pi) => {
        $crate::settings::range!(@ 0.0, true, core::f64::consts::PI, "above zero and at most pi")
    };
    (above 0 to tau) => {
        $crate::settings::range!(@ 0.0, true, core::f64::consts::TAU, "above zero and at most 2 pi")
    };
    (above 0 to $max:literal) => {
        $crate::settings::range!(@ 0.0, true, $max as f64, concat!("above zero and at most ", $max))
    };
    (at_least 0) => {
        $crate::settings::range!(@ 0.0, false, f64::INFINITY, "finite and at least zero")
    };
    (at_least $min:literal) => {
        $crate::settings::range!(@ $min as f64, false, f64::INFINITY, concat!("at least ", $min))
    };
    (below 0) => {
        $crate::settings::Range::new(
            (f64::NEG_INFINITY, true),
            (0.0, true),
            "finite and below zero",
        )
    };
    ($min:literal to $max:literal) => {
        $crate::settings::range!(@ $min as f64, false, $max as f64, concat!($min, " to ", $max))
    };
    (@ $min:expr, $is_open:literal, $max:expr, $text:expr) => {
        $crate::settings::Range::new(($min, $is_open), ($max, false), $text)
    };
}
pub(crate) use range;

/// Declares a struct of settings.
///
/// Each key has a comment, a default, and for a number its unit and its [`range`].
macro_rules! settings {
    (
        $(#[$about:meta])*
        pub struct $name:ident {
            $(
                $(#[doc = $doc:literal])+
                pub $key:ident: $kind:ty = $default:expr $(, [$unit:literal, $($range:tt)+])?;
            )+
        }
    ) => {
        $(#[$about])*
        pub struct $name {
            $(
                $(#[doc = $doc])+
                $(#[doc = concat!("\n\nUnit and range: `", $unit, "`, `", stringify!($($range)+), "`.")])?
                pub $key: $kind,
            )+
        }

        impl Default for $name {
            fn default() -> Self {
                Self {
                    $($key: $default,)+
                }
            }
        }

        impl $crate::settings::Setting for $name {
            const FIELDS: &'static [$crate::settings::Field] = &[$(
                $crate::settings::Field {
                    name: stringify!($key),
                    doc: concat!($($doc),+),
                    unit: concat!($($unit)?),
                    range: {
                        let range: Option<$crate::settings::Range> = None;
                        $(
                            let _ = range;
                            let range = Some($crate::settings::range!($($range)+));
                        )?
                        range
                    },
                    fields: <$kind as $crate::settings::Setting>::FIELDS,
                    schema: <$kind as $crate::settings::Setting>::schema,
                },
            )+];

            fn schema() -> serde_json::Value {
                $crate::settings::table_schema(Self::FIELDS)
            }

            fn check_ranges(&self) -> Result<(), $crate::settings::SettingError> {
                $($(
                    $crate::settings::Setting::check(
                        &self.$key,
                        stringify!($key),
                        &$crate::settings::range!($($range)+),
                    )?;
                )?)+
                Ok(())
            }
        }
    };
}
pub(crate) use settings;

/// JSON Schema of a table.
pub(crate) fn table_schema(fields: &[Field]) -> Value {
    let properties: Map<String, Value> = fields
        .iter()
        .map(|field| (field.name.to_owned(), field_schema(field)))
        .collect();
    json!({ "type": "object", "properties": properties, "additionalProperties": false })
}

fn field_schema(field: &Field) -> Value {
    let mut schema = (field.schema)();
    schema["description"] = description(field).into();
    if let Some(range) = field.range {
        let mut set = |bound: f64, is_open: bool, [closed, open]: [&str; 2]| {
            if bound.is_finite() {
                schema[if is_open { open } else { closed }] = bound.into();
            }
        };
        set(
            range.min,
            range.is_min_open,
            ["minimum", "exclusiveMinimum"],
        );
        set(
            range.max,
            range.is_max_open,
            ["maximum", "exclusiveMaximum"],
        );
    }
    schema
}

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
    let Some(properties) = schema.get_mut("properties").and_then(Value::as_object_mut) else {
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

/// Text of a key: its meaning, and for a number its unit and range.
fn description(field: &Field) -> String {
    let mut text = field.doc.trim().to_owned();
    if !field.unit.is_empty() {
        text += &[" Unit: ", field.unit, "."].concat();
    }
    if let Some(range) = field.range {
        text += &[" Range: ", range.text, "."].concat();
    }
    text
}

/// TOML of a configuration with every key, its default and a comment. A key without a default is commented out, with the
/// example of its text.
pub(crate) fn commented_toml<T: Setting + Default + Serialize>(heading: &str) -> String {
    let defaults = toml::Table::try_from(T::default()).unwrap_or_default();
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
    if path.is_empty() {
        key.to_owned()
    } else {
        format!("{path}.{key}")
    }
}

fn example(description: &str) -> &str {
    let after = description
        .split_once(EXAMPLE)
        .map_or("", |(_, after)| after);
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
