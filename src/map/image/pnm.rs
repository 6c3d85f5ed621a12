//! Netpbm images: PBM, PGM and PPM, as text or binary, and PAM.

use super::{GreyImage, Pixel, bad_image, to_8_bits};
use crate::map::MapError;
use crate::map::grid::check_size;

/// Longest line of a PAM header, bytes.
const MAX_LINE: usize = 200;

/// Whether the bytes start like a Netpbm image.
pub(super) fn is_pnm(bytes: &[u8]) -> bool {
    matches!(bytes, [b'P', b'1'..=b'7', ..])
}

/// Reads a file from front to back.
struct Input<'a>(core::slice::Iter<'a, u8>);

/// Decodes a Netpbm file whose first two bytes are valid.
pub(super) fn decode(bytes: &[u8]) -> Result<GreyImage, MapError> {
    let kind = bytes[1];
    let mut input = Input(bytes[2..].iter());
    let [width, height, depth, max] =
        if kind == b'7' { input.pam_header()? } else { input.header(kind)? };
    if !(1..=4).contains(&depth) {
        return Err(bad_image(format!("depth {depth}: it must be 1 to 4")));
    }
    if !(1..=0xffff).contains(&max) {
        return Err(bad_image(format!("largest value {max}: it must be 1 to 65535")));
    }
    check_size(i64::from(width), i64::from(height))?;
    let mut bits = 0;
    let pixel = |column: u32| match kind {
        b'1' => input.text_bit(),
        b'4' => {
            bits = if column.is_multiple_of(8) { input.next()? } else { bits << 1 };
            Ok(Pixel::from_bit(bits & 0x80 != 0))
        }
        _ => {
            let is_text = matches!(kind, b'2' | b'3');
            let mut sample = || if is_text { input.text_sample(max) } else { input.sample(max) };
            let color = if depth < 3 {
                Pixel::from_grey(sample()?)
            } else {
                Pixel::from_rgb([sample()?, sample()?, sample()?])
            };
            // The last of two or four channels is alpha.
            let opaque = depth % 2 == 1 || sample()? == u8::MAX;
            Ok(Pixel { opaque, ..color })
        }
    };
    let pixels: Result<Vec<Pixel>, MapError> =
        (0..height).flat_map(|_| 0..width).map(pixel).collect();
    Ok(GreyImage { width: width as i32, height: height as i32, pixels: pixels? })
}

impl Pixel {
    /// The pixel of a bitmap: a set bit is black.
    const fn from_bit(is_black: bool) -> Self {
        Self::from_grey(if is_black { 0 } else { u8::MAX })
    }
}

