//! Reads scans and odometry that a robot recorded with ROS 2, as a log.
//!
//! `rosbag2` writes MCAP files: messages in CDR, with the names of their types. inbye's own recordings are such files too.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::io::{Read, Seek};

use mcap::McapError;
use mcap::records::Record;
use thiserror::Error;

use super::error::RecordingError;
use super::mcap_reader::McapReader;
use crate::geometry::Pose;
use crate::lidar_log::{LidarLog, LogFormat, LogRecord, LoggedScan, remove_limit};
use crate::localization::PoseHistory;
use crate::map::TimedScan;
use crate::ros::msg::{LaserScan, Message, Odometry, TFMessage};
use crate::ros::node::{
    Frames, NoPose, frame_name, laser_scan, level_range, planar_pose, timed_scan,
};

/// Frame of the map by REP-105: with a transform to it, a record has a corrected pose.
const MAP_FRAME: &str = "map";
/// The end of the topic of transforms that hold for all times.
const STATIC_TRANSFORMS: &str = "/tf_static";
/// A stamp that is older than the one before by more than this, seconds, means that the clock was set.
const MAX_BACK_S: f64 = 1.0;

/// The first bytes of a message in CDR whose numbers begin with their highest byte.
const BIG_ENDIAN: [u8; 2] = [0, 0];

/// A kind of message that is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Scan,
    Odometry,
    Transforms,
}

impl Kind {
    const ALL: [(Self, &'static str, &'static str); 3] = [
        (Self::Scan, LaserScan::PACKAGE, LaserScan::NAME),
        (Self::Odometry, Odometry::PACKAGE, Odometry::NAME),
        (Self::Transforms, TFMessage::PACKAGE, TFMessage::NAME),
    ];

    /// The kind of a type such as `sensor_msgs/msg/LaserScan`.
    fn of(type_name: &str) -> Option<Self> {
        let is_so = |(_, package, name): &&(Self, &str, &str)| {
            type_name.strip_prefix(package).and_then(|rest| rest.strip_prefix("/msg/"))
                == Some(name)
        };
        Self::ALL.iter().find(is_so).map(|(kind, ..)| *kind)
    }
}

/// A channel of a file.
#[derive(Clone, Debug)]
struct Channel {
    topic: String,
    kind: Kind,
}

/// A scan whose pose is not known yet.
#[derive(Debug)]
struct RecordedScan {
    beams: TimedScan,
    end_s: f64,
    frame: String,
}

/// What a log leaves out.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum RosLogWarning {
    /// Messages that cannot be used.
    #[error("messages left out on {topic}: {count}; the first: {reason}")]
    InvalidMessages {
        /// Their topic.
        topic: String,
        /// Their number.
        count: usize,
        /// The cause for the first one.
        reason: String,
    },
    /// Scans before the first odometry, or after the last.
    #[error("scans left out: {count}; they have no odometry of their time")]
    ScansWithoutOdometry {
        /// Their number.
        count: usize,
    },
    /// A file was cut off.
    #[error("a file was cut off: everything up to its last whole chunk is read")]
    Truncated,
}

/// Reads a log from the files of a recording, one after the other.
#[derive(Debug)]
pub struct RosLogReader {
    /// The topics to read: of scans, and of odometry.
    chosen: [Option<String>; 2],
    /// Topics with scans, and with odometry, in the order in which they were seen.
    topics: [Vec<String>; 2],
    frames: Frames,
    base_frame: Option<String>,
    /// Poses by odometry in the order of their stamps, which are seconds and nanoseconds.
    odometry: BTreeMap<(i32, u32), (f64, Pose)>,
    scans: Vec<RecordedScan>,
    /// Messages so far.
    messages: u64,
    /// Unusable messages by topic: their number, and the error of the first.
    invalid: BTreeMap<String, (usize, RecordingError)>,
    is_truncated: bool,
}

impl RosLogReader {
    /// Creates a reader for the scans and the odometry of these topics; of the only one where none is named.
    #[must_use]
    pub fn new(scan_topic: Option<&str>, odometry_topic: Option<&str>) -> Self {
        Self {
            chosen: [scan_topic, odometry_topic].map(|topic| topic.map(str::to_owned)),
            topics: [Vec::new(), Vec::new()],
            frames: Frames::of_log(),
            base_frame: None,
            odometry: BTreeMap::new(),
            scans: Vec::new(),
            messages: 0,
            invalid: BTreeMap::new(),
            is_truncated: false,
        }
    }

