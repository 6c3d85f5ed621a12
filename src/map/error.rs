//! What can be wrong with a map or a scenario file.

use std::path::{Path, PathBuf};

use thiserror::Error;

use super::{MAX_GRID_CELLS, MAX_GRID_SIDE};

/// A map that cannot be used. Each message is one line: the file, the place in it, what is wrong, the mend.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum MapError {
    /// Something is wrong with this file.
    #[error("{}: {problem}", path.display())]
    InFile {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        problem: Box<MapError>,
    },
    /// Something is wrong with the image that a YAML file names.
    #[error("line {line}: key `image` names {image:?}: {problem}")]
    InImage {
        /// Line of the key, from one.
        line: usize,
        /// The image, as it was looked for.
        image: PathBuf,
        /// What is wrong with it.
        problem: Box<MapError>,
    },
    /// A file that the system does not give.
    #[error("cannot be read ({reason}): check the path and its permissions")]
    Unreadable {
        /// The system's words.
        reason: String,
    },
    /// A file too long to be what it is taken for.
    #[error(
        "holds more than {limit} bytes, which no such file needs: check that it is the right one"
    )]
    TooLong {
        /// The most bytes accepted.
        limit: u64,
    },
    /// A file that is not text.
    #[error("line {line}: not UTF-8 text: save it as UTF-8, or check that it is a map")]
    NotText {
        /// First line that is not text, from one.
        line: usize,
    },
    /// An image given in place of a map.
    #[error("an image alone has no scale: name the YAML file that goes with it")]
    BareImage,
    /// An image that cannot be decoded.
    #[error("not a PGM, PNG or BMP image that can be decoded ({reason}): export it again")]
    BadImage {
        /// The decoder's words.
        reason: String,
    },
    /// Text that is not YAML, or not a plain mapping of keys to values.
    #[error("line {line}: {reason}: write one `key: value` a line, each key once")]
    BadYaml {
        /// Where the reader gave up, from one.
        line: usize,
        /// The reader's words.
        reason: String,
    },
    /// A key that must be there is not.
    #[error("{}", missing_key(key, found.as_ref()))]
    MissingKey {
        /// The key.
        key: &'static str,
        /// Line and name of a key that was found and looks like a slip of the pen.
        found: Option<(usize, String)>,
    },
    /// A key with a value it cannot have.
    #[error("line {line}: key `{key}` is {value}: it must be {expected}")]
    BadValue {
        /// Line of the value, from one.
        line: usize,
        /// The key.
        key: &'static str,
        /// As given.
        value: String,
        /// What would be accepted.
        expected: &'static str,
    },
    /// A line of a `MovingAI` file that does not follow the format.
    #[error("line {line}: {found}: expected {expected}")]
    BadLine {
        /// The line, from one.
        line: usize,
        /// What is there.
        found: String,
        /// What would be accepted.
        expected: String,
    },
    /// A text map without a cell.
    #[error("holds no cell: give rows of `#`, `.` and `?`, from the largest y down")]
    NoRows,
    /// A row of a text map that is longer or shorter than the first.
    #[error("row {row} has {found} cells where row 1 has {expected}: make all rows equally long")]
    RaggedRow {
        /// The row, from one at the top.
        row: usize,
        /// Its cells.
        found: usize,
        /// Cells of the first row.
        expected: usize,
    },
    /// A character in a text map that stands for no cell.
    #[error(
        "row {row}, column {column}: {character:?} is no cell: use `#` occupied, `.` or space free, `?` unknown"
    )]
    UnknownCharacter {
        /// The row, from one at the top.
        row: usize,
        /// The column, from one at the left.
        column: usize,
        /// As given.
        character: char,
    },
    /// A grid with no cell or too many.
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
    /// Cells of no size.
    #[error("resolution is {resolution_m} metres a cell: it must be finite and above zero")]
    BadResolution {
        /// As given.
        resolution_m: f64,
    },
    /// A grid that lies nowhere.
    #[error("origin is [{x}, {y}, {yaw}]: all three must be finite")]
    BadOrigin {
        /// As given, metres.
        x: f64,
        /// As given, metres.
        y: f64,
        /// As given, radians.
        yaw: f64,
    },
}

impl MapError {
    /// The same problem, together with the file it was found in.
    #[must_use]
    pub fn in_file(self, path: &Path) -> Self {
        Self::InFile {
            path: path.to_owned(),
            problem: Box::new(self),
        }
    }
}

fn missing_key(key: &str, found: Option<&(usize, String)>) -> String {
    match found {
        Some((line, found)) => {
            let found = found.escape_debug();
            format!("line {line}: has `{found}`, needs `{key}`: rename the key")
        }
        None => format!("needs the key `{key}`: add it"),
    }
}
