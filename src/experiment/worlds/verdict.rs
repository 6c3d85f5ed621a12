//! How a run ended.

use serde::{Deserialize, Serialize};

use crate::runtime::MissionResult;

/// How a run ended, in the challenge's words and one more.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The true pose came within 1 m of the goal.
    Succeeded,
    /// The robot touched something.
    Collided,
    /// The time was up.
    Timeout,
    /// The navigator gave up, with a reason.
    Failed,
}

impl Verdict {
    /// Of a mission that was driven.
    #[must_use]
    pub const fn of(result: &MissionResult) -> Self {
        // Contact comes first: a robot that touches something within the goal's radius did not get there.
        if result.collided {
            Self::Collided
        } else if result.reached {
            Self::Succeeded
        } else if result.fault.is_some() {
            Self::Failed
        } else {
            Self::Timeout
        }
    }
}
