//! Images as one grey value for each pixel.

use std::fs::File;
use std::io::{BufRead, BufReader, Seek};
use std::path::Path;

use image::{DynamicImage, ImageDecoder, ImageReader, Limits, Rgba};

use super::grid::check_size;
use super::{MAX_GRID_CELLS, MapError};

/// What a map needs to know of a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pixel {
    /// From 0, black, to 255, white.
    pub grey: u8,
    /// Whether nothing shines through.
    pub opaque: bool,
}

/// An image decoded for a map.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct GreyImage {
    pub width: i32,
    pub height: i32,
    /// Row-major, top row first.
    pub pixels: Vec<Pixel>,
}

/// Bytes of the widest pixel: four channels of 16 bits.
const MAX_PIXEL_BYTES: u64 = 8;

/// Most characters of the decoder's words that are told.
const LONGEST_REASON: usize = 200;

impl GreyImage {
    /// Decodes the image in a file.
    pub(super) fn read(path: &Path) -> Result<Self, MapError> {
        let file = File::open(path).map_err(|error| unreadable(&error))?;
        Self::decode(BufReader::new(file))
    }

    /// Decodes a PGM, PNG or BMP image; the content decides which. Values of any depth become 8 bits, rounded;
    /// palettes are looked up; colours become their luma by the weights of Rec. 601.
    ///
    /// The size in the header is checked before memory is set aside for the pixels.
    pub(super) fn decode(bytes: impl BufRead + Seek) -> Result<Self, MapError> {
        // Some of the decoder's words repeat what the file holds, however long.
        let bad_image = |error: image::ImageError| MapError::BadImage {
            reason: error.to_string().chars().take(LONGEST_REASON).collect(),
        };
        let mut reader = ImageReader::new(bytes)
            .with_guessed_format()
            .map_err(|error| unreadable(&error))?;
        let mut limits = Limits::no_limits();
        limits.max_alloc = Some(MAX_GRID_CELLS as u64 * MAX_PIXEL_BYTES);
        reader.limits(limits);
        let decoder = reader.into_decoder().map_err(bad_image)?;
        let (width, height) = decoder.dimensions();
        check_size(i64::from(width), i64::from(height))?;
        let image = DynamicImage::from_decoder(decoder).map_err(bad_image)?;
        Ok(Self {
            width: width as i32,
            height: height as i32,
            pixels: match image {
                DynamicImage::ImageLuma8(image) => {
                    image.into_raw().into_iter().map(opaque).collect()
                }
                image => image
                    .into_rgba8()
                    .pixels()
                    .map(|&pixel| grey(pixel))
                    .collect(),
            },
        })
    }
}

fn unreadable(error: &std::io::Error) -> MapError {
    MapError::Unreadable {
        reason: error.to_string(),
    }
}

const fn opaque(grey: u8) -> Pixel {
    Pixel { grey, opaque: true }
}

fn grey(Rgba([red, green, blue, alpha]): Rgba<u8>) -> Pixel {
    // 0.299, 0.587 and 0.114 in 65536ths; they sum to one, so a grey pixel keeps its value.
    let luma = 19_595 * u32::from(red) + 38_470 * u32::from(green) + 7_471 * u32::from(blue);
    Pixel {
        grey: ((luma + 0x8000) >> 16) as u8,
        opaque: alpha == u8::MAX,
    }
}
