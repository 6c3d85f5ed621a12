//! Driver of the LD19, a planar lidar of LDROBOT (Shenzhen LDROBOT Co.), and of the LD06, LD14P and STL-19P with the same packets.
//!
//! The lidar rotates and sends by itself at 230,400 baud, and takes no commands. A packet of 47 bytes holds twelve points, numbers
//! little-endian (LDROBOT, "`LD19` Development Manual", V2.3):
//!
//! | bytes | |
//! |---|---|
//! | 0 | 0x54 |
//! | 1 | 0x2C: kind 1 in the upper three bits, twelve points in the lower five |
//! | 2, 3 | speed of rotation, degrees per second |
//! | 4, 5 | angle of the first point, 0.01 degrees |
//! | 6 to 41 | for each point its distance, mm, in two bytes, and its intensity; a distance of zero is no measurement |
//! | 42, 43 | angle of the last point |
//! | 44, 45 | time, ms, wraps at 30,000 |
//! | 46 | CRC-8 of all before: polynomial 0x4D, initial value zero, not reflected |
//!
//! The points lie at equal angles. The sensor's angles run clockwise from its front, seen from above; beams run counter-clockwise
//! (REP-103), so their sign is changed. [`Decoder`] extracts packets from a stream and [`RevolutionAssembler`] joins them to
//! revolutions, both without I/O; [`LidarReader`] owns the port.

mod reader;
mod revolutions;

pub use reader::{LidarFault, LidarReader, LidarStatus, OpenLidar};
#[doc(hidden)]
pub use revolutions::RevolutionAssembler;

use crc::{Algorithm, Crc};
use serde::{Deserialize, Serialize};

use super::frame_decoder::{Frame, FrameDecoder};
use crate::geometry::Pose;
use crate::settings::settings;

/// Extracts packets from a byte stream.
#[doc(hidden)]
pub type Decoder = FrameDecoder<Packet>;

/// Speed of the serial line, baud.
pub const BAUD: u32 = 230_400;

/// Points per second (manual): 450 per revolution at 10 Hz.
pub const POINTS_PER_S: f64 = 4500.0;

/// Longest range, metres (manual).
pub const RANGE_MAX_M: f64 = 12.0;

settings! {
    /// Mounting and timeout of a lidar on the robot.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct LidarSettings {
        /// Position ahead of the robot's origin.
        pub mount_x_m: f64 = 0.0, ["m", -5 to 5];
        /// Position to the left of the robot's origin.
        pub mount_y_m: f64 = 0.0, ["m", -5 to 5];
        /// Direction of the sensor's front, counter-clockwise from the robot's.
        pub mount_yaw_rad: f64 = 0.0, ["rad", -3.2 to 3.2];
        /// Whether the sensor is mounted upside down. Default false.
        pub upside_down: bool = false;
        /// Shortest valid range; nearer returns are the robot itself. Default 0.1 m.
        pub range_min_m: f64 = 0.1, ["m", 0 to 5];
        /// Time without a complete revolution after which the lidar counts as silent. Default 0.5 s, five
        /// revolutions.
        pub timeout_s: f64 = 0.5, ["s", above 0 to 10];
    }
}

impl LidarSettings {
    /// Pose of the sensor in the robot's frame.
    #[must_use]
    pub const fn mount(&self) -> Pose {
        Pose::new(self.mount_x_m, self.mount_y_m, self.mount_yaw_rad)
    }
}

const HEAD: u8 = 0x54;
const KIND: u8 = 0x2C;

/// Bytes of a packet.
#[doc(hidden)]
pub const PACKET_LENGTH: usize = 47;

/// Points of a packet.
#[doc(hidden)]
pub const POINTS: usize = 12;

/// Full revolution, 0.01 degrees.
const REVOLUTION: u16 = 36_000;

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
#[doc(hidden)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Point {
    /// Distance, mm; zero for none.
    pub distance_mm: u16,
    /// Strength of the echo.
    pub intensity: u8,
}

/// Twelve points at equal angles.
#[doc(hidden)]
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
