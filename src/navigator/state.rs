//! The state of the navigator at a tick: robot, obstacles and path.

use std::borrow::Cow;
use std::collections::VecDeque;
use std::sync::Arc;

use super::inflated_bodies::InflatedBodies;
use super::passive_safety::PassiveSafety;
use super::staging::LeadingEnd;
use super::visible_space::VisibleSpace;
use super::{Decision, Goal, Mode, NavigatorSettings, Route};
use crate::geometry::{Point, Pose, Twist, bearing, wrap_angle};
use crate::local::ClearanceField;
use crate::map::{FreeSpace, MovingDisc};
use crate::robot::{Footprint, Limits, TickTime};

/// Longest line of sight, metres: more than any lookahead in use.
const MAX_LINE_M: f64 = 1000.0;
/// Distance between two checked points of a straight line, metres.
const LINE_STEP_M: f64 = 0.1;

/// The lidar must see this far in the direction of motion, metres, as far as a robot gets there within a time, seconds.
const PROBED_M: f64 = 0.15;
const MAX_PROBED_S: f64 = 1.0;

/// The robot keeps its command for this many periods until it brakes for what a scan shows: the next scan may just have missed
/// it.
const SCANS_TO_REACT: f64 = 2.0;

/// A robot waits for people within this distance, metres.
const WAITING_M: f64 = 2.0;

/// A robot creeps if all its parts are at most this fast, m/s. Next to a person it stands still instead: creeping gains nothing,
/// and the person may come.
pub(super) const CREEP: f64 = 0.05;

/// Shares of a wanted velocity. They are tried in this order, and the robot drives the first one that keeps passive safety.
const SAFE_SHARES: [f64; 6] = [1.0, 0.8, 0.6, 0.4, 0.2, 0.1];

/// The navigator's model of the robot.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotModel {
    /// Shape of the robot.
    pub footprint: Footprint,
    /// Velocity and acceleration limits of its base.
    pub limits: Limits,
}

/// Longest history of commands, seconds: no base reacts later. Largest number of commands.
const IN_FLIGHT_S: f64 = 2.0;
const MAX_IN_FLIGHT: usize = 256;

/// The latest commands with their times. Radio, bus and motor delay a command; until it takes effect the robot follows the
/// earlier ones.
#[derive(Clone, Debug, Default)]
pub(super) struct CommandsInFlight(VecDeque<(f64, Twist)>);

impl CommandsInFlight {
    /// Records a command handed over at a time, seconds. A time that descends clears the history: the clock jumped.
    pub fn record(&mut self, time_s: f64, command: &Twist) {
        if self.0.back().is_some_and(|last| last.0 >= time_s) {
            self.0.clear();
        }
        self.0.push_back((time_s, *command));
        while self.0.len() > MAX_IN_FLIGHT
            || self.0.get(1).is_some_and(|next| time_s - next.0 > IN_FLIGHT_S)
        {
            self.0.pop_front();
        }
    }
}

/// Oldest scan from which moving obstacles are predicted, seconds.
const OLDEST_SCAN_S: f64 = 1.0;

/// A measured pose and velocity.
#[derive(Clone, Copy, Debug)]
pub(super) struct Measured<'a> {
    /// Time of the tick, seconds.
    pub time_s: f64,
    /// Time at which pose and velocity were measured, seconds, by the same clock.
    pub odometry_s: f64,
    /// Time of the scan that shows the moving obstacles, seconds.
    pub scan_s: f64,
    pub pose: &'a Pose,
    pub twist: &'a Twist,
}

/// The robot and the moving obstacles at the time when a command sent now takes effect.
///
/// A decision for the present pose would brake too late by the distance driven until then. The prediction starts at the time of
/// the measurement, not of the tick, so it covers the age of the measurement.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PredictedState {
    /// Time of the observation, seconds.
    pub time_s: f64,
    /// Predicted pose of the robot.
    pub pose: Pose,
    /// Predicted velocity, as far as the base can have followed the commands.
    pub twist: Twist,
    /// Predicted moving obstacles.
    pub moving: Vec<MovingDisc>,
    /// `moving`, and people who entered free ground and are not tracked.
    pub may_come: Vec<MovingDisc>,
    /// The people whom a turn in place may meet: `may_come`, where people who have not stood for long may walk, and people whom
    /// the tracker lost.
    pub near_turn: Vec<MovingDisc>,
    /// Objects that stand alone: each may be a post, or a person who starts to walk.
    pub may_start: Vec<MovingDisc>,
    /// Time from the scan to the effect of the command, seconds.
    pub since_scan_s: f64,
}

