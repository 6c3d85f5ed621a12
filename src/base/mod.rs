//! Drivers of real bases: wire protocols, the serial port, and the supervisor that keeps a base safe.
//!
//! Each protocol has its frames, a [`Session`] (the host's side) and a [`DeviceProtocol`] (the base's side), all without I/O.
//! Only [`SerialBase`] opens a port. [`BaseSupervisor`] sends commands at a fixed rate and stops the base in doubt.
//!
//! Do not rely on a base to stop by itself when commands cease: some published firmware has its watchdog disabled.

pub mod arduino;
mod emulator;
mod encoder_speed;
mod error;
mod fault_detector;
mod faults;
mod frame_decoder;
pub mod ld19;
pub mod native;
#[cfg(feature = "serial")]
mod port_identity;
pub mod protective_layer;
mod protocol;
mod request;
pub mod roboclaw;
#[cfg(feature = "serial")]
mod serial;
mod settings;
mod stop_cause;
pub mod supervisor;
mod tilt;
pub mod wheeltec;

pub(crate) use emulator::standard_normal;
pub use emulator::{Emulator, InjectedFault, LidarFaultInjector, ScheduledFault};
pub use error::BaseError;
pub use fault_detector::FaultDetectorSettings;
#[doc(hidden)]
pub use fault_detector::{BaseSample, FaultDetector};
pub use faults::Faults;
#[cfg(feature = "serial")]
pub use port_identity::SamePort;
pub use protective_layer::{
    CollisionMonitorSettings, OperatorState, OperatorSwitch, ProtectiveAction, ProtectiveLayer,
};
pub use protocol::{
    CommandStats, DeviceProtocol, MachineState, Protocol, Session, SessionCore, SessionCounters,
    TimedFeedback,
};
#[cfg(feature = "serial")]
pub use serial::{SerialBase, SerialSettings, open_lidar_port};
pub use settings::{BaseConfig, BaseSettings};
pub use stop_cause::StopCause;
pub use supervisor::{
    BaseSupervisor, CommandRejected, DriveStatus, OpenBase, OutgoingCommand, SafetyController,
    ScanSource, SupervisorCounters, SupervisorSettings, SupervisorStatus,
};

use crate::geometry::Twist;
use crate::robot::PerTrack;

/// A base's report of its state.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Feedback {
    /// Measured velocity in the base's frame.
    pub twist: Twist,
    /// Whether the motors are disabled by an emergency stop, or by a fault that the base acts on itself.
    pub emergency_stop: bool,
    /// Battery voltage, if the base measures it.
    pub battery_v: Option<f64>,
    /// Encoder counts of the tracks, forward positive, modulo 2^32, if the base reports them.
    pub encoder_counts: Option<PerTrack<u32>>,
    /// Turn rate by a gyro, rad/s, if the base has one.
    pub yaw_rate: Option<f64>,
    /// Faults found by the base or by its driver.
    pub faults: Faults,
    /// Age of the oldest command that the base had not accepted when it reported, seconds, if the protocol acknowledges commands.
    pub command_delay_s: Option<f64>,
    /// Time since the report arrived, seconds; zero if the driver does not know it.
    pub age_s: f64,
    /// Whether a report that may be damaged shows disabled motors. The next report confirms or refutes it.
    pub is_stop_suspected: bool,
    /// Tilt against the horizontal, if the base measures it.
    pub tilt: Option<Tilt>,
    /// Bumpers that are pressed; none for a base without bumpers.
    pub bumper: Bumper,
    /// Whether a cliff sensor sees no ground; false for a base without cliff sensors.
    pub cliff: bool,
}

/// Tilt of a base against the horizontal, with the signs of REP-103.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tilt {
    /// Rotation about the forward axis, rad: positive with the left side up.
    pub roll: f64,
    /// Rotation about the axis to the left, rad: positive with the front down.
    pub pitch: f64,
}

/// The two halves of a bumper.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Bumper {
    /// Whether the left half is pressed.
    pub left: bool,
    /// Whether the right half is pressed.
    pub right: bool,
}

impl Bumper {
    /// Whether any half is pressed.
    #[must_use]
    pub const fn is_pressed(self) -> bool {
        self.left || self.right
    }
}

/// A base that takes velocity commands and reports its motion.
///
/// No method blocks longer than the implementation states. A command holds until the next one; the caller must not rely on the
/// base to stop by itself when commands cease.
pub trait Base {
    /// Sends a velocity command. A command beyond the base's limits is reduced to the nearest feasible one.
    ///
    /// # Errors
    /// [`BaseError::NotFinite`] for a rate that is NaN or infinite: nothing is sent then. Other errors if the base cannot be
    /// reached; part of the command may then have arrived, and never a different command.
    fn send(&mut self, command: &Twist) -> Result<(), BaseError>;

    /// Returns the latest report; the same one again until a newer one arrives or it is out of date.
    ///
    /// # Errors
    /// The base cannot be reached or has been silent for too long.
    fn feedback(&mut self) -> Result<Feedback, BaseError>;

    /// Stops the base until [`Base::release`], if the base can latch a stop; otherwise sends a zero command, and the caller must
    /// keep sending zero commands. Blocks like [`Base::send`].
    ///
    /// # Errors
    /// The base cannot be reached.
    fn engage_stop(&mut self) -> Result<(), BaseError> {
        self.send(&Twist::STOP)
    }

    /// Ends a latched stop, as an operator's explicit decision, and commands zero velocity. Blocks like [`Base::send`].
    ///
    /// # Errors
    /// The base cannot be reached.
    fn release(&mut self) -> Result<(), BaseError> {
        self.send(&Twist::STOP)
    }
}

/// Rejects a command that is not finite.
pub(crate) fn require_finite(command: &Twist) -> Result<&Twist, BaseError> {
    if command.is_finite() {
        Ok(command)
    } else {
        Err(BaseError::NotFinite { linear: command.linear, angular: command.angular })
    }
}
