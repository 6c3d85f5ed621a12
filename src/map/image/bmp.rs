//! BMP images: palettes, bit fields and run-length encoding.

use super::{GreyImage, Pixel, bad_image};
use crate::map::MapError;
use crate::map::grid::check_size;

/// Bytes of the smallest header, which has 16-bit sizes and no compression.
const CORE_HEADER: usize = 12;

/// Header sizes with 32-bit sizes: the original one, and versions 2 to 5.
const INFO_HEADERS: [usize; 5] = [40, 52, 56, 108, 124];

/// Smallest header with a mask for alpha.
const ALPHA_HEADER: usize = 56;

/// Largest width and height accepted before the size of the grid is checked.
const MAX_SIDE: i32 = 0xffff;

/// The first bytes of a BMP file.
pub(super) const MAGIC: &[u8] = b"BM";

/// A decoded header.
struct Header {
    width: i32,
    height: i32,
    /// Whether the first row is the top row.
    is_top_down: bool,
    bits_per_pixel: usize,
    is_run_length: bool,
    /// Number of palette colours.
    colors: usize,
    /// Bytes of a palette entry.
    color_bytes: usize,
    /// Where the palette starts.
    palette_at: usize,
    /// Where the pixels start.
    pixels_at: usize,
    /// The bits of red, green, blue and alpha in a pixel without palette.
    channels: [Channel; 4],
}

/// A contiguous group of bits; without bits, the channel is missing.
#[derive(Clone, Copy)]
struct Channel {
    shift: u32,
    bits: u32,
}

/// Little-endian reads with a bounds check.
struct Input<'a>(&'a [u8]);

impl<'a> Input<'a> {
    fn slice(&self, at: usize, length: usize) -> Result<&'a [u8], MapError> {
        let bytes = self.0.get(at..).and_then(|rest| rest.get(..length));
        bytes.ok_or_else(|| bad_image("the file ends too early"))
    }

    fn number(&self, at: usize, bytes: usize) -> Result<u32, MapError> {
        self.slice(at, bytes).map(little_endian)
    }
}

fn little_endian(bytes: &[u8]) -> u32 {
    bytes.iter().rev().fold(0, |number, &byte| number << 8 | u32::from(byte))
}

/// Decodes a BMP file.
pub(super) fn decode(bytes: &[u8]) -> Result<GreyImage, MapError> {
    let input = Input(bytes);
    let header = Header::read(&input)?;
    let Header { width, height, .. } = header;
    check_size(i64::from(width), i64::from(height))?;
    let palette = header.palette(&input)?;
    let mut pixels = if header.is_run_length {
        header.run_length_pixels(&input, &palette)?
    } else {
        header.uncompressed_pixels(&input, &palette)?
    };
    if !header.is_top_down {
        pixels = pixels.chunks_exact(width as usize).rev().flatten().copied().collect();
    }
    Ok(GreyImage { width, height, pixels })
}

