//! Reads scans and odometry that a robot recorded with ROS 2, as a log.
//!
//! `rosbag2` writes MCAP files: messages in CDR, with the names of their types. inbye's own recordings are such files too.

use std::collections::{BTreeMap, VecDeque};
use std::io::{Read, Seek};

use mcap::McapError;
use mcap::records::Record;

use super::error::RecordingError;
use super::mcap_reader::McapReader;
use crate::geometry::Pose;
use crate::lidar_log::{LidarLog, LogFormat, LogRecord, LoggedScan};
use crate::localization::PoseHistory;
use crate::map::TimedScan;
use crate::ros::msg::{LaserScan, Message, Odometry, TFMessage};
use crate::ros::node::{Frames, laser_scan, planar_pose, timed_scan};

/// Frame of the map by REP-105: with a transform to it, a record has a corrected pose.
const MAP_FRAME: &str = "map";
/// The topic of transforms that hold for all times.
const STATIC_TRANSFORMS: &str = "/tf_static";

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

/// A scan that waits for odometry of its time.
#[derive(Debug)]
struct PendingScan {
    beams: TimedScan,
    end_s: f64,
    frame: String,
}

/// Reads a log from the files of a recording, one after the other.
#[derive(Debug)]
pub struct RosLogReader {
    scan_topic: Option<String>,
    /// Topics with scans, and with odometry, in the order in which they were seen.
    topics: [Vec<String>; 2],
    frames: Frames,
    base_frame: Option<String>,
    odometry: PoseHistory,
    /// Time of the first pose by odometry, seconds.
    first_s: Option<f64>,
    pending: VecDeque<PendingScan>,
    records: Vec<LogRecord>,
    /// Messages so far.
    messages: u64,
}

impl RosLogReader {
    /// Creates a reader for the scans of a topic, or of the only one.
    #[must_use]
    pub fn new(scan_topic: Option<&str>) -> Self {
        Self {
            scan_topic: scan_topic.map(str::to_owned),
            topics: [Vec::new(), Vec::new()],
            frames: Frames::default(),
            base_frame: None,
            odometry: PoseHistory::new(),
            first_s: None,
            pending: VecDeque::new(),
            records: Vec::new(),
            messages: 0,
        }
    }