impl Input<'_> {
    fn next(&mut self) -> Result<u8, MapError> {
        let byte = self.0.next().copied();
        byte.ok_or_else(|| bad_image("the file ends too early"))
    }

    /// Width, height, number of channels and largest value of all formats except PAM.
    fn header(&mut self, kind: u8) -> Result<[u32; 4], MapError> {
        let (width, height) = (self.header_number()?, self.header_number()?);
        let depth = if matches!(kind, b'3' | b'6') { 3 } else { 1 };
        let max = if matches!(kind, b'1' | b'4') { 1 } else { self.header_number()? };
        Ok([width, height, depth, max])
    }

    /// A number of the header. A comment runs from `#` to the end of its line, and ends the number before it.
    fn header_number(&mut self) -> Result<u32, MapError> {
        let mut number: Option<u32> = None;
        while let Some(&byte) = self.0.next() {
            if byte == b'#' {
                while self.0.next().is_some_and(|&byte| byte != b'\n' && byte != b'\r') {}
            }
            if byte == b'#' || is_space(byte) {
                if number.is_some() {
                    break;
                }
            } else {
                number = Some(append_digit(number.unwrap_or(0), byte)?);
            }
        }
        number.ok_or_else(|| bad_image("the header ends too early"))
    }

    /// The same four numbers of a PAM image (netpbm.sourceforge.net/doc/pam.html); those that are missing are zero. The
    /// type of a tuple follows from the number of channels.
    fn pam_header(&mut self) -> Result<[u32; 4], MapError> {
        let mut numbers = [0; 4];
        loop {
            let line = self.line()?;
            let bad_line = || bad_image(format!("{line:?} in the header"));
            let (key, value) = line.split_once(' ').unwrap_or((&line, ""));
            let keys = ["WIDTH", "HEIGHT", "DEPTH", "MAXVAL"];
            if let Some(at) = keys.into_iter().position(|known| known == key) {
                numbers[at] = value.trim().parse().map_err(|_| bad_line())?;
            } else if key == "ENDHDR" {
                return Ok(numbers);
            } else if !matches!(key, "" | "TUPLTYPE") && !key.starts_with('#') {
                return Err(bad_line());
            }
        }
    }

    fn line(&mut self) -> Result<String, MapError> {
        let rest = self.0.as_slice();
        let end = rest.iter().take(MAX_LINE + 1).position(|&byte| byte == b'\n');
        let end = end.ok_or_else(|| bad_image("a line of the header does not end"))?;
        self.0 = rest[end + 1..].iter();
        Ok(String::from_utf8_lossy(&rest[..end]).trim().to_owned())
    }

    /// A sample of a text format, scaled to 0..=255.
    fn text_sample(&mut self, max: u32) -> Result<u8, MapError> {
        let mut byte = self.next()?;
        while is_space(byte) {
            byte = self.next()?;
        }
        let mut number = append_digit(0, byte)?;
        while let Some(&byte) = self.0.next().filter(|&&byte| !is_space(byte)) {
            number = append_digit(number, byte)?;
            if number > 0xffff {
                break;
            }
        }
        if number > limit(max) {
            return Err(bad_image(format!("value {number} with {max} as the largest")));
        }
        Ok(scaled(number, max))
    }

    /// A sample of a binary format, scaled to 0..=255: one byte, or two with the high byte first.
    fn sample(&mut self, max: u32) -> Result<u8, MapError> {
        let high = if max > 0xff { self.next()? } else { 0 };
        let low = self.next()?;
        Ok(scaled(u32::from(high) << 8 | u32::from(low), max))
    }

    /// A bit of a text bitmap.
    fn text_bit(&mut self) -> Result<Pixel, MapError> {
        loop {
            match self.next()? {
                byte @ (b'0' | b'1') => return Ok(Pixel::from_bit(byte == b'1')),
                byte if is_space(byte) => {}
                byte => {
                    return Err(bad_image(format!("{:?} in place of a bit", char::from(byte))));
                }
            }
        }
    }
}

const fn is_space(byte: u8) -> bool {
    matches!(byte, b'\t' | b'\n' | 0x0b | 0x0c | b'\r' | b' ')
}

fn append_digit(number: u32, byte: u8) -> Result<u32, MapError> {
    let digit = byte.is_ascii_digit().then(|| u32::from(byte - b'0'));
    digit
        .and_then(|digit| number.checked_mul(10)?.checked_add(digit))
        .ok_or_else(|| bad_image(format!("{:?} in a number", char::from(byte))))
}

/// Largest value of a sample in the file: 8 bits, or 16 if the largest value of the image needs them.
const fn limit(max: u32) -> u32 {
    if max <= 0xff { 0xff } else { 0xffff }
}

/// A value of 0 to `max` scaled to 8 bits; a larger one is limited.
fn scaled(value: u32, max: u32) -> u8 {
    let limit = limit(max);
    // Single precision, as in the `image` crate.
    let scaled = if max == limit {
        value
    } else {
        let factor = limit as f32 / max as f32;
        (value as f32 * factor).round().min(limit as f32) as u32
    };
    if limit == 0xff { scaled as u8 } else { to_8_bits(scaled as u16) }
}
