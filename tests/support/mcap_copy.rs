//! Copies a recording with one changed message. The checksums of the copy are valid, so only its values reveal the change.

use mcap::records::Record;
use mcap::write::WriteOptions;
use mcap::{Attachment, read::LinearReader};
use std::io::Cursor;

/// Copies a file. `alter` changes the message with this number on a topic, or the attachment with this name.
pub fn altered(file: &[u8], what: &str, number: usize, alter: impl Fn(&mut [u8])) -> Vec<u8> {
    let mut copy = WriteOptions::new()
        .profile("ros2")
        .create(Cursor::new(Vec::new()))
        .expect("writable memory");
    let (mut seen, mut channel_id) = (0, None);
    for record in mcap::read::ChunkFlattener::new(file).expect("an MCAP file") {
        match record.expect("a whole file") {
            Record::Schema { header, data } => {
                copy.add_schema_with_id(header.id, &header.name, &header.encoding, &data)
                    .expect("a new number");
            }
            Record::Channel(channel) => {
                if channel.topic == what {
                    channel_id = Some(channel.id);
                }
                copy.add_channel_with_id(
                    channel.id,
                    channel.schema_id,
                    &channel.topic,
                    &channel.message_encoding,
                    &channel.metadata,
                )
                .expect("a new number");
            }
            Record::Message { header, data } => {
                let mut data = data.into_owned();
                if Some(header.channel_id) == channel_id {
                    if seen == number {
                        alter(&mut data);
                    }
                    seen += 1;
                }
                copy.write_to_known_channel(&header, &data).expect("writable memory");
            }
            Record::Attachment { header, data, .. } => {
                let mut data = data.into_owned();
                if header.name == what {
                    alter(&mut data);
                    seen = number + 1;
                }
                copy.attach(&Attachment {
                    log_time: header.log_time,
                    create_time: header.create_time,
                    name: header.name,
                    media_type: header.media_type,
                    data: data.into(),
                })
                .expect("writable memory");
            }
            Record::Metadata(metadata) => copy.write_metadata(&metadata).expect("writable memory"),
            Record::DataEnd(_) => break,
            _ => {}
        }
    }
    assert!(seen > number, "{what} has {seen} messages");
    copy.finish().expect("writable memory");
    copy.into_inner().into_inner()
}

/// The end offsets of the chunks of a file, bytes.
pub fn chunk_ends(file: &[u8]) -> Vec<usize> {
    let mut ends = Vec::new();
    let mut at = mcap::MAGIC.len();
    for record in LinearReader::new(file).expect("an MCAP file") {
        let opcode = record.expect("a whole file").opcode();
        let size: [u8; 8] = file[at + 1..at + 9].try_into().expect("eight bytes");
        at += 9 + u64::from_le_bytes(size) as usize;
        if opcode == mcap::records::op::CHUNK {
            ends.push(at);
        }
    }
    ends
}