impl PredictedState {
    /// Predicts from the measurement, the tracked obstacles of the tick, and the commands. Each command takes effect after a
    /// delay, seconds.
    pub fn new(
        measured: &Measured<'_>,
        moving: &[MovingDisc],
        commands: &CommandsInFlight,
        limits: &Limits,
        delay_s: f64,
    ) -> Self {
        let Measured { time_s, odometry_s, scan_s, .. } = *measured;
        let (mut pose, mut twist) = (*measured.pose, *measured.twist);
        let mut at_s = odometry_s.clamp(time_s - IN_FLIGHT_S, time_s);
        let mut active = Twist::STOP;
        for (sent_s, command) in &commands.0 {
            let effect_s = sent_s + delay_s;
            if effect_s > at_s {
                (pose, twist) = limits.advance(&pose, &twist, &active, effect_s - at_s);
                at_s = effect_s;
            }
            active = *command;
        }
        let left_s = (time_s + delay_s - at_s).max(0.0);
        (pose, twist) = limits.advance(&pose, &twist, &active, left_s);
        let since_scan_s = delay_s + (time_s - scan_s).clamp(0.0, OLDEST_SCAN_S);
        let moving: Vec<_> = moving.iter().map(|disc| disc.after(since_scan_s)).collect();
        Self {
            time_s,
            pose,
            twist,
            may_come: moving.clone(),
            near_turn: moving.clone(),
            may_start: Vec::new(),
            moving,
            since_scan_s,
        }
    }
}

/// The command after the time of a tick of braking at the limit, from the slower of the predicted motion and the last command.
///
/// Motors follow a braking command with a lag. A command that starts from the measured motion follows that lag, and the robot
/// then brakes at a part of its limit. A robot that still accelerates is slower than its last command.
pub(super) fn brake(
    limits: &Limits,
    predicted: &Twist,
    last_command: &Twist,
    time: impl Into<TickTime>,
) -> Twist {
    let slower = |one: f64, other: f64| {
        if one * other <= 0.0 { 0.0 } else { one.abs().min(other.abs()).copysign(one) }
    };
    let from = Twist::new(
        slower(predicted.linear, last_command.linear),
        slower(predicted.angular, last_command.angular),
    );
    limits.brake(&from, time)
}

/// What a behaviour decides from.
pub(super) struct State<'a> {
    pub settings: &'a NavigatorSettings,
    pub robot: &'a RobotModel,
    /// Time since the tick before, one control period at least.
    pub tick: TickTime,
    /// The robot and the moving obstacles when the command takes effect.
    pub now: &'a PredictedState,
    /// The twist that the base measured.
    pub measured: &'a Twist,
    /// The command of the last tick.
    pub last_command: &'a Twist,
    /// Distances to static obstacles around the robot.
    pub field: &'a Arc<ClearanceField>,
    /// Whether the robot was in a narrow passage, or near one, at the last tick.
    pub is_narrow: bool,
    /// The end of the robot that drives ahead: its tail where it cannot turn at its goal.
    pub leading_end: LeadingEnd,
    /// The robot with the discs of narrow passages.
    pub slim: &'a Footprint,
    /// The footprint and the moving obstacles with their margins.
    pub inflated: InflatedBodies,
    /// What the latest scan shows.
    pub visible: VisibleSpace<'a>,
    /// Where the map has room for a person; `None` if hidden people are not considered.
    pub standing_room: Option<&'a FreeSpace>,
    pub goal: &'a Goal,
    pub route: &'a Route,
    /// Distance of the robot from the path, metres.
    pub off_path_m: f64,
    /// The key node to drive to.
    pub local_target: Point,
    /// Angle from the robot's heading to the local target, radians.
    pub heading_error: f64,
    /// Mode of the last tick with a valid observation.
    pub mode: Mode,
    /// Whether the robot is near enough to the goal to park.
    pub is_at_goal: bool,
    /// Time since the last progress along the path, seconds.
    pub stuck_s: f64,
    /// Time since the robot last came nearer to its goal than it has been since its last escape, seconds.
    pub since_nearer_s: f64,
    /// Whether the protective layer slowed the last command.
    pub is_slowed: bool,
    /// Highest forward speed of the robot here, by its limits and the zones, m/s.
    pub fastest: f64,
    /// Highest forward speed that the behaviours with higher priority allow, m/s.
    pub speed_limit: f64,
}

