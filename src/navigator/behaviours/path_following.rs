//! Follows the path with the dynamic window.

use super::super::state::State;
use super::super::{Decision, Fault, Mode};
use super::{Behaviour, Override, Proposal};
use crate::geometry::Twist;
use crate::local::{DecisionInput, LocalPlanner};
use crate::robot::Limits;

/// A robot below this speed creeps, m/s.
const CREEPING: f64 = 0.05;
/// Share of the braking deceleration that the approach to the goal uses.
const APPROACH: f64 = 0.6;
/// Lowest speed limit near the goal, m/s.
const MIN_APPROACH_SPEED: f64 = 0.1;

/// Chooses a velocity of the dynamic window that leads to the local target.
pub(super) struct PathFollowing {
    pub planner: LocalPlanner,
}

impl Behaviour for PathFollowing {
    fn propose(&mut self, state: &State<'_>) -> Result<Option<Proposal>, Fault> {
        let mut weights = self.planner.settings().weights;
        if state.is_narrow {
            // Every way in has little clearance: with that weight the robot turns away from the entrance, or creeps.
            weights.clearance = 0.0;
        }
        let input = DecisionInput {
            field: state.field,
            pose: state.now.pose,
            twist: state.now.twist,
            last_command: *state.last_command,
            obstacles: &state.inflated.moving,
            target: state.local_target,
            key_node: state.local_target,
            limits: limits(state),
            footprint: &state.inflated.footprint,
            weights,
        };
        let (command, evaluation) = self.planner.decide(&input).map_err(Fault::Choose)?;
        // The speed limit holds for the present turn rate, not for the chosen one.
        let safe = |command: Twist| {
            let is_safe = state.is_safe_towards(&command);
            state.without_creep(if is_safe { command } else { state.safe_towards(&command) })
        };
        let command = command.map(safe);
        // Next to an obstacle the robot may only creep, unless it first rotates towards a free path.
        let creeps = state.now.twist.linear.abs() < CREEPING
            && command.is_none_or(|command| command.linear.abs() < CREEPING);
        let allowed = match command {
            _ if creeps => Override::ByEvasionOrRotation,
            None => Override::ByEvasion,
            Some(_) => Override::Never,
        };
        let mode = if command.is_some() { Mode::Driving } else { Mode::Blocked };
        let decision = Decision {
            command: command.unwrap_or_else(|| state.brake()),
            mode,
            local_target: state.local_target,
            counts: Some(evaluation.counts),
        };
        Ok(Some(Proposal::Decide(decision, allowed)))
    }
}

/// Velocity limits for the dynamic window: forwards only, slow enough to stop at the goal, and slow within a margin.
fn limits(state: &State<'_>) -> Limits {
    let limits = &state.robot.limits;
    let to_goal_m = (state.now.pose.position() - state.goal.position).norm();
    let stops_in_time = (-2.0 * APPROACH * limits.decel_lim_x * to_goal_m).sqrt();
    let mut fastest = stops_in_time.max(MIN_APPROACH_SPEED);
    if state.inflated.within_a_margin {
        fastest = fastest.min(state.settings.passing_speed);
    }
    if let Some(safety) = state.passive_safety() {
        fastest = safety.fastest(fastest);
    }
    let fastest = fastest.min(state.speed_limit);
    // Widened by what braking needs to get there: the robot reaches every sample, and drives it as it was evaluated.
    let in_reach = |speed: f64| state.towards(&Twist::new(speed, 0.0)).linear;
    let within = |speed: f64| speed.clamp(limits.min_vel_x, limits.max_vel_x);
    Limits {
        min_vel_x: within(0.0_f64.min(in_reach(0.0))),
        max_vel_x: within(fastest.max(in_reach(fastest))),
        ..*limits
    }
}
