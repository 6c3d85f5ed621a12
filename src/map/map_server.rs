//! Maps of ROS `map_server`: an image and a YAML file that describes it.
//!
//! The interpretation follows Nav2's `map_io.cpp` (2026). A grey value g of 0..=255 has the occupancy p = 1 - g/255, or
//! g/255 with `negate`. Cells with p at or above `occupied_thresh` are 100; cells with p at or below `free_thresh` are 0.
//! Between the thresholds, a cell is unknown in mode `trinary` and round(100 (p - free) / (occupied - free)) in mode
//! `scale`; a pixel with any transparency is unknown in both. In mode `raw` the grey value is the percentage itself, and
//! unknown above 100; `negate`, thresholds and transparency are ignored. The bottom row of the image is row 0 of the
//! grid.
//!
//! Colours are converted to luma, as in current Nav2; older releases averaged the three channels. Nav2 computes p in
//! single precision, this module in double. The two may differ where p equals a threshold up to rounding.

use std::collections::BTreeMap;
use std::env;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde_json::Value;
use serde_saphyr::Spanned;
use strsim::levenshtein;

use super::image::{GreyImage, MAX_BYTES, Pixel};
use super::yaml::{self, BadYaml};
use super::{GridFrame, MAX_RESOLUTION_M, MapError, MapWarning, OccupancyGrid, UNKNOWN};
use crate::geometry::Pose;
use crate::input_file::read_regular_bytes;
use crate::suggest::closest_name;

/// Reads a map from the text of its YAML file and the image that the text names.
pub(super) fn read(
    yaml_path: &Path,
    text: &str,
    warn: &mut dyn FnMut(MapWarning),
) -> Result<OccupancyGrid, MapError> {
    let mut yaml = MapYaml::parse(text)?;
    yaml.warnings.drain(..).for_each(warn);
    let image_path = image_path(yaml_path, &yaml.image, env::home_dir().as_deref());
    let bytes = read_regular_bytes(&image_path, MAX_BYTES as u64).map_err(MapError::from);
    let image = bytes.and_then(|bytes| GreyImage::decode(&bytes));
    let image = image.map_err(|problem| MapError::InImage {
        line: yaml.image_line,
        image: image_path,
        problem: Box::new(problem),
    })?;
    grid(&yaml, &image)
}

impl OccupancyGrid {
    /// Reads a ROS `map_server` map from memory: the text of the YAML file and the bytes of its PGM, PNG or BMP image.
    /// The image path in the YAML text is required but not opened.
    ///
    /// # Errors
    /// Returns an error if the text or the image is invalid; the message names the place.
    pub fn from_map_server(yaml: &str, image: &[u8]) -> Result<Self, MapError> {
        grid(&MapYaml::parse(yaml)?, &GreyImage::decode(image)?)
    }
}

fn grid(yaml: &MapYaml, image: &GreyImage) -> Result<OccupancyGrid, MapError> {
    let frame = GridFrame::new(image.width, image.height, yaml.resolution_m, yaml.origin)?;
    let of_grey: [i8; 256] = core::array::from_fn(|grey| occupancy(yaml, grey as u8));
    let is_known = |pixel: &Pixel| pixel.opaque || yaml.mode == Mode::Raw;
    let cell = |pixel: &Pixel| {
        if is_known(pixel) { of_grey[usize::from(pixel.grey)] } else { UNKNOWN }
    };
    let cells: Vec<i8> = image.pixels.iter().map(cell).collect();
    Ok(OccupancyGrid::from_top_down(frame, &cells))
}

/// The path of an image: relative to the YAML file, unless it is absolute or in the home directory (`~/`).
fn image_path(yaml_path: &Path, image: &str, home: Option<&Path>) -> PathBuf {
    match (image.strip_prefix("~/"), home) {
        (Some(rest), Some(home)) => home.join(rest),
        _ => yaml_path.with_file_name(image),
    }
}

/// The occupancy of an opaque pixel.
fn occupancy(yaml: &MapYaml, grey: u8) -> i8 {
    let occupancy = f64::from(grey) / 255.0;
    let occupancy = if yaml.negate { occupancy } else { 1.0 - occupancy };
    let (free, occupied) = (yaml.free_thresh, yaml.occupied_thresh);
    match yaml.mode {
        Mode::Raw => i8::try_from(grey).ok().filter(|&percent| percent <= 100).unwrap_or(UNKNOWN),
        _ if occupancy >= occupied => 100,
        _ if occupancy <= free => 0,
        Mode::Trinary => UNKNOWN,
        Mode::Scale => ((occupancy - free) / (occupied - free) * 100.0).round() as i8,
    }
}

