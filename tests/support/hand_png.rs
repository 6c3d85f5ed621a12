//! Hand-written PNG files for cases that encoders do not produce: palettes, single bits, false headers.

/// Builds a PNG file. The rows are packed samples as in the file, top row first; chunks between the header and the
/// pixels (`PLTE`, `tRNS`) are given with their names.
pub fn png(
    (width, height): (u32, u32),
    bit_depth: u8,
    color_type: u8,
    chunks: &[(&[u8; 4], &[u8])],
    rows: &[Vec<u8>],
) -> Vec<u8> {
    let mut header = Vec::new();
    header.extend(width.to_be_bytes());
    header.extend(height.to_be_bytes());
    header.extend([bit_depth, color_type, 0, 0, 0]);
    let scanlines: Vec<u8> =
        rows.iter().flat_map(|row| core::iter::once(0).chain(row.iter().copied())).collect();
    let mut file = b"\x89PNG\r\n\x1a\n".to_vec();
    append_chunk(&mut file, *b"IHDR", &header);
    for (name, data) in chunks {
        append_chunk(&mut file, **name, data);
    }
    append_chunk(&mut file, *b"IDAT", &stored_zlib(&scanlines));
    append_chunk(&mut file, *b"IEND", &[]);
    file
}

fn append_chunk(file: &mut Vec<u8>, name: [u8; 4], data: &[u8]) {
    file.extend((data.len() as u32).to_be_bytes());
    let checked_from = file.len();
    file.extend(name);
    file.extend(data);
    let check = crc_32(&file[checked_from..]);
    file.extend(check.to_be_bytes());
}

/// A zlib stream without compression.
fn stored_zlib(data: &[u8]) -> Vec<u8> {
    let mut stream = vec![0x78, 0x01];
    let blocks: Vec<&[u8]> = data.chunks(0xffff).collect();
    for (index, block) in blocks.iter().enumerate() {
        let length = block.len() as u16;
        stream.push(u8::from(index + 1 == blocks.len()));
        stream.extend(length.to_le_bytes());
        stream.extend((!length).to_le_bytes());
        stream.extend(*block);
    }
    let (mut a, mut b) = (1_u32, 0_u32);
    for &byte in data {
        a = (a + u32::from(byte)) % 65_521;
        b = (b + a) % 65_521;
    }
    stream.extend((b << 16 | a).to_be_bytes());
    stream
}

fn crc_32(data: &[u8]) -> u32 {
    !data.iter().fold(u32::MAX, |sum, &byte| {
        (0..8).fold(sum ^ u32::from(byte), |sum, _| (sum >> 1) ^ (0xedb8_8320 * (sum & 1)))
    })
}