impl Header {
    fn read(input: &Input<'_>) -> Result<Self, MapError> {
        const AT: usize = 14;
        let pixels_at = input.number(10, 4)? as usize;
        let size = input.number(AT, 4)? as usize;
        let is_core = size == CORE_HEADER;
        if !is_core && !INFO_HEADERS.contains(&size) {
            return Err(bad_image(format!("unknown header of {size} bytes")));
        }
        let (width, height) = if is_core {
            (input.number(AT + 4, 2)? as i32, input.number(AT + 6, 2)? as i32)
        } else {
            (input.number(AT + 4, 4)? as i32, input.number(AT + 8, 4)? as i32)
        };
        if !(1..=MAX_SIDE).contains(&width) || height == 0 || height > MAX_SIDE {
            return Err(bad_image(format!("size of {width} x {height} pixels")));
        }
        let is_top_down = height < 0;
        let height = height.checked_abs().ok_or_else(|| bad_image("invalid height"))?;
        let after_size = if is_core { AT + 8 } else { AT + 12 };
        if input.number(after_size, 2)? != 1 {
            return Err(bad_image("more than one plane"));
        }
        let bits = input.number(after_size + 2, 2)?;
        let (compression, colors) = if is_core {
            (0, 0)
        } else {
            input.slice(AT + 20, 20)?;
            (input.number(AT + 16, 4)?, input.number(AT + 32, 4)?)
        };
        let is_supported = match (compression, bits) {
            (0, 1 | 4 | 8 | 24) | (3, 16 | 32) => true,
            (0, 2 | 16 | 32) => !is_core,
            (1, 8) | (2, 4) => !is_top_down,
            _ => false,
        };
        if !is_supported {
            return Err(bad_image(format!("compression {compression} with {bits} bits per pixel")));
        }
        if bits <= 8 && colors > 1 << bits {
            return Err(bad_image(format!(
                "palette of {colors} colours with {bits} bits per pixel"
            )));
        }
        let channels = match (compression, bits) {
            (3, _) => Channel::read_masks(input, AT + 40, size >= ALPHA_HEADER, bits)?,
            (_, 16) => Channel::packed(5),
            _ => Channel::packed(8),
        };
        Ok(Self {
            width,
            height,
            is_top_down,
            bits_per_pixel: bits as usize,
            is_run_length: matches!(compression, 1 | 2),
            colors: if colors == 0 { 1 << bits.min(8) } else { colors as usize },
            color_bytes: if is_core { 3 } else { 4 },
            palette_at: AT + size,
            pixels_at,
            channels,
        })
    }

    /// 256 colours; those beyond the palette's are black. Pixels of more than 8 bits have no palette.
    fn palette(&self, input: &Input<'_>) -> Result<Vec<Pixel>, MapError> {
        if self.bits_per_pixel > 8 {
            return Ok(Vec::new());
        }
        let bytes = input.slice(self.palette_at, self.colors * self.color_bytes)?;
        let entries = bytes.chunks_exact(self.color_bytes);
        let mut palette: Vec<Pixel> =
            entries.map(|entry| Pixel::from_rgb([entry[2], entry[1], entry[0]])).collect();
        palette.resize(256, Pixel::BLACK);
        Ok(palette)
    }

    fn uncompressed_pixels(
        &self,
        input: &Input<'_>,
        palette: &[Pixel],
    ) -> Result<Vec<Pixel>, MapError> {
        let (width, bits) = (self.width as usize, self.bits_per_pixel);
        let stride = (width * bits).div_ceil(32) * 4;
        let bytes = input.slice(self.pixels_at, stride * self.height as usize)?;
        let mut pixels = Vec::with_capacity(width * self.height as usize);
        for row in bytes.chunks_exact(stride) {
            if bits <= 8 {
                let per_byte = 8 / bits;
                pixels.extend((0..width).map(|column| {
                    let shift = 8 - bits * (column % per_byte + 1);
                    let index = row[column / per_byte] >> shift & (0xff >> (8 - bits));
                    palette[usize::from(index)]
                }));
            } else {
                let whole = row.chunks_exact(bits / 8).take(width);
                pixels.extend(whole.map(|bytes| self.pixel(little_endian(bytes))));
            }
        }
        Ok(pixels)
    }

