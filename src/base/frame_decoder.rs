//! Extracts frames of fixed length from a damaged byte stream.

use std::collections::VecDeque;
use std::marker::PhantomData;

/// A frame of fixed length that starts with a header.
pub trait Frame: Default {
    /// Length with header and checksum, bytes.
    const LENGTH: usize;

    /// First bytes of the frame.
    const HEADER: &'static [u8];

    /// Decodes [`Self::LENGTH`] bytes that start with the header; returns none if they are no valid frame.
    fn decode(bytes: &[u8]) -> Option<Self>;
}

/// Extracts frames of one kind from a stream that arrives in pieces and may be damaged.
///
/// The iterator ends when bytes are missing and continues after the next [`FrameDecoder::push`]. If no frame fits, it drops one
/// byte and tries the next position, so that a damaged frame never costs the frame after it.
#[derive(Clone, Debug, Default)]
pub struct FrameDecoder<F> {
    pending: VecDeque<u8>,
    dropped: u64,
    frame: PhantomData<F>,
}

impl<F> FrameDecoder<F> {
    /// Appends received bytes. They are kept until [`Iterator::next`] consumes them.
    pub fn push(&mut self, bytes: &[u8]) {
        self.pending.extend(bytes);
    }

    /// Bytes dropped so far because no frame fitted: zero on a clean line.
    #[must_use]
    pub const fn dropped_bytes(&self) -> u64 {
        self.dropped
    }
}

impl<F: Frame> Iterator for FrameDecoder<F> {
    type Item = F;

    fn next(&mut self) -> Option<F> {
        loop {
            let mut start = self.pending.iter().zip(F::HEADER);
            if start.all(|(byte, expected)| byte == expected) {
                if self.pending.len() < F::LENGTH {
                    return None;
                }
                let candidate = &self.pending.make_contiguous()[..F::LENGTH];
                if let Some(frame) = F::decode(candidate) {
                    self.pending.drain(..F::LENGTH);
                    return Some(frame);
                }
            }
            self.pending.pop_front()?;
            self.dropped += 1;
        }
    }
}
