//! Why the supervisor rejects a target or a release.

use thiserror::Error;

/// Why a target or a release was rejected.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum CommandRejected {
    /// A motion or a time stamp that is NaN or infinite.
    #[error("the target is not finite")]
    NotFinite,
    /// The time stamp is older than that of the previous target.
    #[error("the target is {by_s:.3} s older than the previous one")]
    OutOfOrder {
        /// Difference of the time stamps, seconds.
        by_s: f64,
    },
    /// The time stamp is farther ahead than a target lasts: such a target would never expire.
    #[error("the target is {ahead_s:.3} s ahead of the clock")]
    TooFarAhead {
        /// Time stamp minus now, seconds.
        ahead_s: f64,
    },
    /// A stop is latched.
    #[error("a stop is latched: release it first")]
    Stopped,
    /// The base still moves.
    #[error("the base still moves: a stop is released at a standstill")]
    StillMoving,
}