impl<'a> State<'a> {
    /// Follows a route: selects its key node to drive to.
    pub fn follow(&mut self, route: &'a Route) {
        let Self { settings, now, .. } = *self;
        let in_sight = |node: &Point| self.is_straight_clear_to(node);
        let target = route.key_node(settings.min_lookahead_m, settings.lookahead_m, in_sight);
        self.route = route;
        self.local_target = target;
        self.heading_error = wrap_angle(bearing(&now.pose.position(), &target) - now.pose.yaw);
    }

    /// The velocity after the time of this tick of braking at the limit, on the same arc.
    pub fn brake(&self) -> Twist {
        brake(&self.robot.limits, &self.now.twist, self.last_command, self.tick)
    }

    /// The velocity nearest to a wanted one that the robot reaches at this tick.
    pub fn towards(&self, wanted: &Twist) -> Twist {
        self.robot.limits.reachable(&self.now.twist, wanted, self.tick)
    }

    /// Time without progress after which the robot is held up, seconds: that of the settings, or at least the time that a slow robot
    /// needs for what counts as progress.
    pub fn stuck_patience_s(&self) -> f64 {
        let NavigatorSettings { stuck_patience_s, required_movement_radius, .. } = *self.settings;
        let needed_s = required_movement_radius / self.fastest;
        if needed_s.is_finite() { stuck_patience_s.max(needed_s) } else { stuck_patience_s }
    }

    /// Whether a person is near enough to hold the robot up.
    pub fn waits_for_people(&self) -> bool {
        let gap_m = |disc: &MovingDisc| self.robot.footprint.gap_to_moving_m(&self.now.pose, disc);
        self.now.may_come.iter().any(|disc| gap_m(disc) < WAITING_M)
    }

    /// Braking instead of a command that lets a robot creep next to a person. A robot that starts is as slow for a moment.
    pub fn without_creep(&self, command: Twist) -> Twist {
        let fastest_part = |twist: &Twist| self.robot.footprint.fastest_part(twist);
        // A robot that still brakes does not start, although the prediction has it standing already.
        let starts = fastest_part(&command) > fastest_part(self.measured);
        let creeps = fastest_part(&command) <= CREEP && !starts;
        let is_on = self.settings.features.passive_safety;
        if is_on && creeps && self.waits_for_people() { self.brake() } else { command }
    }

