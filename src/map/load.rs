//! Loading map files of all supported formats.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use super::{MAX_GRID_CELLS, MapError, MapWarning, OccupancyGrid, map_server, movingai};

/// Values that a map file may not contain.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadOptions {
    /// Cell size of a `.map` or text map, metres. A YAML file states its own.
    pub resolution_m: f64,
}

impl Default for LoadOptions {
    fn default() -> Self {
        Self { resolution_m: 1.0 }
    }
}

/// Largest YAML file accepted, bytes.
const MAX_YAML_BYTES: u64 = 1 << 20;

/// Largest text file accepted, bytes: a grid of one column with two-byte line ends needs three per cell.
const MAX_ROWS_BYTES: u64 = 3 * MAX_GRID_CELLS as u64;

/// Reads a map. The format is a ROS `map_server` YAML file with its image (`.yaml`, `.yml`), a `MovingAI` grid (`.map`,
/// or a first line `type octile`), or else rows of text (see [`OccupancyGrid::from_rows`]).
///
/// Maps of the last two formats have their lower left corner at the origin of the map frame.
///
/// # Errors
/// Returns an error if the file cannot be read or has a syntax error; the message names the file and the place.
pub fn load(path: &Path, options: &LoadOptions) -> Result<OccupancyGrid, MapError> {
    load_with_warnings(path, options, &mut |_| {})
}

/// Reads a map as [`load`] does, and passes each warning to `warn`.
///
/// # Errors
/// See [`load`].
pub fn load_with_warnings(
    path: &Path,
    options: &LoadOptions,
    warn: &mut dyn FnMut(MapWarning),
) -> Result<OccupancyGrid, MapError> {
    read(path, options, warn).map_err(|problem| problem.in_file(path))
}

fn read(
    path: &Path,
    options: &LoadOptions,
    warn: &mut dyn FnMut(MapWarning),
) -> Result<OccupancyGrid, MapError> {
    let extension = path.extension().unwrap_or_default().to_string_lossy();
    match extension.to_ascii_lowercase().as_str() {
        "yaml" | "yml" => map_server::read(path, &read_text(path, MAX_YAML_BYTES)?, warn),
        "pgm" | "png" | "bmp" => Err(MapError::ImageWithoutYaml),
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

/// Reads a text file of at most `limit` bytes and removes its byte order mark.
pub(super) fn read_text(path: &Path, limit: u64) -> Result<String, MapError> {
    let unreadable = |error: std::io::Error| MapError::Unreadable { reason: error.to_string() };
    let mut bytes = Vec::new();
    File::open(path)
        .and_then(|file| file.take(limit + 1).read_to_end(&mut bytes))
        .map_err(unreadable)?;
    if bytes.len() as u64 > limit {
        return Err(MapError::TooLarge { limit });
    }
    let text = String::from_utf8(bytes).map_err(|error| {
        let valid = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        MapError::NotUtf8 { line: valid.split(|&byte| byte == b'\n').count() }
    })?;
    Ok(match text.strip_prefix('\u{feff}') {
        Some(rest) => rest.to_owned(),
        None => text,
    })
}
