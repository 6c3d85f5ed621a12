//! What the supervisor sends to the base, and why.

use crate::base::{BaseError, ProtectiveAction, StopCause};
use crate::geometry::Twist;

/// What goes to the base.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum OutgoingCommand {
    /// A motion, ramped and within the tracks' limits.
    Drive(Twist),
    /// The latched stop.
    EngageStop,
    /// The end of the latched stop. The session of a base that can lose a command repeats it.
    ReleaseStop,
}

/// What the base is commanded to do, and why.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum DriveStatus {
    /// Stands: no target was set.
    #[default]
    NoTarget,
    /// Follows the target.
    Driving,
    /// Brakes and stands: the target has expired.
    TargetExpired {
        /// Age of the target, seconds.
        age_s: f64,
    },
    /// Stands after a gap until there is a target that is newer than the end of the gap.
    Restarting,
    /// Brakes and stands: the base's last report is too old.
    ReportsLate {
        /// Age of the report, seconds.
        age_s: f64,
    },
    /// Stands or is slower than its target: the protective layer acts.
    Protected(ProtectiveAction),
    /// Stands: the base has not reported since the connection was opened.
    AwaitingFeedback,
    /// Gets no command: there is no connection.
    Disconnected(BaseError),
    /// Stands until the latched stop is released.
    Stopped(StopCause),
}
