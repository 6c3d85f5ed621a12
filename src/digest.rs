//! One short name for many numbers: two sets that differ in one bit have different digests.

use core::fmt::Write;

use sha2::{Digest, Sha256};

/// A SHA-256 over the exact bits of the numbers added to it, in order, each little-endian.
#[derive(Clone, Default)]
pub struct BitDigest(Sha256);

impl BitDigest {
    /// Adds a number of 32 bits.
    pub fn word(&mut self, value: u32) {
        self.0.update(value.to_le_bytes());
    }

    /// Adds a number of 64 bits.
    pub fn wide(&mut self, value: u64) {
        self.0.update(value.to_le_bytes());
    }

    /// Adds the bits of a real number.
    pub fn real(&mut self, value: f64) {
        self.wide(value.to_bits());
    }

    /// Adds a text, byte by byte.
    pub fn text(&mut self, text: &str) {
        self.0.update(text.as_bytes());
    }

    /// The digest in hex.
    #[must_use]
    pub fn hex(self) -> String {
        self.0
            .finalize()
            .iter()
            .fold(String::new(), |mut text, byte| {
                write!(text, "{byte:02x}").expect("a string takes whatever is written");
                text
            })
    }
}
