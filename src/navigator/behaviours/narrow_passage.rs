//! Drives the narrow stretches of a path: lines up in front of one, and holds its line.
//!
//! The dynamic window keeps discs clear that are wider than the body, and drives forwards only. Here the body itself counts, by
//! the exact distances to the occupied cells.

use core::f64::consts::PI;

use super::super::exact_clearance::ExactClearance;
use super::super::route::ConditionTimer;
use super::super::state::State;
use super::super::{Decision, Fault, Goal, Mode, NavigatorSettings};
use super::goal_handling::{is_clear, moving_or_zero};
use super::parking::{Motion, Parking};
use super::rotate_in_place::clear_rotation;
use super::{Behaviour, Override, Proposal};
use crate::geometry::{Point, Pose, Twist, bearing, wrap_angle};
use crate::global::{NarrowStretch, Travel};

/// The robot lines up from this distance to the begin of a stretch on, along the path, metres; from the second one after it was
/// blocked there.
const LINE_UP_FROM_M: f64 = 0.5;
const LINE_UP_AGAIN_FROM_M: f64 = 0.15;
/// Time for which lining up may be blocked, seconds. Then the robot drives nearer by its path.
const BLOCKED_S: f64 = 1.0;
/// A robot is lined up within this distance of the line, metres, and this angle, radians.
const ALIGNED_M: f64 = 0.02;
const ALIGNED_RAD: f64 = 0.04;
/// Tolerances of lining up, metres and radians.
const LINE_UP_M: f64 = 0.015;
const LINE_UP_RAD: f64 = 0.015;
/// A robot without room to line up drives the stretch up to this angle off it, radians; else it turns first.
const MAX_OFF_RAD: f64 = 0.3;
/// A stretch ends this far before its end, metres.
const END_M: f64 = 0.02;
/// A robot this far before the end of a stretch that it has driven drives it again, metres.
const AGAIN_M: f64 = 0.3;
/// Distance within which the robot steers back to the line, metres, and turn rate for each radian off, 1/s.
const STEER_WITHIN_M: f64 = 0.4;
const RATE_PER_RAD: f64 = 2.0;
/// Least distance to static obstacles, metres: what a robot at the edge of [`ALIGNED_M`] keeps of the margin of the path. It
/// covers an error of the pose of two centimetres, and the motion between two steps. A robot that is nearer comes no nearer.
const MIN_GAP_M: f64 = 0.03;
/// A robot that is nearer than this stands, metres: it can only escape.
const LEAST_GAP_M: f64 = 0.015;
/// Time and time step of the collision check, seconds: longer than the robot takes to stop from the passing speed, even if it
/// brakes at half its limit and with a lag.
const HORIZON_S: f64 = 1.0;
const STEP_S: f64 = 0.1;
/// Speed for each metre left to a stop, 1/s, and least speed, m/s.
const SPEED_PER_M: f64 = 1.5;
const LEAST_SPEED: f64 = 0.05;
/// Tried shares of the speed.
const SHARES: [f64; 4] = [1.0, 0.5, 0.25, 0.15];

/// A narrow stretch in the map frame.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Line {
    from: Point,
    to: Point,
    travel: Travel,
    /// Whether the robot stops at its end.
    stops: bool,
}

/// A pose relative to a line.
#[derive(Clone, Copy, Debug)]
struct Offset {
    /// Distance left along the line, metres.
    left_m: f64,
    /// Distance from the line to the left of the robot's heading on it, metres.
    aside_m: f64,
    /// Turn that aligns the robot, radians.
    turn: f64,
}

impl Line {
    fn heading(&self) -> f64 {
        let along = bearing(&self.from, &self.to);
        match self.travel {
            Travel::Forward => along,
            Travel::Backward => wrap_angle(along + PI),
        }
    }

    /// One forwards, minus one backwards.
    const fn sign(&self) -> f64 {
        match self.travel {
            Travel::Forward => 1.0,
            Travel::Backward => -1.0,
        }
    }

