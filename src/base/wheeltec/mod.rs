//! The WHEELTEC STM32 lower controller: it mixes itself, reports unasked, and has no watchdog.
//!
//! 115200 baud, 8N1. A frame starts with `7B` and ends with `7D`; the byte before the end is the exclusive or of all
//! before it. Numbers are big-endian signed 16-bit in mm/s and mrad/s. Both marks also occur inside frames, so a
//! frame is one only when its length, both marks and the check byte agree. That check is weak: any two flips of the same
//! bit in two bytes pass it.

mod frames;
mod peer;
mod session;

pub use frames::{COMMAND_LENGTH, Command, Decoder, FEEDBACK_LENGTH, Frame, Report};
pub use peer::WheeltecPeer;
pub use session::WheeltecSession;

/// Speed of the line.
pub const BAUD: u32 = 115_200;

/// Time from one report to the next, seconds: 20 Hz.
pub const REPORT_EVERY_S: f64 = 0.05;
