//! Logs of real robots: lidar scans, wheel odometry and, where the file has them, corrected poses.
//!
//! Three text formats are read; the first significant lines decide the format:
//!
//! - CARMEN logs (<http://carmen.sourceforge.net>): `ODOM`, `FLASER`, `RLASER`, `ROBOTLASER1`, `RAWLASER1`. They include the
//!   logs of GMapping's `gfs2log`, whose poses are those of the best particle.
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
mod recording_folder;
mod tinyslam;

use std::collections::BTreeSet;
use std::path::Path;

use serde::Serialize;

#[cfg(feature = "mcap")]
pub(crate) use beams::remove_limit;
pub use error::LogError;
#[doc(hidden)]
pub use recording_folder::recording_files;

use crate::geometry::Pose;
use crate::input_file::{InputFileError, read_regular_bytes};
use crate::map::TimedScan;

/// Largest file accepted, bytes.
const MAX_BYTES: u64 = 1 << 30;

/// Time between the records of a log whose stamps do not advance, seconds.
const ASSUMED_PERIOD_S: f64 = 0.1;

/// A longer and faster step of the odometry is no motion of a robot: metres or radians, and these per second. Scans of real logs
/// that came in bursts share a stamp, and are up to a metre or half a radian apart. Robots with wheels drive at up to 5 m/s and
/// turn at up to 7 rad/s.
const JUMP: f64 = 1.0;
const JUMP_PER_S: f64 = 10.0;
/// The time of a step in a log whose stamps do not advance, seconds.
const LONGEST_STEP_S: f64 = 1.0;

/// The first bytes of files that are no texts, what they are, and what to do.
const OTHER_KINDS: [(&[u8], &str, &str); 5] = [
    (b"\x1f\x8b", "compressed", "decompress it with `gunzip`"),
    (b"\x28\xb5\x2f\xfd", "compressed", "decompress it with `zstd -d`"),
    (b"\x89MCAP", "a recording in MCAP", "rename it, so that its name ends in .mcap"),
    (
        b"#ROSBAG",
        "a recording of ROS 1",
        "convert it to MCAP with `rosbags-convert --dst-storage mcap`",
    ),
    (b"SQLite format 3", "a recording in SQLite", "convert it to MCAP with `ros2 bag convert`"),
];

/// The format of a log.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum LogFormat {
    /// A CARMEN log with poses by odometry, and possibly with corrected laser poses as well.
    Carmen,
    /// A CARMEN log with the poses of GMapping's best particle.
    CarmenGmapping,
    /// A GMapping `.gfs` file.
    Gfs,
    /// A tinySLAM `.dat` file.
    TinySlam,
    /// A recording of ROS 2 in MCAP, see `recording::RosLogReader`.
    Ros2,
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
    /// Number of the last line, from one, where it was cut off and is left out: the logger was killed.
    pub cut_line: Option<usize>,
}

/// A step of the odometry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OdometryStep {
    /// The time after it, seconds.
    pub time_s: f64,
    /// Its length, metres.
    pub distance_m: f64,
    /// The angle by which it turns, radians, zero or more.
    pub turn_rad: f64,
}

impl LidarLog {
    /// Reads a log from a file.
    ///
    /// # Errors
    /// Returns an error if the file cannot be read, has an unknown format or a bad line; the message names file and line.
    pub fn read(path: &Path) -> Result<Self, LogError> {
        let bytes = read_regular_bytes(path, MAX_BYTES);
        let log = bytes.map_err(LogError::from).and_then(|bytes| {
            let mut kinds = OTHER_KINDS.iter();
            match kinds.find(|(begin, ..)| bytes.starts_with(begin)) {
                Some(&(_, kind, remedy)) => Err(LogError::OtherKind { kind, remedy }),
                None => Self::parse(&decoded(bytes)?),
            }
        });
        log.map_err(|problem| LogError::InFile {
            path: path.to_path_buf(),
            problem: Box::new(problem),
        })
    }

