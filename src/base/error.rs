//! Why a base cannot be commanded or heard.

use thiserror::Error;

use crate::robot::RobotError;

/// What went wrong on the way to or from a base.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum BaseError {
    /// Limits that no robot can have.
    #[error(transparent)]
    Robot(#[from] RobotError),
    /// A setting out of range.
    #[error("{name} is {value}: it must be {expected}")]
    BadSetting {
        /// Name as in the configuration.
        name: &'static str,
        /// As given.
        value: f64,
        /// What would be accepted.
        expected: &'static str,
    },
    /// A table of a configuration that no base can have.
    #[error("[{table}] {reason}")]
    BadConfig {
        /// Name of the table.
        table: &'static str,
        /// What is wrong in it.
        reason: String,
    },
    /// A command that no base can follow. Nothing was sent.
    #[error(
        "the command is linear {linear} m/s, angular {angular} rad/s: both must be finite; nothing was sent"
    )]
    NotFinite {
        /// As given, m/s.
        linear: f64,
        /// As given, rad/s.
        angular: f64,
    },
    /// A port that could not be opened.
    #[error(
        "{port}: cannot be opened ({reason}): check the name, the cable and your right to use it"
    )]
    CannotOpen {
        /// Name of the port.
        port: String,
        /// In the system's words.
        reason: String,
    },
    /// The other end is gone: a cable pulled out, a converter unplugged, a peer closed. Open the port anew.
    #[error("{port}: the other end is gone: plug it in and open the port again")]
    Unplugged {
        /// Name of the port.
        port: String,
    },
    /// The other end did not do its part in time.
    #[error("{port}: timed out after {bound_ms} ms {waiting_for}: is the base switched on?")]
    TimedOut {
        /// Name of the port.
        port: String,
        /// What was waited for.
        waiting_for: &'static str,
        /// How long, milliseconds.
        bound_ms: u128,
    },
    /// No complete feedback frame since the port was opened, and not yet too late for one. Ask again.
    #[error("{port}: no complete feedback frame has come yet: ask again at the next tick")]
    NoFeedbackYet {
        /// Name of the port.
        port: String,
    },
    /// The system refused to read or write.
    #[error("{port}: {reason}: close the port and open it again")]
    Port {
        /// Name of the port.
        port: String,
        /// In the system's words.
        reason: String,
    },
}
