//! Logs of real robots: lidar scans, wheel odometry and, where the file has them, corrected poses.
//!
//! Three text formats are read (the first significant lines tell which):
//!
//! - CARMEN logs (<http://carmen.sourceforge.net>): `ODOM`, `FLASER`, `RLASER`, `ROBOTLASER1`. Also the form that GMapping's
//!   `gfs2log` writes, whose poses are those of the best particle.
//! - GMapping's own `.gfs` files: `ODOM`, `LASER_READING`, `SM_UPDATE`, `RESAMPLE`, `SCANMATCH`.
//! - The `.dat` files of tinySLAM (Steux and El Hamzaoui, "tinySLAM: A SLAM algorithm in less than 200 lines C-language
//!   program", ICARCV 2010): wheel counts and the 682 ranges of a Hokuyo URG-04LX.
//!
//! All become one sequence of [`LogRecord`]s. A bad line gives an error with file and line.

mod beams;
mod carmen;
mod error;
mod fields;
mod gmapping;
mod tinyslam;

use std::fs::{self, File};
use std::io::Read;
use std::path::Path;

use serde::Serialize;

pub use error::LogError;

use crate::geometry::Pose;
use crate::map::TimedScan;

/// Largest file accepted, bytes.
const MAX_BYTES: u64 = 1 << 30;

/// Time between the records of a log whose stamps do not advance, seconds.
const ASSUMED_PERIOD_S: f64 = 0.1;

/// The format of a log.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum LogFormat {
    /// A CARMEN log with poses by odometry, or with corrected laser poses beside them.
    Carmen,
    /// A CARMEN log with the poses of GMapping's best particle.
    CarmenGmapping,
    /// A GMapping `.gfs` file.
    Gfs,
    /// A tinySLAM `.dat` file.
    TinySlam,
}

/// One measurement of a log, in the order of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct LogRecord {
    /// Time, seconds. Real logs have stamps that go back by a fraction of a second.
    pub time_s: f64,
    /// The robot's pose by wheel odometry at that time, metres and radians.
    pub odometry: Pose,
    /// The robot's pose as corrected by the program that wrote the log.
    pub corrected: Option<Pose>,
    /// The scan that ends at that time.
    pub scan: Option<LoggedScan>,
}

/// A scan of a log.
#[derive(Clone, Debug, PartialEq)]
pub struct LoggedScan {
    /// Pose of the lidar in the robot's frame.
    pub mount: Pose,
    /// The beams in the robot's frame.
    pub beams: TimedScan,
}

/// A log as one sequence.
#[derive(Clone, Debug, PartialEq)]
pub struct LidarLog {
    /// The format of the file.
    pub format: LogFormat,
    /// The measurements in the order of the file.
    pub records: Vec<LogRecord>,
    /// Whether the stamps of the file advance. Otherwise (they are printed with too few digits) each record is 0.1 s after
    /// the one before.
    pub has_times: bool,
}

impl LidarLog {
    /// Reads a log from a file.
    ///
    /// # Errors
    /// Returns an error if the file cannot be read, has an unknown format or a bad line; the message names file and line.
    pub fn read(path: &Path) -> Result<Self, LogError> {
        let text = read_text(path).and_then(|text| Self::parse(&text));
        text.map_err(|problem| LogError::InFile {
            path: path.to_path_buf(),
            problem: Box::new(problem),
        })
    }

    /// Reads a log from its text.
    ///
    /// # Errors
    /// Returns an error if the text has an unknown format or a bad line; the message names the line.
    pub fn parse(text: &str) -> Result<Self, LogError> {
        let format = format_of(text).ok_or(LogError::UnknownFormat)?;
        let mut records = match format {
            LogFormat::Carmen => carmen::parse(text)?,
            LogFormat::CarmenGmapping => carmen::parse_gmapping(text)?,
            LogFormat::Gfs => gmapping::parse(text)?,
            LogFormat::TinySlam => tinyslam::parse(text)?,
        };
        beams::remove_saturated(&mut records);
        let has_times = times_advance(&records);
        if !has_times {
            for (index, record) in records.iter_mut().enumerate() {
                let time_s = ASSUMED_PERIOD_S * index as f64;
                record.time_s = time_s;
                let beams = record.scan.iter_mut().flat_map(|scan| &mut scan.beams.beams);
                beams.for_each(|beam| beam.time_s = time_s);
            }
        }
        Ok(Self { format, records, has_times })
    }

    /// Number of scans.
    #[must_use]
    pub fn scans(&self) -> usize {
        self.records.iter().filter(|record| record.scan.is_some()).count()
    }

    /// The pose at the first scan: the corrected one, or that by odometry. None for a log without scans.
    #[must_use]
    pub fn start(&self) -> Option<Pose> {
        let first = self.records.iter().find(|record| record.scan.is_some())?;
        Some(first.corrected.unwrap_or(first.odometry))
    }
}

/// Whether most pairs of scans have different stamps.
fn times_advance(records: &[LogRecord]) -> bool {
    let scans: Vec<f64> =
        records.iter().filter(|record| record.scan.is_some()).map(|record| record.time_s).collect();
    let advances = scans.windows(2).filter(|pair| pair[0] != pair[1]).count();
    2 * advances >= scans.len().saturating_sub(1)
}

/// The format of a text, by its first scan.
fn format_of(text: &str) -> Option<LogFormat> {
    let is_corrected = || text.lines().any(|line| line.starts_with("NEFF"));
    text.lines().find_map(|line| {
        let mut words = line.split_whitespace();
        match words.next()? {
            "LASER_READING" => Some(LogFormat::Gfs),
            "FLASER" | "RLASER" if is_corrected() => Some(LogFormat::CarmenGmapping),
            "FLASER" | "RLASER" | "ROBOTLASER1" => Some(LogFormat::Carmen),
            first if first.parse::<u64>().is_ok() && words.count() + 1 >= tinyslam::FIELDS => {
                Some(LogFormat::TinySlam)
            }
            _ => None,
        }
    })
}

fn read_text(path: &Path) -> Result<String, LogError> {
    let unreadable = |reason: String| LogError::Unreadable { reason };
    // Opening a pipe waits for its writer, possibly for ever.
    let metadata = fs::metadata(path).map_err(|error| unreadable(error.to_string()))?;
    if !metadata.is_file() {
        return Err(unreadable("it is no regular file".to_owned()));
    }
    let mut bytes = Vec::new();
    let read = File::open(path).and_then(|file| file.take(MAX_BYTES + 1).read_to_end(&mut bytes));
    read.map_err(|error| unreadable(error.to_string()))?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(LogError::TooLarge { limit: MAX_BYTES });
    }
    String::from_utf8(bytes).map_err(|error| {
        let valid = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        LogError::NotUtf8 { line: 1 + valid.iter().filter(|byte| **byte == b'\n').count() }
    })
}
