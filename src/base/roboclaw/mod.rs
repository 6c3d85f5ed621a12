//! `RoboClaw` motor controllers by packet serial: questions and answers, with a check of 16 bits.
//!
//! A packet is an address (80h to 87h), a command, its data and a CRC-16 of all of them: polynomial 1021h, initial value
//! zero, the high byte first (CRC-16/XMODEM). Numbers are big-endian. A packet that only writes is answered by the byte
//! `FF`, one that reads by its data and a CRC over address, command and these data; a packet that is wrong in any way not
//! at all. A pause of 10 ms inside a packet makes the controller forget it (`RoboClaw` Series User Manual, "Packet Serial").
//!
//! Its watchdog, command 14, counts any byte as a sign of life, questions too. So it does not notice a caller that
//! only asks and commands no more.

mod frames;
mod peer;
mod session;
mod status;

pub use frames::{Reply, Request};
pub use peer::RoboClawPeer;
pub use session::RoboClawSession;

use serde::{Deserialize, Serialize};

use super::BaseError;
use super::settings::{above_zero, require};
use crate::documented::documented;

/// A pause inside a packet after which a controller forgets its beginning, seconds.
const PACKET_PAUSE_S: f64 = 0.01;

documented! {
    /// The manners of a `RoboClaw`.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct RoboClawSettings {
        /// Address, 128 to 135 (80h to 87h). Default 128.
        pub address: u8,
        /// Speed of the line, baud, above zero. Default 38,400, as the controller's.
        pub baud: u32,
        /// The watchdog to set in the controller, seconds in steps of 0.1, 0.1 to 25.5. Default 0.5 s.
        pub watchdog_s: f64,
        /// Bytes of the status that command 90 reads, 2 or 4. Default 4; firmware before 2017 or so sends 2.
        pub status_bytes: usize,
        /// Time until an answer counts as lost, seconds, above 0.01: by then the controller has forgotten a cut packet.
        /// Default 0.02 s: the vendor's library waits 0.01 s, but USB adapters hold bytes back for up to 0.016 s.
        pub answer_within_s: f64,
        /// Tries of each question, at least one. Default 3, as the vendor's library.
        pub tries: u32,
        /// Time from the start of one round of questions to that of the next, seconds, above zero. Default 0.05 s.
        pub poll_every_s: f64,
    }
}

impl Default for RoboClawSettings {
    fn default() -> Self {
        Self {
            address: 0x80,
            baud: 38_400,
            watchdog_s: 0.5,
            status_bytes: 4,
            answer_within_s: 0.02,
            tries: 3,
            poll_every_s: 0.05,
        }
    }
}

impl RoboClawSettings {
    /// Checks every number.
    ///
    /// # Errors
    /// [`BaseError::BadSetting`] names the first that is out of range.
    pub fn validate(&self) -> Result<(), BaseError> {
        require(
            (0x80..=0x87).contains(&self.address),
            "roboclaw.address",
            self.address.into(),
            "from 128 to 135",
        )?;
        require(
            self.baud > 0,
            "roboclaw.baud",
            self.baud.into(),
            "above zero",
        )?;
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
            self.answer_within_s > PACKET_PAUSE_S && self.answer_within_s.is_finite(),
            "roboclaw.answer_within_s",
            self.answer_within_s,
            "finite and above 0.01",
        )?;
        require(
            self.tries > 0,
            "roboclaw.tries",
            self.tries.into(),
            "at least 1",
        )?;
        above_zero("roboclaw.poll_every_s", self.poll_every_s)
    }

    /// The watchdog in the controller's unit of 0.1 s.
    fn watchdog_tenths(&self) -> u8 {
        (self.watchdog_s * 10.0).round() as u8
    }
}