    /// The check for passive safety; `None` where that feature is off.
    pub fn passive_safety(&self) -> Option<PassiveSafety<'_>> {
        let is_on = self.settings.features.passive_safety;
        is_on.then(|| self.safety_from(&self.now.may_come))
    }

    /// The check for obstacles that the next scan shows.
    pub fn safety_from<'b>(&'b self, obstacles: &'b [MovingDisc]) -> PassiveSafety<'b> {
        let settings = self.settings;
        PassiveSafety {
            now: self.now,
            obstacles,
            footprint: &self.robot.footprint,
            limits: &self.robot.limits,
            reaction_s: SCANS_TO_REACT * self.tick.period_s(),
            acceleration: settings.pedestrian_acceleration,
            top_speed: settings.pedestrian_speed,
        }
    }

    /// Whether driving towards a velocity until the next tick keeps passive safety.
    pub fn is_safe_towards(&self, wanted: &Twist) -> bool {
        let is_on = self.settings.features.passive_safety;
        let people = self.people_near(wanted);
        !is_on || self.safety_from(people).stops_in_time(&self.towards(wanted))
    }

    /// As [`Self::towards`], but slower on the same arc where that would break passive safety; braking where no speed is safe.
    pub fn safe_towards(&self, wanted: &Twist) -> Twist {
        let slower = |share: f64| Twist::new(share * wanted.linear, share * wanted.angular);
        let mut tried = SAFE_SHARES.map(slower).into_iter();
        let safe = tried.find(|slower| self.is_safe_towards(slower));
        safe.map_or_else(|| self.brake(), |safe| self.towards(&safe))
    }

    /// Whether the lidar sees all that the robot newly enters if it drives towards a velocity and brakes from the next decision
    /// on.
    pub fn is_path_visible(&self, wanted: &Twist) -> bool {
        if self.settings.may_enter_unseen {
            return true;
        }
        let RobotModel { footprint, limits } = self.robot;
        let period_s = self.tick.period_s();
        // A slow robot stops within less than what its own outline hides.
        let probed_s = (PROBED_M / wanted.linear.abs()).min(MAX_PROBED_S);
        let probe = self.now.pose.after(wanted, probed_s);
        if wanted.linear != 0.0
            && !self.visible.is_path_visible(footprint, &self.visible.pose, &probe)
        {
            return false;
        }
        let (pose, twist) = limits.advance(&self.now.pose, &self.now.twist, wanted, period_s);
        for (pose, twist) in limits.braking(pose, twist, period_s) {
            if !self.visible.is_path_visible(footprint, &self.visible.pose, &pose) {
                return false;
            }
            if twist == Twist::STOP {
                return true;
            }
        }
        false
    }

    /// The limits of the base, without reversing where the lidar does not see behind the robot.
    pub fn limits_in_sight(&self) -> Limits {
        let limits = self.robot.limits;
        let backwards = Twist::new(limits.min_vel_x.min(0.0), 0.0);
        if backwards == Twist::STOP || self.is_path_visible(&backwards) {
            return limits;
        }
        Limits { min_vel_x: 0.0, ..limits }
    }

    /// Whether the robot stands so near to an obstacle at its side that only the slim cover has room there.
    pub fn is_beside_obstacle(&self) -> bool {
        let room_m = |cover: &Footprint| self.field.clearance_m(cover, &self.now.pose);
        // Once there, until the usual cover keeps its whole margin: the covers and the resolutions of the window do not alternate.
        let needed_m = self.inflated.needed_room_m(self.is_narrow);
        let has_slim_room = |usual_m: f64| {
            let least_m = self.inflated.needed_room_m(false);
            room_m(self.slim).is_some_and(|slim_m| slim_m > usual_m && slim_m >= least_m)
        };
        self.settings.features.narrow_passages
            && room_m(&self.robot.footprint)
                .is_some_and(|usual_m| usual_m < needed_m && has_slim_room(usual_m))
    }

    /// Whether the robot could move straight to a point, as far as the local window shows: a disc that needs as much room as the
    /// footprint with its margin, and in a narrow passage the body that heads there. Without the margin the robot would head for a
    /// target that it cannot drive to.
    pub fn is_straight_clear_to(&self, point: &Point) -> bool {
        let from = self.now.pose.position();
        let (body, yaw) = if self.is_narrow {
            (Cow::Borrowed(&self.inflated.footprint), bearing(&from, point))
        } else {
            let room_m = self.robot.footprint.passing_radius_m() + self.inflated.padding_m();
            let Ok(disc) = Footprint::round(room_m) else {
                return false;
            };
            (Cow::Owned(disc), 0.0)
        };
        let line = point - from;
        let length_m = line.norm();
        // A pose or a point far outside the map has no line of sight, and no line so long may be walked along.
        if length_m > MAX_LINE_M || length_m.is_nan() {
            return false;
        }
        let steps = (length_m / LINE_STEP_M).ceil();
        (1..=steps as u32).all(|step| {
            let point = from + line * (f64::from(step) / steps);
            let clearance_m = self.field.clearance_m(&body, &Pose::new(point.x, point.y, yaw));
            clearance_m.is_none_or(|clearance_m| clearance_m > 0.0)
        })
    }

    /// A decision to brake.
    pub fn stand(&self, mode: Mode) -> Decision {
        Decision::new(self.brake(), mode, self.goal.position)
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_state::{PERIOD_S, standing_at, with_state};
    use super::*;
    use crate::map::{GridFrame, ObstacleGrid};

    const LAG_S: f64 = 0.15;

    /// A base at 1 m/s whose motors follow the command with a lag of 0.15 s. Returns the distance to a standstill, metres, when
    /// each command is computed from the measured speed and the last command.
    fn braking_distance_m(next_command: impl Fn(f64, f64) -> f64) -> f64 {
        let (mut speed, mut command, mut distance_m) = (1.0, 1.0, 0.0);
        for _ in 0..100 {
            command = next_command(speed, command);
            for _ in 0..100 {
                speed += (command - speed) * 0.001 / LAG_S;
                distance_m += speed * 0.001;
            }
        }
        assert!(speed.abs() < 1e-6, "{speed}");
        distance_m
    }

    #[test]
    fn braking_distance_with_motor_lag_is_that_of_the_full_deceleration() {
        let limits = Limits { decel_lim_x: -1.0, ..Limits::default() };
        let ideal_m = braking_distance_m(|_, command| (command - PERIOD_S).max(0.0));
        let braked_m = braking_distance_m(|speed, command| {
            let (pose, twist) = (&Pose::default(), &Twist::new(speed, 0.0));
            let measured = Measured { time_s: 0.0, odometry_s: 0.0, scan_s: 0.0, pose, twist };
            let last = Twist::new(command, 0.0);
            let mut in_flight = CommandsInFlight::default();
            in_flight.record(-PERIOD_S, &last);
            let now = PredictedState::new(&measured, &[], &in_flight, &limits, 0.08);
            brake(&limits, &now.twist, &last, PERIOD_S).linear
        });
        assert!((braked_m / ideal_m - 1.0).abs() < 0.1, "{braked_m} m, ideally {ideal_m} m");
    }

    /// Commands of 0.1 m/s more at each tick, on a base that reacts after two and a half ticks.
    #[test]
    fn prediction_plays_the_commands_in_flight_from_the_time_of_the_measurement() {
        let limits = Limits::default();
        let mut in_flight = CommandsInFlight::default();
        for tick in 0..10 {
            in_flight.record(PERIOD_S * f64::from(tick), &Twist::new(0.1 * f64::from(tick), 0.0));
        }
        let (delay_s, time_s) = (0.25, 1.0);
        let speed_at = |time_s: f64| (time_s - delay_s).max(0.0);
        for age_s in [0.0, 0.15] {
            let odometry_s = time_s - age_s;
            let twist = &Twist::new(speed_at(odometry_s), 0.0);
            let pose = &Pose::default();
            let measured = Measured { time_s, odometry_s, scan_s: time_s, pose, twist };
            let now = PredictedState::new(&measured, &[], &in_flight, &limits, delay_s);
            // The last command is that of the tick before.
            assert!((now.twist.linear - 0.9).abs() < 0.011, "{age_s}: {now:?}");
            let distance_m = (0.9 * 0.9 - twist.linear * twist.linear) / 2.0 + 0.05 * 0.9;
            assert!((now.pose.x - distance_m).abs() < 0.05, "{age_s}: {now:?} {distance_m}");
        }
    }

    /// The speed that is left of a slow command. The robot has a measured and a predicted speed, and a person at a distance.
    fn without_creep(
        settings: &NavigatorSettings,
        command: f64,
        (measured, predicted): (f64, f64),
        person_m: f64,
    ) -> f64 {
        let footprint = Footprint::round(0.3).expect("a radius");
        let robot = RobotModel { footprint, limits: Limits::default() };
        let frame = GridFrame::new(100, 100, 0.1, Pose::new(-5.0, -5.0, 0.0)).expect("a size");
        let ground = ObstacleGrid::filled(frame, false);
        let person = MovingDisc { x: 0.6 + person_m, y: 0.0, radius: 0.3, vx: 0.0, vy: 0.0 };
        let twist = Twist::new(predicted, 0.0);
        let now = PredictedState { twist, may_come: vec![person], ..standing_at(Pose::default()) };
        let command = Twist::new(command, 0.0);
        let motion = (Twist::new(measured, 0.0), command);
        with_state(settings, &robot, &ground, &now, motion, |state| {
            state.without_creep(command).linear
        })
    }

    #[test]
    fn robot_that_slows_down_next_to_a_person_stands_instead_of_creeping() {
        let mut settings = NavigatorSettings::default();
        let slowing = (0.1, 0.1);
        assert_eq!(without_creep(&settings, 0.05, slowing, 1.9), 0.0);
        assert_eq!(without_creep(&settings, 0.06, slowing, 1.9), 0.06, "not a creep");
        assert_eq!(without_creep(&settings, 0.05, slowing, 2.1), 0.05, "no person is near");
        assert_eq!(without_creep(&settings, 0.05, (0.0, 0.0), 1.9), 0.05, "it starts");
        assert_eq!(without_creep(&settings, 0.05, (0.1, 0.0), 1.9), 0.0, "it still brakes");
        settings.features.passive_safety = false;
        assert_eq!(without_creep(&settings, 0.05, slowing, 1.9), 0.05, "the feature is off");
    }

    #[test]
    fn brake_starts_from_the_slower_of_motion_and_last_command() {
        let limits = Limits::default();
        let from = |predicted: f64, last: f64| {
            brake(&limits, &Twist::new(predicted, 0.0), &Twist::new(last, 0.0), PERIOD_S).linear
        };
        assert!((from(0.9, 0.6) - 0.5).abs() < 1e-12, "a base that lags behind a braking command");
        assert!((from(0.3, 0.6) - 0.2).abs() < 1e-12, "a base that still accelerates");
        assert!((from(-0.3, -0.6) + 0.2).abs() < 1e-12, "in reverse");
        assert_eq!(from(0.3, -0.1), 0.0, "a reversal passes through zero");
    }
}