    fn offset(&self, pose: &Pose) -> Offset {
        let heading = self.heading();
        let to = Pose::new(self.to.x, self.to.y, heading);
        let at = to.inverse_transform(&pose.position());
        Offset { left_m: -self.sign() * at.x, aside_m: at.y, turn: wrap_angle(heading - pose.yaw) }
    }
}

/// Drives narrow stretches.
#[derive(Debug, Default)]
pub(super) struct NarrowPassage {
    /// The stretch that the robot lines up for or drives.
    line: Option<Line>,
    /// The last stretch that it has driven.
    driven: Option<Line>,
    parking: Parking,
    is_lined_up: bool,
    blocked: ConditionTimer,
    was_blocked: bool,
}

impl Behaviour for NarrowPassage {
    fn propose(&mut self, state: &State<'_>) -> Result<Option<Proposal>, Fault> {
        if state.route.narrow.is_empty() {
            *self = Self::default();
            return Ok(None);
        }
        let Some(line) = self.next_line(state) else {
            self.begin(None);
            return Ok(None);
        };
        if self.line != Some(line) {
            self.begin(Some(line));
        }
        let offset = line.offset(&state.now.pose);
        if self.is_lined_up && offset.left_m <= END_M && has_ended(&line, state) {
            self.driven = Some(line);
            self.begin(None);
            return self.propose(state);
        }
        let decision = if self.is_lined_up || self.lines_up(&line, &offset, state) {
            Some(drive(&line, &offset, state))
        } else {
            self.line_up(&line, &offset, state)
        };
        Ok(decision.map(|decision| Proposal::Decide(decision, Override::ByEvasion)))
    }
}

impl NarrowPassage {
    fn begin(&mut self, line: Option<Line>) {
        if line.is_some() || self.line.is_some() {
            *self = Self { line, driven: self.driven, ..Self::default() };
        }
    }

    /// The stretch that the robot drives, or the next one if it is near.
    fn next_line(&self, state: &State<'_>) -> Option<Line> {
        let route = state.route;
        let line = |index: usize| {
            let stretch = &route.narrow[index];
            let next = route.narrow.get(index + 1);
            let is_followed = next.is_some_and(|next: &NarrowStretch| next.from_m <= stretch.to_m);
            Line {
                from: route.path.point_at(stretch.from_m),
                to: route.path.point_at(stretch.to_m),
                travel: stretch.travel,
                stops: is_followed || stretch.travel == Travel::Backward,
            }
        };
        let lines = (0..route.narrow.len()).map(line);
        if let Some(begun) = self.line.filter(|_| self.is_lined_up)
            && lines.clone().any(|line| line == begun)
        {
            return Some(begun);
        }
        let after = lines
            .clone()
            .position(|line| self.driven == Some(line))
            .filter(|&index| route.narrow[index].to_m - route.progress_m < AGAIN_M);
        let first = after.map_or(0, |index| index + 1);
        let within_m = if self.was_blocked { LINE_UP_AGAIN_FROM_M } else { LINE_UP_FROM_M };
        let is_ahead = |index: &usize| route.narrow[*index].to_m > route.progress_m;
        let index = (first..route.narrow.len()).find(is_ahead)?;
        (route.narrow[index].from_m - route.progress_m <= within_m).then(|| line(index))
    }

    /// Whether the robot may drive a stretch: it is lined up, or has no room to do more.
    fn lines_up(&mut self, line: &Line, offset: &Offset, state: &State<'_>) -> bool {
        let is_aligned = offset.aside_m.abs() <= ALIGNED_M && offset.turn.abs() <= ALIGNED_RAD;
        let is_near = offset.turn.abs() <= MAX_OFF_RAD;
        let before_m = offset.left_m - (line.to - line.from).norm();
        self.is_lined_up = is_aligned && before_m.abs() <= LINE_UP_FROM_M
            || is_near && before_m <= LINE_UP_AGAIN_FROM_M && !has_room_to_turn(state);
        self.is_lined_up
    }

