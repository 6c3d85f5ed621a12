//! Errors of lidar logs.

use std::path::PathBuf;

use thiserror::Error;

use crate::input_file::InputFileError;

/// A lidar log that cannot be used. Each message is one line: file, line, cause and remedy.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum LogError {
    /// A problem in the named file.
    #[error("{}: {problem}", path.display())]
    InFile {
        /// The file.
        path: PathBuf,
        /// The problem.
        problem: Box<LogError>,
    },
    /// A file that cannot be read.
    #[error(transparent)]
    File(#[from] InputFileError),
    /// A `metadata.yaml` of `rosbag2` that cannot be read.
    #[error(
        "line {line}: {reason}: it must be a metadata.yaml of rosbag2; `ros2 bag reindex` writes one"
    )]
    BadMetadata {
        /// Line number, from one.
        line: usize,
        /// The cause.
        reason: String,
    },
    /// A file that a `metadata.yaml` of `rosbag2` names is missing.
    #[error("it names {}, which is missing: copy that file into the folder, or run `ros2 bag reindex`", path.display())]
    MissingRecordingFile {
        /// The missing file.
        path: PathBuf,
    },
    /// A file of no known format.
    #[error(
        "no line begins with FLASER, RLASER, ROBOTLASER1, RAWLASER1, LASER_READING or 706 numbers: it is no CARMEN, GMapping or \
         tinySLAM log"
    )]
    UnknownFormat,
    /// A CARMEN log without a scan that is read.
    #[error(
        "it has no scan that is read: its messages are {found}; scans are read from FLASER, RLASER, ROBOTLASER1 and RAWLASER1"
    )]
    NoScans {
        /// The names of its messages.
        found: String,
    },
    /// A file of another kind.
    #[error("it is {kind}: {remedy}")]
    OtherKind {
        /// What it is.
        kind: &'static str,
        /// What to do.
        remedy: &'static str,
    },
    /// A line that ends too early.
    #[error("line {line}: {record} ends before its {field}: the line is cut; remove it")]
    Missing {
        /// Line number, from one.
        line: usize,
        /// The kind of the record.
        record: &'static str,
        /// The missing field.
        field: &'static str,
    },
    /// A field with an invalid value.
    #[error("line {line}: {record} has `{value}` as its {field}: it must be {expected}")]
    BadField {
        /// Line number, from one.
        line: usize,
        /// The kind of the record.
        record: &'static str,
        /// The field.
        field: &'static str,
        /// The value found.
        value: String,
        /// What the field may be.
        expected: &'static str,
    },
    /// A record that needs another one before it.
    #[error("line {line}: {record} has no {needed} before it: the log is incomplete")]
    OutOfOrder {
        /// Line number, from one.
        line: usize,
        /// The kind of the record.
        record: &'static str,
        /// The record that it needs.
        needed: &'static str,
    },
}
