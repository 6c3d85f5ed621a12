//! Reads an MCAP file from front to back, a record at a time. A truncated file is readable up to its last whole chunk.

use std::collections::BTreeMap;
use std::io::{ErrorKind, Read};

use mcap::McapResult;
use mcap::records::Record;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};

/// Bytes of a read. A length in the file is not trusted: more memory is used only as the file continues.
const READ_BYTES: usize = 1 << 20;
/// Longest record, bytes: the largest map has 100 million cells.
const MAX_RECORD_BYTES: usize = 1 << 28;

/// A record of an MCAP file.
pub enum McapEvent {
    /// An attached file.
    Attachment { name: String, bytes: Vec<u8> },
    /// A topic and its number in this file.
    Channel { id: u16, topic: String },
    /// A message.
    Message { channel: u16, bytes: Vec<u8> },
    /// Named values.
    Metadata { name: String, values: BTreeMap<String, String> },
    /// Any other record.
    Other,
}

/// The records of a file.
pub struct McapReader<R> {
    file: R,
    reader: LinearReader,
}

impl<R: Read> McapReader<R> {
    pub fn new(file: R) -> Self {
        let options = LinearReaderOptions::default()
            .with_prevalidate_chunk_crcs(true)
            .with_record_length_limit(MAX_RECORD_BYTES);
        Self { file, reader: LinearReader::new_with_options(options) }
    }

    /// The next record, or nothing at the end of a whole file.
    ///
    /// # Errors
    /// `McapError::UnexpectedEof` at the end of a truncated file; others if the file is damaged or cannot be read.
    pub fn next(&mut self) -> McapResult<Option<McapEvent>> {
        loop {
            let requested = match self.reader.next_event() {
                None => return Ok(None),
                Some(Err(error)) => return Err(error),
                Some(Ok(LinearReadEvent::Record { data, opcode })) => {
                    return Ok(Some(event(mcap::parse_record(opcode, data)?)));
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

fn event(record: Record<'_>) -> McapEvent {
    match record {
        Record::Attachment { header, data, .. } => {
            McapEvent::Attachment { name: header.name, bytes: data.into_owned() }
        }
        Record::Channel(channel) => McapEvent::Channel { id: channel.id, topic: channel.topic },
        Record::Message { header, data } => {
            McapEvent::Message { channel: header.channel_id, bytes: data.into_owned() }
        }
        Record::Metadata(metadata) => {
            McapEvent::Metadata { name: metadata.name, values: metadata.metadata }
        }
        _ => McapEvent::Other,
    }
}
