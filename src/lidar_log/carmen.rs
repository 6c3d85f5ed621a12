//! CARMEN logs (message formats: comment lines at the head of every CARMEN log file).

use core::f64::consts::PI;

use super::beams::{self, SICK_RANGE_M};
use super::fields::Fields;
use super::{LogError, LogRecord, LoggedScan};
use crate::geometry::{Pose, wrap_angle};

/// A laser pose that differs from the mounting by more than this, metres and radians, is a corrected one. Logs print two to
/// six decimals.
const SAME_M: f64 = 0.02;
const SAME_RAD: f64 = 0.02;

/// A scan line as it stands.
struct Line {
    time_s: f64,
    robot: Pose,
    /// The laser pose of the line.
    laser: Pose,
    readings: Vec<f64>,
    angles: (f64, f64),
    range_max: f64,
    /// Whether the lidar looks backwards.
    is_rear: bool,
}

enum Record {
    Odometry(f64, Pose),
    Scan(Line),
}

/// Reads a log with poses by odometry. If the laser poses of the scans do not keep a fixed place on the robot, they are
/// corrected ones.
pub(super) fn parse(text: &str) -> Result<Vec<LogRecord>, LogError> {
    let records = records(text)?;
    let offsets = Offsets::parse(text)?;
    let scans = || {
        records.iter().filter_map(|record| match record {
            Record::Scan(line) => Some(line),
            Record::Odometry(..) => None,
        })
    };
    let mounting = |is_rear| {
        let mut of_side = scans().filter(|line| line.is_rear == is_rear);
        let first = of_side.next().map(|line| line.robot.inverse_transform_pose(&line.laser))?;
        let is_same = |line: &Line| {
            let mount = line.robot.inverse_transform_pose(&line.laser);
            (mount.position() - first.position()).norm() <= SAME_M
                && wrap_angle(mount.yaw - first.yaw).abs() <= SAME_RAD
        };
        of_side.all(is_same).then_some(first)
    };
    let mounts = [mounting(false), mounting(true)];
    let record = |record: &Record| match record {
        Record::Odometry(time_s, odometry) => {
            LogRecord { time_s: *time_s, odometry: *odometry, corrected: None, scan: None }
        }
        Record::Scan(line) => {
            let fixed = mounts[usize::from(line.is_rear)];
            let mount = fixed.unwrap_or_else(|| offsets.mount(line.is_rear));
            LogRecord {
                time_s: line.time_s,
                odometry: line.robot,
                corrected: fixed.is_none().then(|| line.laser.frame_origin(&mount)),
                scan: Some(line.scan(&mount)),
            }
        }
    };
    Ok(records.iter().map(record).collect())
}

/// Reads a log that `gfs2log` of GMapping wrote. A scan has the corrected pose. The `ODOM` lines continue from there, so their
/// steps are those of the odometry; an `ODOM` line with the time zero repeats the corrected pose.
pub(super) fn parse_gmapping(text: &str) -> Result<Vec<LogRecord>, LogError> {
    let mut parsed = Vec::new();
    let (mut odometry, mut last): (Pose, Option<Pose>) = (Pose::default(), None);
    for record in records(text)? {
        match record {
            Record::Odometry(time_s, pose) => {
                odometry = last.map_or(pose, |last| {
                    odometry.transform_pose(&last.inverse_transform_pose(&pose))
                });
                odometry.yaw = wrap_angle(odometry.yaw);
                last = Some(pose);
                if time_s != 0.0 {
                    parsed.push(LogRecord { time_s, odometry, corrected: None, scan: None });
                }
            }
            Record::Scan(line) => {
                if last.replace(line.robot).is_none() {
                    odometry = line.robot;
                }
                let mount = Offsets::default().mount(line.is_rear);
                let corrected = Some(line.robot);
                let scan = Some(line.scan(&mount));
                parsed.push(LogRecord { time_s: line.time_s, odometry, corrected, scan });
            }
        }
    }
    Ok(parsed)
}

