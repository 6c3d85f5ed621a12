//! Map images as one grey value per pixel.

mod bmp;
mod pnm;

use std::io::Cursor;

use png_codec::{BitDepth, ColorType, Decoder, DecodingError, Limits, Transformations};

use super::grid::check_size;
use super::{MAX_GRID_CELLS, MapError};

/// The part of a pixel that a map needs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pixel {
    /// From 0, black, to 255, white.
    pub grey: u8,
    /// Whether the pixel is fully opaque.
    pub opaque: bool,
}

impl Pixel {
    const BLACK: Self = Self::from_grey(0);

    const fn from_grey(grey: u8) -> Self {
        Self { grey, opaque: true }
    }

    /// Converts a colour to its luma with the weights of Rec. 601.
    fn from_rgb([red, green, blue]: [u8; 3]) -> Self {
        // 0.299, 0.587 and 0.114 in 65536ths. Their sum is one, so a grey pixel keeps its value.
        let luma = 19_595 * u32::from(red) + 38_470 * u32::from(green) + 7_471 * u32::from(blue);
        Self::from_grey(((luma + 0x8000) >> 16) as u8)
    }
}

/// A decoded map image.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct GreyImage {
    pub width: i32,
    pub height: i32,
    /// Row-major, top row first.
    pub pixels: Vec<Pixel>,
}

/// Limit of file size and decoder memory, bytes: eight for each cell, four channels of 16 bits.
pub(super) const MAX_BYTES: usize = 8 * MAX_GRID_CELLS;

/// Largest length of a decoder's message in an error, characters: some messages repeat parts of the file.
const MAX_REASON: usize = 200;

/// The first bytes of a PNG file.
const PNG_MAGIC: &[u8] = b"\x89PNG\r\n\x1a\n";

impl GreyImage {
    /// Decodes a PGM, PNG or BMP image; the content determines the format. Samples of any depth are rounded to 8 bits, palettes
    /// are resolved, and colours become luma.
    ///
    /// The size in the header is checked before memory for the pixels is allocated.
    pub(super) fn decode(bytes: &[u8]) -> Result<Self, MapError> {
        if bytes.starts_with(PNG_MAGIC) {
            decode_png(bytes)
        } else if bytes.starts_with(bmp::MAGIC) {
            bmp::decode(bytes)
        } else if pnm::is_pnm(bytes) {
            pnm::decode(bytes)
        } else {
            Err(bad_image("unknown format"))
        }
    }
}

/// Decodes a PNG file. Text and colour profiles are skipped.
fn decode_png(bytes: &[u8]) -> Result<GreyImage, MapError> {
    let failed = |error: DecodingError| bad_image(error.to_string());
    let limits = Limits { bytes: MAX_BYTES };
    let mut decoder = Decoder::new_with_limits(Cursor::new(bytes), limits);
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    decoder.set_transformations(Transformations::EXPAND);
    let header = decoder.read_header_info().map_err(failed)?;
    let (width, height) = (header.width, header.height);
    check_size(i64::from(width), i64::from(height))?;
    let mut reader = decoder.read_info().map_err(failed)?;
    let size = reader.output_buffer_size();
    let mut buffer = vec![0; size.ok_or_else(|| bad_image("the image is too large"))?];
    let info = reader.next_frame(&mut buffer).map_err(failed)?;
    let sample_bytes = if info.bit_depth == BitDepth::Sixteen { 2 } else { 1 };
    let pixel = |bytes: &[u8]| {
        let sample = |channel: usize| match sample_bytes {
            1 => bytes[channel],
            _ => to_8_bits(u16::from_be_bytes([bytes[2 * channel], bytes[2 * channel + 1]])),
        };
        let rgb = || Pixel::from_rgb([sample(0), sample(1), sample(2)]);
        let (color, alpha) = match info.color_type {
            ColorType::Grayscale | ColorType::Indexed => (Pixel::from_grey(sample(0)), u8::MAX),
            ColorType::GrayscaleAlpha => (Pixel::from_grey(sample(0)), sample(1)),
            ColorType::Rgb => (rgb(), u8::MAX),
            ColorType::Rgba => (rgb(), sample(3)),
        };
        Pixel { opaque: alpha == u8::MAX, ..color }
    };
    let pixels =
        buffer[..info.buffer_size()].chunks_exact(info.color_type.samples() * sample_bytes);
    Ok(GreyImage {
        width: width as i32,
        height: height as i32,
        pixels: pixels.map(pixel).collect(),
    })
}

fn bad_image(reason: impl Into<String>) -> MapError {
    MapError::BadImage { reason: reason.into().chars().take(MAX_REASON).collect() }
}

/// Rounds a sample of 16 bits to 8.
const fn to_8_bits(sample: u16) -> u8 {
    ((sample as u32 + 128) / 257) as u8
}
