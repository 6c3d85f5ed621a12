//! The machine's wire: what every base, real or simulated, owes the caller, and the bytes that a real one speaks.
//!
//! Each protocol is a folder with its frames, a [`Session`] for the host's side and a [`Peer`] for the base's, all
//! without I/O. Only [`SerialBase`] opens a port.
//!
//! Do not rely on the base to stop by itself when commands cease: some published firmware has that disabled. The
//! caller sends at a fixed rate, and [`Twist::STOP`] when in doubt: [`Keeper`] does so.

pub mod arduino;
mod config;
mod emulator;
mod error;
mod exchange;
mod faults;
pub mod keeper;
pub mod ld19;
pub mod native;
mod peer;
mod plausibility;
mod protocol;
pub mod roboclaw;
#[cfg(feature = "serial")]
mod serial;
mod session;
mod settings;
mod tick_meter;
mod verdict;
pub mod wheeltec;

pub use config::BaseConfig;
pub use emulator::{Emulator, PlannedTrouble, Trouble};
pub use error::BaseError;
pub use faults::Faults;
pub use keeper::{
    Condition, Guard, Keeper, KeeperCounters, KeeperSettings, Odometer, Open, Order, Refusal,
    Status, StopReason,
};
pub use peer::{Machine, Orders, Peer};
pub use plausibility::{Observation, Plausibility, PlausibilitySettings};
pub use protocol::Protocol;
#[cfg(feature = "serial")]
pub use serial::{SerialBase, SerialSettings, open_lidar};
pub use session::{Counters, Heard, Session};
pub use settings::BaseSettings;
pub use verdict::Verdict;

use crate::geometry::Twist;
use crate::robot::PerTrack;

/// What a base reports of itself.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Feedback {
    /// How fast the base measures itself to move, in its own frame.
    pub twist: Twist,
    /// Whether the motors are disabled: an emergency stop, or a fault that the base acts on itself.
    pub emergency_stop: bool,
    /// Battery voltage, for a base that measures it.
    pub battery_v: Option<f64>,
    /// Encoder counts of the tracks, forward positive, for a base that reports them: they wrap around at 2^32.
    pub ticks: Option<PerTrack<u32>>,
    /// Turn rate by a gyro, rad/s, for a base that has one.
    pub yaw_rate: Option<f64>,
    /// What is wrong with the base, as it or its driver found.
    pub faults: Faults,
    /// Age of the oldest command that the base had not taken when it reported, seconds, for a base that says which it has.
    pub behind_s: Option<f64>,
}

/// A base that takes velocity commands and reports its motion.
///
/// Neither method blocks longer than the implementation states. A command lasts until the next one; whether a base
/// stops by itself when commands cease is its own affair, and not to be relied on.
pub trait Base {
    /// Hands a command to the base. What the base cannot do it brings to the nearest it can.
    ///
    /// # Errors
    /// [`BaseError::NotFinite`] for a rate that is NaN or infinite: nothing is sent then. Others where the base
    /// cannot be reached; part of the command may then have arrived, and never a different command.
    fn send(&mut self, command: &Twist) -> Result<(), BaseError>;

    /// The newest report of the base; the same one again while no newer has come and it is not yet out of date.
    ///
    /// # Errors
    /// Where the base cannot be reached or has been silent for too long.
    fn feedback(&mut self) -> Result<Feedback, BaseError>;

    /// Stops the base for good: until [`Base::release`] where it can latch a stop, else by a command of zero, and then it is
    /// the caller who must keep to it. Returns as [`Base::send`] does.
    ///
    /// # Errors
    /// Where the base cannot be reached.
    fn engage_stop(&mut self) -> Result<(), BaseError> {
        self.send(&Twist::STOP)
    }

    /// Ends a stop that is latched, as an operator's explicit wish; the base is told to stand. Returns as [`Base::send`] does.
    ///
    /// # Errors
    /// Where the base cannot be reached.
    fn release(&mut self) -> Result<(), BaseError> {
        self.send(&Twist::STOP)
    }
}

/// The command itself, or the error that every base answers a command with that is not finite.
pub(crate) fn finite(command: &Twist) -> Result<&Twist, BaseError> {
    if command.is_finite() {
        Ok(command)
    } else {
        Err(BaseError::NotFinite {
            linear: command.linear,
            angular: command.angular,
        })
    }
}