/// Reads all lines. Messages that hold neither scans nor odometry are skipped.
fn records(text: &str) -> Result<Vec<Record>, LogError> {
    let mut records = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let mut words = line.split_whitespace();
        let name = words.next().unwrap_or("#");
        let fields = |record| Fields::new(index + 1, record, words);
        match name {
            "ODOM" => {
                let mut fields = fields("ODOM");
                let pose = fields.pose("pose")?;
                fields.skip(3, "speeds")?;
                records.push(Record::Odometry(fields.number("time")?, pose));
            }
            "FLASER" => records.push(Record::Scan(old_scan(fields("FLASER"))?)),
            "RLASER" => records.push(Record::Scan(old_scan(fields("RLASER"))?)),
            "ROBOTLASER1" => records.push(Record::Scan(scan(fields("ROBOTLASER1"))?)),
            name if !is_name(name) => {
                let expected = "the name of a CARMEN message, or #";
                return Err(fields("a line").bad("first word", name, expected));
            }
            _ => {}
        }
    }
    Ok(records)
}

/// Whether a word is the name of a message or begins a comment.
fn is_name(word: &str) -> bool {
    let is_letter = |letter: char| letter.is_ascii_alphanumeric() || "_-()[]".contains(letter);
    word.starts_with(['#', '%'])
        || word.starts_with(|letter: char| letter.is_ascii_alphabetic())
            && word.chars().all(is_letter)
}

/// `FLASER` and `RLASER`: readings, laser pose, robot pose, time.
fn old_scan(mut fields: Fields<'_>) -> Result<Line, LogError> {
    let count = fields.count("number of readings")?;
    let readings = fields.numbers(count, "readings")?;
    let laser = fields.pose("laser pose")?;
    let robot = fields.pose("robot pose")?;
    let time_s = fields.number("time")?;
    Ok(Line {
        time_s,
        robot,
        laser,
        angles: beams::half_turn(count),
        readings,
        range_max: SICK_RANGE_M,
        is_rear: fields.record == "RLASER",
    })
}

/// `ROBOTLASER1`: configuration, readings, remissions, laser pose, robot pose, speeds and safety distances, time.
fn scan(mut fields: Fields<'_>) -> Result<Line, LogError> {
    fields.skip(1, "laser type")?;
    let first = fields.number("start angle")?;
    fields.skip(1, "field of view")?;
    let step = fields.number("angular resolution")?;
    let range_max = fields.number("maximum range")?;
    if !(step > 0.0 && range_max > 0.0) {
        let value = format!("{step} and {range_max}");
        return Err(fields.bad("angular resolution and maximum range", &value, "above zero"));
    }
    fields.skip(2, "accuracy and remission mode")?;
    let count = fields.count("number of readings")?;
    let readings = fields.numbers(count, "readings")?;
    let remissions = fields.count("number of remissions")?;
    fields.skip(remissions, "remissions")?;
    let laser = fields.pose("laser pose")?;
    let robot = fields.pose("robot pose")?;
    fields.skip(5, "speeds and safety distances")?;
    let time_s = fields.number("time")?;
    // The largest value means that nothing was seen.
    let range_max = range_max.next_down();
    Ok(Line { time_s, robot, laser, readings, angles: (first, step), range_max, is_rear: false })
}

impl Line {
    fn scan(&self, mount: &Pose) -> LoggedScan {
        beams::scan(&self.readings, self.angles, self.range_max, mount, self.time_s)
    }
}

/// Distances of the lidars before and behind the robot's origin, metres: the parameters `robot_frontlaser_offset` and
/// `robot_rearlaser_offset`.
#[derive(Default)]
struct Offsets {
    front_m: f64,
    rear_m: f64,
}

impl Offsets {
    fn parse(text: &str) -> Result<Self, LogError> {
        let mut offsets = Self::default();
        for (index, line) in text.lines().enumerate() {
            let mut words = line.split_whitespace();
            if words.next() != Some("PARAM") {
                continue;
            }
            let name = words.next();
            let mut value = Fields::new(index + 1, "PARAM", words);
            match name {
                Some("robot_frontlaser_offset") => offsets.front_m = value.number("value")?,
                Some("robot_rearlaser_offset") => offsets.rear_m = value.number("value")?,
                _ => {}
            }
        }
        Ok(offsets)
    }

    const fn mount(&self, is_rear: bool) -> Pose {
        if is_rear { Pose::new(self.rear_m, 0.0, PI) } else { Pose::new(self.front_m, 0.0, 0.0) }
    }
}
