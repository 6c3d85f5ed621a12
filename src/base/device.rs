//! The base's side of a protocol, without I/O: what a lower controller decodes and answers, for emulators.

use serde::Serialize;

use super::Faults;
use crate::robot::{PerTrack, TrackSpeeds};

/// The communication part of a lower controller's firmware. The caller simulates motors, encoders and faults.
///
/// It knows the machine by settings of its own, which may differ from the host's, as firmware does.
pub trait DeviceProtocol: Send {
    /// Takes received bytes, in pieces of any size.
    fn receive(&mut self, bytes: &[u8], now_s: f64);

    /// Runs one cycle of the firmware's loop: appends the bytes to write to `line` and returns the set speeds of the tracks,
    /// m/s: zero while the watchdog or an emergency stop acts. Time never runs backwards.
    fn step(&mut self, now_s: f64, machine: &MachineState, line: &mut Vec<u8>) -> TrackSpeeds;

    /// Statistics of the commands received so far.
    fn command_stats(&self) -> CommandStats;
}

/// Commands received by a controller since power-on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct CommandStats {
    /// Accepted motor commands.
    pub commands: u64,
    /// Number of consecutive zero commands at the end.
    pub final_zero_commands: u64,
    /// How often the watchdog stopped running motors because commands ceased.
    pub watchdog_stops: u64,
}

/// Collects [`CommandStats`].
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct CommandCounter {
    stats: CommandStats,
    is_watchdog_active: bool,
}

impl CommandCounter {
    pub(super) const fn stats(&self) -> CommandStats {
        self.stats
    }

    /// Counts an accepted command.
    pub(super) const fn command(&mut self, is_zero: bool) {
        self.stats.commands += 1;
        self.stats.final_zero_commands =
            if is_zero { self.stats.final_zero_commands + 1 } else { 0 };
    }

    /// Counts the watchdog's stops; call it in every cycle with whether the watchdog holds motors that were commanded to run.
    pub(super) fn watchdog(&mut self, is_active: bool) {
        self.stats.watchdog_stops += u64::from(is_active && !self.is_watchdog_active);
        self.is_watchdog_active = is_active;
    }
}

/// State of the machine as its controller measures it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MachineState {
    /// Encoder counts of the tracks, modulo 2^32.
    pub encoder_counts: PerTrack<u32>,
    /// Measured speeds of the tracks, m/s.
    pub speeds: TrackSpeeds,
    /// Turn rate by the gyro, rad/s.
    pub yaw_rate: f64,
    /// Battery voltage.
    pub battery_v: f64,
    /// Faults found by the controller.
    pub faults: Faults,
    /// Whether the emergency button is pressed.
    pub button_pressed: bool,
}
