//! Reads a recording: the metadata of the drive, then its ticks.

use std::io::{Read, Seek};

use mcap::McapError;
use mcap::records::Record;

use super::error::RecordingError;
use super::mcap_reader::McapReader;
use super::messages::Topic;
use super::metadata::{CONFIG, DRIVE, DriveFile, DriveMetadata, DriveSummary};
use super::tick::RecordedTick;
use super::writer::{SUMMARY, TICKS, TRACE_DIGEST};
use crate::map::OccupancyGrid;
use crate::ros::msg::{self, Message};

/// Reads a recording.
pub struct Reader<R> {
    mcap: McapReader<R>,
    metadata: DriveMetadata,
    /// The channel of the ticks; none before its record. Other programs write it just before the first tick.
    tick_channel: Option<u16>,
    updated_map_channel: Option<u16>,
    updated_map: Option<OccupancyGrid>,
    ticks: u64,
    summary: Option<DriveSummary>,
    is_truncated: bool,
}

crate::settings::opaque_debug!(Reader<R>);

/// The parts of the metadata that were read so far.
#[derive(Default)]
struct Parts {
    config: Option<String>,
    drive: Option<DriveFile>,
    map_channel: Option<u16>,
    zones: Option<Vec<i8>>,
    zones_channel: Option<u16>,
    cells: Option<Vec<i8>>,
}

impl<R: Read + Seek> Reader<R> {
    /// Reads the metadata and the map of a recording, wherever in the file they are, and continues at its start.
    ///
    /// # Errors
    /// When the file is no recording of this format, is damaged or cannot be read.
    pub fn open(file: R) -> Result<Self, RecordingError> {
        let mut mcap = McapReader::new(file);
        let mut parts = Parts::default();
        while !parts.are_complete() {
            match mcap.next() {
                Ok(Some(record)) => parts.take(record)?,
                Ok(None) | Err(McapError::UnexpectedEof | McapError::UnexpectedEoc) => break,
                Err(McapError::BadMagic) => return Err(RecordingError::NotMcap),
                Err(error) => return Err(damaged(0, error)),
            }
        }
        let metadata = parts.join()?;
        mcap.rewind().map_err(|error| damaged(0, error))?;
        Ok(Self {
            mcap,
            metadata,
            tick_channel: None,
            updated_map_channel: None,
            updated_map: None,
            ticks: 0,
            summary: None,
            is_truncated: false,
        })
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
                    if Some(header.channel_id) == self.tick_channel =>
                {
                    return self.tick(&data).map(Some);
                }
                Ok(Some(Record::Channel(channel))) if channel.topic == Topic::Tick.name() => {
                    self.tick_channel = Some(channel.id);
                }
                Ok(Some(Record::Message { header, data }))
                    if Some(header.channel_id) == self.updated_map_channel =>
                {
                    self.updated_map = Some(self.map_of(&data)?);
                }
                Ok(Some(Record::Channel(channel))) if channel.topic == Topic::UpdatedMap.name() => {
                    self.updated_map_channel = Some(channel.id);
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

    /// The map that the navigator uses from the last tick on, once, if it is a new one.
    #[must_use]
    pub const fn take_updated_map(&mut self) -> Option<OccupancyGrid> {
        self.updated_map.take()
    }

    /// The map of a message; it has the frame of the first map, which the message has only in single precision.
    fn map_of(&self, message: &[u8]) -> Result<OccupancyGrid, RecordingError> {
        let frame = *self.metadata.map.frame();
        let grid = OccupancyGrid::from_cells(frame, cells("an updated map", message)?);
        let ticks = self.ticks;
        grid.map_err(|error| RecordingError::Damaged { ticks, reason: error.to_string() })
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
    const fn are_complete(&self) -> bool {
        let Some(drive) = &self.drive else {
            return false;
        };
        let has_zones = self.zones.is_some() || !drive.has_zones;
        self.config.is_some() && self.cells.is_some() && has_zones
    }

    fn take(&mut self, record: Record<'_>) -> Result<(), RecordingError> {
        match record {
            Record::Attachment { header, data, .. } if header.name == CONFIG => {
                self.config = Some(text(CONFIG, data.into_owned())?);
            }
            Record::Attachment { header, data, .. } if header.name == DRIVE => {
                self.drive = Some(DriveFile::parse(&text(DRIVE, data.into_owned())?)?);
            }
            Record::Channel(channel) if channel.topic == Topic::Map.name() => {
                self.map_channel = Some(channel.id);
            }
            Record::Channel(channel) if channel.topic == Topic::Zones.name() => {
                self.zones_channel = Some(channel.id);
            }
            Record::Message { header, data } if Some(header.channel_id) == self.map_channel => {
                self.cells = Some(cells("the map", &data)?);
            }
            Record::Message { header, data } if Some(header.channel_id) == self.zones_channel => {
                self.zones = Some(cells("the map of zones", &data)?);
            }
            _ => {}
        }
        Ok(())
    }

    fn join(self) -> Result<DriveMetadata, RecordingError> {
        let missing = |missing| RecordingError::NotOurs { missing };
        let config = self.config.ok_or(missing("attachment config.toml"))?;
        let drive = self.drive.ok_or(missing("attachment drive.toml"))?;
        let cells = self.cells.ok_or(missing("message on /map"))?;
        if drive.has_zones && self.zones.is_none() {
            return Err(missing("message on /zones"));
        }
        DriveMetadata::join(&config, drive, cells, self.zones)
    }
}

/// The cells of a map's message.
fn cells(what: &str, message: &[u8]) -> Result<Vec<i8>, RecordingError> {
    msg::OccupancyGrid::from_cdr(message)
        .map(|map| map.data)
        .ok_or_else(|| RecordingError::Damaged { ticks: 0, reason: format!("{what} is invalid") })
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