    /// Reads a file. Of a truncated one, everything up to its last whole chunk. A message that cannot be used is left out.
    ///
    /// # Errors
    /// When the file is no MCAP file, is damaged or cannot be read, or the stamps of the odometry go back.
    pub fn read(&mut self, file: impl Read + Seek) -> Result<(), RecordingError> {
        let mut mcap = McapReader::new(file);
        let mut types: BTreeMap<u16, String> = BTreeMap::new();
        let mut channels: BTreeMap<u16, Channel> = BTreeMap::new();
        let mut is_mcap = false;
        loop {
            let next = mcap.next();
            is_mcap |= matches!(next, Ok(Some(_)));
            match next {
                Ok(Some(Record::Schema { header, .. })) => {
                    types.insert(header.id, header.name);
                }
                Ok(Some(Record::Channel(channel))) => {
                    let kind = types.get(&channel.schema_id).and_then(|name| Kind::of(name));
                    if let Some(kind) = kind {
                        if channel.message_encoding != "cdr" {
                            let (topic, encoding) = (channel.topic, channel.message_encoding);
                            return Err(RecordingError::OtherEncoding { topic, encoding });
                        }
                        channels.insert(channel.id, Channel { topic: channel.topic, kind });
                    }
                }
                Ok(Some(Record::Message { header, data })) => {
                    if let Some(channel) = channels.get(&header.channel_id) {
                        self.messages += 1;
                        let taken = self.take(channel, &data, header.log_time as f64 * 1e-9);
                        self.leave_out_invalid(taken)?;
                    }
                }
                Ok(Some(_)) => {}
                Ok(None) | Err(McapError::UnexpectedEof | McapError::BadMagic) if !is_mcap => {
                    return Err(RecordingError::NotMcap);
                }
                Ok(None) => return Ok(()),
                // After the first record, a bad magic number is that of the end.
                Err(McapError::UnexpectedEof | McapError::UnexpectedEoc | McapError::BadMagic) => {
                    self.is_truncated = true;
                    return Ok(());
                }
                Err(error) => {
                    let (messages, reason) = (self.messages, error.to_string());
                    return Err(RecordingError::DamagedLog { messages, reason });
                }
            }
        }
    }

    /// The log of all files, and what it leaves out.
    ///
    /// # Errors
    /// When scans or odometry are missing, are on several topics, or the place of the lidar on the robot is not known.
    pub fn finish(mut self) -> Result<(LidarLog, Vec<RosLogWarning>), RecordingError> {
        self.check_topics()?;
        let scans = core::mem::take(&mut self.scans);
        let all = scans.len();
        let mut records = Vec::with_capacity(all + self.odometry.len());
        let mut history = PoseHistory::of_log();
        self.odometry.values().for_each(|(time_s, pose)| history.record(*time_s, pose));
        for scan in scans {
            records.extend(self.scan_record(scan, &history)?);
        }
        let mut warnings: Vec<RosLogWarning> = Vec::new();
        if records.len() < all {
            warnings.push(RosLogWarning::ScansWithoutOdometry { count: all - records.len() });
        }
        records.extend(self.odometry.values().map(|(time_s, pose)| LogRecord {
            time_s: *time_s,
            odometry: *pose,
            corrected: None,
            scan: None,
        }));
        // Stable: a scan stays before the odometry of its end.
        records.sort_by(|one, other| one.time_s.total_cmp(&other.time_s));
        let first_s = records.first().map_or(0.0, |record| record.time_s);
        for record in &mut records {
            record.corrected = self.corrected(record.time_s);
            record.time_s -= first_s;
            let beams = record.scan.iter_mut().flat_map(|scan| &mut scan.beams.beams);
            beams.for_each(|beam| beam.time_s -= first_s);
        }
        let scans = records.iter_mut().filter_map(|record| record.scan.as_mut());
        remove_limit(&mut scans.collect::<Vec<_>>());
        let invalid = self.invalid.into_iter().map(|(topic, (count, error))| {
            let reason = error.to_string();
            RosLogWarning::InvalidMessages { topic, count, reason }
        });
        warnings.extend(invalid);
        if self.is_truncated {
            warnings.push(RosLogWarning::Truncated);
        }
        let format = LogFormat::Ros2;
        Ok((LidarLog { format, records, has_times: true, cut_line: None }, warnings))
    }

    /// Checks that there are usable scans and odometry, each of one topic.
    fn check_topics(&mut self) -> Result<(), RecordingError> {
        let kinds =
            [(LaserScan::NAME, self.scans.is_empty()), (Odometry::NAME, self.odometry.is_empty())];
        for (((name, is_empty), topics), chosen) in
            kinds.into_iter().zip(&self.topics).zip(&self.chosen)
        {
            let Some(first) = topics.first() else {
                if self.is_truncated && self.messages == 0 {
                    return Err(RecordingError::TruncatedLog);
                }
                return Err(RecordingError::NoMessages { missing: name });
            };
            let listed = || topics.join(", ");
            match chosen {
                None if topics.len() > 1 => {
                    return Err(RecordingError::SeveralTopics { name, topics: listed() });
                }
                Some(topic) if !topics.contains(topic) => {
                    let topic = topic.clone();
                    return Err(RecordingError::NotOnTopic { name, topic, topics: listed() });
                }
                _ => {}
            }
            if is_empty
                && let Some((_, error)) = self.invalid.remove(chosen.as_ref().unwrap_or(first))
            {
                return Err(error);
            }
        }
        Ok(())
    }

    /// Keeps the error of a message that is left out; other errors end the reading.
    fn leave_out_invalid(
        &mut self,
        taken: Result<(), RecordingError>,
    ) -> Result<(), RecordingError> {
        let Err(error) = taken else {
            return Ok(());
        };
        let RecordingError::InvalidMessage { topic, .. } = &error else {
            return Err(error);
        };
        let topic = topic.clone();
        self.invalid.entry(topic).or_insert((0, error)).0 += 1;
        Ok(())
    }

