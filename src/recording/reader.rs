//! Reading a recording: the drive, then tick after tick.

use std::io::Read;

use mcap::McapError;

use super::head::{CONFIG, DRIVE};
use super::messages::{Tick, map_cells};
use super::records::{Found, Records};
use super::writer::{END, TICKS, TRACE_DIGEST};
use super::{Head, RecordingError, Tail, Topic};

/// A recording that is being read.
pub struct Recording<R> {
    records: Records<R>,
    head: Head,
    channel: u16,
    ticks: u64,
    tail: Option<Tail>,
    is_cut: bool,
}

/// What is known of a recording before its head is whole.
#[derive(Default)]
struct Parts {
    config: Option<String>,
    drive: Option<String>,
    map_channel: Option<u16>,
    tick_channel: Option<u16>,
    cells: Option<Vec<i8>>,
}

impl<R: Read> Recording<R> {
    /// Reads the beginning of a file.
    ///
    /// # Errors
    /// When it is no MCAP file, no recording of ours or of another format, or cannot be read.
    pub fn open(file: R) -> Result<Self, RecordingError> {
        let mut records = Records::new(file);
        let mut parts = Parts::default();
        while parts.cells.is_none() {
            match records.next() {
                Ok(Some(found)) => parts.take(found)?,
                Ok(None) | Err(McapError::UnexpectedEof | McapError::UnexpectedEoc) => break,
                Err(McapError::BadMagic) => return Err(RecordingError::NotMcap),
                Err(error) => return Err(damaged(0, error)),
            }
        }
        let (head, channel) = parts.join()?;
        Ok(Self {
            records,
            head,
            channel,
            ticks: 0,
            tail: None,
            is_cut: false,
        })
    }

    /// How the drive began.
    #[must_use]
    pub const fn head(&self) -> &Head {
        &self.head
    }

    /// The next tick; none after the last. Of a file that was cut, the last is that of the last whole chunk.
    ///
    /// # Errors
    /// When the file is damaged or cannot be read.
    pub fn next_tick(&mut self) -> Result<Option<Tick>, RecordingError> {
        loop {
            match self.records.next() {
                Ok(Some(Found::Message { channel, bytes })) if channel == self.channel => {
                    return self.tick(&bytes).map(Some);
                }
                Ok(Some(Found::Metadata { name, words })) if name == END => {
                    let ticks = words.get(TICKS).and_then(|text| text.parse().ok());
                    let digest = words.get(TRACE_DIGEST);
                    self.tail = ticks.zip(digest).map(|(ticks, digest)| Tail {
                        ticks,
                        trace_digest: digest.clone(),
                    });
                }
                Ok(Some(_)) => {}
                Ok(None) => return Ok(None),
                Err(McapError::UnexpectedEof | McapError::UnexpectedEoc) => {
                    self.is_cut = true;
                    return Ok(None);
                }
                Err(error) => return Err(damaged(self.ticks, error)),
            }
        }
    }

    fn tick(&mut self, message: &[u8]) -> Result<Tick, RecordingError> {
        let bad = |reason: String| RecordingError::Damaged {
            ticks: self.ticks,
            reason,
        };
        let tick = Tick::read(message).ok_or_else(|| bad("a tick is no tick".to_owned()))?;
        if tick.tick != self.ticks {
            return Err(bad(format!("it goes on with tick {}", tick.tick)));
        }
        self.ticks += 1;
        Ok(tick)
    }

    /// How the drive ended: known after the last tick, unless the recording ended before it.
    #[must_use]
    pub const fn tail(&self) -> Option<&Tail> {
        self.tail.as_ref()
    }

    /// Whether the file holds the drive to its end: known after the last tick.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        let ticks = self.tail.as_ref().map(|tail| tail.ticks);
        !self.is_cut && ticks == Some(self.ticks)
    }
}

impl Parts {
    fn take(&mut self, found: Found) -> Result<(), RecordingError> {
        match found {
            Found::Attachment { name, bytes } if name == CONFIG => {
                self.config = Some(text(CONFIG, bytes)?);
            }
            Found::Attachment { name, bytes } if name == DRIVE => {
                self.drive = Some(text(DRIVE, bytes)?);
            }
            Found::Channel { id, topic } if topic == Topic::Map.name() => {
                self.map_channel = Some(id);
            }
            Found::Channel { id, topic } if topic == Topic::Tick.name() => {
                self.tick_channel = Some(id);
            }
            Found::Message { channel, bytes } if Some(channel) == self.map_channel => {
                let no_map = || RecordingError::Damaged {
                    ticks: 0,
                    reason: "its map is no map".to_owned(),
                };
                self.cells = Some(map_cells(&bytes).ok_or_else(no_map)?);
            }
            _ => {}
        }
        Ok(())
    }

    fn join(self) -> Result<(Head, u16), RecordingError> {
        let missing = |missing| RecordingError::NotOurs { missing };
        let config = self.config.ok_or(missing("attachment config.toml"))?;
        let drive = self.drive.ok_or(missing("attachment drive.toml"))?;
        let channel = self.tick_channel.ok_or(missing("topic /inbye/tick"))?;
        let cells = self.cells.ok_or(missing("message on /map"))?;
        Ok((Head::read(&config, &drive, cells)?, channel))
    }
}

fn text(name: &'static str, bytes: Vec<u8>) -> Result<String, RecordingError> {
    String::from_utf8(bytes).map_err(|error| RecordingError::BadHead {
        name,
        reason: error.to_string(),
    })
}

fn damaged(ticks: u64, error: McapError) -> RecordingError {
    match error {
        McapError::Io(error) => RecordingError::Io(error),
        other => RecordingError::Damaged {
            ticks,
            reason: other.to_string(),
        },
    }
}
