//! Recordings that other programs rewrote, and crafted ones.

use std::io::{Cursor, Write};

use inbye::recording::{Reader, RecordingError};
use lz4_flex::frame::FrameEncoder;
use ruzstd::encoding::{CompressionLevel, compress_to_vec};

use super::drives::{cpu, record, replay_on, tour};

pub const TESTS: &[super::Test] = &[
    ("recording_compressed_by_other_programs_is_replayed", compressed_recording_is_replayed),
    ("recording_with_crafted_lengths_is_rejected", crafted_lengths_are_rejected),
    ("chunk_that_decompresses_to_other_size_is_rejected", other_sizes_are_rejected),
];

const MAGIC: &[u8] = b"\x89MCAP0\r\n";
const FOOTER: u8 = 2;
const SCHEMA: u8 = 3;
const CHANNEL: u8 = 4;
const MESSAGE: u8 = 5;
const CHUNK: u8 = 6;
const ATTACHMENT: u8 = 9;
const METADATA: u8 = 12;
const DATA_END: u8 = 15;

/// A compression by its name in the format, with its encoder.
type Compression = (&'static str, fn(&[u8]) -> Vec<u8>);

const COMPRESSIONS: [Compression; 3] = [
    ("", <[u8]>::to_vec),
    ("lz4", |records| {
        let mut encoder = FrameEncoder::new(Vec::new());
        encoder.write_all(records).expect("writable memory");
        encoder.finish().expect("writable memory")
    }),
    ("zstd", |records| compress_to_vec(records, CompressionLevel::Fastest)),
];

fn framed(opcode: u8, content: &[u8]) -> Vec<u8> {
    let length = (content.len() as u64).to_le_bytes();
    [&[opcode], &length[..], content].concat()
}

fn chunk(records: &[u8], size: u64, (name, compress): Compression) -> Vec<u8> {
    let compressed = compress(records);
    let content = [
        &[0; 16][..],
        &size.to_le_bytes(),
        // No checksum.
        &[0; 4],
        &(name.len() as u32).to_le_bytes(),
        name.as_bytes(),
        &(compressed.len() as u64).to_le_bytes(),
        &compressed,
    ];
    framed(CHUNK, &content.concat())
}

/// The records of a file, chunks opened, each with its opcode.
fn records(file: &[u8]) -> Vec<(u8, Vec<u8>)> {
    let mut all = Vec::new();
    let mut rest = &file[MAGIC.len()..];
    while rest.len() > MAGIC.len() {
        let length = u64::from_le_bytes(*rest[1..].first_chunk().expect("a length")) as usize;
        let (opcode, content) = (rest[0], &rest[9..9 + length]);
        match opcode {
            // The recorder does not compress; 40 bytes are the fields before the records.
            CHUNK => all.extend(records(&[MAGIC, &content[40..], MAGIC].concat())),
            DATA_END => return all,
            _ => all.push((opcode, content.to_vec())),
        }
        rest = &rest[9 + length..];
    }
    all
}

/// The file with smaller chunks, each channel registered just before its first message, attachments and metadata at the end.
fn rewritten(file: &[u8], compression: Compression) -> Vec<u8> {
    let all = records(file);
    let of = |opcode: u8| all.iter().filter(move |(found, _)| *found == opcode);
    let mut copy = [MAGIC, &framed(1, &[0; 8])].concat();
    let mut registered = Vec::new();
    let messages: Vec<_> = of(MESSAGE).collect();
    for group in messages.chunks(50) {
        let mut content = Vec::new();
        for (_, message) in group {
            let id = &message[..2];
            if !registered.contains(&id) {
                registered.push(id);
                let channel = of(CHANNEL).find(|(_, channel)| &channel[..2] == id);
                let channel = &channel.expect("a channel").1;
                let schema = of(SCHEMA).find(|(_, schema)| schema[..2] == channel[2..4]);
                content.extend(framed(SCHEMA, &schema.expect("a schema").1));
                content.extend(framed(CHANNEL, channel));
            }
            content.extend(framed(MESSAGE, message));
        }
        copy.extend(chunk(&content, content.len() as u64, compression));
    }
    for (opcode, content) in of(ATTACHMENT).chain(of(METADATA)) {
        copy.extend(framed(*opcode, content));
    }
    copy.extend(framed(DATA_END, &[0; 4]));
    copy.extend(framed(FOOTER, &[0; 20]));
    copy.extend(MAGIC);
    copy
}

fn compressed_recording_is_replayed() {
    let (simulation, config) = tour();
    let (result, file) = record(&simulation, &config);
    for compression in COMPRESSIONS {
        let copy = rewritten(&file, compression);
        let replay = replay_on(&copy, cpu(1));
        assert_eq!(replay.first_difference, None, "{}", compression.0);
        assert_eq!(replay.ticks, result.trace.rows.len() as u64);
        assert!(replay.is_complete);
    }
}

fn error_of(records: &[u8]) -> RecordingError {
    let file = [MAGIC, &framed(1, &[0; 8]), records].concat();
    Reader::open(Cursor::new(file)).expect_err("it is no recording")
}

fn crafted_lengths_are_rejected() {
    let plain = COMPRESSIONS[0];
    // A length that ends before the record's own header, and lengths beyond all memory.
    for crafted in [
        chunk(&[MESSAGE], 1, plain),
        chunk(&[&[MESSAGE][..], &u64::MAX.to_le_bytes()].concat(), 9, plain),
        chunk(&[&[MESSAGE][..], &40_u64.to_le_bytes(), &[0; 8]].concat(), 17, plain),
        chunk(&chunk(b"", 0, plain), chunk(b"", 0, plain).len() as u64, plain),
        framed(ATTACHMENT, &[]),
        framed(ATTACHMENT, &[0; 30]),
        framed(ATTACHMENT, &[0xFF; 40]),
        framed(MESSAGE, &[0; 3]),
    ] {
        let error = error_of(&crafted);
        assert!(
            matches!(error, RecordingError::Damaged { .. } | RecordingError::NotOurs { .. }),
            "{error}"
        );
    }
}

fn other_sizes_are_rejected() {
    let zeros = vec![0; 1 << 20];
    for compression in COMPRESSIONS {
        for size in [0, 5, (1 << 20) - 1, (1 << 20) + 1, 1 << 40, u64::MAX] {
            let error = error_of(&chunk(&zeros, size, compression));
            assert!(matches!(error, RecordingError::Damaged { .. }), "{size}: {error}");
        }
    }
    let error = error_of(&chunk(b"data", 4, ("brotli", <[u8]>::to_vec)));
    assert!(error.to_string().contains("brotli"), "{error}");
}
