//! Reads a recording: the metadata of the drive, then its ticks.

use std::io::{ErrorKind, Read};

use mcap::records::Record;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{McapError, McapResult};

use super::error::RecordingError;
use super::messages::Topic;
use super::metadata::{CONFIG, DRIVE, DriveMetadata, DriveSummary};
use super::tick::RecordedTick;
use super::writer::{SUMMARY, TICKS, TRACE_DIGEST};
use crate::ros::msg::{Message, OccupancyGrid};

/// Reads a recording.
pub struct Reader<R> {
    mcap: McapReader<R>,
    metadata: DriveMetadata,
    tick_channel: u16,
    ticks: u64,
    summary: Option<DriveSummary>,
    is_truncated: bool,
}

/// The parts of the metadata that were read so far.
#[derive(Default)]
struct Parts {
    config: Option<String>,
    drive: Option<String>,
    map_channel: Option<u16>,
    tick_channel: Option<u16>,
    cells: Option<Vec<i8>>,
}

impl<R: Read> Reader<R> {
    /// Reads the start of a recording: its metadata and its map.
    ///
    /// # Errors
    /// When the file is no recording of this format, is damaged or cannot be read.
    pub fn open(file: R) -> Result<Self, RecordingError> {
        let mut mcap = McapReader::new(file);
        let mut parts = Parts::default();
        while parts.cells.is_none() {
            match mcap.next() {
                Ok(Some(record)) => parts.take(record)?,
                Ok(None) | Err(McapError::UnexpectedEof | McapError::UnexpectedEoc) => break,
                Err(McapError::BadMagic) => return Err(RecordingError::NotMcap),
                Err(error) => return Err(damaged(0, error)),
            }
        }
        let (metadata, tick_channel) = parts.join()?;
        Ok(Self { mcap, metadata, tick_channel, ticks: 0, summary: None, is_truncated: false })
    }

    /// The initial state of the drive.
    #[must_use]
    pub const fn metadata(&self) -> &DriveMetadata {
        &self.metadata
    }

    /// The next tick, or nothing after the last. The last tick of a truncated file is that of the last whole chunk.
    ///
    /// # Errors
    /// When the file is damaged or cannot be read.
    pub fn next_tick(&mut self) -> Result<Option<RecordedTick>, RecordingError> {
        loop {
            match self.mcap.next() {
                Ok(Some(Record::Message { header, data }))
                    if header.channel_id == self.tick_channel =>
                {
                    return self.tick(&data).map(Some);
                }
                Ok(Some(Record::Metadata(summary))) if summary.name == SUMMARY => {
                    let values = summary.metadata;
                    let ticks = values.get(TICKS).and_then(|text| text.parse().ok());
                    let digest = values.get(TRACE_DIGEST);
                    self.summary = ticks.zip(digest).map(|(ticks, digest)| DriveSummary {
                        ticks,
                        trace_digest: digest.clone(),
                    });
                }
                Ok(Some(_)) => {}
                Ok(None) => return Ok(None),
                Err(McapError::UnexpectedEof | McapError::UnexpectedEoc) => {
                    self.is_truncated = true;
                    return Ok(None);
                }
                Err(error) => return Err(damaged(self.ticks, error)),
            }
        }
    }

    fn tick(&mut self, message: &[u8]) -> Result<RecordedTick, RecordingError> {
        let bad = |reason: String| RecordingError::Damaged { ticks: self.ticks, reason };
        let tick =
            RecordedTick::from_cdr(message).ok_or_else(|| bad("a tick is invalid".to_owned()))?;
        if tick.tick != self.ticks {
            return Err(bad(format!("the next tick is number {}", tick.tick)));
        }
        self.ticks += 1;
        Ok(tick)
    }

    /// The end of the drive. It is known after the last tick, unless the recording ended earlier.
    #[must_use]
    pub const fn summary(&self) -> Option<&DriveSummary> {
        self.summary.as_ref()
    }

