//! A recording copied record by record, with one thing in it altered: the copy's checksums are right, so that only who compares
//! the numbers can tell.

use mcap::records::Record;
use mcap::write::WriteOptions;
use mcap::{Attachment, read::LinearReader};
use std::io::Cursor;

/// Copies a file; `alter` gets the bytes of the message with this number on a topic, or of an attachment of this
/// name.
pub fn altered(file: &[u8], what: &str, number: usize, alter: impl Fn(&mut [u8])) -> Vec<u8> {
    let mut copy = WriteOptions::new()
        .profile("ros2")
        .create(Cursor::new(Vec::new()))
        .expect("memory takes it");
    let (mut seen, mut wanted) = (0, None);
    for record in mcap::read::ChunkFlattener::new(file).expect("an MCAP file") {
        match record.expect("it is whole") {
            Record::Schema { header, data } => {
                copy.add_schema_with_id(header.id, &header.name, &header.encoding, &data)
                    .expect("its first");
            }
            Record::Channel(channel) => {
                if channel.topic == what {
                    wanted = Some(channel.id);
                }
                copy.add_channel_with_id(
                    channel.id,
                    channel.schema_id,
                    &channel.topic,
                    &channel.message_encoding,
                    &channel.metadata,
                )
                .expect("its first");
            }
            Record::Message { header, data } => {
                let mut data = data.into_owned();
                if Some(header.channel_id) == wanted {
                    if seen == number {
                        alter(&mut data);
                    }
                    seen += 1;
                }
                copy.write_to_known_channel(&header, &data)
                    .expect("memory takes it");
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
                .expect("memory takes it");
            }
            Record::Metadata(metadata) => copy.write_metadata(&metadata).expect("as above"),
            Record::DataEnd(_) => break,
            _ => {}
        }
    }
    assert!(seen > number, "{what} has {seen} messages");
    copy.finish().expect("memory takes it");
    copy.into_inner().into_inner()
}

/// Ends of the chunks of a file, bytes from its beginning.
pub fn chunk_ends(file: &[u8]) -> Vec<usize> {
    let mut ends = Vec::new();
    let mut at = mcap::MAGIC.len();
    for record in LinearReader::new(file).expect("an MCAP file") {
        let opcode = record.expect("it is whole").opcode();
        let size: [u8; 8] = file[at + 1..at + 9].try_into().expect("eight bytes");
        at += 9 + u64::from_le_bytes(size) as usize;
        if opcode == mcap::records::op::CHUNK {
            ends.push(at);
        }
    }
    ends
}
