//! Arbitrary bytes as the numbers of a story: what a target needs is read from the front, zeros when they run out.

/// What is left of the input.
pub struct Bytes<'a>(pub &'a [u8]);

impl<'a> Bytes<'a> {
    /// The next ones, fewer at the end.
    pub fn take(&mut self, count: usize) -> &'a [u8] {
        let (taken, rest) = self.0.split_at(count.min(self.0.len()));
        self.0 = rest;
        taken
    }

    /// The next ones, and zeros where there are none.
    pub fn array<const N: usize>(&mut self) -> [u8; N] {
        let taken = self.take(N);
        core::array::from_fn(|index| taken.get(index).copied().unwrap_or_default())
    }

    /// The next one.
    pub fn byte(&mut self) -> u8 {
        u8::from_le_bytes(self.array())
    }

    /// A whole number.
    pub fn u16(&mut self) -> u16 {
        u16::from_le_bytes(self.array())
    }

    /// A whole number.
    pub fn u32(&mut self) -> u32 {
        u32::from_le_bytes(self.array())
    }

    /// Any number at all, infinities and NaN among them.
    pub fn real(&mut self) -> f64 {
        f64::from_le_bytes(self.array())
    }

    /// A number of a few thousandths to some tens: what machines have.
    pub fn plain(&mut self) -> f64 {
        f64::from(self.u16() as i16) / 1000.0
    }
}