    /// Reads a log from its text. A last line without a line end that is bad, goes back in time, or ends after its time where other
    /// lines go on, was cut off and is left out.
    ///
    /// # Errors
    /// Returns an error if the text has an unknown format or a bad line; the message names the line.
    pub fn parse(text: &str) -> Result<Self, LogError> {
        // Editors of Windows begin a text with a byte order mark.
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let log = Self::parse_whole(text);
        let begin = text.rfind('\n').map(|end| end + 1).filter(|begin| *begin < text.len());
        let (Some(begin), true) = (begin, log.as_ref().map_or(true, Self::goes_back_at_its_end))
        else {
            return log;
        };
        let (whole, records) = (&text[..begin], log.as_ref().ok().map(|log| log.records.len()));
        match Self::parse_whole(whole) {
            // A line may have no record.
            Ok(without) if Some(without.records.len()) != records => {
                Ok(Self { cut_line: Some(whole.lines().count() + 1), ..without })
            }
            _ => log,
        }
    }

    /// Whether the time of the last record is before that of the one before, as that of a line without its last digits.
    fn goes_back_at_its_end(&self) -> bool {
        matches!(&self.records[..], [.., before, last] if last.time_s < before.time_s)
    }

    fn parse_whole(text: &str) -> Result<Self, LogError> {
        let format = format_of(text).ok_or_else(|| unknown(text))?;
        let mut records = match format {
            LogFormat::Carmen => carmen::parse(text)?,
            LogFormat::CarmenGmapping => carmen::parse_gmapping(text)?,
            LogFormat::Gfs => gmapping::parse(text)?,
            LogFormat::TinySlam => tinyslam::parse(text)?,
            LogFormat::Ros2 => return Err(LogError::UnknownFormat),
        };
        beams::remove_limits(&mut records);
        let has_times = times_advance(&records);
        if !has_times {
            for (index, record) in records.iter_mut().enumerate() {
                let time_s = ASSUMED_PERIOD_S * index as f64;
                record.time_s = time_s;
                let beams = record.scan.iter_mut().flat_map(|scan| &mut scan.beams.beams);
                beams.for_each(|beam| beam.time_s = time_s);
            }
        }
        Ok(Self { format, records, has_times, cut_line: None })
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

    /// The first step of the odometry from one record to the next that no robot drives: over 1 m at over 10 m/s, or over 1 rad at
    /// over 10 rad/s.
    #[must_use]
    pub fn odometry_jump(&self) -> Option<OdometryStep> {
        (1..self.records.len()).find_map(|record| self.jump_to(record))
    }

    /// The step to a record from the one before, if no robot drives it.
    pub(crate) fn jump_to(&self, record: usize) -> Option<OdometryStep> {
        let [from, to] = self.records.get(record.checked_sub(1)?..=record)? else {
            return None;
        };
        let took_s = if self.has_times { to.time_s - from.time_s } else { LONGEST_STEP_S };
        let step = step(from, to);
        let is_fast = |size: f64| size > JUMP && size > JUMP_PER_S * took_s;
        (is_fast(step.distance_m) || is_fast(step.turn_rad)).then_some(step)
    }

    /// The step of the odometry to the scan of a record, from the scan before it. None if there is none before.
    #[must_use]
    pub fn step_to_scan(&self, record: usize) -> Option<OdometryStep> {
        let to = self.records.get(record)?;
        let from = self.records[..record].iter().rfind(|record| record.scan.is_some())?;
        Some(step(from, to))
    }
}

fn step(from: &LogRecord, to: &LogRecord) -> OdometryStep {
    let moved = from.odometry.inverse_transform_pose(&to.odometry);
    let distance_m = moved.position().to_vector().norm();
    OdometryStep { time_s: to.time_s, distance_m, turn_rad: moved.yaw.abs() }
}

/// Whether most pairs of scans of the same lidar have different stamps: two lidars may have the same ones.
fn times_advance(records: &[LogRecord]) -> bool {
    let mut last_of: Vec<(Pose, f64)> = Vec::new();
    let (mut pairs, mut advances) = (0, 0);
    for record in records {
        let Some(LoggedScan { mount, .. }) = &record.scan else {
            continue;
        };
        match last_of.iter_mut().find(|(place, _)| place == mount) {
            Some((_, last_s)) => {
                pairs += 1;
                advances += u32::from(*last_s != record.time_s);
                *last_s = record.time_s;
            }
            None => last_of.push((*mount, record.time_s)),
        }
    }
    2 * advances >= pairs
}

/// The format of a text, by its first scan. Scans without poses count only where there are no others.
fn format_of(text: &str) -> Option<LogFormat> {
    let is_corrected = || text.lines().any(|line| line.starts_with("NEFF"));
    let with_pose = text.lines().find_map(|line| {
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
    });
    let has_raw = || first_words(text).any(|word| word == carmen::RAW);
    with_pose.or_else(|| has_raw().then_some(LogFormat::Carmen))
}

fn first_words(text: &str) -> impl Iterator<Item = &str> {
    text.lines().filter_map(|line| line.split_whitespace().next())
}

/// The error for a text without scans. The names of CARMEN's messages are in capitals.
fn unknown(text: &str) -> LogError {
    let is_word = |word: &&str| word.starts_with(|first: char| first.is_ascii_alphabetic());
    let is_message = |word: &&str| !word.contains(|it: char| it.is_ascii_lowercase());
    let words = first_words(text).filter(|word| is_word(word) && *word != "PARAM");
    let found: BTreeSet<&str> = words.collect();
    if found.is_empty() || !found.iter().all(is_message) {
        return LogError::UnknownFormat;
    }
    let found: Vec<&str> = found.into_iter().take(8).collect();
    LogError::NoScans { found: found.join(", ") }
}

/// The text of UTF-8. Only comments may have other characters.
fn decoded(bytes: Vec<u8>) -> Result<String, InputFileError> {
    String::from_utf8(bytes).or_else(|error| {
        let bytes = error.as_bytes();
        let is_bad = |line: &[u8]| !line.starts_with(b"#") && core::str::from_utf8(line).is_err();
        match bytes.split(|byte| *byte == b'\n').position(is_bad) {
            Some(index) => Err(InputFileError::NotUtf8 { line: index + 1 }),
            None => Ok(String::from_utf8_lossy(bytes).into_owned()),
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const RAW: &str = "# a comment\nPARAM robot_frontlaser_offset 0.1\n\
        ODOM 0 0 0 0.1 0 0 1.0 host 1.0\n\
        FLASER 3 1.0 2.0 81.91 0.2 0 0 0.1 0 0 1.5 host 1.5\n\
        FLASER 3 1.0 2.0 81.91 0.3 0 0 0.2 0 0 2.5 host 2.5\n";

    fn near(pose: &Pose, x: f64, y: f64, yaw: f64) -> bool {
        (pose.x - x).abs() < 1e-9 && (pose.y - y).abs() < 1e-9 && (pose.yaw - yaw).abs() < 1e-9
    }

    #[test]
    fn byte_order_mark_is_skipped() {
        let marked = LidarLog::parse(&format!("\u{feff}{RAW}")).expect("a valid log");
        assert_eq!((marked.format, marked.scans()), (LogFormat::Carmen, 2));
    }

    #[test]
    fn only_comments_may_have_other_characters() {
        let latin =
            |text: &str| decoded(text.replace('@', "\u{fc}").chars().map(|it| it as u8).collect());
        assert!(latin("# M@nchen\nODOM\n").is_ok_and(|text| text.ends_with("\nODOM\n")));
        assert_eq!(latin("# M@nchen\nOD@M\n"), Err(InputFileError::NotUtf8 { line: 2 }));
    }

    #[test]
    fn jump_of_the_odometry_is_found() {
        let log = LidarLog::parse(RAW).expect("it is valid");
        assert_eq!(log.odometry_jump(), None);
        // 50 m and 10 m in a second, 3 rad in 0.2 s. The robot may turn by 1.5 rad in that time, and stamps may be late.
        for (moved, is_jump) in [
            ("50.2 0 0 2.5", true),
            ("10.2 0 0 2.5", true),
            ("0.2 0 3 1.7", true),
            ("0.2 0 1.5 1.7", false),
            ("1.0 0 0 1.5001", false),
        ] {
            let text = RAW.replace("0.2 0 0 2.5 host", &format!("{moved} host"));
            let jump = LidarLog::parse(&text).expect("it is valid").odometry_jump();
            assert_eq!(jump.is_some(), is_jump, "{moved}: {jump:?}");
        }
    }

    #[test]
    fn cut_last_line_is_left_out() {
        let log = LidarLog::parse(&format!("{RAW}FLASER 3 1.0 2.0")).expect("one line is cut");
        assert_eq!((log.scans(), log.cut_line), (2, Some(6)));
        let log = LidarLog::parse(RAW.trim_end()).expect("it is valid");
        assert_eq!((log.scans(), log.cut_line), (2, None));
        assert!(LidarLog::parse(&format!("{RAW}FLASER 3 1.0 2.0\n")).is_err());
    }

    #[test]
    fn log_without_scans_names_its_messages() {
        let error = |text: &str| LidarLog::parse(text).expect_err("no scan").to_string();
        let text = RAW.replace("FLASER", "ROBOTLASER2");
        let found = error(&text);
        assert!(found.contains("its messages are ODOM, ROBOTLASER2;"), "{found}");
        assert!(error("# nothing\nPARAM a 1\n").contains("it is no CARMEN"));
        assert!(error("some other text\n").contains("it is no CARMEN"));
    }

    #[test]
    fn files_of_other_kinds_are_named() {
        for (kind, name) in [(0, "gunzip"), (2, ".mcap"), (3, "ROS 1"), (4, "SQLite")] {
            let file = tempfile::NamedTempFile::new().expect("a file");
            std::fs::write(file.path(), [OTHER_KINDS[kind].0, b"\x00more"].concat())
                .expect("written");
            let error = LidarLog::read(file.path()).expect_err("no text").to_string();
            assert!(error.contains(name), "{error}");
        }
    }

    #[test]
    fn carmen_log_has_odometry_scans_and_mounting() {
        let log = LidarLog::parse(RAW).expect("it is valid");
        assert_eq!((log.format, log.has_times, log.scans()), (LogFormat::Carmen, true, 2));
        assert_eq!(log.records.len(), 3);
        let record = &log.records[1];
        let scan = record.scan.as_ref().expect("a scan");
        assert!(near(&scan.mount, 0.1, 0.0, 0.0), "{:?}", scan.mount);
        assert_eq!((record.time_s, record.corrected), (1.5, None));
        assert_eq!(scan.beams.origin, scan.mount.position());
        // Beams to the right, ahead and to the left.
        let [right, ahead, left] = scan.beams.beams[..] else { panic!("three beams") };
        assert_eq!((ahead.angle, ahead.range), (0.0, 2.0));
        assert!(right.range == 1.0 && right.angle < -1.5);
        assert!(left.range.is_nan());
        assert_eq!(log.start(), Some(Pose::new(0.1, 0.0, 0.0)));
    }

    #[test]
    fn laser_poses_that_leave_the_robot_are_corrected_ones() {
        let text = RAW.replace("0.3 0 0 0.2", "0.5 0.2 0.1 0.2");
        let log = LidarLog::parse(&text).expect("it is valid");
        let corrected = log.records[2].corrected.expect("corrected");
        let (sin, cos) = libm::sincos(0.1);
        assert!(near(&corrected, 0.5 - 0.1 * cos, 0.2 - 0.1 * sin, 0.1), "{corrected:?}");
        assert!(near(&log.records[2].odometry, 0.2, 0.0, 0.0));
    }

    #[test]
    fn robotlaser_states_its_angles_and_range() {
        let text = "ROBOTLASER1 0 -1.0 2.0 0.5 8.0 0.01 0 3 1.0 8.0 3.0 1 7 \
            0.1 0 0 0 0 0 0.2 0 0 0 0 4.5 host 4.5\n";
        let log = LidarLog::parse(text).expect("it is valid");
        let scan = log.records[0].scan.as_ref().expect("a scan");
        let ranges: Vec<bool> = scan.beams.beams.iter().map(|it| it.range.is_finite()).collect();
        assert_eq!((ranges, log.records[0].time_s), (vec![true, false, true], 4.5));
    }

    #[test]
    fn gmapping_poses_are_corrected_and_their_steps_are_odometry() {
        let text = "ODOM 0 0 0 0 0 0 1 p 1\nODOM 1 0 0 0 0 0 2 p 2\n\
            FLASER 1 3 1 0.5 0 1 0.5 0 2 p 2\nODOM 1 0.5 0 0 0 0 0 p 0\nNEFF 15\n\
            ODOM 2 0.5 0 0 0 0 3 p 3\nFLASER 1 3 2 0.4 0 2 0.4 0 3 p 3\n";
        let log = LidarLog::parse(text).expect("it is valid");
        assert_eq!(log.format, LogFormat::CarmenGmapping);
        let last = &log.records[log.records.len() - 1];
        assert!(near(&last.odometry, 2.0, 0.0, 0.0), "{last:?}");
        assert_eq!(last.corrected, Some(Pose::new(2.0, 0.4, 0.0)));
    }

    #[test]
    fn tinyslam_counts_turn_the_robot() {
        let line = |time_us: u32, left: i32, right: i32| {
            let ranges = "1000 ".repeat(682);
            format!("{time_us} 0 {left} {right} {}{ranges}\n", "0 ".repeat(20))
        };
        let text =
            line(1_000_000, 0, 0) + &line(1_100_000, 2000, 2000) + &line(1_200_000, 1000, 3000);
        let log = LidarLog::parse(&text).expect("it is valid");
        let around_m = core::f64::consts::TAU * 0.077;
        assert!(near(&log.records[1].odometry, around_m, 0.0, 0.0));
        let turn = around_m / 0.33;
        assert!((log.records[2].odometry.yaw - turn).abs() < 1e-9, "{:?}", log.records[2].odometry);
        let scan = log.records[1].scan.as_ref().expect("a scan");
        assert!((scan.beams.end_s().expect("beams") - 1.1).abs() < 1e-9);
        assert!(scan.beams.beams[0].time_s < 1.04);
    }

    /// The front lidar reads at most 5 m, the rear one 12 m.
    #[test]
    fn each_lidar_has_its_own_limit() {
        let scan = |name, limit_m: f64| format!("{name} 3 1.0 2.0 {limit_m} 0 0 0 0 0 0");
        let line = |time_s: u32| {
            let (front, rear) = (scan("FLASER", 5.0), scan("RLASER", 12.0));
            format!("{front} {time_s} h {time_s}\n{rear} {time_s}.5 h {time_s}.5\n")
        };
        let text = (0..20).map(line).collect::<String>();
        let text = text.replace("12 0 0 0", "12 0 0 3.1416");
        let log = LidarLog::parse(&text).expect("it is valid");
        for record in &log.records {
            let scan = record.scan.as_ref().expect("a scan");
            assert!(scan.beams.beams[2].range.is_nan(), "{record:?}");
            assert!(scan.beams.beams[1].range.is_finite(), "{record:?}");
        }
    }

    #[test]
    fn stamps_that_do_not_advance_are_replaced() {
        let log = LidarLog::parse(&RAW.replace("2.5 host", "1.5 host")).expect("it is valid");
        assert!(!log.has_times);
        assert_eq!(log.records[2].time_s, 0.2);
    }

    #[test]
    fn bad_lines_are_named() {
        for (from, to, expected) in [
            ("0.3 0 0 0.2", "0.3 0 x 0.2", "line 5: FLASER has `x` as its laser pose"),
            ("FLASER 3 1.0", "FLASER 300 1.0", "line 4: FLASER has `host` as its readings"),
            ("0.1 0 0 1.0 host 1.0", "0.1", "line 3: ODOM ends before its speeds"),
            ("1.0 2.0", "nan 2.0", "line 4: FLASER has `nan` as its readings"),
            ("# a comment", "1 2 3", "line 1: a line has `1` as its first word"),
            ("FLASER", "FLAS", "it has no scan that is read: its messages are FLAS, ODOM;"),
        ] {
            let error = LidarLog::parse(&RAW.replace(from, to)).expect_err(expected);
            assert!(error.to_string().contains(expected), "{error}");
        }
        let text = "LASER_READING 1 3 0 0 0 1\nSM_UPDATE 1 0 0 0 9\nRESAMPLE 1 1\n";
        let error = LidarLog::parse(text).expect_err("no such particle");
        assert!(error.to_string().contains("line 3: RESAMPLE has `1` as its parent"), "{error}");
        let error = LidarLog::read(Path::new("/nowhere.log")).expect_err("it is missing");
        assert!(error.to_string().starts_with("/nowhere.log: cannot be read"), "{error}");
    }
}
