//! Parks the robot at its goal: at the position to the centimetre, and at the yaw.
//!
//! The dynamic window evaluates where a trajectory ends after seconds; to stand at a station the distance itself counts.

use core::f64::consts::{FRAC_PI_2, PI};

use super::super::condition_timer::ConditionTimer;
use super::super::exact_clearance::ExactClearance;
use super::super::progress::spared_s;
use super::super::staging::can_turn;
use super::super::state::State;
use super::super::{Decision, Fault, Goal, Mode, NavigatorSettings};
use super::parking::{AIM_FROM, Motion, Parking};
use super::{Behaviour, Override, Proposal};
use crate::geometry::{Point, Pose, Twist, bearing, wrap_angle};
use crate::robot::Limits;

/// A robot that parks leaves its goal at this many times the goal's tolerance, and drives there again.
const LEAVES_GOAL: f64 = 2.0;
/// Time and time step of the collision check, seconds: longer than the robot takes to stop.
const HORIZON_S: f64 = 1.0;
const STEP_S: f64 = 0.1;

/// Time for which parking may be blocked, seconds. Then the robot drives nearer by its path, or it has no room for a correction within
/// the goal's tolerances: it stays there, or at its position and turns to the yaw.
const BLOCKED_S: f64 = 1.0;
/// Where static obstacles keep the robot from turning to the goal's yaw, it turns the other way round after the first time, seconds. The
/// mission fails after the second: people who stand there may go.
const TURNS_BACK_AFTER_S: f64 = 2.0;
const NO_ROOM_TO_TURN_S: f64 = 20.0;

/// Parks at the goal.
#[derive(Clone, Debug, Default)]
pub(super) struct GoalHandling {
    parking: Parking,
    blocked: ConditionTimer,
    has_no_room: ConditionTimer,
    cannot_turn: ConditionTimer,
    /// The robot has tried the longer turn to the goal's yaw.
    has_turned_back: bool,
    /// Since when the robot has had no room to turn, seconds, whether or not it turns back meanwhile.
    held_since_s: Option<f64>,
    /// Time for which the robot parked next to people, seconds.
    waited_s: f64,
    /// Parking was blocked: the straight line to the goal keeps less than the margin. The robot parks again only within the goal's
    /// tolerance.
    was_blocked: bool,
}

impl Behaviour for GoalHandling {
    fn propose(&mut self, state: &State<'_>) -> Result<Option<Proposal>, Fault> {
        if !state.is_at_goal {
            // It evaded people, or the straight line to the goal is no longer clear.
            if self.parking.has_begun() {
                let is_hurried = self.parking.is_hurried() || state.waits_for_people();
                self.restart(is_hurried);
            }
            return Ok(None);
        }
        let (now, goal, settings) = (state.now, state.goal, state.settings);
        let stand = |mode, allowed| Ok(Some(Proposal::Decide(state.stand(mode), allowed)));
        let motion = Motion {
            time_s: now.time_s,
            pose: &now.pose,
            twist: &now.twist,
            measured: state.measured,
            sent: state.last_command,
        };
        let off_m = (goal.position - now.pose.position()).norm();
        let off_rad = goal.yaw.map_or(0.0, |yaw| wrap_angle(yaw - now.pose.yaw));
        let is_within_xy = off_m <= settings.xy_goal_tolerance;
        let is_within = is_within_xy && off_rad.abs() <= settings.yaw_goal_tolerance;
        let lasted_s = self.parking.lasted_s(now.time_s);
        if state.waits_for_people() {
            self.waited_s += state.tick.elapsed_s();
        }
        if lasted_s > settings.parking_timeout_s {
            if is_within {
                let stands = self.parking.stands(&motion, settings);
                let mode = if stands { Mode::Arrived } else { Mode::Parking };
                return stand(mode, Override::Never);
            }
            let counted_s = lasted_s - spared_s(self.waited_s);
            if counted_s > settings.parking_timeout_s + settings.movement_time_allowance {
                return Err(Fault::NoProgress {
                    stuck_s: lasted_s,
                    radius_m: settings.xy_parking_tolerance,
                    left_m: off_m,
                    held_by: "the robot was parking".to_owned(),
                });
            }
        }
        let limits = limits_in_sight(state);
        // A loop that is slower than its period keeps each command for longer.
        let inputs = (settings, &limits, state.tick.elapsed_s());
        let Some(wanted) = self.parking.next(motion, goal, inputs) else {
            return stand(Mode::Arrived, Override::Never);
        };
        let command = moving_or_zero(&wanted, state);
        let ends_after_s = self.parking.ends_after_s(&command, &limits);
        let has_room = is_clear_of_static(&command, ends_after_s, state);
        if self.has_no_room.update(now.time_s, !has_room && is_within) >= BLOCKED_S {
            return stand(Mode::Arrived, Override::Never);
        }
        let is_held = !has_room && is_within_xy && !is_within;
        let held_s = self.cannot_turn.update(now.time_s, is_held);
        if held_s >= BLOCKED_S || is_within_xy && self.must_turn_here(state, &limits) {
            self.parking.keep_position();
        }
        if held_s >= TURNS_BACK_AFTER_S && !self.has_turned_back {
            self.has_turned_back = true;
            self.parking.turn_other_way(goal, &now.pose);
        }
        if is_held {
            let since_s = *self.held_since_s.get_or_insert(now.time_s);
            if let Some(yaw) = goal.yaw.filter(|_| now.time_s - since_s >= NO_ROOM_TO_TURN_S) {
                return Err(Fault::NoRoomToTurn { yaw, from: wrap_angle(now.pose.yaw) });
            }
        }
        let is_clear = has_room && is_clear_of_moving(&command, state);
        let blocked_s = self.blocked.update(now.time_s, !is_clear && !is_within_xy);
        if blocked_s >= BLOCKED_S {
            self.was_blocked = true;
            self.restart(self.parking.is_hurried());
            return Ok(None);
        }
        let standing = state.stand(Mode::Parking);
        let decision = if is_clear { Decision { command, ..standing } } else { standing };
        Ok(Some(Proposal::Decide(decision, Override::ByEvasion)))
    }
}

