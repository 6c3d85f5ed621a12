//! The behaviours of the robot, in the order of their priority.
//!
//! Each behaviour reads one [`State`], keeps its own memory and proposes a decision or nothing. [`Behaviours::decide`] lists
//! them.

mod escape;
mod evasion;
mod goal_handling;
mod path_following;
mod proposal;
mod rotate_in_place;

use super::state::State;
use super::{Decision, Fault, Mode};
use crate::local::LocalPlanner;
use escape::Escape;
use evasion::Evasion;
use goal_handling::GoalHandling;
use path_following::PathFollowing;
use proposal::{Behaviour, Override, Overriding, Proposal};
use rotate_in_place::RotateInPlace;

/// All behaviours with their memories.
pub(super) struct Behaviours {
    goal_handling: GoalHandling,
    escape: Escape,
    rotate_in_place: RotateInPlace,
    path_following: PathFollowing,
    evasion: Evasion,
}

impl Behaviours {
    pub fn new(planner: LocalPlanner) -> Self {
        Self {
            goal_handling: GoalHandling::default(),
            escape: Escape::default(),
            rotate_in_place: RotateInPlace::default(),
            path_following: PathFollowing::new(planner),
            evasion: Evasion,
        }
    }

    /// The decision in a state.
    ///
    /// # Errors
    /// When the mission must end.
    pub fn decide(&mut self, mut state: State<'_>) -> Result<Decision, Fault> {
        let by_priority: [&mut dyn Behaviour; 4] = [
            // 1. A robot at its goal has nothing else to do. The local planner cannot park it to the centimetre.
            &mut self.goal_handling,
            // 2. A robot that was held up for long leaves the place before it tries its path again.
            &mut self.escape,
            // 3. A robot that faces away from its target rotates before it drives: driving forwards it would circle around it.
            &mut self.rotate_in_place,
            // 4. Otherwise the robot follows its path with the dynamic window. This behaviour always proposes a decision.
            &mut self.path_following,
        ];
        let mut proposed = (state.stand(Mode::Blocked), Override::Never);
        for behaviour in by_priority {
            match behaviour.propose(&state)? {
                None => {}
                Some(Proposal::SpeedLimit(limit)) => {
                    state.speed_limit = state.speed_limit.min(limit);
                }
                Some(Proposal::Decide(decision, allowed)) => {
                    proposed = (decision, allowed);
                    break;
                }
            }
        }
        let (mut decision, allowed) = proposed;
        let overriding: [&mut dyn Overriding; 2] = [
            // 1. A slow robot evades an approaching obstacle, whatever else it would do. A robot that drives on needs no
            //    evasion: its samples are clear of moving obstacles.
            &mut self.evasion,
            // 2. A robot that only creeps along its path rotates towards its target, and may then drive on.
            &mut self.rotate_in_place,
        ];
        for behaviour in overriding {
            if let Some(replacement) = behaviour.replace(&state, allowed) {
                decision = replacement;
                break;
            }
        }
        let with_memory: [&mut dyn Behaviour; 2] = [&mut self.escape, &mut self.rotate_in_place];
        for behaviour in with_memory {
            behaviour.observe(&state, &decision);
        }
        Ok(decision)
    }

    /// Whether the robot is near enough to its goal to park, or parks and has not left it since.
    pub fn is_at_goal(&self, state: &State<'_>) -> bool {
        self.goal_handling.is_at_goal(state)
    }

    /// Forgets the last goal and the attempts to escape.
    pub fn start_leg(&mut self) {
        self.goal_handling = GoalHandling::default();
        self.escape = Escape::default();
    }

    /// The local planner.
    pub const fn planner(&self) -> &LocalPlanner {
        self.path_following.planner()
    }

    pub const fn planner_mut(&mut self) -> &mut LocalPlanner {
        self.path_following.planner_mut()
    }
}
