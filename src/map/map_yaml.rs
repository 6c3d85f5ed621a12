//! The YAML file of a ROS map: scale, origin and the meaning of the image's pixels.

use std::collections::BTreeMap;

use serde_json::Value;
use serde_saphyr::Spanned;
use strsim::levenshtein;

use super::yaml::{self, BadYaml};
use super::{MapError, MapWarning};
use crate::geometry::Pose;
use crate::suggest::closest_name;

/// The validated contents of the file.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MapYaml {
    /// Path of the image, as in the file.
    pub image: String,
    /// Line of the `image` key, from one.
    pub image_line: usize,
    /// Side of a pixel, metres, above zero.
    pub resolution_m: f64,
    /// Pose of the lower left corner of the image.
    pub origin: Pose,
    /// Largest occupancy of a free cell, 0..=1.
    pub free_thresh: f64,
    /// Smallest occupancy of an occupied cell, above `free_thresh`, at most 1.
    pub occupied_thresh: f64,
    /// Whether white means occupied.
    pub negate: bool,
    /// How grey values become occupancy.
    pub mode: Mode,
    /// Warnings for the author of the file.
    pub warnings: Vec<MapWarning>,
}

/// How grey values become occupancy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mode {
    /// Free, occupied or unknown.
    Trinary,
    /// Percentage between the thresholds.
    Scale,
    /// The grey value is the percentage.
    Raw,
}

/// Largest number of nodes after alias expansion. A map file has about twenty; aliases can expand a few lines to billions.
const MAX_NODES: usize = 10_000;

/// All known keys.
const KEYS: [&str; 7] =
    ["image", "resolution", "origin", "negate", "occupied_thresh", "free_thresh", "mode"];

impl MapYaml {
    /// Parses a YAML file. Unknown keys are ignored, as in Nav2, since other tools store theirs in the same file; a key
    /// that resembles a known one gives a warning.
    pub(super) fn parse(text: &str) -> Result<Self, MapError> {
        let file = Entries::parse(text)?;
        let unit = |number: f64| (0.0..=1.0).contains(&number);
        let [x, y, yaw] = file.get("origin", "three finite numbers, [x, y, yaw]", triple)?;
        let parsed = Self {
            image: file.get("image", "the path of an image", path)?,
            image_line: file.required("image")?.0,
            resolution_m: file.get(
                "resolution",
                "a finite number of metres above zero",
                |value| number(value).filter(|&metres| metres > 0.0),
            )?,
            origin: Pose::new(x, y, yaw),
            free_thresh: file.get("free_thresh", "a number from 0 to 1", |value| {
                number(value).filter(|&occupancy| unit(occupancy))
            })?,
            occupied_thresh: file.get("occupied_thresh", "a number from 0 to 1", |value| {
                number(value).filter(|&occupancy| unit(occupancy))
            })?,
            negate: file.get("negate", "0, 1, true or false", flag)?,
            mode: if file.entries.contains_key("mode") {
                file.get("mode", "trinary, scale or raw", mode)?
            } else {
                Mode::Trinary
            },
            warnings: file.warnings(),
        };
        if parsed.free_thresh < parsed.occupied_thresh {
            Ok(parsed)
        } else {
            file.get("free_thresh", "below `occupied_thresh`", |_| None)
        }
    }
}

/// The top-level mapping of the file.
struct Entries {
    entries: BTreeMap<String, Spanned<Value>>,
}

impl Entries {
    fn parse(text: &str) -> Result<Self, MapError> {
        match yaml::parse(text, MAX_NODES) {
            Ok(entries) => Ok(Self { entries }),
            Err(BadYaml { line, reason }) => Err(MapError::BadYaml { line, reason }),
        }
    }

    /// Warnings for unknown keys that resemble a known one, in the order of their lines.
    fn warnings(&self) -> Vec<MapWarning> {
        let warning = |(found, entry): (&String, &Spanned<Value>)| {
            let is_unknown = !KEYS.contains(&found.as_str());
            let suggestion = closest_name(found, KEYS).filter(|_| is_unknown)?;
            Some(MapWarning::MisspelledKey {
                line: entry.referenced.line() as usize,
                found: found.clone(),
                suggestion,
            })
        };
        let mut warnings: Vec<MapWarning> = self.entries.iter().filter_map(warning).collect();
        warnings.sort_by_key(|MapWarning::MisspelledKey { line, .. }| *line);
        warnings
    }

    /// Line and value of a required key.
    fn required(&self, key: &'static str) -> Result<(usize, &Value), MapError> {
        match self.entries.get(key) {
            Some(entry) => Ok((entry.referenced.line() as usize, &entry.value)),
            None => Err(MapError::MissingKey { key, found: self.misspelling_of(key) }),
        }
    }

    /// The converted value of a required key.
    fn get<T>(
        &self,
        key: &'static str,
        expected: &'static str,
        convert: impl Fn(&Value) -> Option<T>,
    ) -> Result<T, MapError> {
        let (line, value) = self.required(key)?;
        convert(value).ok_or_else(|| MapError::BadValue {
            line,
            key,
            value: shown(value),
            expected,
        })
    }

    /// Line and name of the unknown key most similar to this one, if any is similar.
    fn misspelling_of(&self, key: &str) -> Option<(usize, String)> {
        let unknown = self.entries.iter().filter(|(found, _)| !KEYS.contains(&found.as_str()));
        unknown
            .map(|(found, entry)| {
                (levenshtein(found, key), entry.referenced.line() as usize, found)
            })
            .filter(|(edits, ..)| 2 * edits <= key.len())
            .min()
            .map(|(_, line, found)| (line, found.clone()))
    }
}

fn path(value: &Value) -> Option<String> {
    let path = value.as_str().filter(|path| !path.is_empty());
    path.map(str::to_owned)
}

/// A finite number, which may be quoted.
fn number(value: &Value) -> Option<f64> {
    let number = match value {
        Value::String(text) => text.parse().ok(),
        value => value.as_f64(),
    };
    number.filter(|number: &f64| number.is_finite())
}

fn triple(value: &Value) -> Option<[f64; 3]> {
    let numbers: Option<Vec<f64>> = value.as_array()?.iter().map(number).collect();
    numbers?.try_into().ok()
}

fn flag(value: &Value) -> Option<bool> {
    match value {
        Value::Bool(flag) => Some(*flag),
        Value::Number(number) => number.as_i64().map(|number| number != 0),
        _ => None,
    }
}

fn mode(value: &Value) -> Option<Mode> {
    match value.as_str()?.to_ascii_lowercase().as_str() {
        "trinary" => Some(Mode::Trinary),
        "scale" => Some(Mode::Scale),
        "raw" => Some(Mode::Raw),
        _ => None,
    }
}

/// A value as text for a message: one line, shortened.
fn shown(value: &Value) -> String {
    let text = value.to_string();
    match text.char_indices().nth(60) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text,
    }
}