impl GoalHandling {
    /// Begins to park again. A robot that people made leave its goal is hurried.
    fn restart(&mut self, is_hurried: bool) {
        let (parking, was_blocked) = (Parking::new(is_hurried), self.was_blocked);
        *self = Self { parking, was_blocked, ..Self::default() };
    }

    /// Whether the robot must turn to the yaw of its goal before it comes nearer: it has room to turn here, and none there.
    fn must_turn_here(&self, state: &State<'_>, limits: &Limits) -> bool {
        let (goal, pose, settings) = (state.goal, &state.now.pose, state.settings);
        let Some(yaw) = goal.yaw.filter(|_| !self.parking.is_at_position()) else {
            return false;
        };
        let footprint = &state.robot.footprint;
        let reach_m =
            footprint.body_radius_m() + settings.safety_margin_m + settings.xy_goal_tolerance;
        let clearance = ExactClearance::new(state.field, &pose.position(), reach_m);
        let has_room = |place: &Point, from: f64| {
            can_turn(footprint, settings, place, &clearance, [from, yaw])
        };
        let nose_first = bearing(&pose.position(), &goal.position);
        let reverses =
            wrap_angle(nose_first - pose.yaw).abs() > FRAC_PI_2 && limits.min_vel_x < 0.0;
        let arrival = if reverses { nose_first + PI } else { nose_first };
        !has_room(&goal.position, arrival) && has_room(&pose.position(), pose.yaw)
    }

    /// Whether the robot is near enough to its goal to park, or parks and has not left it since.
    pub fn is_at_goal(&self, state: &State<'_>) -> bool {
        let (goal, pose) = (state.goal, &state.now.pose);
        let away_m = (pose.position() - goal.position).norm();
        let tolerance_m = state.settings.xy_goal_tolerance;
        let near_m = if self.parking.has_begun() { LEAVES_GOAL * tolerance_m } else { tolerance_m };
        let may_begin = !self.was_blocked && can_begin(pose, goal, state.settings);
        away_m <= near_m || may_begin && state.is_straight_clear_to(&goal.position)
    }
}

/// As [`State::limits_in_sight`], but where an obstacle behind the robot hides what is beyond it, the robot may creep towards it.
fn limits_in_sight(state: &State<'_>) -> Limits {
    let limits = state.limits_in_sight();
    let slowest = state.robot.limits.min_vel_x.max(-state.settings.min_approach_linear_velocity);
    let is_hidden = limits.min_vel_x == 0.0 && slowest < 0.0;
    let may_creep = is_hidden && state.is_path_visible(&Twist::new(slowest, 0.0));
    if may_creep { Limits { min_vel_x: slowest, ..limits } } else { limits }
}

