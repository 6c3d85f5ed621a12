//! The behaviours of the robot, in the order of their priority.
//!
//! Each behaviour reads one [`State`], keeps its own memory and proposes a decision or nothing. [`Behaviours::decide`] lists
//! them, and those that override the decision of another one.

mod escape;
mod evasion;
mod forward_escape;
mod goal_handling;
mod occlusion_speed;
mod parking;
mod path_following;
mod rotate_in_place;

use super::state::State;
use super::{Decision, Fault, Mode};
use crate::local::LocalPlanner;
use escape::Escape;
use goal_handling::GoalHandling;
use occlusion_speed::OcclusionSpeed;
use path_following::PathFollowing;
use rotate_in_place::RotateInPlace;

/// What a behaviour proposes.
#[derive(Debug)]
enum Proposal {
    /// The behaviours with lower priority keep below this forward speed, m/s.
    SpeedLimit(f64),
    /// A decision, and how it may be overridden.
    Decide(Decision, Override),
}

/// Which behaviours may override a decision.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Override {
    /// None: the robot drives on, or has arrived.
    Never,
    /// Evasion: the robot is so slow that an approaching obstacle may hit it.
    ByEvasion,
    /// Evasion, then rotation in place: the robot creeps along its path.
    ByEvasionOrRotation,
}

/// A behaviour that proposes what to do.
trait Behaviour {
    /// Proposes a decision; `None` where the behaviour does not apply.
    ///
    /// # Errors
    /// When the mission must end.
    fn propose(&mut self, state: &State<'_>) -> Result<Option<Proposal>, Fault>;
}

/// All behaviours with their memories.
pub(super) struct Behaviours {
    goal_handling: GoalHandling,
    escape: Escape,
    rotate_in_place: RotateInPlace,
    path_following: PathFollowing,
}

impl Behaviours {
    pub fn new(planner: LocalPlanner) -> Self {
        Self {
            goal_handling: GoalHandling::default(),
            escape: Escape::default(),
            rotate_in_place: RotateInPlace::default(),
            path_following: PathFollowing { planner },
        }
    }

    /// The decision in a state.
    ///
    /// # Errors
    /// When the mission must end.
    pub fn decide(&mut self, mut state: State<'_>) -> Result<Decision, Fault> {
        let by_priority: [&mut dyn Behaviour; 5] = [
            // 1. A robot at its goal has nothing else to do. The local planner cannot park it to the centimetre.
            &mut self.goal_handling,
            // 2. A robot that was held up for long leaves the place before it tries its path again.
            &mut self.escape,
            // 3. A robot that faces away from its target rotates before it drives: driving forwards it would circle around it.
            &mut self.rotate_in_place,
            // 4. A robot that drives on is slow enough for what it cannot see.
            &mut OcclusionSpeed,
            // 5. Otherwise the robot follows its path with the dynamic window. This behaviour always proposes a decision.
            &mut self.path_following,
        ];
        let mut proposed = None;
        for behaviour in by_priority {
            match behaviour.propose(&state)? {
                None => {}
                Some(Proposal::SpeedLimit(limit)) => {
                    state.speed_limit = state.speed_limit.min(limit);
                }
                Some(Proposal::Decide(decision, allowed)) => {
                    proposed = Some((decision, allowed));
                    break;
                }
            }
        }
        let (decision, allowed) =
            proposed.unwrap_or_else(|| (state.stand(Mode::Blocked), Override::Never));
        // 1. A slow robot evades an approaching obstacle, whatever else it would do. A robot that drives on needs no
        //    evasion: its samples are clear of moving obstacles.
        let evasion = evasion::replacement(&state, allowed);
        // 2. A robot that only creeps along its path rotates towards its target, and may then drive on.
        let rotate = || self.rotate_in_place.replacement(&state, allowed, &decision.command);
        let replacement = evasion.or_else(rotate);
        let mut decision = replacement.unwrap_or(decision);
        // No behaviour reverses into what the lidar does not see.
        if decision.command.linear < 0.0 && !state.is_path_visible(&decision.command) {
            decision.command = state.brake();
        }
        self.escape.observe(&state, &decision);
        self.rotate_in_place.observe(&decision);
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
        &self.path_following.planner
    }

    pub const fn planner_mut(&mut self) -> &mut LocalPlanner {
        &mut self.path_following.planner
    }
}
