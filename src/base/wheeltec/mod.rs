//! Protocol of the WHEELTEC STM32 lower controller. It mixes the tracks itself, reports periodically, and has no watchdog.
//!
//! 115200 baud, 8N1. A frame starts with `7B` and ends with `7D`; the byte before the end is the exclusive or of all
//! before it. Numbers are big-endian signed 16-bit in mm/s and mrad/s. Both marks also occur inside frames, so a frame is valid
//! only if its length, both marks and the check byte agree. The check is weak: two flips of the same bit in two bytes pass it.

mod device;
mod frames;
mod session;

#[doc(hidden)]
pub use super::frame_decoder::FrameDecoder as Decoder;
#[doc(hidden)]
pub use device::WheeltecDevice;
#[doc(hidden)]
pub use frames::{COMMAND_LENGTH, Command, FEEDBACK_LENGTH, Report};
#[doc(hidden)]
pub use session::WheeltecSession;

/// Speed of the serial line, baud.
pub const BAUD: u32 = 115_200;

/// Time between reports, seconds: 20 Hz.
pub const REPORT_PERIOD_S: f64 = 0.05;
