//! Arbitrary bytes as numbers: a target reads them from the front, and zeros after their end.

/// The unread part of the input.
pub struct Bytes<'a>(pub &'a [u8]);

impl<'a> Bytes<'a> {
    /// Returns this number of bytes, fewer at the end.
    pub fn take(&mut self, count: usize) -> &'a [u8] {
        let (taken, rest) = self.0.split_at(count.min(self.0.len()));
        self.0 = rest;
        taken
    }

    /// Returns the next bytes, and zeros after the end.
    pub fn array<const N: usize>(&mut self) -> [u8; N] {
        let taken = self.take(N);
        core::array::from_fn(|index| taken.get(index).copied().unwrap_or_default())
    }

    /// Returns the next byte.
    pub fn byte(&mut self) -> u8 {
        u8::from_le_bytes(self.array())
    }

    /// Reads two bytes.
    pub fn u16(&mut self) -> u16 {
        u16::from_le_bytes(self.array())
    }

    /// Reads four bytes.
    pub fn u32(&mut self) -> u32 {
        u32::from_le_bytes(self.array())
    }

    /// Any number, including infinities and NaN.
    pub fn real(&mut self) -> f64 {
        f64::from_le_bytes(self.array())
    }

    /// A number between -32.768 and 32.767 with three decimals, as machines have.
    pub fn plain(&mut self) -> f64 {
        f64::from(self.u16() as i16) / 1000.0
    }
}
