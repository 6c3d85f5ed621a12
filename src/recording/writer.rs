//! Writes the MCAP file from front to back in whole chunks.

use std::collections::BTreeMap;
use std::io::{BufWriter, Write};

use mcap::records::{MessageHeader, Metadata};
use mcap::write::NoSeek;
use mcap::{Attachment, McapError, WriteOptions};

use super::error::RecordingError;
use super::messages::{self, Topic};
use super::metadata::{DriveMetadata, DriveSummary};
use crate::map::OccupancyGrid;
use crate::ros::msg::Message;

/// Name and keys of the metadata record with the summary of the drive.
pub const SUMMARY: &str = "inbye.summary";
pub const TICKS: &str = "ticks";
pub const TRACE_DIGEST: &str = "trace_digest";

/// Name and key of the metadata record with the date of time zero.
const START: &str = "inbye.start";
const UNIX_S: &str = "unix_s";

/// Size at which a chunk is written, bytes. It limits the buffer.
const CHUNK_BYTES: usize = 1 << 20;
/// Age at which a chunk is written, nanoseconds. It limits the loss if the process is killed.
const CHUNK_NANOSECONDS: u64 = 2_000_000_000;

/// A message for the file.
pub struct Entry {
    pub topic: Topic,
    /// Time of the message, nanoseconds.
    pub time_ns: u64,
    pub bytes: Vec<u8>,
}

/// Writes a recording. Data before an error is readable.
pub struct RecordingWriter<W: Write> {
    file: mcap::Writer<NoSeek<BufWriter<W>>>,
    /// Channels by the numbers of the topics; none of those that most drives lack, before their first message.
    channels: [Option<u16>; Topic::ALL.len()],
    sequence: [u32; Topic::ALL.len()],
    chunk_bytes: usize,
    chunk_began: Option<u64>,
    /// Number of messages in the current chunk.
    buffered: u64,
    /// Number of messages in written chunks.
    written: u64,
}

impl<W: Write> RecordingWriter<W> {
    /// Writes the metadata as attachments, then the map and its zones.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn new(file: W, metadata: &DriveMetadata) -> Result<Self, RecordingError> {
        let options = WriteOptions::new()
            .profile("ros2")
            .library(concat!("inbye ", env!("CARGO_PKG_VERSION")))
            .disable_seeking(true)
            // This writer ends the chunks.
            .chunk_size(None);
        let mut file = options.create(NoSeek::new(BufWriter::new(file))).map_err(io_error)?;
        for (name, text) in metadata.attachments()? {
            let attachment = Attachment {
                log_time: 0,
                create_time: 0,
                name: name.to_owned(),
                media_type: "application/toml".to_owned(),
                data: text.into_bytes().into(),
            };
            file.attach(&attachment).map_err(io_error)?;
        }
        let mut writer = Self {
            file,
            channels: [None; Topic::ALL.len()],
            sequence: [0; Topic::ALL.len()],
            chunk_bytes: 0,
            chunk_began: None,
            buffered: 0,
            written: 0,
        };
        for topic in Topic::ALL {
            if !matches!(topic, Topic::Zones | Topic::UpdatedMap) {
                writer.channel(topic)?;
            }
        }
        let entry = |topic: Topic, grid: &OccupancyGrid| Entry {
            topic,
            time_ns: 0,
            bytes: messages::map(0.0, grid).to_cdr(),
        };
        writer.write(&[entry(Topic::Map, &metadata.map)])?;
        if let Some(zones) = &metadata.zones {
            writer.write(&[entry(Topic::Zones, zones.grid())])?;
        }
        writer.end_chunk()?;
        Ok(writer)
    }

    /// Writes the date of time zero, seconds since 1970-01-01 00:00 UTC.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write_start(&mut self, unix_s: f64) -> Result<(), RecordingError> {
        self.end_chunk()?;
        let metadata = BTreeMap::from([(UNIX_S.to_owned(), format!("{unix_s:.3}"))]);
        let record = Metadata { name: START.to_owned(), metadata };
        self.file.write_metadata(&record).map_err(io_error)
    }

    /// Writes the messages of a tick into the same chunk.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write(&mut self, entries: &[Entry]) -> Result<(), RecordingError> {
        for entry in entries {
            let number = entry.topic as usize;
            let header = MessageHeader {
                channel_id: self.channel(entry.topic)?,
                sequence: self.sequence[number],
                log_time: entry.time_ns,
                publish_time: entry.time_ns,
            };
            self.file.write_to_known_channel(&header, &entry.bytes).map_err(io_error)?;
            self.sequence[number] = self.sequence[number].wrapping_add(1);
            self.chunk_bytes += entry.bytes.len();
            self.buffered += 1;
        }
        let now = entries.last().map_or(0, |entry| entry.time_ns);
        let began = *self.chunk_began.get_or_insert(now);
        if self.chunk_bytes >= CHUNK_BYTES || now >= began.saturating_add(CHUNK_NANOSECONDS) {
            self.end_chunk()?;
        }
        Ok(())
    }

    /// The channel of a topic, which is written first if it is new.
    fn channel(&mut self, topic: Topic) -> Result<u16, RecordingError> {
        if let Some(channel) = self.channels[topic as usize] {
            return Ok(channel);
        }
        let (name, message_type, schema) = topic.description();
        let schema =
            self.file.add_schema(&message_type, "ros2msg", schema.as_bytes()).map_err(io_error)?;
        let quality = ("offered_qos_profiles".to_owned(), topic.quality_of_service());
        let channel = self
            .file
            .add_channel(schema, name, "cdr", &BTreeMap::from([quality]))
            .map_err(io_error)?;
        self.channels[topic as usize] = Some(channel);
        Ok(channel)
    }

    /// Writes the current chunk.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn end_chunk(&mut self) -> Result<(), RecordingError> {
        self.file.flush().map_err(io_error)?;
        self.written += self.buffered;
        self.buffered = 0;
        self.chunk_bytes = 0;
        self.chunk_began = None;
        Ok(())
    }

    /// Number of messages that are readable in the file.
    pub const fn written(&self) -> u64 {
        self.written
    }

    /// Writes the summary of the drive and the index of the file.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn finish(&mut self, summary: &DriveSummary) -> Result<(), RecordingError> {
        self.end_chunk()?;
        let values = BTreeMap::from([
            (TICKS.to_owned(), summary.ticks.to_string()),
            (TRACE_DIGEST.to_owned(), summary.trace_digest.clone()),
        ]);
        let metadata = Metadata { name: SUMMARY.to_owned(), metadata: values };
        self.file.write_metadata(&metadata).map_err(io_error)?;
        self.file.finish().map_err(io_error)?;
        Ok(())
    }
}

/// Unwraps the error of the operating system: the message of `mcap` does not contain it.
fn io_error(error: McapError) -> RecordingError {
    RecordingError::Io(match error {
        McapError::Io(error) => error,
        other => std::io::Error::other(other),
    })
}