    /// Drives to the begin of a stretch, and turns to its heading. `None` where that is blocked.
    fn line_up(&mut self, line: &Line, offset: &Offset, state: &State<'_>) -> Option<Decision> {
        let stand = state.stand(Mode::Parking);
        if !has_room_to_turn(state) && offset.left_m < (line.to - line.from).norm() {
            // A turn within a passage: the robot stays where it is.
            let turn = clear_rotation(state, offset.turn)?;
            let command =
                state.safe_towards(&super::rotate_in_place::rotation(turn, &state.robot.limits));
            return Some(Decision { command, mode: Mode::Rotating, ..stand });
        }
        let settings = NavigatorSettings {
            xy_parking_tolerance: LINE_UP_M,
            yaw_parking_tolerance: LINE_UP_RAD,
            ..state.settings.clone()
        };
        let now = state.now;
        let motion = Motion {
            time_s: now.time_s,
            pose: &now.pose,
            twist: &now.twist,
            measured: state.measured,
            sent: state.last_command,
        };
        let goal = Goal { position: line.from, yaw: Some(line.heading()) };
        let limits = state.limits_in_sight();
        let Some(wanted) = self.parking.next(motion, &goal, (&settings, &limits, state.period_s))
        else {
            self.is_lined_up = true;
            return Some(drive(line, offset, state));
        };
        let command = moving_or_zero(&wanted, state);
        let is_clear = is_clear(&command, state);
        if self.blocked.update(now.time_s, !is_clear) >= BLOCKED_S {
            *self = Self { was_blocked: true, driven: self.driven, ..Self::default() };
            return None;
        }
        Some(if is_clear { Decision { command, ..stand } } else { stand })
    }
}

/// Whether a robot at the end of a stretch may go on: it stands, where it has to stop.
fn has_ended(line: &Line, state: &State<'_>) -> bool {
    !line.stops || state.now.twist.linear.abs() < LEAST_SPEED
}

/// Whether the robot can turn to any heading where it is.
fn has_room_to_turn(state: &State<'_>) -> bool {
    let radius_m = state.robot.footprint.body_radius_m();
    let place = state.now.pose.position();
    let clearance = ExactClearance::new(state.field, &place, radius_m + MIN_GAP_M);
    clearance.gap_to_point_m(&place) >= radius_m + MIN_GAP_M
}

/// Drives along a line; stands where the body has no room.
fn drive(line: &Line, offset: &Offset, state: &State<'_>) -> Decision {
    let limits = &state.robot.limits;
    let mut speed = state.settings.passing_speed;
    if line.stops {
        let left_m = (offset.left_m - END_M / 2.0).max(0.0);
        speed = speed.min(SPEED_PER_M * left_m).max(LEAST_SPEED);
        if offset.left_m <= END_M {
            speed = 0.0;
        }
    }
    let back = -libm::atan(offset.aside_m / STEER_WITHIN_M) * line.sign();
    let rate = RATE_PER_RAD * (offset.turn + back);
    let footprint = &state.robot.footprint;
    let pose = &state.now.pose;
    let reach_m = footprint.body_radius_m() + 2.0 * HORIZON_S * state.settings.passing_speed;
    let clearance = ExactClearance::new(state.field, &pose.position(), reach_m);
    let least_m = MIN_GAP_M.min(clearance.gap_m(footprint, pose)).max(LEAST_GAP_M);
    let wanted = SHARES.into_iter().flat_map(|share| {
        [rate, 0.5 * rate, 0.0].map(|rate| Twist::new(line.sign() * share * speed, rate))
    });
    let is_admissible = |wanted: &Twist| {
        stays_clear(wanted, &clearance, least_m, state) && state.is_safe_towards(wanted)
    };
    let command = wanted.map(|wanted| limits.clamp(&wanted)).find(is_admissible);
    let (command, mode) = match command {
        Some(wanted) => (state.towards(&wanted), Mode::Driving),
        None => (state.brake(), Mode::Blocked),
    };
    Decision::new(command, mode, line.to)
}

