//! `ROSArduinoBridge`: lines of text, and no check of any kind.
//!
//! A command is a letter, its arguments after spaces, and a carriage return; each is answered by one line that ends with
//! carriage return and line feed. `m L R` sets the speeds of both motors in encoder ticks per turn of the firmware's
//! speed control, which is answered by `OK`; `e` reads both encoders. The turn takes 1000 / 30 milliseconds in integers,
//! so 33 ms and not a thirtieth of a second. The firmware stops 2 s after the last `m`.
//!
//! What has no check must be guarded otherwise. An answer counts only when it is exactly `OK` or exactly two integers, and
//! counters that ran farther than a track can are refused. A lost carriage return would make one command of two, whose
//! arguments the firmware joins to a wild speed: so the next command waits for the answer to the last, and after an answer
//! that did not come a carriage return goes first, which ends what the firmware may hold.
//!
//! The firmware gives its first argument to the left motor, its own driver in Python writes the right one first. Which
//! holds on a robot is seen by a turn on the spot, of `swap_tracks` in the settings: with encoders alone nothing shows,
//! since they are swapped as well; with a gyro the turn rates differ in sign.

mod lines;
mod peer;
mod session;

pub use lines::{Answer, read_answer};
pub use peer::ArduinoPeer;
pub use session::ArduinoSession;

use serde::{Deserialize, Serialize};

use super::BaseError;
use super::settings::{above_zero, require};
use crate::documented::documented;

/// Time after the last command for the motors at which the firmware stops, seconds.
pub const WATCHDOG_S: f64 = 2.0;

documented! {
    /// The manners of a `ROSArduinoBridge`.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct ArduinoSettings {
        /// Speed of the line, baud, above zero. Default 57,600, as the firmware's.
        pub baud: u32,
        /// Time of one turn of the firmware's speed control, seconds, above zero. Default 0.033 s.
        pub pid_interval_s: f64,
        /// Time until an answer counts as lost, seconds, above zero. Default 0.05 s: its loop may move servos between two
        /// looks at the line, and USB adapters hold bytes back for up to 0.016 s.
        pub answer_within_s: f64,
        /// Tries of each question, at least one. Default 3.
        pub tries: u32,
        /// Time from one reading of the encoders to the next, seconds, above zero. Default 0.033 s, a turn of the firmware.
        pub poll_every_s: f64,
    }
}

impl Default for ArduinoSettings {
    fn default() -> Self {
        Self {
            baud: 57_600,
            pid_interval_s: 0.033,
            answer_within_s: 0.05,
            tries: 3,
            poll_every_s: 0.033,
        }
    }
}

impl ArduinoSettings {
    /// Checks every number.
    ///
    /// # Errors
    /// [`BaseError::BadSetting`] names the first that is out of range.
    pub fn validate(&self) -> Result<(), BaseError> {
        require(
            self.baud > 0,
            "arduino.baud",
            self.baud.into(),
            "above zero",
        )?;
        above_zero("arduino.pid_interval_s", self.pid_interval_s)?;
        above_zero("arduino.answer_within_s", self.answer_within_s)?;
        require(
            self.tries > 0,
            "arduino.tries",
            self.tries.into(),
            "at least 1",
        )?;
        above_zero("arduino.poll_every_s", self.poll_every_s)
    }
}
