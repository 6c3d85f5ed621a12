//! The states of a managed node, and the transitions between them.
//!
//! As in ROS 2's design of managed nodes. Only in the state active the node pursues goals and publishes velocities; in the others
//! it takes its inputs, and localises the robot.

use crate::ros::msg::State;

/// A primary state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum LifecycleState {
    /// Before it is configured.
    Unconfigured,
    /// Configured, and not active.
    Inactive,
    /// It pursues goals.
    Active,
    /// It ends.
    Finalized,
}

/// A transition: its number, its name, and the states before and after it.
pub type Step = (u8, &'static str, LifecycleState, LifecycleState);

/// The transitions that a request can cause, as in `lifecycle_msgs/Transition`.
pub const TRANSITIONS: [Step; 7] = {
    use LifecycleState::{Active, Finalized, Inactive, Unconfigured};
    [
        (1, "configure", Unconfigured, Inactive),
        (2, "cleanup", Inactive, Unconfigured),
        (3, "activate", Inactive, Active),
        (4, "deactivate", Active, Inactive),
        (5, "shutdown", Unconfigured, Finalized),
        (6, "shutdown", Inactive, Finalized),
        (7, "shutdown", Active, Finalized),
    ]
};

impl LifecycleState {
    /// Its number in `lifecycle_msgs/State`.
    #[must_use]
    pub const fn id(self) -> u8 {
        match self {
            Self::Unconfigured => 1,
            Self::Inactive => 2,
            Self::Active => 3,
            Self::Finalized => 4,
        }
    }

    /// Its name.
    #[must_use]
    pub const fn label(self) -> &'static str {
        match self {
            Self::Unconfigured => "unconfigured",
            Self::Inactive => "inactive",
            Self::Active => "active",
            Self::Finalized => "finalized",
        }
    }

    /// The state with a number.
    #[must_use]
    pub fn from_id(id: u8) -> Option<Self> {
        let all = [Self::Unconfigured, Self::Inactive, Self::Active, Self::Finalized];
        all.into_iter().find(|state| state.id() == id)
    }

    /// The state after a transition, unless the transition does not begin here.
    #[must_use]
    pub fn after(self, transition: u8) -> Option<Self> {
        let step = TRANSITIONS.iter().find(|(id, _, from, _)| *id == transition && *from == self);
        step.map(|(_, _, _, to)| *to)
    }

    /// The state as a message.
    #[must_use]
    pub fn message(self) -> State {
        State { id: self.id(), label: self.label().to_owned() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transitions_begin_where_they_may() {
        use LifecycleState::{Active, Finalized, Inactive, Unconfigured};
        assert_eq!(Unconfigured.after(1), Some(Inactive));
        assert_eq!(Unconfigured.after(3), None);
        assert_eq!(Inactive.after(3), Some(Active));
        assert_eq!(Active.after(7), Some(Finalized));
        assert_eq!(Active.after(6), None);
        assert_eq!(LifecycleState::from_id(3), Some(Active));
        assert_eq!(LifecycleState::from_id(9), None);
        assert!(TRANSITIONS.iter().all(|(id, _, from, to)| from.after(*id) == Some(*to)));
    }
}
