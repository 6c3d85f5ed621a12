//! Reads input files, each with a limit: a device or a pipe may never end.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use thiserror::Error;

/// Largest text of settings, a plan, a problem or a world, bytes.
const MAX_TEXT_BYTES: u64 = 16 << 20;

/// An input file that cannot be read. The message does not name the file.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum InputFileError {
    /// A file that the operating system cannot read.
    #[error("cannot be read ({reason}): check the path and its permissions")]
    Unreadable {
        /// The operating system's message.
        reason: String,
    },
    /// A file larger than its kind needs.
    #[error("holds more than {limit} bytes, which no file of this kind needs: check the path")]
    TooLarge {
        /// Largest size accepted, bytes.
        limit: u64,
    },
    /// A file that is not UTF-8 text.
    #[error("line {line}: not UTF-8 text: save it as UTF-8, or check that it is the right file")]
    NotUtf8 {
        /// First line that is not UTF-8, from one.
        line: usize,
    },
}

impl From<io::Error> for InputFileError {
    fn from(error: io::Error) -> Self {
        Self::Unreadable { reason: error.to_string() }
    }
}

/// Reads a file of at most `limit` bytes.
///
/// # Errors
/// The file cannot be read, or is larger.
#[doc(hidden)]
pub fn read_bytes(path: &Path, limit: u64) -> Result<Vec<u8>, InputFileError> {
    let mut bytes = Vec::new();
    File::open(path)?.take(limit + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit {
        return Err(InputFileError::TooLarge { limit });
    }
    Ok(bytes)
}

/// Like [`read_bytes`], of a file on a disk: opening a pipe waits for its writer, possibly for ever.
pub(crate) fn read_regular_bytes(path: &Path, limit: u64) -> Result<Vec<u8>, InputFileError> {
    if !fs::metadata(path)?.is_file() {
        return Err(InputFileError::Unreadable { reason: "it is no regular file".to_owned() });
    }
    read_bytes(path, limit)
}

/// Reads a text file of at most 16 MiB, without its byte order mark.
///
/// # Errors
/// The file cannot be read, is larger, or is not UTF-8.
#[doc(hidden)]
pub fn read_text(path: &Path) -> Result<String, InputFileError> {
    text(read_bytes(path, MAX_TEXT_BYTES)?)
}

/// The text of a file, without the byte order mark that some editors write.
pub(crate) fn text(bytes: Vec<u8>) -> Result<String, InputFileError> {
    let mut text = String::from_utf8(bytes).map_err(|error| {
        let valid = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        InputFileError::NotUtf8 { line: valid.split(|byte| *byte == b'\n').count() }
    })?;
    if text.starts_with('\u{feff}') {
        text.drain(..'\u{feff}'.len_utf8());
    }
    Ok(text)
}

/// The files and folders in a folder, sorted by name.
///
/// # Errors
/// The folder cannot be read.
#[doc(hidden)]
pub fn list(folder: &Path) -> Result<Vec<PathBuf>, InputFileError> {
    let entries = fs::read_dir(folder)?.map(|entry| Ok(entry?.path()));
    let mut paths = entries.collect::<io::Result<Vec<_>>>()?;
    paths.sort();
    Ok(paths)
}
