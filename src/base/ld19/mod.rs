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

mod frames;
mod reader;
mod revolutions;
mod settings;

#[doc(hidden)]
pub use frames::{PACKET_LENGTH, POINTS, Packet, Point};
pub use reader::{LidarFault, LidarReader, LidarStatus, OpenLidar};
#[doc(hidden)]
pub use revolutions::RevolutionAssembler;
pub use settings::LidarSettings;

/// Extracts packets from a byte stream.
#[doc(hidden)]
pub type Decoder = super::frame_decoder::FrameDecoder<Packet>;

/// Speed of the serial line, baud.
pub const BAUD: u32 = 230_400;

/// Points per second (manual): 450 per revolution at 10 Hz.
pub const POINTS_PER_S: f64 = 4500.0;

/// Longest range, metres (manual).
pub const RANGE_MAX_M: f64 = 12.0;
