//! Protocol of `RoboClaw` motor controllers in packet serial mode: requests and replies with a CRC-16.
//!
//! A packet is an address (80h to 87h), a command, its data and a CRC-16 of all of them: polynomial 1021h, initial value
//! zero, the high byte first (CRC-16/XMODEM). Numbers are big-endian. A packet that only writes is answered by the byte
//! `FF`, one that reads by its data and a CRC over address, command and data. An invalid packet is not answered. A pause of 10 ms
//! inside a packet makes the controller discard it (`RoboClaw` Series User Manual, "Packet Serial").
//!
//! Any received byte resets its watchdog, command 14, including the bytes of queries. So the watchdog does not act on a host that
//! sends queries but no commands.

mod frames;
mod session;

#[doc(hidden)]
pub use frames::Request;
#[doc(hidden)]
pub use session::{RoboClawDevice, RoboClawSession};

use serde::{Deserialize, Serialize};

use crate::settings::{require, settings};

/// Pause inside a packet after which a controller discards it, seconds.
const PACKET_PAUSE_S: f64 = 0.01;

settings! {
    /// Protocol settings of a `RoboClaw`.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct RoboClawSettings {
        /// Address, 80h to 87h. Default 128.
        pub address: u8 = 0x80, ["", 128 to 135];
        /// Speed of the serial line. Default 38,400, the controller's.
        pub baud: u32 = 38_400, ["baud", at_least 1];
        /// Watchdog timeout to set in the controller, in steps of 0.1 s. Default 0.5 s.
        pub watchdog_s: f64 = 0.5, ["s", 0.1 to 25.5];
        /// Length of the status that command 90 reads, 2 or 4 bytes. Default 4; firmware before about 2017 sends 2.
        pub status_bytes: usize = 4, ["bytes", 2 to 4];
        /// Time until an answer counts as lost: by then the controller has discarded a partial packet. Default 0.02
        /// s: the vendor's library waits 0.01 s, but USB adapters delay bytes for up to 0.016 s.
        pub answer_timeout_s: f64 = 0.02, ["s", above 0.01];
        /// Attempts of each request. Default 3, as in the vendor's library.
        pub max_attempts: u32 = 3, ["", at_least 1];
        /// Time between the starts of poll cycles. Default 0.05 s.
        pub poll_period_s: f64 = 0.05, ["s", above 0];
    }
    rule |settings| {
        require(settings.status_bytes != 3, "status_bytes", settings.status_bytes as f64, "2 or 4")
    }
}

impl RoboClawSettings {
    /// The watchdog in the controller's unit of 0.1 s.
    fn watchdog_tenths(&self) -> u8 {
        (self.watchdog_s * 10.0).round() as u8
    }
}