/// A command towards a velocity: zero, or at least the least speed that moves the base. The base itself keeps its limits of
/// acceleration; a command below its deadband would do nothing.
fn moving_or_zero(wanted: &Twist, state: &State<'_>) -> Twist {
    if !state.is_safe_towards(wanted) {
        return state.brake();
    }
    let (settings, command) = (state.settings, state.towards(wanted));
    let axis = |command: f64, wanted: f64, least: f64| {
        let is_small = command.abs() < least.min(wanted.abs());
        if is_small && command * wanted >= 0.0 {
            least.min(wanted.abs()).copysign(wanted)
        } else {
            command
        }
    };
    let stopped = |command: f64, wanted: f64, least: f64| {
        if wanted == 0.0 && command.abs() < least { 0.0 } else { axis(command, wanted, least) }
    };
    let least_rate = if wanted.linear == 0.0 { settings.min_rotational_vel } else { 0.0 };
    Twist::new(
        stopped(command.linear, wanted.linear, settings.min_approach_linear_velocity),
        stopped(command.angular, wanted.angular, least_rate),
    )
}

/// Whether a goal lies near enough, and far enough ahead, to drive straight to it.
fn can_begin(pose: &Pose, goal: &Goal, settings: &NavigatorSettings) -> bool {
    let to_goal = pose.inverse_transform(&goal.position);
    let off_nose = libm::atan2(to_goal.y, to_goal.x);
    to_goal.to_vector().norm() <= settings.parking_distance_m && off_nose.abs() <= AIM_FROM
}

/// Whether the body of a robot that keeps a velocity for a time, seconds, keeps the safety margin within the horizon, by the exact
/// distances to the occupied cells: the distance field is too coarse for a goal near a wall. One that is within the margin must only
/// come no nearer.
fn is_clear_of_static(command: &Twist, ends_after_s: f64, state: &State<'_>) -> bool {
    if *command == Twist::STOP {
        return true;
    }
    let (footprint, pose) = (&state.robot.footprint, &state.now.pose);
    let margin_m = state.settings.safety_margin_m;
    let reach_m = footprint.body_radius_m() + margin_m + command.linear.abs() * HORIZON_S;
    let clearance = ExactClearance::new(state.field, &pose.position(), reach_m);
    let kept_m = margin_m.min(clearance.gap_m(footprint, pose));
    let before_end = |(_, time_s): &(Pose, f64)| *time_s < ends_after_s + STEP_S;
    let mut poses = horizon(command, pose).take_while(before_end);
    poses.all(|(there, _)| clearance.keeps_gap(footprint, &there, kept_m))
}

/// Whether the robot then touches no moving obstacle.
fn is_clear_of_moving(command: &Twist, state: &State<'_>) -> bool {
    *command == Twist::STOP
        || horizon(command, &state.now.pose)
            .all(|(there, time_s)| state.inflated.is_clear_of_moving(&there, time_s))
}

