//! The LD19, a planar lidar of LDROBOT (Shenzhen LDROBOT Co.), and its kin with the same packets: LD06, LD14P, STL-19P.
//!
//! It turns and talks by itself, at 230,400 baud, and hears nothing. A packet of 47 bytes holds twelve points, numbers little-endian
//! (LDROBOT, "`LD19` Development Manual", V2.3):
//!
//! | bytes | |
//! |---|---|
//! | 0 | 0x54 |
//! | 1 | 0x2C: kind 1 in the upper three bits, twelve points in the lower five |
//! | 2, 3 | speed of rotation, degrees per second |
//! | 4, 5 | angle of the first point, 0.01 degrees |
//! | 6 to 41 | for each point its distance, mm, in two bytes, and its intensity; a distance of zero is no measurement |
//! | 42, 43 | angle of the last point |
//! | 44, 45 | time, ms, from 0 to 30,000 and round again |
//! | 46 | CRC-8 of all before: polynomial 0x4D, from zero, not reflected |
//!
//! Points between lie at equal angles. Angles run clockwise seen from above, from the sensor's front; ours run counter-clockwise
//! (REP-103), so they are turned round. [`Decoder`] finds packets in a stream, [`Revolutions`] makes whole turns of them, both without
//! I/O; [`LidarKeeper`] has the port.

mod frames;
mod keeper;
mod revolutions;
mod settings;

pub use frames::{Decoder, PACKET_LENGTH, POINTS, Packet, Point};
pub use keeper::{LidarKeeper, LidarStatus, LidarTrouble, OpenLidar};
pub use revolutions::Revolutions;
pub use settings::LidarSettings;

/// Speed of the line.
pub const BAUD: u32 = 230_400;

/// Points a second, as the manual has it: 450 in a turn at 10 Hz.
pub const POINTS_PER_S: f64 = 4500.0;

/// Longest range, metres, as the manual has it.
pub const RANGE_MAX_M: f64 = 12.0;
