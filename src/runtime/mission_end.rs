//! How a mission ended.

/// How a mission ended, with a navigator or without one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MissionEnd {
    /// The robot reached its goal.
    Reached,
    /// The robot and something touched.
    Contact,
    /// The time was up, the mission was interrupted, or the robot stopped for good.
    Timeout,
    /// The navigator gave up.
    Failed,
}

impl MissionEnd {
    /// Contact comes first: a robot that touches something at its goal has not reached it.
    pub(super) const fn new(collided: bool, reached: bool, has_failed: bool) -> Self {
        match (collided, reached, has_failed) {
            (true, _, _) => Self::Contact,
            (false, true, _) => Self::Reached,
            (false, false, true) => Self::Failed,
            (false, false, false) => Self::Timeout,
        }
    }
}
