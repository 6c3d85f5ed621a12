//! Loading map files of all supported formats, and maps as rows of text.

use std::path::Path;

use super::{
    GridFrame, MAX_GRID_CELLS, MapError, MapWarning, OccupancyGrid, UNKNOWN, map_server, movingai,
};
use crate::geometry::Pose;
use crate::input_file::{self, read_regular_bytes};

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

/// Whether the format of a map file, by its name, states the size of a cell, so that [`LoadOptions::resolution_m`] is not used.
#[must_use]
pub fn has_own_resolution(path: &Path) -> bool {
    let extension = path.extension().unwrap_or_default();
    ["yaml", "yml"].into_iter().any(|own| extension.eq_ignore_ascii_case(own))
}

fn read(
    path: &Path,
    options: &LoadOptions,
    warn: &mut dyn FnMut(MapWarning),
) -> Result<OccupancyGrid, MapError> {
    if has_own_resolution(path) {
        return map_server::read(path, &read_text(path, MAX_YAML_BYTES)?, warn);
    }
    let extension = path.extension().unwrap_or_default().to_string_lossy();
    match extension.to_ascii_lowercase().as_str() {
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

/// Reads a text file of at most `limit` bytes.
pub(super) fn read_text(path: &Path, limit: u64) -> Result<String, MapError> {
    Ok(input_file::text(read_regular_bytes(path, limit)?)?)
}

impl OccupancyGrid {
    /// Parses rows of text, from the largest y down, one character per cell: `#` is occupied, `.` or a space is free, `?`
    /// is unknown. The resolution is in metres per cell; the origin is the lower left corner.
    ///
    /// # Errors
    /// Returns an error if there is no cell, a row differs in length from the first, a character is unknown, or
    /// [`GridFrame::new`] rejects the frame. Rows and columns are counted from one at the top left.
    pub fn from_rows(
        rows: &[impl AsRef<str>],
        resolution_m: f64,
        origin: Pose,
    ) -> Result<Self, MapError> {
        let length = |row: &dyn AsRef<str>| row.as_ref().chars().count();
        let width = rows.first().map_or(0, |row| length(row));
        if width == 0 {
            let filled = rows.iter().position(|row| length(row) > 0).ok_or(MapError::Empty)?;
            let found = length(&rows[filled]);
            return Err(MapError::RaggedRow { row: filled + 1, found, expected: 0 });
        }
        let side = |cells: usize| i32::try_from(cells).unwrap_or(i32::MAX);
        let frame = GridFrame::new(side(width), side(rows.len()), resolution_m, origin)?;
        let mut cells = Vec::with_capacity(frame.len());
        for (row, text) in rows.iter().enumerate() {
            for (column, character) in text.as_ref().chars().enumerate() {
                let value = occupancy(character).ok_or(MapError::UnknownCharacter {
                    row: row + 1,
                    column: column + 1,
                    character,
                })?;
                cells.push(value);
            }
            let found = cells.len() - row * width;
            if found != width {
                return Err(MapError::RaggedRow { row: row + 1, found, expected: width });
            }
        }
        Ok(Self::from_top_down(frame, &cells))
    }

    /// Parses the lines of a text with [`Self::from_rows`], with the lower left corner at the origin. Empty lines at the
    /// end are ignored.
    ///
    /// # Errors
    /// See [`Self::from_rows`].
    pub fn from_text(text: &str, resolution_m: f64) -> Result<Self, MapError> {
        let mut rows: Vec<&str> = text.lines().collect();
        while rows.last().is_some_and(|row| row.is_empty()) {
            rows.pop();
        }
        Self::from_rows(&rows, resolution_m, Pose::default())
    }
}

fn occupancy(character: char) -> Option<i8> {
    match character {
        '#' => Some(100),
        '.' | ' ' => Some(0),
        '?' => Some(UNKNOWN),
        _ => None,
    }
}
