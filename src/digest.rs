//! SHA-256 digests of numbers, to compare results bit for bit.

use core::fmt::Write;

use sha2::{Digest, Sha256};

/// A SHA-256 over the exact bits of the added values, in order, little-endian.
#[derive(Clone, Default)]
pub struct BitDigest(Sha256);

impl BitDigest {
    /// Adds 32 bits.
    pub fn word(&mut self, value: u32) {
        self.0.update(value.to_le_bytes());
    }

    /// Adds 64 bits.
    pub fn wide(&mut self, value: u64) {
        self.0.update(value.to_le_bytes());
    }

    /// Adds the bits of a float.
    pub fn real(&mut self, value: f64) {
        self.wide(value.to_bits());
    }

    /// Adds bytes.
    pub fn bytes(&mut self, bytes: &[u8]) {
        self.0.update(bytes);
    }

    /// Adds the bytes of a text.
    pub fn text(&mut self, text: &str) {
        self.0.update(text.as_bytes());
    }

    /// Returns the digest as hexadecimal digits.
    #[must_use]
    pub fn hex(self) -> String {
        self.0.finalize().iter().fold(String::new(), |mut text, byte| {
            write!(text, "{byte:02x}").expect("writing to a string never fails");
            text
        })
    }
}