    /// Whether the file holds the whole drive. It is known after the last tick.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        let ticks = self.summary.as_ref().map(|summary| summary.ticks);
        !self.is_truncated && ticks == Some(self.ticks)
    }
}

impl Parts {
    fn take(&mut self, record: Record<'_>) -> Result<(), RecordingError> {
        match record {
            Record::Attachment { header, data, .. } if header.name == CONFIG => {
                self.config = Some(text(CONFIG, data.into_owned())?);
            }
            Record::Attachment { header, data, .. } if header.name == DRIVE => {
                self.drive = Some(text(DRIVE, data.into_owned())?);
            }
            Record::Channel(channel) if channel.topic == Topic::Map.name() => {
                self.map_channel = Some(channel.id);
            }
            Record::Channel(channel) if channel.topic == Topic::Tick.name() => {
                self.tick_channel = Some(channel.id);
            }
            Record::Message { header, data } if Some(header.channel_id) == self.map_channel => {
                let map = OccupancyGrid::from_cdr(&data);
                let map = map.ok_or_else(|| RecordingError::Damaged {
                    ticks: 0,
                    reason: "the map is invalid".to_owned(),
                })?;
                self.cells = Some(map.data);
            }
            _ => {}
        }
        Ok(())
    }

    fn join(self) -> Result<(DriveMetadata, u16), RecordingError> {
        let missing = |missing| RecordingError::NotOurs { missing };
        let config = self.config.ok_or(missing("attachment config.toml"))?;
        let drive = self.drive.ok_or(missing("attachment drive.toml"))?;
        let channel = self.tick_channel.ok_or(missing("topic /inbye/tick"))?;
        let cells = self.cells.ok_or(missing("message on /map"))?;
        Ok((DriveMetadata::read(&config, &drive, cells)?, channel))
    }
}

fn text(name: &'static str, bytes: Vec<u8>) -> Result<String, RecordingError> {
    String::from_utf8(bytes)
        .map_err(|error| RecordingError::BadMetadata { name, reason: error.to_string() })
}

fn damaged(ticks: u64, error: McapError) -> RecordingError {
    match error {
        McapError::Io(error) => RecordingError::Io(error),
        other => RecordingError::Damaged { ticks, reason: other.to_string() },
    }
}

/// Bytes of a read. A length in the file is not trusted: more memory is used only as the file continues.
const READ_BYTES: usize = 1 << 20;
/// Longest record, bytes: the largest map has 100 million cells.
const MAX_RECORD_BYTES: usize = 1 << 28;

/// The records of an MCAP file from front to back. A truncated file is readable up to its last whole chunk.
struct McapReader<R> {
    file: R,
    reader: LinearReader,
}

impl<R: Read> McapReader<R> {
    fn new(file: R) -> Self {
        let options = LinearReaderOptions::default()
            .with_prevalidate_chunk_crcs(true)
            .with_record_length_limit(MAX_RECORD_BYTES);
        Self { file, reader: LinearReader::new_with_options(options) }
    }

    /// The next record, or nothing at the end of a whole file.
    ///
    /// # Errors
    /// `McapError::UnexpectedEof` at the end of a truncated file; others if the file is damaged or cannot be read.
    fn next(&mut self) -> McapResult<Option<Record<'static>>> {
        loop {
            let requested = match self.reader.next_event() {
                None => return Ok(None),
                Some(Err(error)) => return Err(error),
                Some(Ok(LinearReadEvent::Record { data, opcode })) => {
                    return Ok(Some(mcap::parse_record(opcode, data)?.into_owned()));
                }
                Some(Ok(LinearReadEvent::ReadRequest(bytes))) => bytes,
            };
            let buffer = self.reader.insert(requested.min(READ_BYTES));
            match self.file.read(buffer) {
                Ok(bytes) => self.reader.notify_read(bytes),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(error.into()),
            }
        }
    }
}
