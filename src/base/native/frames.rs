//! Encoding and decoding of the command and report frames.

use std::collections::VecDeque;
use std::marker::PhantomData;

use crc::{CRC_16_IBM_3740, Crc};

use super::VERSION;
use crate::base::{Bumper, Faults};

const CRC: Crc<u16> = Crc::<u16>::new(&CRC_16_IBM_3740);

/// Longest piece between two zeros that can be a frame, bytes.
const MAX_PIECE: usize = 32;

/// One kind of frame, for [`Decoder`].
pub trait Frame: Default {
    /// Bytes of the payload, with its CRC.
    const LENGTH: usize;

    /// The second byte of the payload.
    const KIND: u8;

    /// Decodes a payload whose length, version, kind and CRC are valid; returns none if a reserved bit is set.
    fn from_checked(payload: &[u8]) -> Option<Self>;
}

/// A command of the host.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Command {
    /// Sequence of the command.
    pub sequence: u16,
    /// Whether to engage the stop.
    pub stop: bool,
    /// Whether to release the stop.
    pub release: bool,
    /// Set speeds of the channels, ticks per second.
    pub speeds: [i32; 2],
}

/// A report of the base.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Report {
    /// Sequence of the report.
    pub sequence: u16,
    /// Sequence of the last accepted command, if there was one since power-on.
    pub echo: Option<u16>,
    /// Whether the stop is latched.
    pub stopped: bool,
    /// Whether the button is pressed.
    pub button_pressed: bool,
    /// Faults.
    pub faults: Faults,
    /// Time of the encoder counts, milliseconds since power-on.
    pub time_ms: u32,
    /// Encoder counts of the channels.
    pub counts: [u32; 2],
    /// Turn rate by the gyro, mrad/s, if the base has one.
    pub yaw_rate_mrad_s: Option<i16>,
    /// Battery voltage, millivolts, if the base measures it.
    pub battery_mv: Option<u16>,
    /// Bumpers that are pressed.
    pub bumper: Bumper,
    /// Whether a cliff sensor sees no ground.
    pub cliff: bool,
}

impl Command {
    /// Encodes the frame.
    #[must_use]
    pub fn encode(&self) -> Vec<u8> {
        let mut payload = vec![VERSION, Self::KIND];
        payload.extend(self.sequence.to_le_bytes());
        payload.push(u8::from(self.stop) | u8::from(self.release) << 1);
        for speed in self.speeds {
            payload.extend(speed.to_le_bytes());
        }
        seal(payload)
    }
}

impl Frame for Command {
    const LENGTH: usize = 15;
    const KIND: u8 = 0x43;

    fn from_checked(payload: &[u8]) -> Option<Self> {
        let flags = payload[4];
        (flags < 4).then(|| Self {
            sequence: u16::from_le_bytes(at(payload, 2)),
            stop: flags & 1 != 0,
            release: flags & 2 != 0,
            speeds: [5, 9].map(|start| i32::from_le_bytes(at(payload, start))),
        })
    }
}

impl Report {
    /// Encodes the frame.
    #[must_use]
    pub fn encode(&self) -> Vec<u8> {
        let flags = [
            self.stopped,
            self.button_pressed,
            self.echo.is_some(),
            self.yaw_rate_mrad_s.is_some(),
            self.battery_mv.is_some(),
            self.bumper.left,
            self.bumper.right,
            self.cliff,
        ];
        let mut payload = vec![VERSION, Self::KIND];
        payload.extend(self.sequence.to_le_bytes());
        payload.extend(self.echo.unwrap_or_default().to_le_bytes());
        payload.push((0..).zip(flags).map(|(bit, flag)| u8::from(flag) << bit).sum());
        payload.extend(self.faults.bits().to_le_bytes());
        payload.extend(self.time_ms.to_le_bytes());
        for count in self.counts {
            payload.extend(count.to_le_bytes());
        }
        payload.extend(self.yaw_rate_mrad_s.unwrap_or_default().to_le_bytes());
        payload.extend(self.battery_mv.unwrap_or_default().to_le_bytes());
        seal(payload)
    }
}

