//! Sends velocity commands to a base at a fixed rate, independent of the planner's timing.
//!
//! [`SafetyController`] decides what to send and takes time as a parameter. [`BaseSupervisor`] runs it on a thread that owns the
//! connection. They guarantee:
//!
//! - The base receives a command at a fixed rate. A target is valid for 0.3 s from its time stamp; after that the base is braked
//!   to a standstill. The age of the target decides, not the liveness of the planner's thread.
//! - The ramp uses the measured time between commands: a late one brakes for all of it, and accelerates for one period at most.
//! - After a gap, zero commands go first: for at least 0.1 s, and until a target has a time stamp after the end of the gap.
//!   The motion then ramps up from the measured speed. A gap is a pause of more than 0.2 s of the sender or its process, the
//!   base's reports, or the connection. A stop by the base's own watchdog, a latched stop, and a time without the operator's
//!   permission are gaps too.
//! - A target that is not finite, older than the previous one or too far ahead is rejected and counted.
//! - With [`BaseSupervisor::protect`], raw scans limit every target ([`ProtectiveLayer`](super::ProtectiveLayer)): nothing moves
//!   before it is armed, and the operator's stop is zero with the next command, with or without a valid target.
//! - A requested stop, and a stop by the fault detector, is latched: targets are rejected until an explicit
//!   [`BaseSupervisor::release`] while the base stands still.
//! - A failed connection is closed with three or more zero commands and reopened after a pause that doubles with each failure.
//!   On a new connection zero commands go first, until the base has reported.
//! - The supervisor ends with zero commands until the reports show a standstill: when it is dropped, hence also when the owner's
//!   thread panics, and when the shutdown flag is set, as a handler of Ctrl-C and SIGTERM does. A base that has not stopped one second
//!   after its braking time ignores its commands: [`BaseSupervisor::end`] returns that cause. When the supervisor's own thread panics,
//!   three or more zero commands are sent.
//!
//! A process that is killed or suspended (SIGKILL, SIGSTOP, a crash, loss of power) sends nothing more, and a cut cable carries
//! nothing. The base's own watchdog must then act: after 0.5 s with native frames and, as the session configures it, with a
//! `RoboClaw`; after 2 s with a `ROSArduinoBridge`. WHEELTEC's published firmware has no watchdog and keeps driving.

mod command_rejected;
mod connection;
mod drive_status;
mod odometer;
mod safety;
mod standstill;
mod thread;

pub use command_rejected::CommandRejected;
pub(super) use connection::Backoff;
pub use connection::OpenBase;
pub use drive_status::{DriveStatus, OutgoingCommand};
pub use safety::SafetyController;
pub use thread::{BaseSupervisor, ScanSource, SupervisorCounters, SupervisorStatus};

use serde::{Deserialize, Serialize};

use super::FaultDetectorSettings;
use crate::settings::{require, settings};

settings! {
    /// Command rate, target timeout, reconnection and fault detection.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct SupervisorSettings {
        /// Commands per second. Default 50. A late command brakes for the whole time since the one before it, and accelerates for one
        /// period at most. At least 10: a target lasts three periods.
        pub rate_hz: f64 = 50.0, ["Hz", 10 to 1000];
        /// Age at which a target expires. Default 0.3 s: three periods of the planner. The ROS differential drive
        /// controller allows 0.5 s, and cannot tell that a hung planner repeats an old target.
        pub target_timeout_s: f64 = 0.3, ["s", above 0 to 5];
        /// Longest time between two cycles of the sender, or between two reports of the base. Default 0.2 s: four reports of
        /// the slowest controller, and less than any base's watchdog. After a longer gap the base stands, and moves again
        /// from its measured speed, for a target that is newer than the gap.
        pub max_gap_s: f64 = 0.2, ["s", above 0 to 5];
        /// Pause after the first failure of the connection. Default 0.1 s.
        pub reconnect_min_s: f64 = 0.1, ["s", above 0 to 3600];
        /// Longest pause between attempts to reconnect, at least `reconnect_min_s`. Default 5 s.
        pub reconnect_max_s: f64 = 5.0, ["s", above 0 to 3600];
        /// Thresholds of the fault detector.
        pub fault_detector: FaultDetectorSettings = FaultDetectorSettings::default();
    }
    rule |settings| require(
        settings.reconnect_max_s >= settings.reconnect_min_s,
        "reconnect_max_s",
        settings.reconnect_max_s,
        "finite and at least reconnect_min_s",
    )
}

impl SupervisorSettings {
    /// Time between commands, seconds.
    #[must_use]
    pub fn period_s(&self) -> f64 {
        self.rate_hz.recip()
    }
}
