//! Follows the path with the dynamic window.

use core::f64::consts::{FRAC_PI_2, PI};
use std::borrow::Cow;

use super::super::staging::LeadingEnd;
use super::super::state::State;
use super::super::{Decision, Fault, Mode};
use super::{Behaviour, Override, Proposal};
use crate::geometry::{Pose, Twist};
use crate::local::{DecisionInput, LocalPlanner, LocalSettings};
use crate::robot::{Footprint, Limits};

/// A robot below this speed creeps, m/s.
const CREEPING: f64 = 0.05;
/// Share of the braking deceleration that the approach to the goal uses.
const APPROACH: f64 = 0.6;
/// Lowest speed limit near the goal, or near the local target past people, m/s.
const MIN_APPROACH_SPEED: f64 = 0.1;
/// Shortest horizon near the local target, seconds.
const MIN_HORIZON_S: f64 = 0.5;

/// Replanning periods within which the robot gets a path around an obstacle, if there is one nearby.
const PERIODS_TO_REPLAN: f64 = 2.0;

/// Longest horizon past a person who comes, seconds: the path bends to the side and back, and a longer arc does not.
const ASIDE_HORIZON_S: f64 = 1.5;

/// Chooses a velocity of the dynamic window that leads to the local target.
pub(super) struct PathFollowing {
    pub planner: LocalPlanner,
}

impl Behaviour for PathFollowing {
    fn propose(&mut self, state: &State<'_>) -> Result<Option<Proposal>, Fault> {
        let LocalSettings { mut weights, sim_time_s: usual_s, .. } = *self.planner.settings();
        let is_past_people = state.is_past_people();
        let sim_time_s = if is_past_people { usual_s.min(ASIDE_HORIZON_S) } else { usual_s };
        let view = View::new(state);
        let limits = view.limits(state, sim_time_s);
        // Beyond its target the directions to it, and the distances, mean little: a longer horizon makes the robot creep towards a
        // target that a corner hides until the robot is there. In front of an obstacle it is to slow down early.
        let horizon_s = if is_past_people || has_no_way_around(state) {
            sim_time_s
        } else {
            (state.to_target_m() / limits.max_vel_x).max(MIN_HORIZON_S).min(sim_time_s)
        };
        if state.is_narrow || is_past_people || horizon_s < sim_time_s && is_goal_in_sight(state) {
            // Every way in has little clearance: with that weight the robot turns away from the entrance, or creeps. Near the goal it
            // would drive past it, for the sake of small differences.
            weights.clearance = 0.0;
        }
        if is_past_people {
            // With it the robot drives on straight, and reaches its side too late.
            weights.velocity = 0.0;
        }
        let input = DecisionInput {
            field: state.field,
            pose: view.pose,
            twist: view.twist,
            last_command: view.last_command,
            obstacles: &state.inflated.moving,
            target: state.local_target,
            key_node: state.local_target,
            limits,
            footprint: &view.footprint,
            weights,
        };
        self.planner.set_tick_time(state.tick);
        self.planner.set_horizon(horizon_s);
        let decided = self.planner.decide(&input);
        self.planner.set_horizon(usual_s);
        let (command, evaluation) = decided.map_err(Fault::Choose)?;
        let command = command.map(|command| view.in_robot_frame(command));
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

/// Whether an obstacle has been on the path ahead for so long that a path around it would be known.
fn has_no_way_around(state: &State<'_>) -> bool {
    let known_s = PERIODS_TO_REPLAN * state.settings.replan_period_s;
    state.blocked_s.is_some_and(|blocked_s| blocked_s > known_s)
}

/// Whether the goal is the local target, and in sight.
fn is_goal_in_sight(state: &State<'_>) -> bool {
    state.local_target == state.goal.position && state.is_straight_clear_to(&state.local_target)
}

/// The robot as the local planner sees it. One that drives backwards looks the other way there, and has the same motions.
struct View<'a> {
    is_backwards: bool,
    pose: Pose,
    twist: Twist,
    last_command: Twist,
    base: Limits,
    footprint: Cow<'a, Footprint>,
}

impl<'a> View<'a> {
    /// The robot drives backwards on a way that it drives tail first, and where its target is behind it in a narrow passage. Where it
    /// can, it has rotated before.
    fn new(state: &'a State<'_>) -> Self {
        let footprint = &state.inflated.footprint;
        let forwards = Self {
            is_backwards: false,
            pose: state.now.pose,
            twist: state.now.twist,
            last_command: *state.last_command,
            base: state.robot.limits,
            footprint: Cow::Borrowed(footprint),
        };
        let is_behind = state.is_narrow && state.heading_error.abs() > FRAC_PI_2;
        if !is_behind && state.leading_end == LeadingEnd::Nose {
            return forwards;
        }
        let base = state.limits_in_sight();
        if base.min_vel_x >= 0.0 {
            return forwards;
        }
        let (min_vel_x, max_vel_x) = (-base.max_vel_x, -base.min_vel_x);
        Self {
            is_backwards: true,
            pose: Pose { yaw: forwards.pose.yaw + PI, ..forwards.pose },
            twist: turned_around(forwards.twist),
            last_command: turned_around(forwards.last_command),
            base: Limits { min_vel_x, max_vel_x, ..base },
            footprint: Cow::Owned(footprint.turned_around()),
        }
    }

