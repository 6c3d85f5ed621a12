//! Errors of bases and lidars.

use std::io::ErrorKind;

use thiserror::Error;

use crate::settings::SettingError;

/// Why a base or a lidar cannot be used.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum BaseError {
    /// A setting is out of range.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// A command that is NaN or infinite. Nothing was sent.
    #[error(
        "the command is linear {linear} m/s, angular {angular} rad/s: both must be finite; nothing was sent"
    )]
    NotFinite {
        /// The given speed, m/s.
        linear: f64,
        /// The given turn rate, rad/s.
        angular: f64,
    },
    /// A port that could not be opened.
    #[error(
        "{port}: cannot be opened ({reason}): check the name, the cable and your permission to use it"
    )]
    CannotOpen {
        /// Name of the port.
        port: String,
        /// Message of the operating system.
        reason: String,
    },
    /// A port that another program has opened.
    #[error("{port}: another program uses this port: end it, or give another port")]
    InUse {
        /// Name of the port.
        port: String,
    },
    /// The name of a port leads to another device than the one that was opened first. Nothing was sent to it. The port is opened again
    /// once the name leads to the first device.
    #[error(
        "{port}: another device has this name: it was {was}, it is {now}: connect the first one again; to use the other one, start again"
    )]
    OtherDevice {
        /// Name of the port.
        port: String,
        /// The device that was opened first.
        was: String,
        /// The device of that name now.
        now: String,
    },
    /// The device is gone: its cable or adapter was unplugged, or the other end closed. Open the port again.
    #[error("{port}: the device is disconnected: plug it in and open the port again")]
    Disconnected {
        /// Name of the port.
        port: String,
    },
    /// The base did not respond in time.
    #[error("{port}: timed out after {timeout_ms} ms {waiting_for}: is the base switched on?")]
    TimedOut {
        /// Name of the port.
        port: String,
        /// The operation that timed out.
        waiting_for: &'static str,
        /// The limit, milliseconds.
        timeout_ms: u128,
    },
    /// No complete feedback frame since the port was opened, and the timeout has not passed. Ask again.
    #[error("{port}: no complete feedback frame has arrived yet: ask again at the next tick")]
    NoFeedbackYet {
        /// Name of the port.
        port: String,
    },
    /// The operating system failed to read or write.
    #[error("{port}: {reason}: close the port and open it again")]
    Port {
        /// Name of the port.
        port: String,
        /// Message of the operating system.
        reason: String,
    },
}

/// Whether a read ended because no bytes came.
pub(super) const fn is_timeout(kind: ErrorKind) -> bool {
    matches!(kind, ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted)
}
