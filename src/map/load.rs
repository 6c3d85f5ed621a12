//! Read a map file of any of the three kinds.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use super::{MAX_GRID_CELLS, MapError, MapWarning, OccupancyGrid, map_server, movingai};

/// What a map file may leave unsaid.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadOptions {
    /// Side of a cell of a `.map` or text map, metres. A YAML file states its own.
    pub resolution_m: f64,
}

impl Default for LoadOptions {
    fn default() -> Self {
        Self { resolution_m: 1.0 }
    }
}

/// Longest YAML file read, bytes.
const MAX_YAML_BYTES: u64 = 1 << 20;

/// Longest file of one character a cell, bytes: every row of a grid of one column has a line end of two.
const MAX_ROWS_BYTES: u64 = 3 * MAX_GRID_CELLS as u64;

/// Reads a map: `.yaml` or `.yml` of ROS `map_server` with its image; `.map`, or any file that begins with the line
/// `type octile`, of `MovingAI`; anything else as rows of text (see [`OccupancyGrid::from_rows`]).
///
/// Maps of the last two kinds have their lower left corner at the origin of the map frame.
///
/// # Errors
/// When the file cannot be read or does not follow its format; the message names the file and the place.
pub fn load(path: &Path, options: &LoadOptions) -> Result<OccupancyGrid, MapError> {
    load_with_warnings(path, options, &mut |_| {})
}

/// The same, and tells what in the file is no error and may not be meant.
///
/// # Errors
/// As [`load`].
pub fn load_with_warnings(
    path: &Path,
    options: &LoadOptions,
    note: &mut dyn FnMut(MapWarning),
) -> Result<OccupancyGrid, MapError> {
    read(path, options, note).map_err(|problem| problem.in_file(path))
}

fn read(
    path: &Path,
    options: &LoadOptions,
    note: &mut dyn FnMut(MapWarning),
) -> Result<OccupancyGrid, MapError> {
    let extension = path.extension().unwrap_or_default().to_string_lossy();
    match extension.to_ascii_lowercase().as_str() {
        "yaml" | "yml" => map_server::read(path, &read_text(path, MAX_YAML_BYTES)?, note),
        "pgm" | "png" | "bmp" => Err(MapError::BareImage),
        extension => {
            let text = read_text(path, MAX_ROWS_BYTES)?;
            if extension == "map" || movingai::begins(&text) {
                OccupancyGrid::from_movingai(&text, options.resolution_m)
            } else {
                OccupancyGrid::from_text(&text, options.resolution_m)
            }
        }
    }
}

/// The text of a file of at most so many bytes, without a byte order mark.
pub(super) fn read_text(path: &Path, limit: u64) -> Result<String, MapError> {
    let unreadable = |error: std::io::Error| MapError::Unreadable {
        reason: error.to_string(),
    };
    let mut bytes = Vec::new();
    File::open(path)
        .and_then(|file| file.take(limit + 1).read_to_end(&mut bytes))
        .map_err(unreadable)?;
    if bytes.len() as u64 > limit {
        return Err(MapError::TooLong { limit });
    }
    let text = String::from_utf8(bytes).map_err(|error| {
        let sound = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        MapError::NotText {
            line: sound.split(|&byte| byte == b'\n').count(),
        }
    })?;
    Ok(match text.strip_prefix('\u{feff}') {
        Some(rest) => rest.to_owned(),
        None => text,
    })
}
