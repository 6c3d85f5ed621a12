//! Errors and warnings of map and scenario files.

use core::fmt::{self, Display, Formatter};
use std::path::{Path, PathBuf};

use thiserror::Error;

use super::{MAX_GRID_CELLS, MAX_GRID_SIDE, MAX_RESOLUTION_M};
use crate::input_file::InputFileError;

/// A map or scenario file that cannot be used. Each message is one line: file, place, cause and remedy.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum MapError {
    /// A problem in the named file.
    #[error("{}: {problem}", path.display())]
    InFile {
        /// The file.
        path: PathBuf,
        /// The problem.
        problem: Box<MapError>,
    },
    /// A problem in the image that a YAML file names.
    #[error("line {line}: key `image` names {image:?}: {problem}")]
    InImage {
        /// Line of the key, from one.
        line: usize,
        /// The resolved path of the image.
        image: PathBuf,
        /// The problem.
        problem: Box<MapError>,
    },
    /// A file that cannot be read.
    #[error(transparent)]
    File(#[from] InputFileError),
    /// An image given instead of its YAML file.
    #[error("an image alone has no scale: name the YAML file that belongs to it")]
    ImageWithoutYaml,
    /// An image that cannot be decoded.
    #[error("not a PGM, PNG or BMP image that can be decoded ({reason}): export it again")]
    BadImage {
        /// The decoder's message.
        reason: String,
    },
    /// Text that is not YAML, or not a mapping of keys to values.
    #[error("line {line}: {reason}: write one `key: value` per line, each key once")]
    BadYaml {
        /// Line at which the parser failed, from one.
        line: usize,
        /// The parser's message.
        reason: String,
    },
    /// A required key is missing.
    #[error("{}", missing_key(key, found.as_ref()))]
    MissingKey {
        /// The key.
        key: &'static str,
        /// Line and name of an unknown key that is probably a misspelling of it.
        found: Option<(usize, String)>,
    },
    /// A key with an invalid value.
    #[error("line {line}: key `{key}` is {value}: it must be {expected}")]
    BadValue {
        /// Line of the value, from one.
        line: usize,
        /// The key.
        key: &'static str,
        /// The value found.
        value: String,
        /// The values accepted.
        expected: &'static str,
    },
    /// A line of a `MovingAI` file with a syntax error.
    #[error("line {line}: {found}: expected {expected}")]
    BadLine {
        /// The line, from one.
        line: usize,
        /// The text found.
        found: String,
        /// The text accepted.
        expected: String,
    },
    /// A text map without cells.
    #[error("holds no cell: give rows of `#`, `.` and `?`, from the largest y down")]
    Empty,
    /// A row of a text map with another length than the first.
    #[error("row {row} has {found} cells where row 1 has {expected}: make all rows equally long")]
    RaggedRow {
        /// The row, from one at the top.
        row: usize,
        /// Number of cells in the row.
        found: usize,
        /// Number of cells in the first row.
        expected: usize,
    },
    /// An unknown character in a text map.
    #[error(
        "row {row}, column {column}: {character:?} is no cell: use `#` occupied, `.` or space free, `?` unknown"
    )]
    UnknownCharacter {
        /// The row, from one at the top.
        row: usize,
        /// The column, from one at the left.
        column: usize,
        /// The character found.
        character: char,
    },
    /// A grid with no cells or too many.
    #[error(
        "{width} x {height} cells: each side must be 1 to {MAX_GRID_SIDE} and their product at most \
         {MAX_GRID_CELLS}: crop the map, or make its cells larger"
    )]
    BadGridSize {
        /// Columns.
        width: i64,
        /// Rows.
        height: i64,
    },
    /// An invalid cell size.
    #[error(
        "resolution is {resolution_m} metres a cell: it must be above zero and at most {MAX_RESOLUTION_M}"
    )]
    BadResolution {
        /// The value found.
        resolution_m: f64,
    },
    /// Another number of cells than those of the frame.
    #[error("it has {found} cells, but {width} columns and {height} rows")]
    WrongCellCount {
        /// Number of cells.
        found: usize,
        /// Columns.
        width: i32,
        /// Rows.
        height: i32,
    },
    /// A cell of an occupancy grid out of range.
    #[error("cell {index} is {value}: it must be 0 to 100, or -1 for unknown")]
    BadCell {
        /// Its index, row-major from zero with the lowest row first.
        index: usize,
        /// The value found.
        value: i8,
    },
    /// A grid origin that is not finite.
    #[error("origin is [{x}, {y}, {yaw}]: all three must be finite")]
    BadOrigin {
        /// The x coordinate found, metres.
        x: f64,
        /// The y coordinate found, metres.
        y: f64,
        /// The yaw found, radians.
        yaw: f64,
    },
}

impl MapError {
    /// Wraps the error with the file in which it occurred.
    pub(crate) fn in_file(self, path: &Path) -> Self {
        Self::InFile { path: path.to_owned(), problem: Box::new(self) }
    }
}

/// A suspicious entry of a map file. The map is loaded regardless.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum MapWarning {
    /// An unknown key that is probably a misspelling of a known one. It is ignored.
    MisspelledKey {
        /// Its line, from one.
        line: usize,
        /// The key found.
        found: String,
        /// The known key that it resembles.
        suggestion: &'static str,
    },
    /// In `mode: scale`, thresholds other than 0 and 1: values are not the percentages of the image. That is usual for a map, but a
    /// mask of speed limits then has other limits than its greys say. Nav2 reads it in the same way.
    ClippedScale {
        /// Values up to this share are 0.
        free_thresh: f64,
        /// Values from this share on are 100.
        occupied_thresh: f64,
    },
}

impl Display for MapWarning {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::MisspelledKey { line, found, suggestion } => write!(
                formatter,
                "line {line}: unknown key `{found}` is ignored: did you mean `{suggestion}`?"
            ),
            Self::ClippedScale { free_thresh, occupied_thresh } => write!(
                formatter,
                "`mode: scale` with `free_thresh: {free_thresh}` and `occupied_thresh: {occupied_thresh}`: zones that are at most \
                 {free_thresh} dark have no limit, and the limits of darker ones are scaled between the thresholds: set \
                 `free_thresh: 0.0` and `occupied_thresh: 1.0`"
            ),
        }
    }
}

fn missing_key(key: &str, found: Option<&(usize, String)>) -> String {
    match found {
        Some((line, found)) => {
            let found = found.escape_debug();
            format!("line {line}: has `{found}`, needs `{key}`: correct the name")
        }
        None => format!("needs the key `{key}`: add it"),
    }
}
