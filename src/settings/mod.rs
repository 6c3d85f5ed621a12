//! Settings that are declared once: default, unit, range and meaning of a key stand together.
//!
//! The macro `settings!` turns a declaration into the struct with its documentation, its `Default`, the check of its ranges, and
//! the table from which the commented TOML and the JSON Schema are written. Rules between keys are code of the module.

mod choices;
#[cfg(feature = "sim")]
mod document;
#[cfg(feature = "sim")]
mod key_place;
mod opaque_debug;
#[cfg(feature = "sim")]
mod tables;
mod words;

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::Serialize;
use serde_json::{Map, Value, json};

pub use choices::choices;
#[cfg(feature = "sim")]
pub(crate) use choices::parse_choice;
#[cfg(feature = "sim")]
pub use document::KeyDescription;
#[cfg(feature = "sim")]
pub(crate) use document::{commented_toml, keys, schema};
#[cfg(feature = "sim")]
#[doc(hidden)]
pub use key_place::{KeyError, line_in_json, line_in_toml};
pub(crate) use opaque_debug::opaque_debug;
#[cfg(feature = "sim")]
pub(crate) use tables::read_table;
#[cfg(feature = "sim")]
#[doc(hidden)]
pub use tables::{read_json, read_toml};
pub(crate) use words::words;

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
        Self { min, is_min_open, max, is_max_open, text }
    }

    /// Whether a value is permitted.
    #[must_use]
    pub fn contains(&self, value: f64) -> bool {
        let is_above = if self.is_min_open { value > self.min } else { value >= self.min };
        let is_below = if self.is_max_open { value < self.max } else { value <= self.max };
        value.is_finite() && is_above && is_below
    }

    /// The schema of a number with the bounds of the range.
    pub(crate) fn schema(&self, mut number: Value) -> Value {
        let mut set = |bound: f64, is_open: bool, [closed, open]: [&str; 2]| {
            if bound.is_finite() {
                number[if is_open { open } else { closed }] = bound.into();
            }
        };
        set(self.min, self.is_min_open, ["minimum", "exclusiveMinimum"]);
        set(self.max, self.is_max_open, ["maximum", "exclusiveMaximum"]);
        number
    }
}

/// A number out of its range.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "{}{name} is {}: it must be {expected}{}",
    in_brackets(table),
    compact(*value),
    bound.map_or_else(String::new, |bound| format!(", {}", compact(bound)))
)]
#[non_exhaustive]
pub struct SettingError {
    /// Path of the table from the settings that were checked; empty for a key of their own.
    pub table: String,
    /// The key.
    pub name: &'static str,
    /// The value.
    pub value: f64,
    /// The permitted range in words.
    pub expected: &'static str,
    /// The bound by the other settings, where that is a number.
    pub bound: Option<f64>,
}

impl SettingError {
    pub(crate) const fn new(name: &'static str, value: f64, expected: &'static str) -> Self {
        Self { table: String::new(), name, value, expected, bound: None }
    }

    /// The same error with the bound that other settings give.
    #[cfg(feature = "sim")]
    pub(crate) const fn with_bound(mut self, bound: f64) -> Self {
        self.bound = Some(bound);
        self
    }

    /// The same error, seen from the table that has the checked one as its key.
    #[doc(hidden)]
    #[must_use]
    pub fn in_table(mut self, key: &str) -> Self {
        let separator = if self.table.is_empty() { "" } else { "." };
        self.table = [key, separator, &self.table].concat();
        self
    }
}

/// Formats a number; from 1e9, and below 1e-9, in exponential notation.
pub(crate) fn compact(value: f64) -> String {
    let size = value.abs();
    let is_long = value.is_finite() && (size >= 1e9 || size > 0.0 && size < 1e-9);
    if is_long { format!("{value:e}") } else { value.to_string() }
}

fn in_brackets(table: &str) -> String {
    if table.is_empty() { String::new() } else { format!("[{table}] ") }
}

/// Checks a rule between settings.
pub(crate) const fn require(
    is_valid: bool,
    name: &'static str,
    value: f64,
    expected: &'static str,
) -> Result<(), SettingError> {
    if is_valid { Ok(()) } else { Err(SettingError::new(name, value, expected)) }
}

/// One key of a settings struct.
#[doc(hidden)]
pub struct Field {
    pub name: &'static str,
    pub doc: &'static str,
    pub unit: &'static str,
    pub range: Option<Range>,
    /// The keys of the table, for a key that is a table of settings.
    pub fields: &'static [Field],
    pub schema: fn() -> Value,
}

/// A type of settings.
#[doc(hidden)]
pub trait Setting {
    /// The keys, for a table of settings.
    const FIELDS: &'static [Field] = &[];

    /// JSON Schema of the type without unit, range and default.
    fn schema() -> Value;