impl Frame for Report {
    const LENGTH: usize = 27;
    const KIND: u8 = 0x52;

    fn from_checked(payload: &[u8]) -> Option<Self> {
        let flags = payload[6];
        let flag = |bit: u8| flags >> bit & 1 != 0;
        Some(Self {
            sequence: u16::from_le_bytes(at(payload, 2)),
            echo: flag(2).then(|| u16::from_le_bytes(at(payload, 4))),
            stopped: flag(0),
            button_pressed: flag(1),
            faults: Faults::from_bits(u16::from_le_bytes(at(payload, 7))),
            time_ms: u32::from_le_bytes(at(payload, 9)),
            counts: [13, 17].map(|start| u32::from_le_bytes(at(payload, start))),
            yaw_rate_mrad_s: flag(3).then(|| i16::from_le_bytes(at(payload, 21))),
            battery_mv: flag(4).then(|| u16::from_le_bytes(at(payload, 23))),
            bumper: Bumper { left: flag(5), right: flag(6) },
            cliff: flag(7),
        })
    }
}

/// Bytes of a number in a payload of checked length.
fn at<const N: usize>(payload: &[u8], start: usize) -> [u8; N] {
    let mut bytes = [0; N];
    bytes.copy_from_slice(&payload[start..start + N]);
    bytes
}

fn seal(mut payload: Vec<u8>) -> Vec<u8> {
    let check = CRC.checksum(&payload);
    payload.extend(check.to_le_bytes());
    let mut line = vec![0; payload.len() + cobs::max_encoding_overhead(payload.len()) + 2];
    let length = cobs::encode(&payload, &mut line[1..]);
    line.truncate(length + 2);
    line
}

/// Extracts frames of one kind from a stream that arrives in pieces and may be damaged.
///
/// The iterator ends when bytes are missing and continues after the next [`Decoder::push`].
#[derive(Clone, Debug, Default)]
pub struct Decoder<F> {
    pending: VecDeque<u8>,
    /// Bytes since the last zero, at most [`MAX_PIECE`].
    piece: Vec<u8>,
    /// Bytes of the piece beyond that.
    excess: u64,
    dropped: u64,
    frame: PhantomData<F>,
}

impl<F: Frame> Decoder<F> {
    /// Appends received bytes. They are kept until [`Iterator::next`] consumes them.
    pub fn push(&mut self, bytes: &[u8]) {
        self.pending.extend(bytes);
    }

    /// Bytes dropped so far because they are no valid frame of this kind: zero on a clean line.
    #[must_use]
    pub const fn dropped_bytes(&self) -> u64 {
        self.dropped
    }

    /// Decodes the piece, if it is a frame.
    fn decode(&self) -> Option<F> {
        let mut payload = [0; MAX_PIECE];
        let report = cobs::decode(&self.piece, &mut payload).ok()?;
        let payload = payload.get(..report.frame_size())?;
        if payload.len() != F::LENGTH || payload[..2] != [VERSION, F::KIND] {
            return None;
        }
        let (content, check) = payload.split_at(F::LENGTH - 2);
        (CRC.checksum(content).to_le_bytes() == check).then(|| F::from_checked(payload)).flatten()
    }
}

impl<F: Frame> Iterator for Decoder<F> {
    type Item = F;

    fn next(&mut self) -> Option<F> {
        while let Some(byte) = self.pending.pop_front() {
            if byte != 0 {
                if self.piece.len() < MAX_PIECE {
                    self.piece.push(byte);
                } else {
                    self.excess += 1;
                }
                continue;
            }
            let frame = if self.excess == 0 { self.decode() } else { None };
            if frame.is_none() {
                self.dropped += self.piece.len() as u64 + self.excess;
            }
            self.piece.clear();
            self.excess = 0;
            if frame.is_some() {
                return frame;
            }
        }
        None
    }
}
