//! What the navigator is doing at a tick.

use serde::Serialize;

/// The state of a mission, one for each tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Mode {
    /// Following the path with the command the local planner chose.
    Driving,
    /// Turning in place towards the path.
    Turning,
    /// Stopped: no sample was admissible.
    Blocked,
    /// Backing away from where nothing was admissible.
    BackingUp,
    /// At the goal.
    Arrived,
    /// Given up, with a reason.
    Failed,
    /// Within reach of a stop, on the last decimetres to it.
    Parking,
    /// Standing at a stop that is not the last.
    Stopped,
    /// Getting out of somebody's way.
    Evading,
    /// Stopped: what it senses cannot be believed.
    Doubting,
}

impl Mode {
    /// Its word in JSON and diagnostics.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Driving => "driving",
            Self::Turning => "turning",
            Self::Blocked => "blocked",
            Self::BackingUp => "backing_up",
            Self::Arrived => "arrived",
            Self::Failed => "failed",
            Self::Parking => "parking",
            Self::Stopped => "stopped",
            Self::Evading => "evading",
            Self::Doubting => "doubting",
        }
    }
}