/// Whether a robot that drives towards a velocity keeps a distance to static obstacles, metres, and touches no moving one within
/// the horizon. It goes on meanwhile: how well the base brakes, and how late the next decision is, does not matter.
fn stays_clear(
    wanted: &Twist,
    clearance: &ExactClearance,
    least_m: f64,
    state: &State<'_>,
) -> bool {
    let (limits, footprint) = (&state.robot.limits, &state.robot.footprint);
    let (mut pose, mut twist) = (state.now.pose, state.now.twist);
    (1..=(HORIZON_S / STEP_S) as u32).all(|step| {
        (pose, twist) = limits.advance(&pose, &twist, wanted, STEP_S);
        // A moving obstacle may go on, or stop where it is.
        clearance.gap_m(footprint, &pose) >= least_m
            && state.inflated.is_clear_of_moving(&pose, 0.0)
            && state.inflated.is_clear_of_moving(&pose, f64::from(step) * STEP_S)
    })
}

#[cfg(test)]
mod tests {
    use super::super::super::RobotModel;
    use super::super::super::test_state::{standing_at, with_state};
    use super::*;
    use crate::map::{Cell, GridFrame, ObstacleGrid};
    use crate::robot::{Footprint, Limits, Polygon};

    /// The result of a call with the state of a robot 0.7 m long and 0.5 m wide, its centre at the origin, that drives along x at
    /// this speed, m/s, among obstacles in the cells that a rule selects by their centre.
    fn among<R>(
        speed: f64,
        is_blocked: impl Fn(&Point) -> bool,
        call: impl FnOnce(&State<'_>) -> R,
    ) -> R {
        let settings = NavigatorSettings { may_enter_unseen: true, ..NavigatorSettings::default() };
        let body = Polygon::rectangle(0.7, 0.5).expect("a rectangle");
        let robot = RobotModel { footprint: Footprint::covering(body), limits: Limits::default() };
        let frame = GridFrame::new(550, 300, 0.01, Pose::new(-1.5, -1.5, 0.0)).expect("a size");
        let cells =
            (0..frame.len()).map(|index| is_blocked(&frame.center_of(frame.cell_at(index))));
        let ground = ObstacleGrid::new(frame, cells.collect());
        let twist = Twist::new(speed, 0.0);
        let mut now = standing_at(Pose::default());
        now.twist = twist;
        with_state(&settings, &robot, &ground, &now, (twist, twist), call)
    }

    /// The decision of a robot that stands on its line, with a wall on its left at this gap, metres.
    fn beside_a_wall(gap_m: f64) -> Decision {
        let (from, to) = (Point::new(-1.0, 0.0), Point::new(1.5, 0.0));
        let line = Line { from, to, travel: Travel::Forward, stops: false };
        let is_wall = |at: &Point| (0.25 + gap_m..1.0).contains(&at.y);
        among(0.0, is_wall, |state| drive(&line, &line.offset(&state.now.pose), state))
    }

    /// The gap is 0.04, 0.02 and 0.01 m: beyond what it keeps, less than that, less than what a moving robot needs.
    #[test]
    fn robot_with_less_room_than_the_least_gap_stands() {
        for (gap_m, mode) in [(0.04, Mode::Driving), (0.02, Mode::Driving), (0.01, Mode::Blocked)] {
            let decision = beside_a_wall(gap_m);
            assert_eq!(decision.mode, mode, "{gap_m}");
            assert_eq!(decision.command.linear > 0.0, mode == Mode::Driving, "{gap_m}");
        }
    }

    /// At 0.3 m/s it drives 0.3 m, and keeps 0.03 m.
    #[test]
    fn motion_is_clear_where_a_whole_second_of_it_is() {
        let is_clear = |speed: f64, before_m: f64| {
            let is_wall = |at: &Point| (0.35 + before_m..0.8 + before_m).contains(&at.x);
            among(speed, is_wall, |state| {
                let clearance = ExactClearance::new(state.field, &Point::default(), 1.5);
                stays_clear(&Twist::new(speed, 0.0), &clearance, MIN_GAP_M, state)
            })
        };
        assert!(is_clear(0.3, 0.34) && !is_clear(0.3, 0.31));
        assert!(is_clear(0.1, 0.14) && !is_clear(0.1, 0.11));
    }
}
