//! The base's side of a protocol, without I/O: what a lower controller decodes and answers, for a virtual one.

use serde::Serialize;

use super::Faults;
use crate::robot::{PerTrack, TrackSpeeds};

/// The communication part of a lower controller's firmware. Motors, encoders and their faults are the caller's.
///
/// It knows the machine as its firmware does: by settings of its own, which may differ from what the host believes.
pub trait Peer: Send {
    /// Takes bytes that came, in pieces of any size.
    fn receive(&mut self, bytes: &[u8], now_s: f64);

    /// One turn of the firmware's loop: appends what is to be written now, and returns the speeds, m/s, that the tracks are
    /// to make for: zero where the watchdog or an emergency stop acts. Time never runs backwards.
    fn step(&mut self, now_s: f64, machine: &Machine, line: &mut Vec<u8>) -> TrackSpeeds;

    /// What it was told so far.
    fn orders(&self) -> Orders;
}

/// What a controller was told since it was switched on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Orders {
    /// Commands for the motors that were accepted.
    pub commands: u64,
    /// How many of them, the last ones in a row, were to stand.
    pub zeros_at_end: u64,
    /// How often motors that were told to run were stopped because no more commands came.
    pub watchdog_stops: u64,
}

/// Keeps [`Orders`].
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct OrderBook {
    orders: Orders,
    is_starved: bool,
}

impl OrderBook {
    pub(super) const fn orders(&self) -> Orders {
        self.orders
    }

    /// Notes a command that was accepted.
    pub(super) const fn command(&mut self, is_zero: bool) {
        self.orders.commands += 1;
        self.orders.zeros_at_end = if is_zero {
            self.orders.zeros_at_end + 1
        } else {
            0
        };
    }

    /// Notes, each turn, whether the watchdog holds motors that were told to run.
    pub(super) fn starved(&mut self, is_starved: bool) {
        self.orders.watchdog_stops += u64::from(is_starved && !self.is_starved);
        self.is_starved = is_starved;
    }
}

/// The state of the machine, as its controller measures it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Machine {
    /// Encoder counts of the tracks, which wrap around.
    pub ticks: PerTrack<u32>,
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