/// The validated contents of the file.
#[derive(Clone, Debug, PartialEq)]
struct MapYaml {
    /// Path of the image, as in the file.
    image: String,
    /// Line of the `image` key, from one.
    image_line: usize,
    /// Side of a pixel, metres, above zero.
    resolution_m: f64,
    /// Pose of the lower left corner of the image.
    origin: Pose,
    /// Largest occupancy of a free cell, 0..=1.
    free_thresh: f64,
    /// Smallest occupancy of an occupied cell, above `free_thresh`, at most 1.
    occupied_thresh: f64,
    /// Whether white means occupied.
    negate: bool,
    /// How grey values become occupancy.
    mode: Mode,
    /// Warnings for the author of the file.
    warnings: Vec<MapWarning>,
}

/// How grey values become occupancy.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Mode {
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
    fn parse(text: &str) -> Result<Self, MapError> {
        let file = Entries::parse(text)?;
        let [x, y, yaw] = file.get("origin", "three finite numbers, [x, y, yaw]", triple)?;
        let mut parsed = Self {
            image: file.get("image", "the path of an image", path)?,
            image_line: file.required("image")?.0,
            resolution_m: file.get(
                "resolution",
                "a finite number of metres, above zero and at most 100",
                size,
            )?,
            origin: Pose::new(x, y, yaw),
            free_thresh: file.get("free_thresh", "a number from 0 to 1", share)?,
            occupied_thresh: file.get("occupied_thresh", "a number from 0 to 1", share)?,
            negate: file.get("negate", "0, 1, true or false", flag)?,
            mode: if file.entries.contains_key("mode") {
                file.get("mode", "trinary, scale or raw", mode)?
            } else {
                Mode::Trinary
            },
            warnings: file.warnings(),
        };
        let (free_thresh, occupied_thresh) = (parsed.free_thresh, parsed.occupied_thresh);
        if parsed.mode == Mode::Scale && (free_thresh > 0.0 || occupied_thresh < 1.0) {
            parsed.warnings.push(MapWarning::ClippedScale { free_thresh, occupied_thresh });
        }
        if parsed.mode == Mode::Raw || parsed.free_thresh < parsed.occupied_thresh {
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
        let bad = |BadYaml { line, reason }| MapError::BadYaml { line, reason };
        Ok(Self { entries: yaml::parse(text, MAX_NODES).map_err(bad)? })
    }

    /// Warnings for unknown keys that resemble a known one, in the order of their lines.
    fn warnings(&self) -> Vec<MapWarning> {
        let misspelled = |(found, entry): (&String, &Spanned<Value>)| {
            let is_unknown = !KEYS.contains(&found.as_str());
            let suggestion = closest_name(found, KEYS).filter(|_| is_unknown)?;
            let line = entry.referenced.line() as usize;
            let found = found.clone();
            Some((line, MapWarning::MisspelledKey { line, found, suggestion }))
        };
        let mut warnings: Vec<(usize, MapWarning)> =
            self.entries.iter().filter_map(misspelled).collect();
        warnings.sort_by_key(|(line, _)| *line);
        warnings.into_iter().map(|(_, warning)| warning).collect()
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

fn size(value: &Value) -> Option<f64> {
    number(value).filter(|&metres| metres > 0.0 && metres <= MAX_RESOLUTION_M)
}

fn share(value: &Value) -> Option<f64> {
    number(value).filter(|number| (0.0..=1.0).contains(number))
}

fn triple(value: &Value) -> Option<[f64; 3]> {
    let numbers: Option<Vec<f64>> = value.as_array()?.iter().map(number).collect();
    numbers?.try_into().ok()
}

fn flag(value: &Value) -> Option<bool> {
    match value {
        Value::Bool(flag) => Some(*flag),
        Value::Number(number) => match number.as_i64()? {
            0 => Some(false),
            1 => Some(true),
            _ => None,
        },
        _ => None,
    }
}

fn mode(value: &Value) -> Option<Mode> {
    let name = value.as_str()?.to_ascii_lowercase();
    serde_json::from_value(name.into()).ok()
}

/// A value as text for a message: one line, shortened.
fn shown(value: &Value) -> String {
    let text = value.to_string();
    match text.char_indices().nth(60) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn image_path_is_relative_to_the_yaml_file_or_the_home_directory() {
        let resolved =
            |image| image_path(Path::new("maps/mine.yaml"), image, Some(Path::new("/home/me")));
        assert_eq!(resolved("mine.png"), Path::new("maps/mine.png"));
        assert_eq!(resolved("scans/mine.png"), Path::new("maps/scans/mine.png"));
        assert_eq!(resolved("/data/mine.png"), Path::new("/data/mine.png"));
        assert_eq!(resolved("~/mine.png"), Path::new("/home/me/mine.png"));
        let without_home = image_path(Path::new("maps/mine.yaml"), "~/mine.png", None);
        assert_eq!(without_home, Path::new("maps/~/mine.png"));
    }
}
