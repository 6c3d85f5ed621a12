//! Protocol of `RoboClaw` motor controllers in packet serial mode: requests and replies with a CRC-16.
//!
//! A packet is an address (80h to 87h), a command, its data and a CRC-16 of all of them: polynomial 1021h, initial value
//! zero, the high byte first (CRC-16/XMODEM). Numbers are big-endian. A packet that only writes is answered by the byte
//! `FF`, one that reads by its data and a CRC over address, command and data. An invalid packet is not answered. A pause of 10 ms
//! inside a packet makes the controller discard it (`RoboClaw` Series User Manual, "Packet Serial").
//!
//! Any received byte resets its watchdog, command 14, including the bytes of queries. So the watchdog does not act on a host that
//! sends queries but no commands.

mod device;
mod frames;
mod session;
mod status;

#[doc(hidden)]
pub use device::RoboClawDevice;
#[doc(hidden)]
pub use frames::{Reply, Request};
#[doc(hidden)]
pub use session::RoboClawSession;

use serde::{Deserialize, Serialize};

use super::BaseError;
use super::settings::{above_zero, at_least_one, require};
use crate::documented::documented;

/// Pause inside a packet after which a controller discards it, seconds.
const PACKET_PAUSE_S: f64 = 0.01;

documented! {
    /// Protocol settings of a `RoboClaw`.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct RoboClawSettings {
        /// Address, 128 to 135 (80h to 87h). Default 128.
        pub address: u8,
        /// Speed of the serial line, baud, at least 1. Default 38,400, the controller's.
        pub baud: u32,
        /// Watchdog timeout to set in the controller, 0.1 to 25.5 s in steps of 0.1 s. Default 0.5 s.
        pub watchdog_s: f64,
        /// Length of the status that command 90 reads, 2 or 4 bytes. Default 4; firmware before about 2017 sends 2.
        pub status_bytes: usize,
        /// Time until an answer counts as lost, seconds, above 0.01: by then the controller has discarded a partial packet.
        /// Default 0.02 s: the vendor's library waits 0.01 s, but USB adapters delay bytes for up to 0.016 s.
        pub answer_timeout_s: f64,
        /// Attempts of each request, at least one. Default 3, as in the vendor's library.
        pub max_attempts: u32,
        /// Time between the starts of poll cycles, seconds, above zero. Default 0.05 s.
        pub poll_period_s: f64,
    }
}

impl Default for RoboClawSettings {
    fn default() -> Self {
        Self {
            address: 0x80,
            baud: 38_400,
            watchdog_s: 0.5,
            status_bytes: 4,
            answer_timeout_s: 0.02,
            max_attempts: 3,
            poll_period_s: 0.05,
        }
    }
}

impl RoboClawSettings {
    /// Checks every number.
    ///
    /// # Errors
    /// [`BaseError::BadSetting`] for the first number out of range.
    pub fn validate(&self) -> Result<(), BaseError> {
        require(
            (0x80..=0x87).contains(&self.address),
            "roboclaw.address",
            self.address.into(),
            "from 128 to 135",
        )?;
        at_least_one("roboclaw.baud", self.baud)?;
        require(
            (0.1..=25.5).contains(&self.watchdog_s),
            "roboclaw.watchdog_s",
            self.watchdog_s,
            "from 0.1 to 25.5",
        )?;
        require(
            matches!(self.status_bytes, 2 | 4),
            "roboclaw.status_bytes",
            self.status_bytes as f64,
            "2 or 4",
        )?;
        require(
            self.answer_timeout_s > PACKET_PAUSE_S && self.answer_timeout_s.is_finite(),
            "roboclaw.answer_timeout_s",
            self.answer_timeout_s,
            "finite and above 0.01",
        )?;
        at_least_one("roboclaw.max_attempts", self.max_attempts)?;
        above_zero("roboclaw.poll_period_s", self.poll_period_s)
    }

    /// The watchdog in the controller's unit of 0.1 s.
    fn watchdog_tenths(&self) -> u8 {
        (self.watchdog_s * 10.0).round() as u8
    }
}
