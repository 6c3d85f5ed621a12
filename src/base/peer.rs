//! The base's side of a protocol, without I/O: what a lower controller decodes and answers, for a virtual one.

use super::Faults;
use crate::robot::{Sides, TrackSpeeds};

/// The communication part of a lower controller's firmware. Motors, encoders and their faults are the caller's.
///
/// It knows the machine as its firmware does: by settings of its own, which may differ from what the host believes.
pub trait Peer: Send {
    /// Takes bytes that came, in pieces of any size.
    fn receive(&mut self, bytes: &[u8], now_s: f64);

    /// One turn of the firmware's loop: appends what is to be written now, and returns the speeds, m/s, that the tracks are
    /// to make for: zero where the watchdog or an emergency stop acts. Time never runs backwards.
    fn step(&mut self, now_s: f64, machine: &Machine, line: &mut Vec<u8>) -> TrackSpeeds;
}

/// The state of the machine, as its controller measures it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Machine {
    /// Encoder counts of the tracks, which wrap around.
    pub ticks: Sides<u32>,
    /// Measured speeds of the tracks, m/s.
    pub speeds: TrackSpeeds,
    /// Turn rate by the gyro, rad/s.
    pub yaw_rate: f64,
    /// Voltage of the battery.
    pub battery_v: f64,
    /// What its own supervision found.
    pub faults: Faults,
    /// Whether the emergency button is pressed.
    pub button_pressed: bool,
}