    /// Checks the numbers of a table and of its tables, and the rules between keys.
    fn check_table(&self) -> Result<(), SettingError> {
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

/// A range of values: the least and the largest.
impl Setting for [f64; 2] {
    fn schema() -> Value {
        json!({ "type": "array", "minItems": 2, "maxItems": 2, "items": f64::schema() })
    }

    fn check(&self, name: &'static str, range: &Range) -> Result<(), SettingError> {
        let [least, largest] = *self;
        least.check(name, range)?;
        largest.check(name, range)?;
        require(least <= largest, name, largest, "at least the first of the two values")
    }
}

impl<T: Setting> Setting for Vec<T> {
    const FIELDS: &'static [Field] = T::FIELDS;

    fn schema() -> Value {
        json!({ "type": "array", "items": T::schema() })
    }

    fn check_table(&self) -> Result<(), SettingError> {
        self.iter().enumerate().try_for_each(|(index, value)| {
            value.check_table().map_err(|error| error.in_table(&index.to_string()))
        })
    }
}

impl<T: Setting> Setting for BTreeMap<String, T> {
    fn schema() -> Value {
        json!({ "type": "object", "additionalProperties": T::schema() })
    }

    fn check_table(&self) -> Result<(), SettingError> {
        self.iter()
            .try_for_each(|(key, value)| value.check_table().map_err(|error| error.in_table(key)))
    }
}

impl<T: Setting> Setting for Option<T> {
    fn schema() -> Value {
        T::schema()
    }

    fn check_table(&self) -> Result<(), SettingError> {
        self.as_ref().map_or(Ok(()), Setting::check_table)
    }

    fn check(&self, name: &'static str, range: &Range) -> Result<(), SettingError> {
        self.as_ref().map_or(Ok(()), |value| value.check(name, range))
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
}

/// A range as it is declared: `above 0`, `at_least 0`, `below 0`, `at_most 0`, `finite`, `0 to 1`, `0 to below 1`, `above 0 to 1`, `above 0 to pi`, or `above 0 to tau`.
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
    (at_most 0) => {
        $crate::settings::range!(@ f64::NEG_INFINITY, true, 0.0, "finite and at most zero")
    };
    (0 to below $max:literal) => {
        $crate::settings::Range::new(
            (0.0, false),
            ($max as f64, true),
            concat!("at least zero and below ", $max),
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
/// Each key has a comment, a default, and for a number its unit and its [`range`]. The heading of a
/// file and a rule between keys follow the struct. A method with the name of a key sets it, so that
/// other crates write `LocalSettings::default().vx_samples(15)`: the struct can then get more keys.
macro_rules! settings {
    (
        $(#[$about:meta])*
        pub struct $name:ident {
            $(
                $(#[doc = $doc:literal])+
                pub $key:ident: $kind:ty = $default:expr $(, [$unit:literal, $($range:tt)+])?;
            )+
        }
        $(heading $heading:literal)?
        $(rule |$this:ident| $rule:expr)?
    ) => {
        $(#[$about])*
        #[non_exhaustive]
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

        impl $name {
            /// Checks every number, also in tables of these settings, and the rules between them.
            ///
            /// # Errors
            /// Names the first number out of range.
            pub fn validate(&self) -> Result<(), $crate::settings::SettingError> {
                $crate::settings::Setting::check_table(self)
            }
        }

        $(impl $name {
            /// Returns TOML with every key, its default and a comment. Parsing it gives the default configuration.
            #[must_use]
            pub fn documented() -> String {
                $crate::settings::commented_toml($heading, &Self::default())
            }

            /// Returns every key with its default and description.
            #[must_use]
            pub fn keys() -> Vec<$crate::settings::KeyDescription> {
                $crate::settings::keys::<Self>()
            }

            /// Returns the JSON Schema (draft 2020-12) of the file.
            #[must_use]
            pub fn schema() -> serde_json::Value {
                $crate::settings::schema::<Self>($heading)
            }
        })?

        impl $name {
            $(
                $(#[doc = $doc])+
                #[must_use]
                pub fn $key(mut self, $key: $kind) -> Self {
                    self.$key = $key;
                    self
                }
            )+
        }

        impl $crate::settings::Setting for $name {
            const FIELDS: &'static [$crate::settings::Field] = &[$(
                $crate::settings::Field {
                    name: stringify!($key),
                    doc: concat!($($doc),+),
                    unit: concat!($($unit)?),
                    range: <[$crate::settings::Range]>::first(
                        &[$($crate::settings::range!($($range)+))?],
                    )
                    .copied(),
                    fields: <$kind as $crate::settings::Setting>::FIELDS,
                    schema: <$kind as $crate::settings::Setting>::schema,
                },
            )+];

            fn schema() -> serde_json::Value {
                $crate::settings::table_schema(Self::FIELDS)
            }

            fn check_table(&self) -> Result<(), $crate::settings::SettingError> {
                $($(
                    $crate::settings::Setting::check(
                        &self.$key,
                        stringify!($key),
                        &$crate::settings::range!($($range)+),
                    )?;
                )?)+
                $(
                    $crate::settings::Setting::check_table(&self.$key)
                        .map_err(|error| error.in_table(stringify!($key)))?;
                )+
                $(
                    let $this = self;
                    $rule?;
                )?
                Ok(())
            }
        }
    };
}
pub(crate) use settings;

/// JSON Schema of a table.
#[doc(hidden)]
#[must_use]
pub fn table_schema(fields: &[Field]) -> Value {
    let properties: Map<String, Value> =
        fields.iter().map(|field| (field.name.to_owned(), field_schema(field))).collect();
    json!({ "type": "object", "properties": properties, "additionalProperties": false })
}

fn field_schema(field: &Field) -> Value {
    let mut schema = (field.schema)();
    schema["description"] = description(field).into();
    match field.range {
        Some(range) => range.schema(schema),
        None => schema,
    }
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
