//! Protocol of `ROSArduinoBridge`: lines of text without a checksum.
//!
//! A command is a letter, its arguments after spaces, and a carriage return. Each is answered by one line that ends with
//! carriage return and line feed. `m L R` sets the speeds of both motors in encoder ticks per cycle of the firmware's speed
//! control and is answered by `OK`; `e` reads both encoders. The cycle takes 1000 / 30 milliseconds in integers: 33 ms. The
//! firmware stops 2 s after the last `m`.
//!
//! Without a checksum the session validates otherwise. An answer is valid only if it is exactly `OK` or exactly two integers, and
//! counts that ran farther than a track can are rejected. A lost carriage return would join two commands, and the firmware joins
//! their arguments to a wild speed. So each command waits for the answer to the previous one; after a missing answer a carriage
//! return goes first and ends any partial line.
//!
//! The firmware applies its first argument to the left motor, but its own Python driver sends the right one first. Turn on the spot
//! to find the order on your robot, and set `swap_tracks`: encoders alone show nothing, as they are swapped too; with a gyro the
//! turn rates differ in sign.

mod device;
mod lines;
mod session;

#[doc(hidden)]
pub use device::ArduinoDevice;
#[doc(hidden)]
pub use lines::{Answer, parse_answer};
#[doc(hidden)]
pub use session::ArduinoSession;

use serde::{Deserialize, Serialize};

use crate::settings::settings;

/// Time after the last motor command at which the firmware stops, seconds.
pub const WATCHDOG_S: f64 = 2.0;

settings! {
    /// Protocol settings of a `ROSArduinoBridge`.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct ArduinoSettings {
        /// Speed of the serial line. Default 57,600, the firmware's.
        pub baud: u32 = 57_600, ["baud", at_least 1];
        /// Cycle time of the firmware's speed control. Default 0.033 s.
        pub pid_interval_s: f64 = 0.033, ["s", above 0];
        /// Time until an answer counts as lost. Default 0.05 s: the firmware may move servos between two reads, and
        /// USB adapters delay bytes for up to 0.016 s.
        pub answer_timeout_s: f64 = 0.05, ["s", above 0];
        /// Attempts of each request. Default 3.
        pub max_attempts: u32 = 3, ["", at_least 1];
        /// Time between encoder readings. Default 0.033 s, one cycle of the firmware.
        pub poll_period_s: f64 = 0.033, ["s", above 0];
    }
}