    /// Decodes run-length encoded pixels. Skipped pixels are black.
    fn run_length_pixels(
        &self,
        input: &Input<'_>,
        palette: &[Pixel],
    ) -> Result<Vec<Pixel>, MapError> {
        let corrupt = || bad_image("corrupt run-length data");
        let (width, height) = (self.width as usize, self.height as usize);
        let mut pixels = vec![Pixel::BLACK; width * height];
        let mut rest = input.0.get(self.pixels_at..).ok_or_else(corrupt)?.iter().copied();
        let mut next = || rest.next().ok_or_else(corrupt);
        // `column` counts stored pixels and may exceed the width after an 8-bit run beyond the row.
        let (mut row, mut column, mut at) = (0, 0, 0);
        while row < height {
            let (count, value) = (next()?, next()?);
            match (count, value) {
                (0, 0) => (row, column, at) = (row + 1, 0, 0),
                (0, 1) => break,
                (0, 2) => {
                    let (right, up) = (usize::from(next()?), usize::from(next()?));
                    if up > 0 {
                        (row, at) = (row + up, column);
                    }
                    (column, at) = (column + right, at + right);
                    if row >= height || at > width {
                        return Err(corrupt());
                    }
                }
                (0, length) => {
                    let bytes = usize::from(length).div_ceil(8 / self.bits_per_pixel);
                    let mut data = [0; 256];
                    for byte in &mut data[..bytes + bytes % 2] {
                        *byte = next()?;
                    }
                    let indices =
                        |number: usize| self.index(data[number * self.bits_per_pixel / 8], number);
                    let length = usize::from(length);
                    if at + length > width {
                        return Err(corrupt());
                    }
                    for number in 0..length {
                        pixels[row * width + at + number] = palette[indices(number)];
                    }
                    (column, at) = (column + length, at + length);
                }
                (count, value) => {
                    let count = usize::from(count);
                    let fits = count.min(width - at);
                    if fits < count && self.bits_per_pixel == 4 {
                        return Err(corrupt());
                    }
                    for number in 0..fits {
                        pixels[row * width + at + number] = palette[self.index(value, number)];
                    }
                    (column, at) = (column + count, at + fits);
                }
            }
        }
        Ok(pixels)
    }

    /// The palette index of a pixel in a byte of a run: the pixel's number selects the half of a 4-bit pair.
    fn index(&self, byte: u8, number: usize) -> usize {
        usize::from(match self.bits_per_pixel {
            8 => byte,
            _ if number.is_multiple_of(2) => byte >> 4,
            _ => byte & 0xf,
        })
    }

    /// A pixel without palette.
    fn pixel(&self, value: u32) -> Pixel {
        let [rgb @ .., alpha] = self.channels;
        Pixel {
            opaque: alpha.bits == 0 || alpha.read(value) == u8::MAX,
            ..Pixel::from_rgb(rgb.map(|channel| channel.read(value)))
        }
    }
}

impl Channel {
    const MISSING: Self = Self { shift: 0, bits: 0 };

    /// Equal channels in the order blue, green, red from the lowest bit, without alpha.
    const fn packed(bits: u32) -> [Self; 4] {
        let [red, green, blue] = [2 * bits, bits, 0];
        [
            Self { shift: red, bits },
            Self { shift: green, bits },
            Self { shift: blue, bits },
            Self::MISSING,
        ]
    }

    /// Reads the masks of red, green, blue and, optionally, alpha.
    fn read_masks(
        input: &Input<'_>,
        at: usize,
        has_alpha: bool,
        pixel_bits: u32,
    ) -> Result<[Self; 4], MapError> {
        let mut channels = [Self::MISSING; 4];
        for (number, channel) in channels.iter_mut().enumerate().take(3 + usize::from(has_alpha)) {
            *channel = Self::from_mask(input.number(at + 4 * number, 4)?, pixel_bits)?;
            if number < 3 && channel.bits == 0 {
                return Err(bad_image("missing bit mask"));
            }
        }
        Ok(channels)
    }

    /// The upper eight bits of a mask.
    fn from_mask(mask: u32, pixel_bits: u32) -> Result<Self, MapError> {
        if mask == 0 {
            return Ok(Self::MISSING);
        }
        let (shift, bits) = (mask.trailing_zeros(), mask.count_ones());
        if bits != 32 - mask.leading_zeros() - shift || bits + shift > pixel_bits {
            return Err(bad_image("invalid bit mask"));
        }
        let excess = bits.saturating_sub(8);
        Ok(Self { shift: shift + excess, bits: bits - excess })
    }

    /// The channel's value scaled to 0..=255, rounded.
    const fn read(self, value: u32) -> u8 {
        let max = (1 << self.bits) - 1;
        (((value >> self.shift & max) * 255 + max / 2) / max) as u8
    }
}