/// The poses of a robot that keeps a velocity, each with its time, seconds.
fn horizon(command: &Twist, pose: &Pose) -> impl Iterator<Item = (Pose, f64)> {
    let steps = (HORIZON_S / STEP_S) as u32;
    (1..=steps).map(|step| {
        let time_s = f64::from(step) * STEP_S;
        (pose.after(command, time_s), time_s)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::{GridFrame, MovingDisc, ObstacleGrid};
    use crate::navigator::RobotModel;
    use crate::navigator::predicted_state::PredictedState;
    use crate::navigator::test_state::{PERIOD_S, standing_at, with_state};
    use crate::robot::{Footprint, Limits, Polygon};

    /// A robot that stands at its goal, or this far to its left, metres, and turns there from one yaw to another, on a ground with walls at
    /// some x, y. Returns its yaws, and when and why it fails, seconds.
    fn turns(
        body: Polygon,
        is_wall: impl Fn(&Point) -> bool,
        aside_m: f64,
        (from, to): (f64, f64),
    ) -> (Vec<f64>, Option<(f64, String)>) {
        let robot = RobotModel { footprint: Footprint::covering(body), limits: Limits::default() };
        let frame = GridFrame::new(120, 120, 0.1, Pose::new(-3.0, -6.0, 0.0)).expect("a size");
        let ground = ObstacleGrid::from_fn(frame, |cell| is_wall(&frame.center_of(cell)));
        let settings = NavigatorSettings::default();
        let goal = Goal { position: Point::new(3.0, 0.0), yaw: Some(to) };
        let goal: &'static Goal = Box::leak(Box::new(goal));
        let mut handling = GoalHandling::default();
        let (mut pose, mut twist, mut yaws) =
            (Pose::new(3.0, aside_m, from), Twist::STOP, Vec::new());
        for tick in 0..600 {
            let mut now = standing_at(pose);
            (now.time_s, now.twist) = (f64::from(tick) * PERIOD_S, twist);
            let proposed = with_state(&settings, &robot, &ground, &now, (twist, twist), |state| {
                (state.goal, state.is_at_goal) = (goal, true);
                handling.propose(state)
            });
            match proposed {
                Ok(Some(Proposal::Decide(decision, _))) if decision.mode != Mode::Arrived => {
                    twist = decision.command;
                }
                Ok(_) => break,
                Err(fault) => return (yaws, Some((now.time_s, fault.to_string()))),
            }
            pose = pose.after(&twist, PERIOD_S);
            yaws.push(wrap_angle(pose.yaw));
        }
        (yaws, None)
    }

    /// When and why a robot of 0.8 by 0.4 m fails that stands in a corridor along x, turned as far as it has room.
    fn fails_after_s(width_m: f64) -> Option<(f64, String)> {
        let body = Polygon::rectangle(0.8, 0.4).expect("a body");
        turns(body, |place| place.y.abs() > 0.5 * width_m, 0.0, (0.35, 1.4)).1
    }

    /// A robot with a long front, a wall to the right of its goal, room to the left, and a turn of three radians ahead.
    #[test]
    fn robot_turns_the_other_way_where_the_shorter_one_has_no_room() {
        let body = [(-0.3, -0.2), (1.2, -0.2), (1.2, 0.2), (-0.3, 0.2)];
        let body = body.map(|(x, y)| Point::new(x, y)).to_vec();
        let body = || Polygon::new(body.clone()).expect("a body");
        let (yaws, fault) = turns(body(), |place| place.x > 3.8, 0.0, (-1.4, 1.57));
        assert!(fault.is_none() && yaws.last().is_some_and(|yaw| (yaw - 1.57).abs() < 0.05));
        assert!(yaws.iter().all(|yaw| yaw.abs() > 0.8), "to the left: {yaws:?}");
        let (yaws, fault) = turns(body(), |_| false, 0.0, (-1.4, 1.57));
        assert!(fault.is_none() && yaws.iter().any(|yaw| yaw.abs() < 0.1), "the shorter turn");
    }

    /// In a corridor of 0.8 m, a robot of 0.8 by 0.4 m stands 3 cm beside its goal: it has no room to turn across the corridor for these.
    #[test]
    fn robot_that_cannot_aim_at_its_position_turns_to_the_yaw_where_it_is() {
        let body = || Polygon::rectangle(0.8, 0.4).expect("a body");
        let (yaws, fault) = turns(body(), |place| place.y.abs() > 0.4, 0.03, (0.25, 0.0));
        assert!(fault.is_none(), "{fault:?}");
        assert!(yaws.last().is_some_and(|yaw| yaw.abs() < 0.05), "{:?}", yaws.last());
    }

    /// When a robot fails that stands 0.3 m from its goal and cannot come nearer, seconds. It is away from it for the first second of
    /// each period, and a person stands beside it, or not.
    fn fails_while_it_parks(away_every_s: f64, has_person: bool) -> Option<f64> {
        let footprint = Footprint::round(0.3).expect("a radius");
        let robot = RobotModel { footprint, limits: Limits::default() };
        let frame = GridFrame::new(100, 100, 0.1, Pose::new(-2.0, -5.0, 0.0)).expect("a size");
        let ground = ObstacleGrid::filled(frame, false);
        let settings = NavigatorSettings::default();
        let mut handling = GoalHandling::default();
        let person = MovingDisc { x: 2.7, y: 1.5, radius: 0.3, vx: 0.0, vy: 0.0 };
        (0..6000).find_map(|tick| {
            let time_s = f64::from(tick) * PERIOD_S;
            let may_come = if has_person { vec![person] } else { Vec::new() };
            let now = PredictedState { time_s, may_come, ..standing_at(Pose::new(2.7, 0.0, 0.0)) };
            let still = (Twist::STOP, Twist::STOP);
            let proposed = with_state(&settings, &robot, &ground, &now, still, |state| {
                state.is_at_goal = time_s % away_every_s >= 1.0;
                handling.propose(state).err()
            });
            proposed.map(|_| time_s)
        })
    }

    #[test]
    fn robot_that_left_its_goal_parks_anew_and_waits_longer_for_people() {
        let alone_s = fails_while_it_parks(1e9, false).expect("it fails");
        assert!((119.0..123.0).contains(&alone_s), "{alone_s} s");
        assert_eq!(fails_while_it_parks(60.0, false), None);
        let waited_s = fails_while_it_parks(1e9, true).expect("it fails");
        assert!((479.0..483.0).contains(&waited_s), "{waited_s} s");
    }

    #[test]
    fn robot_without_room_to_turn_to_its_yaw_fails_soon_for_that_reason() {
        let (failed_s, reason) = fails_after_s(0.8).expect("no room");
        assert!((20.0..40.0).contains(&failed_s), "{failed_s} s");
        assert!(reason.contains("no room to turn to the yaw 1.40 from -0.25"), "{reason}");
        assert!(fails_after_s(1.2).is_none_or(|(_, reason)| !reason.contains("no room")));
    }
}
