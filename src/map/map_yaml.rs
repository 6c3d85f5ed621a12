//! The YAML file that says what the pixels of a ROS map image mean.

use std::collections::BTreeMap;

use serde_json::Value;
use serde_saphyr::Spanned;
use strsim::levenshtein;

use super::yaml::{self, BadYaml};
use super::{MapError, MapWarning};
use crate::geometry::Pose;
use crate::suggest::closest_name;

/// The contents of the file, checked.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MapYaml {
    /// Path of the image, as written.
    pub image: String,
    /// Line of that path, from one.
    pub image_line: usize,
    /// Side of a pixel, metres, above zero.
    pub resolution_m: f64,
    /// Pose of the lower left corner of the image.
    pub origin: Pose,
    /// Occupancy up to which a cell is free, 0..=1.
    pub free_thresh: f64,
    /// Occupancy from which a cell is occupied, above `free_thresh`, at most 1.
    pub occupied_thresh: f64,
    /// Whether white is occupied rather than black.
    pub negate: bool,
    /// How grey becomes occupancy.
    pub mode: Mode,
    /// What somebody should know who wrote it.
    pub notes: Vec<MapWarning>,
}

/// How grey becomes occupancy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mode {
    /// Free, occupied or unknown.
    Trinary,
    /// Percent between the thresholds.
    Scale,
    /// The pixel's value is the percentage.
    Raw,
}

/// Most nodes a file may unfold to: a map's has about twenty, and aliases can make a few lines into billions.
const MAX_NODES: usize = 10_000;

/// All keys that have a meaning.
const KEYS: [&str; 7] = [
    "image",
    "resolution",
    "origin",
    "negate",
    "occupied_thresh",
    "free_thresh",
    "mode",
];

impl MapYaml {
    /// Reads the text of a YAML file. Keys without a meaning are passed over, as Nav2 does, for other tools have theirs in
    /// the same file; one that is spelled almost like one with a meaning is noted.
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
                number(value).filter(|&share| unit(share))
            })?,
            occupied_thresh: file.get("occupied_thresh", "a number from 0 to 1", |value| {
                number(value).filter(|&share| unit(share))
            })?,
            negate: file.get("negate", "0, 1, true or false", flag)?,
            mode: if file.entries.contains_key("mode") {
                file.get("mode", "trinary, scale or raw", mode)?
            } else {
                Mode::Trinary
            },
            notes: file.notes(),
        };
        if parsed.free_thresh < parsed.occupied_thresh {
            Ok(parsed)
        } else {
            file.get("free_thresh", "below `occupied_thresh`", |_| None)
        }
    }
}

/// The top level of the file.
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

    /// Keys without a meaning that may be one mistyped, in the order of their lines.
    fn notes(&self) -> Vec<MapWarning> {
        let note = |(found, entry): (&String, &Spanned<Value>)| {
            let stranger = !KEYS.contains(&found.as_str());
            let meant = closest_name(found, KEYS).filter(|_| stranger)?;
            Some(MapWarning::MisspelledKey {
                line: entry.referenced.line() as usize,
                found: found.clone(),
                meant,
            })
        };
        let mut notes: Vec<MapWarning> = self.entries.iter().filter_map(note).collect();
        notes.sort_by_key(|MapWarning::MisspelledKey { line, .. }| *line);
        notes
    }

    /// Line and value of a key.
    fn required(&self, key: &'static str) -> Result<(usize, &Value), MapError> {
        match self.entries.get(key) {
            Some(entry) => Ok((entry.referenced.line() as usize, &entry.value)),
            None => Err(MapError::MissingKey {
                key,
                found: self.like(key),
            }),
        }
    }

    /// The value of a key, as something else.
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

    /// Line and name of the key without a meaning that is spelled most like this one, if any is.
    fn like(&self, key: &str) -> Option<(usize, String)> {
        let strangers = self
            .entries
            .iter()
            .filter(|(found, _)| !KEYS.contains(&found.as_str()));
        strangers
            .map(|(found, entry)| {
                (
                    levenshtein(found, key),
                    entry.referenced.line() as usize,
                    found,
                )
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

/// A finite number; one in quotes will do.
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

/// A value as it may stand in a message: one line, not long.
fn shown(value: &Value) -> String {
    let text = value.to_string();
    match text.char_indices().nth(60) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text,
    }
}
