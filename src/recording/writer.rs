//! The file itself: MCAP in the profile of ROS 2, written front to back in whole chunks.

use std::collections::BTreeMap;
use std::io::{BufWriter, Write};

use mcap::records::{MessageHeader, Metadata};
use mcap::write::NoSeek;
use mcap::{Attachment, McapError, WriteOptions};

use super::{Head, RecordingError, Tail, Topic, definitions, messages, parts};

/// Name of the metadata that end a recording.
pub const END: &str = "inbye.end";
pub const TICKS: &str = "ticks";
pub const TRACE_DIGEST: &str = "trace_digest";

/// A chunk is written when it has so many bytes: the most that waits in memory.
const CHUNK_BYTES: usize = 1 << 20;
/// Or when it began so long ago, nanoseconds: what is lost of a drive that is killed.
const CHUNK_NANOSECONDS: u64 = 2_000_000_000;

/// A message on its way to the file.
pub struct Entry {
    pub topic: Topic,
    /// Its time, nanoseconds.
    pub time: u64,
    pub bytes: Vec<u8>,
}

/// A recording that is being written. An error ends it: what was written before can be read.
pub struct RecordingWriter<W: Write> {
    file: mcap::Writer<NoSeek<BufWriter<W>>>,
    /// By the numbers of the topics.
    channels: Vec<u16>,
    sequence: Vec<u32>,
    chunk_bytes: usize,
    chunk_began: Option<u64>,
    /// Messages in the chunk, and in chunks that were written.
    waiting: u64,
    written: u64,
}

impl<W: Write> RecordingWriter<W> {
    /// Writes the head: the drive as attachments, then the map.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn new(file: W, head: &Head) -> Result<Self, RecordingError> {
        let options = WriteOptions::new()
            .profile("ros2")
            .library(concat!("inbye ", env!("CARGO_PKG_VERSION")))
            .disable_seeking(true)
            // Chunks end where this writer says.
            .chunk_size(None);
        let mut file = options
            .create(NoSeek::new(BufWriter::new(file)))
            .map_err(plain)?;
        for (name, text) in head.texts()? {
            let attachment = Attachment {
                log_time: 0,
                create_time: 0,
                name: name.to_owned(),
                media_type: "application/toml".to_owned(),
                data: text.into_bytes().into(),
            };
            file.attach(&attachment).map_err(plain)?;
        }
        let mut channels = Vec::new();
        for topic in Topic::ALL {
            let (package, name) = topic.message();
            let schema = definitions::schema(&format!("{package}/{name}"));
            let full_name = format!("{package}/msg/{name}");
            let schema = file
                .add_schema(&full_name, "ros2msg", schema.as_bytes())
                .map_err(plain)?;
            let quality = (
                "offered_qos_profiles".to_owned(),
                topic.quality_of_service(),
            );
            let channel = file
                .add_channel(schema, topic.name(), "cdr", &BTreeMap::from([quality]))
                .map_err(plain)?;
            channels.push(channel);
        }
        let mut writer = Self {
            file,
            sequence: vec![0; channels.len()],
            channels,
            chunk_bytes: 0,
            chunk_began: None,
            waiting: 0,
            written: 0,
        };
        let map = Entry {
            topic: Topic::Map,
            time: parts::nanoseconds(0.0),
            bytes: messages::map(&head.map),
        };
        writer.write(&[map])?;
        writer.end_chunk()?;
        Ok(writer)
    }

    /// Writes the messages of a tick. They stay together: a chunk never ends between them.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write(&mut self, entries: &[Entry]) -> Result<(), RecordingError> {
        for entry in entries {
            let number = entry.topic as usize;
            let header = MessageHeader {
                channel_id: self.channels[number],
                sequence: self.sequence[number],
                log_time: entry.time,
                publish_time: entry.time,
            };
            self.file
                .write_to_known_channel(&header, &entry.bytes)
                .map_err(plain)?;
            self.sequence[number] = self.sequence[number].wrapping_add(1);
            self.chunk_bytes += entry.bytes.len();
            self.waiting += 1;
        }
        let now = entries.last().map_or(0, |entry| entry.time);
        let began = *self.chunk_began.get_or_insert(now);
        if self.chunk_bytes >= CHUNK_BYTES || now >= began.saturating_add(CHUNK_NANOSECONDS) {
            self.end_chunk()?;
        }
        Ok(())
    }

    /// Writes what waits.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn end_chunk(&mut self) -> Result<(), RecordingError> {
        self.file.flush().map_err(plain)?;
        self.written += self.waiting;
        self.waiting = 0;
        self.chunk_bytes = 0;
        self.chunk_began = None;
        Ok(())
    }

    /// Messages that are in the file and can be read from it, whatever becomes of the rest.
    pub const fn written(&self) -> u64 {
        self.written
    }

    /// Writes how the drive ended, and the index of the file.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn finish(&mut self, tail: &Tail) -> Result<(), RecordingError> {
        self.end_chunk()?;
        let metadata = BTreeMap::from([
            (TICKS.to_owned(), tail.ticks.to_string()),
            (TRACE_DIGEST.to_owned(), tail.trace_digest.clone()),
        ]);
        let end = Metadata {
            name: END.to_owned(),
            metadata,
        };
        self.file.write_metadata(&end).map_err(plain)?;
        self.file.finish().map_err(plain)?;
        Ok(())
    }
}

/// In the system's own words: the crate's do not say what went wrong.
fn plain(error: McapError) -> RecordingError {
    RecordingError::Io(match error {
        McapError::Io(error) => error,
        other => std::io::Error::other(other),
    })
}
