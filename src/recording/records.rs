//! An MCAP file front to back, a record at a time: also one that was cut, up to its last whole chunk.

use std::collections::BTreeMap;
use std::io::{ErrorKind, Read};

use mcap::McapResult;
use mcap::records::Record;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};

/// Read at once: what a file says of its own lengths is believed only as far as it goes on.
const PIECE_BYTES: usize = 1 << 20;
/// No record of ours is longer: the largest map has 100 million cells.
const LONGEST_RECORD: usize = 1 << 28;

/// What a recording is read from.
pub enum Found {
    /// A file within the file.
    Attachment { name: String, bytes: Vec<u8> },
    /// A topic with its number in this file.
    Channel { id: u16, topic: String },
    /// A message.
    Message { channel: u16, bytes: Vec<u8> },
    /// Words by name.
    Metadata {
        name: String,
        words: BTreeMap<String, String>,
    },
    /// Anything else.
    Other,
}

/// The records of a file.
pub struct Records<R> {
    file: R,
    reader: LinearReader,
}

impl<R: Read> Records<R> {
    pub fn new(file: R) -> Self {
        let options = LinearReaderOptions::default()
            .with_prevalidate_chunk_crcs(true)
            .with_record_length_limit(LONGEST_RECORD);
        Self {
            file,
            reader: LinearReader::new_with_options(options),
        }
    }

    /// The next record; none at the end of a whole file.
    ///
    /// # Errors
    /// `McapError::UnexpectedEof` at the end of one that was cut; others where it is damaged or cannot be read.
    pub fn next(&mut self) -> McapResult<Option<Found>> {
        loop {
            let wanted = match self.reader.next_event() {
                None => return Ok(None),
                Some(Err(error)) => return Err(error),
                Some(Ok(LinearReadEvent::Record { data, opcode })) => {
                    return Ok(Some(found(mcap::parse_record(opcode, data)?)));
                }
                Some(Ok(LinearReadEvent::ReadRequest(bytes))) => bytes,
            };
            let room = self.reader.insert(wanted.min(PIECE_BYTES));
            match self.file.read(room) {
                Ok(bytes) => self.reader.notify_read(bytes),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(error.into()),
            }
        }
    }
}

fn found(record: Record<'_>) -> Found {
    match record {
        Record::Attachment { header, data, .. } => Found::Attachment {
            name: header.name,
            bytes: data.into_owned(),
        },
        Record::Channel(channel) => Found::Channel {
            id: channel.id,
            topic: channel.topic,
        },
        Record::Message { header, data } => Found::Message {
            channel: header.channel_id,
            bytes: data.into_owned(),
        },
        Record::Metadata(metadata) => Found::Metadata {
            name: metadata.name,
            words: metadata.metadata,
        },
        _ => Found::Other,
    }
}
