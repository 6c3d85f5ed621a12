//! Encoding and decoding of packets.

use crc::{Algorithm, Crc};

use crate::base::frame_decoder::Frame;

const HEAD: u8 = 0x54;
const KIND: u8 = 0x2C;

/// Bytes of a packet.
pub const PACKET_LENGTH: usize = 47;

/// Points of a packet.
pub const POINTS: usize = 12;

/// Full revolution, 0.01 degrees.
pub(super) const REVOLUTION: u16 = 36_000;

/// Largest plausible span of a packet's twelve points at any speed, 0.01 degrees.
const MAX_SPAN: u16 = 9_000;

/// The check value of `123456789` comes from an independent program: see the tests.
const ALGORITHM: Algorithm<u8> = Algorithm {
    width: 8,
    poly: 0x4D,
    init: 0,
    refin: false,
    refout: false,
    xorout: 0,
    check: 0xC3,
    residue: 0,
};

const CRC: Crc<u8> = Crc::<u8>::new(&ALGORITHM);

/// One measurement.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Point {
    /// Distance, mm; zero for none.
    pub distance_mm: u16,
    /// Strength of the echo.
    pub intensity: u8,
}

/// Twelve points at equal angles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Packet {
    /// Speed of rotation, degrees per second.
    pub speed_deg_s: u16,
    /// Angle of the first point, 0.01 degrees clockwise, below 36,000.
    pub first: u16,
    /// The points in the order in which they were measured.
    pub points: [Point; POINTS],
    /// Angle of the last point, at most 90 degrees on.
    pub last: u16,
    /// Time by the lidar's clock, ms, wraps at 30,000.
    pub time_ms: u16,
}

impl Packet {
    /// Angle from the first point to the last, 0.01 degrees clockwise.
    #[must_use]
    pub const fn span(&self) -> u16 {
        let revolution = REVOLUTION as u32;
        ((self.last as u32 + revolution - self.first as u32 % revolution) % revolution) as u16
    }

    /// Encodes the packet, for an emulated lidar.
    #[must_use]
    pub fn encode(&self) -> [u8; PACKET_LENGTH] {
        let mut bytes = [0; PACKET_LENGTH];
        (bytes[0], bytes[1]) = (HEAD, KIND);
        let mut put = |at: usize, number: u16| {
            bytes[at..at + 2].copy_from_slice(&number.to_le_bytes());
        };
        put(2, self.speed_deg_s);
        put(4, self.first);
        put(42, self.last);
        put(44, self.time_ms);
        for (index, point) in self.points.iter().enumerate() {
            put(6 + 3 * index, point.distance_mm);
        }
        for (index, point) in self.points.iter().enumerate() {
            bytes[8 + 3 * index] = point.intensity;
        }
        bytes[PACKET_LENGTH - 1] = CRC.checksum(&bytes[..PACKET_LENGTH - 1]);
        bytes
    }
}

impl Frame for Packet {
    const LENGTH: usize = PACKET_LENGTH;
    const HEADER: &'static [u8] = &[HEAD, KIND];

    fn decode(bytes: &[u8]) -> Option<Self> {
        let (content, check) = bytes.split_at(PACKET_LENGTH - 1);
        if CRC.checksum(content) != check[0] {
            return None;
        }
        let number = |at: usize| u16::from_le_bytes([bytes[at], bytes[at + 1]]);
        let packet = Self {
            speed_deg_s: number(2),
            first: number(4),
            points: core::array::from_fn(|index| Point {
                distance_mm: number(6 + 3 * index),
                intensity: bytes[8 + 3 * index],
            }),
            last: number(42),
            time_ms: number(44),
        };
        let is_angle = packet.first < REVOLUTION && packet.last < REVOLUTION;
        (is_angle && packet.span() <= MAX_SPAN).then_some(packet)
    }
}
