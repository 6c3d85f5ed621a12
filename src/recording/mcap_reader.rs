//! The records of an MCAP file from front to back, with every length in the file checked before it is used.

use std::io::{ErrorKind, Read, Seek};

use crc::{CRC_32_ISO_HDLC, Crc};
use lz4_flex::frame::FrameDecoder;
use mcap::records::{ChunkHeader, Record, op};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{McapError, McapResult};
use ruzstd::decoding::StreamingDecoder;

/// Bytes of a read. A length in the file is not trusted: more memory is used only as the file continues.
const READ_BYTES: usize = 1 << 20;
/// Longest record and longest decompressed chunk, bytes: the largest map has 100 million cells.
const MAX_RECORD_BYTES: usize = 1 << 28;
/// Bytes of a record before its content: an opcode and a length.
const RECORD_HEADER_BYTES: usize = 9;
/// Bytes of an attachment record without its two strings and its content: two times, three lengths and a checksum.
const ATTACHMENT_BYTES: u64 = 36;
const CRC_32: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// The records of an MCAP file. A truncated file is readable up to its last whole chunk.
///
/// Chunks are plain, or compressed by LZ4 or Zstandard, as `mcap compress` writes them. They are decoded here and not by
/// `mcap`: its reader of chunks fails an assertion on crafted lengths.
pub(super) struct McapReader<R> {
    file: R,
    reader: LinearReader,
    /// The records of the present chunk, and how many of its bytes were read.
    chunk: Vec<u8>,
    position: usize,
}

impl<R: Read + Seek> McapReader<R> {
    pub fn new(file: R) -> Self {
        Self { file, reader: linear_reader(), chunk: Vec::new(), position: 0 }
    }

    /// Continues with the first record of the file.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn rewind(&mut self) -> McapResult<()> {
        self.file.rewind()?;
        (self.reader, self.position) = (linear_reader(), 0);
        self.chunk.clear();
        Ok(())
    }

    /// The next record, or nothing at the end of a whole file.
    ///
    /// # Errors
    /// `McapError::UnexpectedEof` at the end of a truncated file; others if the file is damaged or cannot be read.
    pub fn next(&mut self) -> McapResult<Option<Record<'static>>> {
        loop {
            if self.position < self.chunk.len() {
                return self.next_in_chunk().map(Some);
            }
            let requested = match self.reader.next_event() {
                None => return Ok(None),
                Some(Err(error)) => return Err(error),
                Some(Ok(LinearReadEvent::Record { data, opcode: op::CHUNK })) => {
                    self.chunk = match mcap::parse_record(op::CHUNK, data)? {
                        Record::Chunk { header, data } => decompressed(&header, &data)?,
                        _ => Vec::new(),
                    };
                    self.position = 0;
                    continue;
                }
                Some(Ok(LinearReadEvent::Record { data, opcode })) => {
                    return parsed(opcode, data).map(Some);
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

    /// The next record of the present chunk, which is not at its end.
    fn next_in_chunk(&mut self) -> McapResult<Record<'static>> {
        let rest = &self.chunk[self.position..];
        let (opcode, length) = record_header(rest).ok_or(McapError::UnexpectedEoc)?;
        let end = usize::try_from(length).ok().and_then(|it| it.checked_add(RECORD_HEADER_BYTES));
        let record = end.and_then(|end| rest.get(RECORD_HEADER_BYTES..end));
        let record = parsed(opcode, record.ok_or(McapError::UnexpectedEoc)?)?;
        self.position += end.unwrap_or_default();
        Ok(record)
    }
}

fn linear_reader() -> LinearReader {
    let options = LinearReaderOptions::default()
        .with_emit_chunks(true)
        .with_record_length_limit(MAX_RECORD_BYTES);
    LinearReader::new_with_options(options)
}

/// The opcode and the length of the record that starts here.
fn record_header(bytes: &[u8]) -> Option<(u8, u64)> {
    let (&opcode, rest) = bytes.split_first()?;
    Some((opcode, u64::from_le_bytes(*rest.first_chunk()?)))
}

/// Parses a record that is not a chunk.
fn parsed(opcode: u8, data: &[u8]) -> McapResult<Record<'static>> {
    if opcode == op::CHUNK || opcode == op::ATTACHMENT && !is_whole_attachment(data) {
        return Err(McapError::UnexpectedEoc);
    }
    Ok(mcap::parse_record(opcode, data)?.into_owned())
}

/// Whether an attachment has room for its strings and its checksum, which `mcap` takes for granted.
fn is_whole_attachment(data: &[u8]) -> bool {
    let length_at = |at: u64| -> Option<u64> {
        let at = usize::try_from(at).ok()?;
        Some(u64::from(u32::from_le_bytes(*data.get(at..)?.first_chunk()?)))
    };
    let strings = length_at(16)
        .and_then(|name| Some(name + length_at(20 + name)?))
        .and_then(|strings| strings.checked_add(ATTACHMENT_BYTES));
    strings.is_some_and(|least| least <= data.len() as u64)
}

/// The records of a chunk.
fn decompressed(header: &ChunkHeader, data: &[u8]) -> McapResult<Vec<u8>> {
    let too_large = McapError::ChunkTooLarge(header.uncompressed_size);
    let size = usize::try_from(header.uncompressed_size).ok();
    let size = size.filter(|&size| size <= MAX_RECORD_BYTES).ok_or(too_large)?;
    let records = match header.compression.as_str() {
        "" => data.to_vec(),
        "lz4" => read_bounded(FrameDecoder::new(data), size)?,
        "zstd" => {
            let decoder = StreamingDecoder::new(data);
            read_bounded(decoder.map_err(|error| decompression(&error))?, size)?
        }
        other => return Err(McapError::UnsupportedCompression(other.to_owned())),
    };
    if records.len() != size {
        return Err(McapError::BadChunkLength {
            header: header.uncompressed_size,
            available: records.len() as u64,
        });
    }
    let (saved, calculated) = (header.uncompressed_crc, CRC_32.checksum(&records));
    if saved != 0 && saved != calculated {
        return Err(McapError::BadChunkCrc { saved, calculated });
    }
    Ok(records)
}

/// Reads at most one byte more than expected.
fn read_bounded(decoder: impl Read, expected: usize) -> McapResult<Vec<u8>> {
    let mut records = Vec::new();
    let read = decoder.take(expected as u64 + 1).read_to_end(&mut records);
    read.map_err(|error| decompression(&error))?;
    Ok(records)
}

fn decompression(error: &dyn core::fmt::Display) -> McapError {
    McapError::DecompressionError(error.to_string())
}