    fn in_robot_frame(&self, command: Twist) -> Twist {
        if self.is_backwards { turned_around(command) } else { command }
    }

    /// Velocity limits for the dynamic window: in one direction only, slow enough to stop at the goal, and slow within a margin. The
    /// horizon in seconds.
    fn limits(&self, state: &State<'_>, horizon_s: f64) -> Limits {
        let limits = &self.base;
        let to_goal_m = (state.now.pose.position() - state.goal.position).norm();
        let stops_in_time = (-2.0 * APPROACH * limits.decel_lim_x * to_goal_m).sqrt();
        let mut fastest = stops_in_time.max(MIN_APPROACH_SPEED);
        if state.inflated.within_a_margin {
            fastest = fastest.min(state.settings.passing_speed);
        }
        if state.is_past_people() {
            // Faster arcs end beyond the target.
            fastest = fastest.min((state.to_target_m() / horizon_s).max(MIN_APPROACH_SPEED));
        }
        if let Some(safety) = state.passive_safety() {
            fastest = safety.fastest(fastest);
        }
        let fastest = fastest.min(state.speed_limit);
        // The robot reaches every sample, and drives it as it was evaluated.
        let slowed_to = |fastest: f64| limits.slowed_to(fastest, &self.twist, state.tick);
        Limits { min_vel_x: slowed_to(0.0).min_vel_x, ..slowed_to(fastest) }
    }
}

/// The same motion of a robot that looks the other way.
fn turned_around(twist: Twist) -> Twist {
    Twist::new(-twist.linear, twist.angular)
}

#[cfg(test)]
mod tests {
    use super::super::super::predicted_state::PredictedState;
    use super::super::super::test_state::{standing_at, with_state};
    use super::super::super::{NavigatorSettings, RobotModel};
    use super::*;
    use crate::geometry::{Point, bearing};
    use crate::local::CpuEngine;
    use crate::map::{Cell, GridFrame, ObstacleGrid};

    /// An area of 10 by 6 m without obstacles.
    fn open_ground() -> ObstacleGrid {
        let frame = GridFrame::new(100, 60, 0.1, Pose::new(-2.0, -3.0, 0.0)).expect("a size");
        ObstacleGrid::filled(frame, false)
    }

    /// The command of a robot at 0.9 m/s at this place, whose goal is at (3, 0), after a change of its state.
    fn command(place: &Pose, ground: &ObstacleGrid, change: impl FnOnce(&mut State<'_>)) -> Twist {
        let settings = NavigatorSettings::default();
        let footprint = Footprint::round(0.3).expect("a radius");
        let robot = RobotModel { footprint, limits: Limits::default() };
        let engine = Box::new(CpuEngine::single_threaded());
        let planner = LocalPlanner::new(engine, LocalSettings::default());
        let mut following = PathFollowing { planner };
        let twist = Twist::new(0.9, 0.0);
        let now = PredictedState { twist, ..standing_at(*place) };
        let proposal = with_state(&settings, &robot, ground, &now, (twist, twist), |state| {
            let target = state.goal.position;
            state.local_target = target;
            state.heading_error = bearing(&place.position(), &target) - place.yaw;
            change(state);
            following.propose(state).expect("no fault")
        });
        assert_eq!(following.planner.settings(), &LocalSettings::default());
        match proposal {
            Some(Proposal::Decide(decision, _)) => decision.command,
            other => panic!("{other:?}"),
        }
    }

    /// Away from the wall, which is at y = 0.7 m, there is more clearance, and the samples of the whole horizon end beyond the goal.
    #[test]
    fn robot_beside_its_goal_turns_towards_it() {
        let mut ground = open_ground();
        (0..100).for_each(|column| ground.set(Cell::new(column, 37), true));
        for x in [1.3, 1.8, 2.2] {
            let turns = command(&Pose::new(x, -0.7, 0.0), &ground, |_| {});
            assert!(turns.angular >= 0.15 && turns.linear >= 0.75, "{x} m: {turns:?}");
        }
    }

    /// The wall is at x = 2.3 m, beyond the local target.
    #[test]
    fn robot_slows_down_early_where_an_obstacle_stays_on_its_path() {
        let mut ground = open_ground();
        (0..60).for_each(|row| ground.set(Cell::new(43, row), true));
        let speed_after = |blocked_s: f64| {
            let command = command(&Pose::default(), &ground, |state| {
                state.local_target = Point::new(0.6, 0.0);
                state.blocked_s = Some(blocked_s);
            });
            command.linear
        };
        assert_eq!(speed_after(0.0), speed_after(0.9));
        assert!(speed_after(0.9) >= 0.9 && speed_after(1.1) <= 0.85);
    }
}
