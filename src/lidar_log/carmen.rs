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

/// The message with a scan of the front lidar without poses.
pub(super) const RAW: &str = "RAWLASER1";

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
    let offsets = Offsets::parse(text)?;
    let mut records = records(text, RawScans::Skip)?;
    if !records.iter().any(|record| matches!(record, Record::Scan(_))) {
        records = raw_records(text, &offsets)?;
    }
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
    for record in records(text, RawScans::Skip)? {
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

/// Reads all lines of a log whose scans have no poses: they have those by the odometry at their times.
fn raw_records(text: &str, offsets: &Offsets) -> Result<Vec<Record>, LogError> {
    let mut records = records(text, RawScans::Read)?;
    let odometry = records.iter().filter_map(|record| match record {
        Record::Odometry(time_s, pose) => Some((*time_s, *pose)),
        Record::Scan(_) => None,
    });
    let mut odometry: Vec<(f64, Pose)> = odometry.collect();
    odometry.sort_by(|one, other| one.0.total_cmp(&other.0));
    if odometry.is_empty() {
        let line = text.lines().position(|line| line.starts_with(RAW)).unwrap_or(0) + 1;
        return Err(LogError::OutOfOrder { line, record: RAW, needed: "ODOM" });
    }
    for record in &mut records {
        if let Record::Scan(line) = record {
            line.robot = pose_at(&odometry, line.time_s);
            line.laser = line.robot.transform_pose(&offsets.mount(false));
        }
    }
    Ok(records)
}

/// The pose at a time, interpolated between poses in the order of their times. Before the first and after the last, it is that
/// pose.
fn pose_at(poses: &[(f64, Pose)], time_s: f64) -> Pose {
    let after = poses.partition_point(|(at_s, _)| *at_s <= time_s).min(poses.len() - 1);
    let ((start_s, start), (end_s, end)) = (poses[after.saturating_sub(1)], poses[after]);
    let took_s = end_s - start_s;
    let fraction = if took_s > 0.0 { (time_s - start_s) / took_s } else { 0.0 };
    start.interpolate(&end, fraction.clamp(0.0, 1.0))
}

/// Reads all lines. Messages that hold neither scans nor odometry are skipped, and so are scans without poses unless they are
/// wanted.
fn records(text: &str, raw_scans: RawScans) -> Result<Vec<Record>, LogError> {
    let mut records = Vec::new();
    let mut lines = text.lines().enumerate().peekable();
    // The names of most loggers follow each time, and their own time.
    let mut names_logger = false;
    while let Some((index, line)) = lines.next() {
        let mut words = line.split_whitespace();
        let name = words.next().unwrap_or("#");
        let fields = |record| Fields::new(index + 1, record, words);
        let mut fields = match name {
            "ODOM" => fields("ODOM"),
            "FLASER" => fields("FLASER"),
            "RLASER" => fields("RLASER"),
            "ROBOTLASER1" => fields("ROBOTLASER1"),
            RAW if raw_scans == RawScans::Read => fields(RAW),
            name if !is_name(name) => {
                let expected = "the name of a CARMEN message, or #";
                return Err(fields("a line").bad("first word", name, expected));
            }
            _ => continue,
        };
        records.push(match name {
            "ODOM" => {
                let pose = fields.pose("pose")?;
                fields.skip(3, "speeds")?;
                Record::Odometry(fields.number("time")?, pose)
            }
            "FLASER" | "RLASER" => Record::Scan(old_scan(&mut fields)?),
            _ => Record::Scan(scan(&mut fields)?),
        });
        // A time may have lost its last digits.
        let is_last = lines.peek().is_none() && !text.ends_with('\n');
        if names_logger && is_last {
            fields.skip(1, "name of the logger")?;
        }
        names_logger |= !fields.is_empty();
    }
    Ok(records)
}

/// What to do with scans without poses.
#[derive(Clone, Copy, PartialEq, Eq)]
enum RawScans {
    Read,
    Skip,
}

/// Whether a word is the name of a message or begins a comment.
fn is_name(word: &str) -> bool {
    let is_letter = |letter: char| letter.is_ascii_alphanumeric() || "_-()[]".contains(letter);
    // `$` begins a sentence of a GPS receiver (NMEA 0183).
    word.starts_with(['#', '%', '$'])
        || word.starts_with(|letter: char| letter.is_ascii_alphabetic())
            && word.chars().all(is_letter)
}

/// `FLASER` and `RLASER`: readings, laser pose, robot pose, time.
fn old_scan(fields: &mut Fields<'_>) -> Result<Line, LogError> {
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

/// `ROBOTLASER1`: configuration, readings, remissions, laser pose, robot pose, speeds and safety distances, time. `RAWLASER1` has
/// no poses, speeds and distances.
fn scan(fields: &mut Fields<'_>) -> Result<Line, LogError> {
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
    let (mut laser, mut robot) = (Pose::default(), Pose::default());
    if fields.record != RAW {
        laser = fields.pose("laser pose")?;
        robot = fields.pose("robot pose")?;
        fields.skip(5, "speeds and safety distances")?;
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    const RAW_LOG: &str = "PARAM robot_frontlaser_offset 0.1\n\
        ODOM 1 0 0 0 0 0 10 h 10\nRAWLASER1 0 -1 2 1 8 0.01 0 3 1 8 3 2 7 7 10.5 h 10.5\n\
        ODOM 2 0 0 0 0 0 11 h 11\nRAWLASER1 0 -1 2 1 8 0.01 0 3 1 2 3 0 12.5 h 12.5\n";

    #[test]
    fn raw_scans_have_the_odometry_of_their_times() {
        let records = parse(RAW_LOG).expect("it is valid");
        let scans = records.iter().filter_map(|record| {
            let ranges =
                record.scan.as_ref()?.beams.beams.iter().map(|beam| beam.range.is_finite());
            Some((record.time_s, record.odometry.x, record.corrected, ranges.collect::<Vec<_>>()))
        });
        let expected =
            [(10.5, 1.5, None, vec![true, false, true]), (12.5, 2.0, None, vec![true; 3])];
        assert_eq!(scans.collect::<Vec<_>>(), expected);
        let mounts = records.iter().filter_map(|record| record.scan.as_ref()).map(|it| it.mount);
        assert!(mounts.into_iter().all(|mount| (mount.x - 0.1).abs() < 1e-9));
    }

    #[test]
    fn raw_scans_count_only_where_no_scan_has_poses() {
        let other = "FLASER 1 2 0 0 0 0 0 0 11 h 11\nRAWLASER1 0 not read\n";
        let records =
            parse(&format!("{other}{}", "ODOM 0 0 0 0 0 0 1 h 1\n")).expect("it is valid");
        assert_eq!(records.iter().filter(|record| record.scan.is_some()).count(), 1);
        let error = parse(&RAW_LOG.replace("ODOM", "OTHER")).expect_err("no odometry").to_string();
        assert!(error.starts_with("line 3: RAWLASER1 has no ODOM before it"), "{error}");
    }

    /// The last time may have lost digits; where no line goes on after its time, it is whole.
    #[test]
    fn last_line_without_line_end_must_go_on_after_its_time_as_others_do() {
        let cut = RAW_LOG.strip_suffix("5 h 12.5\n").expect("a time");
        let error = parse(cut).expect_err("it is cut").to_string();
        assert!(
            error.starts_with("line 5: RAWLASER1 ends before its name of the logger"),
            "{error}"
        );
        let plain = RAW_LOG.replace(" h 10.5", "").replace(" h 10", "").replace(" h 11", "");
        let plain = plain.replace(" h 12.5\n", "");
        assert_eq!(parse(&plain).map(|records| records.len()), Ok(4));
    }

    #[test]
    fn sentences_of_a_gps_receiver_are_skipped() {
        let records = parse(&format!("$GPGGA,120000,48.1,N,7.8,E,1,8\n{RAW_LOG}"));
        assert_eq!(records.map(|records| records.len()), Ok(4));
    }
}