    /// Reads a file. Of a truncated one, everything up to its last whole chunk.
    ///
    /// # Errors
    /// When the file is no MCAP file, is damaged or cannot be read, or a message is invalid.
    pub fn read(&mut self, file: impl Read + Seek) -> Result<(), RecordingError> {
        let mut mcap = McapReader::new(file);
        let mut types: BTreeMap<u16, String> = BTreeMap::new();
        let mut channels: BTreeMap<u16, Channel> = BTreeMap::new();
        loop {
            match mcap.next() {
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
                        self.take(channel, &data, header.log_time as f64 * 1e-9)?;
                    }
                }
                Ok(Some(_)) => {}
                Ok(None) | Err(McapError::UnexpectedEof | McapError::UnexpectedEoc) => {
                    return Ok(());
                }
                Err(McapError::BadMagic) => return Err(RecordingError::NotMcap),
                Err(error) => {
                    let (messages, reason) = (self.messages, error.to_string());
                    return Err(RecordingError::DamagedLog { messages, reason });
                }
            }
        }
    }

    /// The log of all files.
    ///
    /// # Errors
    /// When scans or odometry are missing, are on several topics, or the place of the lidar on the robot is not known.
    pub fn finish(mut self) -> Result<LidarLog, RecordingError> {
        let [scans, odometry] = &self.topics;
        for (missing, topics) in [(LaserScan::NAME, scans), (Odometry::NAME, odometry)] {
            if topics.is_empty() {
                return Err(RecordingError::NoMessages { missing });
            }
        }
        if self.scan_topic.is_none() && scans.len() > 1 {
            return Err(RecordingError::SeveralTopics { topics: scans.join(", ") });
        }
        if let Some(topic) = self.scan_topic.as_ref().filter(|topic| !scans.contains(*topic)) {
            let (topic, topics) = (topic.clone(), scans.join(", "));
            return Err(RecordingError::NoScansOn { topic, topics });
        }
        // Scans after the last odometry have no pose.
        let first_s = self.records.iter().map(|record| record.time_s).fold(f64::INFINITY, f64::min);
        for record in &mut self.records {
            record.time_s -= first_s;
            let beams = record.scan.iter_mut().flat_map(|scan| &mut scan.beams.beams);
            beams.for_each(|beam| beam.time_s -= first_s);
        }
        Ok(LidarLog { format: LogFormat::Ros2, records: self.records, has_times: true })
    }

    fn take(&mut self, channel: &Channel, data: &[u8], log_s: f64) -> Result<(), RecordingError> {
        let topic = &channel.topic;
        let invalid = |reason: String| {
            let (topic, number) = (topic.clone(), self.messages);
            RecordingError::InvalidMessage { topic, number, reason }
        };
        let no_cdr = || invalid("it is no message of its type".to_owned());
        match channel.kind {
            Kind::Transforms => {
                let message = TFMessage::from_cdr(data).ok_or_else(no_cdr)?;
                // A transform that repeats an older time is of no use, and no reason to refuse a recording.
                let _ = self.frames.update(log_s, &message, topic == STATIC_TRANSFORMS);
            }
            Kind::Scan => {
                note_topic(&mut self.topics[0], topic);
                if self.scan_topic.as_ref().unwrap_or(&self.topics[0][0]) != topic {
                    return Ok(());
                }
                let message = LaserScan::from_cdr(data).ok_or_else(no_cdr)?;
                let scan = laser_scan(&message).map_err(|error| invalid(error.to_string()))?;
                // A scan without a stamp or without beams tells nothing.
                if let Some(beams) = timed_scan(&message, &scan) {
                    let end_s = beams.beams.last().map_or(0.0, |beam| beam.time_s);
                    let frame = message.header.frame_id;
                    self.pending.push_back(PendingScan { beams, end_s, frame });
                }
            }
            Kind::Odometry => {
                note_topic(&mut self.topics[1], topic);
                if self.topics[1][0] != *topic {
                    return Ok(());
                }
                let message = Odometry::from_cdr(data).ok_or_else(no_cdr)?;
                let pose = planar_pose("pose", &message.pose.pose);
                let pose = pose.map_err(|error| invalid(error.to_string()))?;
                let time_s = message.header.stamp.seconds();
                if self.odometry.newest().is_some_and(|(last_s, _)| time_s <= last_s) {
                    return Ok(());
                }
                self.base_frame.get_or_insert(message.child_frame_id);
                self.first_s.get_or_insert(time_s);
                self.odometry.record(time_s, &pose);
                self.release_scans(time_s)?;
                self.records.push(LogRecord {
                    time_s,
                    odometry: pose,
                    corrected: self.corrected(time_s),
                    scan: None,
                });
            }
        }
        Ok(())
    }

    /// The robot's pose in the map, where the recording has it.
    fn corrected(&self, time_s: f64) -> Option<Pose> {
        let base_frame = self.base_frame.as_deref()?;
        Some(self.frames.pose_in(MAP_FRAME, base_frame, time_s)?.pose)
    }

    /// Adds the scans that ended by the time of the newest odometry.
    fn release_scans(&mut self, newest_s: f64) -> Result<(), RecordingError> {
        while self.pending.front().is_some_and(|scan| scan.end_s <= newest_s) {
            let Some(scan) = self.pending.pop_front() else { break };
            // Before the first odometry there is no pose.
            let has_pose = self.first_s.is_some_and(|first_s| scan.end_s >= first_s);
            let Some(odometry) = self.odometry.at(scan.end_s).filter(|_| has_pose) else {
                continue;
            };
            let base_frame = self.base_frame.as_deref().unwrap_or_default();
            let mount = self.frames.pose_in(base_frame, &scan.frame, scan.end_s);
            let mount = mount.ok_or_else(|| RecordingError::NoMount {
                lidar: scan.frame.clone(),
                base: base_frame.to_owned(),
            })?;
            let mount = mount.pose;
            let mut beams = scan.beams;
            for beam in &mut beams.beams {
                *beam = beam.from_mount(&mount);
            }
            beams.range_max += mount.position().to_vector().norm();
            self.records.push(LogRecord {
                time_s: scan.end_s,
                odometry,
                corrected: self.corrected(scan.end_s),
                scan: Some(LoggedScan { mount, beams }),
            });
        }
        Ok(())
    }
}

fn note_topic(topics: &mut Vec<String>, topic: &str) {
    if !topics.iter().any(|known| known == topic) {
        topics.push(topic.to_owned());
    }
}
