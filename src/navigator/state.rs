//! The state of the navigator at a tick: robot, obstacles and path.

use std::borrow::Cow;
use std::sync::Arc;

use super::inflated_bodies::InflatedBodies;
use super::oncoming::PathKind;
use super::passive_safety::PassiveSafety;
use super::predicted_state::{PredictedState, brake};
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

/// A robot farther than this from its path is beside it in front of a narrow passage, metres.
const ASIDE_M: f64 = 0.2;

/// The least lookahead on a path through a narrow passage, metres: the path turns in front of the passage, and a robot that cuts this
/// corner has no room to turn there.
const NARROW_LOOKAHEAD_M: f64 = 0.1;

/// Lookahead past a person who comes, metres: with a longer one, the robot would cut across where the person walks.
const ASIDE_LOOKAHEAD_M: f64 = 1.2;

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
    /// Distance along the path to that passage, metres; `None` if the path has none here.
    pub to_narrow_m: Option<f64>,
    pub path_kind: PathKind,
    /// Time since an obstacle has been on the path ahead, seconds; `None` without one.
    pub blocked_s: Option<f64>,
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
    /// Follows a route: selects its key node to drive to, unless the robot already turns to one.
    pub fn follow(&mut self, route: &'a Route, turning_to: Option<Point>) {
        let Self { settings, now, .. } = *self;
        let in_sight = |node: &Point| self.is_straight_clear_to(node);
        let (usual_m, farthest_m) = (settings.min_lookahead_m, settings.lookahead_m);
        let nearest_m = self.to_narrow_m.map_or(usual_m, |_| usual_m.min(NARROW_LOOKAHEAD_M));
        // A robot beside its path would enter a passage obliquely, and touch its sides: it first drives to the path in front of it.
        let entered_obliquely_m =
            self.to_narrow_m.filter(|to_m| *to_m > 0.0 && self.off_path_m > ASIDE_M);
        let farthest_m = entered_obliquely_m.map_or(farthest_m, |to_m| {
            farthest_m.min((to_m - settings.key_node_spacing_m).max(nearest_m))
        });
        let farthest_m = if self.is_past_people() {
            farthest_m.min(ASIDE_LOOKAHEAD_M).max(nearest_m)
        } else {
            farthest_m
        };
        let target = turning_to.unwrap_or_else(|| route.key_node(nearest_m, farthest_m, in_sight));
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

    /// Whether the path leads past people who come along the roadway.
    pub fn is_past_people(&self) -> bool {
        self.path_kind == PathKind::PastPeople
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

    /// Distance to the local target, metres.
    pub fn to_target_m(&self) -> f64 {
        (self.now.pose.position() - self.local_target).norm()
    }

    /// Whether the measured position is within the tolerance of the goal.
    pub fn is_near_goal(&self) -> bool {
        let left_m = (self.goal.position - self.visible.pose.position()).norm();
        left_m <= self.settings.xy_goal_tolerance
    }

    /// Angle from the measured yaw to that of the goal, radians; `None` within the tolerance, or for a goal without a yaw.
    pub fn turn_left_rad(&self) -> Option<f64> {
        let left_rad = self.goal.yaw.map(|yaw| wrap_angle(yaw - self.visible.pose.yaw));
        left_rad.filter(|left_rad| left_rad.abs() > self.settings.yaw_goal_tolerance)
    }

    /// A decision to brake.
    pub fn stand(&self, mode: Mode) -> Decision {
        Decision::new(self.brake(), mode, self.goal.position)
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_state::{standing_at, with_state};
    use super::*;
    use crate::map::{GridFrame, ObstacleGrid};

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
    fn robot_on_a_path_through_a_narrow_passage_drives_to_the_next_key_node() {
        let settings = NavigatorSettings { min_lookahead_m: 0.7, ..NavigatorSettings::default() };
        let footprint = Footprint::round(0.3).expect("a radius");
        let robot = RobotModel { footprint, limits: Limits::default() };
        let frame = GridFrame::new(100, 100, 0.1, Pose::new(-5.0, -5.0, 0.0)).expect("a size");
        // No key node is in sight.
        let ground = ObstacleGrid::filled(frame, true);
        let now = standing_at(Pose::default());
        let target_m = |to_narrow_m: Option<f64>| {
            with_state(&settings, &robot, &ground, &now, Default::default(), |state| {
                state.to_narrow_m = to_narrow_m;
                state.follow(state.route, None);
                state.local_target.x
            })
        };
        assert_eq!((target_m(None), target_m(Some(1.0))), (1.0, 0.5));
    }

    #[test]
    fn robot_beside_its_path_drives_to_it_in_front_of_a_narrow_passage() {
        let settings = NavigatorSettings::default();
        let footprint = Footprint::round(0.3).expect("a radius");
        let robot = RobotModel { footprint, limits: Limits::default() };
        let frame = GridFrame::new(100, 100, 0.1, Pose::new(-5.0, -5.0, 0.0)).expect("a size");
        let ground = ObstacleGrid::filled(frame, false);
        let now = standing_at(Pose::default());
        let target_m = |off_path_m: f64, to_narrow_m: Option<f64>| {
            with_state(&settings, &robot, &ground, &now, Default::default(), |state| {
                (state.off_path_m, state.to_narrow_m) = (off_path_m, to_narrow_m);
                state.follow(state.route, None);
                state.local_target.x
            })
        };
        assert_eq!(target_m(0.3, None), 3.0, "no passage");
        assert_eq!(target_m(0.1, Some(2.0)), 3.0, "on the path");
        assert_eq!(target_m(0.3, Some(2.0)), 1.5);
        assert_eq!(target_m(0.3, Some(0.0)), 3.0, "in the passage");
        // It turns to a key node already.
        with_state(&settings, &robot, &ground, &now, Default::default(), |state| {
            let turning_to = Point::new(1.0, 0.0);
            state.follow(state.route, Some(turning_to));
            assert_eq!(state.local_target, turning_to);
        });
    }
}