    /// Notes a topic, and returns whether its messages are read.
    fn is_chosen(&mut self, kind: Kind, topic: &str) -> bool {
        let at = usize::from(kind == Kind::Odometry);
        let topics = &mut self.topics[at];
        if !topics.iter().any(|known| known == topic) {
            topics.push(topic.to_owned());
        }
        self.chosen[at].as_deref().unwrap_or(&topics[0]) == topic
    }

    fn take(&mut self, channel: &Channel, data: &[u8], log_s: f64) -> Result<(), RecordingError> {
        let topic = &channel.topic;
        let number = self.messages;
        let invalid = |reason: String| {
            let topic = topic.clone();
            RecordingError::InvalidMessage { topic, number, reason }
        };
        let no_cdr = || {
            let reason = if data.starts_with(&BIG_ENDIAN) {
                "it is in big-endian CDR, and only little-endian CDR is read: record with a little-endian computer"
            } else {
                "it is no message of its type"
            };
            invalid(reason.to_owned())
        };
        match channel.kind {
            Kind::Transforms => {
                let message = TFMessage::from_cdr(data).ok_or_else(no_cdr)?;
                // A transform that repeats an older time is of no use, and no reason to refuse a recording.
                let _ = self.frames.update(log_s, &message, topic.ends_with(STATIC_TRANSFORMS));
            }
            Kind::Scan if self.is_chosen(channel.kind, topic) => {
                let message = LaserScan::from_cdr(data).ok_or_else(no_cdr)?;
                let scan = laser_scan(&message).map_err(|error| invalid(error.to_string()))?;
                let frame = frame_name("header.frame_id", &message.header.frame_id);
                let frame = frame.map_err(|error| invalid(error.to_string()))?;
                let beams = timed_scan(&message, &scan);
                let beams = beams.ok_or_else(|| invalid("it has no ranges".to_owned()))?;
                let end_s = beams.beams.last().map_or(0.0, |beam| beam.time_s);
                self.scans.push(RecordedScan { beams, end_s, frame });
            }
            Kind::Odometry if self.is_chosen(channel.kind, topic) => {
                let message = Odometry::from_cdr(data).ok_or_else(no_cdr)?;
                let pose = planar_pose("pose", &message.pose.pose);
                let pose = pose.map_err(|error| invalid(error.to_string()))?;
                let base_frame = frame_name("child_frame_id", &message.child_frame_id);
                let base_frame = base_frame.map_err(|error| invalid(error.to_string()))?;
                let stamp = message.header.stamp;
                let time_s = stamp.seconds();
                let newest = self.odometry.last_key_value();
                let back_s = newest.map_or(0.0, |(_, (newest_s, _))| newest_s - time_s);
                if back_s > MAX_BACK_S {
                    let topic = topic.clone();
                    return Err(RecordingError::StampsGoBack { topic, number, back_s });
                }
                let Entry::Vacant(entry) = self.odometry.entry((stamp.sec, stamp.nanosec)) else {
                    return Err(invalid("another message has its stamp".to_owned()));
                };
                entry.insert((time_s, pose));
                self.base_frame.get_or_insert(base_frame);
            }
            Kind::Scan | Kind::Odometry => {}
        }
        Ok(())
    }

    /// The robot's pose in the map, where the recording has it.
    fn corrected(&self, time_s: f64) -> Option<Pose> {
        let base_frame = self.base_frame.as_deref()?;
        let found = self.frames.pose_in(MAP_FRAME, base_frame, time_s).ok()?;
        self.frames.have_begun(base_frame, time_s).then_some(found.pose)
    }

    /// The record of a scan; `None` where there is no odometry of its time.
    fn scan_record(
        &self,
        scan: RecordedScan,
        history: &PoseHistory,
    ) -> Result<Option<LogRecord>, RecordingError> {
        let RecordedScan { mut beams, end_s, frame } = scan;
        let times = history.oldest().zip(history.newest());
        let has_pose =
            times.is_some_and(|((first_s, _), (last_s, _))| (first_s..=last_s).contains(&end_s));
        let Some(odometry) = history.at(end_s).filter(|_| has_pose) else {
            return Ok(None);
        };
        let base = self.base_frame.clone().unwrap_or_default();
        let (mount, lean) = match self.frames.lidar_in(&base, &frame, end_s) {
            Ok(found) => (found.pose, found.lean),
            Err(NoPose::Unconnected) => {
                return Err(RecordingError::NoMount { lidar: frame, base });
            }
            Err(NoPose::Tilted) => {
                return Err(RecordingError::TiltedMount { lidar: frame, base });
            }
        };
        for beam in &mut beams.beams {
            beam.range = level_range(beam.angle, beam.range, &lean);
        }
        let scan = Some(LoggedScan { mount, beams: beams.from_mount(&mount) });
        Ok(Some(LogRecord { time_s: end_s, odometry, corrected: None, scan }))
    }
}
