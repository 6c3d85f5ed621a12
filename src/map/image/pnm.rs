//! Netpbm images: PBM, PGM and PPM, as text or binary, and PAM.

use super::{GreyImage, Pixel, bad_image, to_8_bits};
use crate::map::MapError;
use crate::map::grid::check_size;

/// Whether the bytes start like a Netpbm image.
pub(super) fn is_pnm(bytes: &[u8]) -> bool {
    matches!(bytes, [b'P', b'1'..=b'7', ..])
}

/// Reads a file from front to back.
struct Input<'a>(core::slice::Iter<'a, u8>);

/// Decodes a Netpbm file whose first two bytes are valid.
pub(super) fn decode(bytes: &[u8]) -> Result<GreyImage, MapError> {
    let mut input = Input(bytes[2..].iter());
    if bytes[1] == b'7' {
        return input.pam();
    }
    let (width, height) = (input.header_number()?, input.header_number()?);
    let max = match bytes[1] {
        b'1' | b'4' => 1,
        _ => input.header_number()?,
    };
    if !(1..=0xffff).contains(&max) {
        return Err(bad_image(format!("largest value {max}: it must be 1 to 65535")));
    }
    check_size(i64::from(width), i64::from(height))?;
    let (width, height) = (width as usize, height as usize);
    let pixels: Result<Vec<Pixel>, MapError> = match bytes[1] {
        b'1' => (0..width * height).map(|_| input.text_bit()).collect(),
        b'4' => input.bits(width, height),
        b'2' => (0..width * height).map(|_| input.text_sample(max).map(Pixel::from_grey)).collect(),
        b'3' => (0..width * height).map(|_| input.color(|input| input.text_sample(max))).collect(),
        b'5' => (0..width * height).map(|_| input.sample(max).map(Pixel::from_grey)).collect(),
        _ => (0..width * height).map(|_| input.color(|input| input.sample(max))).collect(),
    };
    Ok(GreyImage { width: width as i32, height: height as i32, pixels: pixels? })
}

impl Input<'_> {
    fn next(&mut self) -> Result<u8, MapError> {
        let byte = self.0.next().copied();
        byte.ok_or_else(|| bad_image("the file ends too early"))
    }

    /// A number of the header. A comment runs from `#` to the end of its line.
    fn header_number(&mut self) -> Result<u32, MapError> {
        let mut number: Option<u32> = None;
        while let Some(&byte) = self.0.next() {
            if byte == b'#' {
                while self.0.next().is_some_and(|&byte| byte != b'\n' && byte != b'\r') {}
            } else if is_space(byte) {
                if number.is_some() {
                    break;
                }
            } else {
                number = Some(append_digit(number.unwrap_or(0), byte)?);
            }
        }
        number.ok_or_else(|| bad_image("the header ends too early"))
    }

    /// A PAM image (netpbm.sourceforge.net/doc/pam.html): one to four binary channels, the last of two or four is alpha.
    fn pam(mut self) -> Result<GreyImage, MapError> {
        let (mut width, mut height, mut depth, mut max) = (0, 0, 0, 0);
        loop {
            let line = self.line()?;
            let (key, value) = line.split_once(' ').unwrap_or((&line, ""));
            let number = || {
                let number = value.trim().parse::<u32>();
                number.map_err(|_| bad_image(format!("{line:?} in the header")))
            };
            match key {
                "WIDTH" => width = number()?,
                "HEIGHT" => height = number()?,
                "DEPTH" => depth = number()?,
                "MAXVAL" => max = number()?,
                "ENDHDR" => break,
                // The type of a tuple follows from its depth.
                "" | "TUPLTYPE" => {}
                comment if comment.starts_with('#') => {}
                _ => return Err(bad_image(format!("{line:?} in the header"))),
            }
        }
        if !((1..=4).contains(&depth) && (1..=0xffff).contains(&max)) {
            return Err(bad_image(format!(
                "depth {depth} and largest value {max}: they must be 1 to 4 and 1 to 65535"
            )));
        }
        check_size(i64::from(width), i64::from(height))?;
        let pixel = |input: &mut Self| {
            let color = if depth < 3 {
                Pixel::from_grey(input.sample(max)?)
            } else {
                input.color(|input| input.sample(max))?
            };
            let opaque = depth % 2 == 1 || input.sample(max)? == u8::MAX;
            Ok(Pixel { opaque, ..color })
        };
        let count = width as usize * height as usize;
        let pixels: Result<Vec<Pixel>, MapError> = (0..count).map(|_| pixel(&mut self)).collect();
        Ok(GreyImage { width: width as i32, height: height as i32, pixels: pixels? })
    }

    /// A line of a header, at most 200 bytes.
    fn line(&mut self) -> Result<String, MapError> {
        let mut line = Vec::new();
        loop {
            match self.next()? {
                b'\n' => break,
                _ if line.len() == 200 => {
                    return Err(bad_image("a line of the header is too long"));
                }
                byte => line.push(byte),
            }
        }
        Ok(String::from_utf8_lossy(&line).trim().to_owned())
    }

    /// A sample as text, scaled to 8 bits.
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
        if number > if max <= 0xff { 0xff } else { 0xffff } {
            return Err(bad_image(format!("value {number} with {max} as the largest")));
        }
        Ok(scaled(number, max))
    }

    /// A binary sample, scaled to 8 bits.
    fn sample(&mut self, max: u32) -> Result<u8, MapError> {
        let high = if max > 0xff { self.next()? } else { 0 };
        let low = self.next()?;
        Ok(scaled(u32::from(high) << 8 | u32::from(low), max))
    }

    fn color(
        &mut self,
        mut sample: impl FnMut(&mut Self) -> Result<u8, MapError>,
    ) -> Result<Pixel, MapError> {
        Ok(Pixel::from_rgb([sample(self)?, sample(self)?, sample(self)?]))
    }

    /// A bit as text: 1 is black.
    fn text_bit(&mut self) -> Result<Pixel, MapError> {
        loop {
            match self.next()? {
                b'0' => return Ok(Pixel::from_grey(u8::MAX)),
                b'1' => return Ok(Pixel::BLACK),
                byte if is_space(byte) => {}
                byte => {
                    return Err(bad_image(format!("{:?} in place of a bit", char::from(byte))));
                }
            }
        }
    }

    /// Rows of bits, each padded to whole bytes: 1 is black.
    fn bits(&mut self, width: usize, height: usize) -> Result<Vec<Pixel>, MapError> {
        let mut pixels = Vec::with_capacity(width * height);
        for _ in 0..height {
            let mut byte = 0;
            for column in 0..width {
                byte = if column.is_multiple_of(8) { self.next()? } else { byte << 1 };
                pixels.push(Pixel::from_grey(if byte & 0x80 == 0 { u8::MAX } else { 0 }));
            }
        }
        Ok(pixels)
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

/// A value of 0 to `max` scaled to 8 bits; a larger one is limited.
fn scaled(value: u32, max: u32) -> u8 {
    let limit = if max <= 0xff { 0xff } else { 0xffff };
    // Single precision, as in the `image` crate.
    let scaled = if max == limit {
        value
    } else {
        let factor = limit as f32 / max as f32;
        (value as f32 * factor).round().min(limit as f32) as u32
    };
    if limit == 0xff { scaled as u8 } else { to_8_bits(scaled as u16) }
}
