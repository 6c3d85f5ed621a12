//! Escapes from a place where the robot is stuck.
//!
//! The dynamic window admits a velocity if the robot can stop within its clearance (eq. 30). Next to a wall there is no
//! clearance, and the robot could only creep. Here a motion is admissible if it comes no nearer to an obstacle than the
//! robot is already, by the exact distance to every occupied cell nearby. The robot moves slowly, to more clearance and back
//! towards where it came from.

use super::super::condition_timer::ConditionTimer;
use super::super::exact_clearance::ExactClearance;
use super::super::state::State;
use super::super::{Decision, Fault, Mode};
use super::{Behaviour, Override, Proposal, forward_escape};
use crate::geometry::{Point, Pose, Twist};

/// Duration of the first attempt, seconds. Each further one lasts twice as long, up to this many doublings.
const FIRST_ATTEMPT_S: f64 = 2.0;
const MAX_DOUBLINGS: u32 = 3;
/// A robot without progress for this many times the patience escapes too, even if it moves.
const WIGGLING_PATIENCES: f64 = 3.0;
/// A robot that waits for people escapes after this many times the patience: two who wait for each other would stand for long.
const PEOPLE_PATIENCES: f64 = 2.0;
/// Time between two attempts, in patiences: the path found after the first gets its chance.
const PAUSE_PATIENCES: f64 = 2.0;
/// A robot below this speed, m/s, and this share of its highest one that does not rotate is held up.
const CREEPING: (f64, f64) = (0.05, 0.25);
/// A robot whose target comes nearer by at least this, m/s, or this share of its highest speed does not wiggle.
const APPROACHING: (f64, f64) = (0.1, 0.5);
/// A robot below this turn rate does not rotate, rad/s.
const TURNING: f64 = 0.05;
/// Time and time step of the prediction, seconds.
const HORIZON_S: f64 = 1.5;
const STEP_S: f64 = 0.1;
/// Obstacles within this distance of the robot's circle count, metres.
pub(super) const RANGE_M: f64 = 0.5;
/// The robot approaches nothing to less than this, metres, or the safety margin if that is less: it must be able to leave each
/// place that it drives into. It does not approach at all what is nearer already.
const MIN_GAP_M: f64 = 0.04;
/// A robot within this gap, metres, or within the safety margin if that is less, only moves to a larger one, by this at least: along
/// a wall it would come nearer by its slip and the error of its pose, a little in each attempt, until it touches.
const LEAVES_WITHIN_M: f64 = 0.02;
const LEAVES_BY_M: f64 = 0.005;
/// The same as [`MIN_GAP_M`] for moving obstacles, metres.
const MIN_MOVING_GAP_M: f64 = 0.1;
/// More clearance than this has no further value, metres.
pub(super) const ENOUGH_GAP_M: f64 = 0.25;
/// Clearance that is worth as much as one metre nearer to where the robot came from, metres.
pub(super) const RETURN_WEIGHT: f64 = 0.3;
/// Clearance that is worth as much as going on with the last motion, metres. Else noise would choose between equal ones at each tick.
const KEEP_WEIGHT: f64 = 0.02;
/// Tried shares of the escape speed, and turn rates, rad/s.
const SPEEDS: [f64; 5] = [-1.0, -0.5, 0.0, 0.5, 1.0];
const TURN_RATES: [f64; 7] = [0.0, 0.2, -0.2, 0.4, -0.4, 0.8, -0.8];
/// Wide arcs, by curvature, 1/m, as far as this, metres. A robot that stands along a wall leaves it only so: its corners come nearer
/// before it leads away.
const WIDE_ARCS: [f64; 4] = [0.1, -0.1, 0.2, -0.2];
const WIDE_ARC_M: f64 = 1.5;

/// Leaves a place where the robot is held up; each attempt lasts longer until there is progress.
#[derive(Default)]
pub(super) struct Escape {
    breadcrumbs: Breadcrumbs,
    held_up: ConditionTimer,
    /// Time since the last progress for which the robot rotated, seconds.
    rotated_s: f64,
    attempts: u32,
    /// The motion of this attempt at the last tick, if there was one.
    last: Option<Twist>,
    /// End of the last attempt, and earliest begin of the next one, seconds.
    until_s: Option<f64>,
    next_s: Option<f64>,
}

impl Behaviour for Escape {
    fn propose(&mut self, state: &State<'_>) -> Result<Option<Proposal>, Fault> {
        if self.until_s.is_none_or(|until_s| state.now.time_s >= until_s) {
            self.last = None;
            return Ok(None);
        }
        let pose = &state.now.pose;
        let came_from = self.breadcrumbs.behind(&pose.position());
        // Next to people, one that sees nothing behind it cannot wait until it does: it turns to where there is room.
        let has_people = state.waits_for_people();
        let limits = if has_people { state.limits_in_sight() } else { state.robot.limits };
        let reverses = limits.min_vel_x < 0.0;
        let forwards = if reverses { None } else { forward_escape::motion(state, came_from) };
        // Straight back where the robot came from nowhere.
        let behind = came_from.unwrap_or_else(|| pose.transform(&Point::new(-1.0, 0.0)));
        // Every second attempt only looks for room: the way back has not helped, or there is none. People need that the robot goes back.
        let returns = !self.attempts.is_multiple_of(2) || has_people;
        let behind = returns.then_some(behind);
        let wanted = forwards.unwrap_or_else(|| best_motion(state, behind, self.last));
        self.last = Some(wanted);
        let command = state.towards(&wanted);
        let decision = Decision::new(command, Mode::Escaping, state.local_target);
        Ok(Some(Proposal::Decide(decision, Override::ByEvasion)))
    }
}

impl Escape {
    /// Updates the memory with the decision of the tick.
    pub fn observe(&mut self, state: &State<'_>, decision: &Decision) {
        if state.stuck_s == 0.0 {
            (self.attempts, self.rotated_s) = (0, 0.0);
        }
        match decision.mode {
            Mode::Escaping => self.breadcrumbs.forget_near(&state.now.pose.position()),
            Mode::Rotating if state.measured.angular.abs() >= TURNING => {
                self.held_up = ConditionTimer::default();
                self.rotated_s += state.tick.elapsed_s();
            }
            // The protective layer may forbid a rotation.
            Mode::Driving | Mode::Blocked | Mode::Rotating if state.settings.features.recovery => {
                self.drove(state);
            }
            _ => {}
        }
    }

    /// Starts an attempt where the robot was held up for longer than its patience.
    fn drove(&mut self, state: &State<'_>) {
        let now = state.now;
        let mut patience_s = state.stuck_patience_s();
        if state.waits_for_people() {
            patience_s *= PEOPLE_PATIENCES;
        }
        self.breadcrumbs.push(&now.pose.position());
        let slow = |(speed, share): (f64, f64)| speed.min(share * state.fastest);
        let comes_nearer = state.since_nearer_s < state.stuck_patience_s();
        // A robot that the protective layer slows is as fast as it may be: where the lidar does not see ahead, it only creeps.
        let is_slowed = state.is_slowed && comes_nearer;
        let creeps = now.twist.linear.abs() < slow(CREEPING) && !is_slowed;
        let held_up_s = self.held_up.update(now.time_s, creeps);
        // A robot that approaches its target again has what an escape is to bring.
        let towards = now.twist.linear * libm::cos(state.heading_error);
        let approaches = towards >= slow(APPROACHING) || comes_nearer;
        let stuck_s = state.stuck_s - self.rotated_s;
        let wiggles = stuck_s > WIGGLING_PATIENCES * patience_s && !approaches;
        let is_patient = held_up_s <= patience_s && !wiggles;
        if is_patient || self.next_s.is_some_and(|next_s| now.time_s < next_s) {
            return;
        }
        // Each attempt lasts longer than the one before, so that two robots that block each other separate in the end.
        let doublings = self.attempts.min(MAX_DOUBLINGS);
        self.attempts += 1;
        self.held_up = ConditionTimer::default();
        let until_s = now.time_s + FIRST_ATTEMPT_S * f64::from(1_u32 << doublings);
        self.until_s = Some(until_s);
        self.next_s = Some(until_s + PAUSE_PATIENCES * state.stuck_patience_s());
    }
}

/// Places that the robot passed, oldest first.
#[derive(Clone, Debug, Default)]
struct Breadcrumbs(Vec<Point>);

/// Distance between two breadcrumbs, metres.
const SPACING_M: f64 = 0.25;
/// The robot escapes to a breadcrumb at least this far away, metres.
const MIN_DISTANCE_M: f64 = 0.5;

impl Breadcrumbs {
    fn push(&mut self, robot: &Point) {
        let moved = |last: &Point| (robot - last).norm() >= SPACING_M;
        if self.0.last().is_none_or(moved) {
            self.0.push(*robot);
        }
    }

    /// The latest breadcrumb that is not near the robot.
    fn behind(&self, robot: &Point) -> Option<Point> {
        let is_near = |crumb: &&Point| (*robot - **crumb).norm() < MIN_DISTANCE_M;
        self.0.iter().rev().find(|crumb| !is_near(crumb)).copied()
    }

    /// Removes the latest breadcrumbs that are near the robot: it is back there.
    fn forget_near(&mut self, robot: &Point) {
        while self.0.pop_if(|last| (*robot - *last).norm() < MIN_DISTANCE_M).is_some() {}
    }
}

/// The gap to static obstacles that an escape keeps, metres, where the robot has this gap at present.
pub(super) fn least_gap_m(state: &State<'_>, present_m: f64) -> f64 {
    present_m.min(MIN_GAP_M).min(state.settings.safety_margin_m)
}

/// Whether a motion from one gap to static obstacles to another, metres, may be driven.
pub(super) fn leaves_if_near(state: &State<'_>, present_m: f64, end_m: f64) -> bool {
    let is_near = present_m < LEAVES_WITHIN_M.min(state.settings.safety_margin_m);
    !is_near || end_m >= present_m + LEAVES_BY_M
}

/// The slow motion with the best end, with much room or near to a place behind, if there is one; standing where none is admissible.
/// Standing is no candidate: a robot at the place with the best score would stand there for good, although another motion leads out.
fn best_motion(state: &State<'_>, behind: Option<Point>, last: Option<Twist>) -> Twist {
    let footprint = &state.robot.footprint;
    let reach_m = footprint.circumscribed_radius_m() + WIDE_ARC_M;
    let clearance = ExactClearance::new(state.field, &state.now.pose.position(), reach_m);
    let present_m = clearance.gap_m(footprint, &state.now.pose);
    let least_m = least_gap_m(state, present_m);
    let mut best = ((false, f64::NEG_INFINITY), Twist::STOP);
    for (wanted, horizon_s) in motions(state, behind.is_none()) {
        let Some(end) = end_of(state, (&wanted, horizon_s), &clearance, least_m) else {
            continue;
        };
        let gap_m = clearance.gap_m(footprint, &end).min(ENOUGH_GAP_M);
        if !leaves_if_near(state, present_m, gap_m) {
            continue;
        }
        // A turn on the spot that comes nearer to what is very near already leads nowhere, and the next tick turns back. A robot
        // that does not see where it came from would prefer it to every motion ahead.
        let leads_out = wanted.linear != 0.0 || gap_m >= present_m.min(MIN_GAP_M);
        let away_m = behind.map_or(0.0, |behind| (behind - end.position()).norm());
        let kept = if last == Some(wanted) { KEEP_WEIGHT } else { 0.0 };
        let score = (leads_out, gap_m + kept - RETURN_WEIGHT * away_m);
        if score > best.0 && state.is_safe_towards(&wanted) && state.is_path_visible(&wanted) {
            best = (score, wanted);
        }
    }
    best.1
}

/// The motions that are tried, with or without wide arcs, each with the time for which it is predicted, seconds.
fn motions(state: &State<'_>, has_wide: bool) -> impl Iterator<Item = (Twist, f64)> {
    let (limits, speed) = (state.robot.limits, state.settings.escape_speed);
    let tight = SPEEDS.into_iter().flat_map(move |share| {
        TURN_RATES.map(|rate| (limits.clamp(&Twist::new(share * speed, rate)), HORIZON_S))
    });
    let wide = [-speed, speed].into_iter().filter(move |_| has_wide).flat_map(move |wanted| {
        let linear = limits.clamp(&Twist::new(wanted, 0.0)).linear;
        WIDE_ARCS.map(|curvature| {
            let wanted = limits.clamp(&Twist::new(linear, curvature * linear));
            (wanted, WIDE_ARC_M / linear.abs())
        })
    });
    tight.chain(wide).filter(|(wanted, _)| *wanted != Twist::STOP)
}

/// The last pose of a motion that lasts for a time, seconds; `None` where the motion comes nearer to a static obstacle than this gap,
/// metres, or too near to a moving one.
fn end_of(
    state: &State<'_>,
    (wanted, horizon_s): (&Twist, f64),
    clearance: &ExactClearance,
    least_m: f64,
) -> Option<Pose> {
    let footprint = &state.robot.footprint;
    // An obstacle may go on, or stop where it is.
    let moving_gap_m = |pose: &Pose, time_s: f64| {
        let gaps_m = state.now.moving.iter().map(|disc| {
            let goes_on_m = footprint.gap_to_moving_m(pose, &disc.after(time_s));
            goes_on_m.min(footprint.gap_to_moving_m(pose, disc))
        });
        gaps_m.fold(f64::INFINITY, f64::min)
    };
    let (mut pose, mut twist) = (state.now.pose, state.now.twist);
    let least_moving_m = moving_gap_m(&pose, 0.0).min(MIN_MOVING_GAP_M);
    for step in 1..=(horizon_s / STEP_S) as u32 {
        (pose, twist) = state.robot.limits.advance(&pose, &twist, wanted, STEP_S);
        let moving_m = moving_gap_m(&pose, f64::from(step) * STEP_S);
        if !clearance.keeps_gap(footprint, &pose, least_m) || moving_m < least_moving_m {
            return None;
        }
    }
    Some(pose)
}

#[cfg(test)]
mod tests {
    use super::super::super::predicted_state::PredictedState;
    use super::super::super::test_state::{standing_at, with_state};
    use super::super::super::{NavigatorSettings, RobotModel};
    use super::*;
    use crate::map::{Cell, GridFrame, ObstacleGrid};
    use crate::robot::{Footprint, Limits, Polygon};

    /// The result of a call with the state of a robot 0.26 m before a wall, with this safety margin, metres.
    fn before_a_wall<R>(safety_margin_m: f64, call: impl FnOnce(&State<'_>) -> R) -> R {
        let limits = Limits { min_vel_x: -0.3, ..Limits::default() };
        near_a_wall(safety_margin_m, &Pose::new(-0.11, 0.0, 0.0), (0.7, 0.5), limits, call)
    }

    /// The same for a robot with this length and width, metres, at a pose near the wall, which begins at x = 0.5 m.
    fn near_a_wall<R>(
        safety_margin_m: f64,
        pose: &Pose,
        (length_m, width_m): (f64, f64),
        limits: Limits,
        call: impl FnOnce(&State<'_>) -> R,
    ) -> R {
        let settings = NavigatorSettings {
            safety_margin_m,
            may_enter_unseen: true,
            ..NavigatorSettings::default()
        };
        let body = Polygon::rectangle(length_m, width_m).expect("a rectangle");
        let robot = RobotModel { footprint: Footprint::covering(body), limits };
        let frame = GridFrame::new(200, 200, 0.05, Pose::new(-5.0, -5.0, 0.0)).expect("a size");
        let mut ground = ObstacleGrid::filled(frame, false);
        (0..200).for_each(|row| ground.set(Cell::new(110, row), true));
        let now = standing_at(*pose);
        with_state(&settings, &robot, &ground, &now, (Twist::STOP, Twist::STOP), |state| {
            call(state)
        })
    }

    /// It came from behind the wall, by another passage. Each motion leads away from there, or nearer to the wall.
    #[test]
    fn robot_at_the_place_with_the_best_score_moves_nevertheless() {
        let behind = Point::new(2.0, 0.0);
        let wanted = before_a_wall(0.05, |state| best_motion(state, Some(behind), None));
        assert_ne!(wanted, Twist::STOP);
    }

    /// It cannot go back to where it came from. A turn on the spot ends nearer to there than a motion ahead, with less clearance.
    #[test]
    fn robot_along_a_wall_drives_on_instead_of_turning_to_and_fro() {
        let along = Pose::new(0.214, 0.0, core::f64::consts::FRAC_PI_2);
        let (size_m, limits) = ((0.2, 0.5), Limits { min_vel_x: 0.0, ..Limits::default() });
        let behind = Point::new(0.214, -2.0);
        let motion = |state: &State<'_>| best_motion(state, Some(behind), None);
        let wanted = near_a_wall(0.01, &along, size_m, limits, motion);
        assert!(wanted.linear > 0.0, "{wanted:?}");
    }

    /// The wall is behind it, within its margin, and it has not moved yet: a turn towards either side would come nearer to the wall.
    #[test]
    fn robot_that_cannot_reverse_drives_away_from_a_wall_behind_it() {
        let facing_away = Pose::new(0.05, 0.0, core::f64::consts::PI);
        let limits = Limits { min_vel_x: 0.0, ..Limits::default() };
        let motion = |state: &State<'_>| forward_escape::motion(state, None);
        let wanted = near_a_wall(0.05, &facing_away, (0.7, 0.5), limits, motion);
        assert!(wanted.is_some_and(|wanted| wanted.linear > 0.0), "{wanted:?}");
    }

    /// It has made no progress for 10 s, three times its patience, and drives at this speed towards its target.
    #[test]
    fn robot_without_progress_escapes_unless_it_approaches_its_target() {
        let settings = NavigatorSettings::default();
        let footprint = Footprint::round(0.3).expect("a radius");
        let robot = RobotModel { footprint, limits: Limits::default() };
        let frame = GridFrame::new(200, 200, 0.05, Pose::new(-5.0, -5.0, 0.0)).expect("a size");
        let ground = ObstacleGrid::filled(frame, false);
        for (speed, heading_error, escapes) in
            [(0.3, 0.0, false), (0.07, 0.0, true), (0.3, 2.0, true)]
        {
            let twist = Twist::new(speed, 0.0);
            let now = PredictedState { twist, ..standing_at(Pose::default()) };
            let proposal = with_state(&settings, &robot, &ground, &now, (twist, twist), |state| {
                (state.stuck_s, state.heading_error) = (10.0, heading_error);
                let mut escape = Escape::default();
                let drives = Decision::new(twist, Mode::Driving, state.local_target);
                escape.observe(state, &drives);
                escape.propose(state).expect("no fault")
            });
            assert_eq!(proposal.is_some(), escapes, "{speed} m/s, {heading_error}");
        }
    }

    /// It drives where the lidar does not see ahead, and the protective layer slows it.
    #[test]
    fn robot_that_the_layer_slows_does_not_escape_while_it_comes_nearer() {
        let settings = NavigatorSettings::default();
        let footprint = Footprint::round(0.3).expect("a radius");
        let robot = RobotModel { footprint, limits: Limits::default() };
        let frame = GridFrame::new(200, 200, 0.05, Pose::new(-5.0, -5.0, 0.0)).expect("a size");
        let ground = ObstacleGrid::filled(frame, false);
        for (speed, since_nearer_s, is_slowed, escapes) in [
            (0.07, 2.0, true, false),
            (0.07, 4.0, true, true),
            (0.03, 2.0, true, false),
            (0.03, 2.0, false, true),
        ] {
            let twist = Twist::new(speed, 0.0);
            let mut escape = Escape::default();
            // Longer than the patience for creeping.
            for tick in 0..40 {
                let time_s = 0.1 * f64::from(tick);
                let now = PredictedState { time_s, twist, ..standing_at(Pose::default()) };
                with_state(&settings, &robot, &ground, &now, (twist, twist), |state| {
                    (state.stuck_s, state.since_nearer_s) = (10.0, since_nearer_s);
                    state.is_slowed = is_slowed;
                    let drives = Decision::new(twist, Mode::Driving, state.local_target);
                    escape.observe(state, &drives);
                });
            }
            assert_eq!(escape.attempts > 0, escapes, "{speed} m/s, {since_nearer_s} s");
        }
    }

    /// Else it could not leave a gap that it may drive into.
    #[test]
    fn escape_keeps_no_larger_gap_than_the_safety_margin() {
        let least_m =
            |margin_m, present_m| before_a_wall(margin_m, |state| least_gap_m(state, present_m));
        assert_eq!(least_m(0.05, 0.3), MIN_GAP_M);
        assert_eq!(least_m(0.01, 0.3), 0.01);
        assert_eq!(least_m(0.05, 0.02), 0.02);
        assert_eq!(least_m(0.01, -0.01), -0.01);
    }

    /// Its body is parallel to the wall, at this gap, metres: every turn away leads a corner towards the wall.
    #[test]
    fn robot_that_nearly_touches_a_wall_does_not_drive_along_it() {
        let moves = |gap_m: f64| {
            let along = Pose::new(0.25 - gap_m, 0.0, core::f64::consts::FRAC_PI_2);
            let limits = Limits { min_vel_x: -0.3, ..Limits::default() };
            let behind = Point::new(0.2, -2.0);
            let motion = |state: &State<'_>| best_motion(state, Some(behind), None);
            near_a_wall(0.05, &along, (0.7, 0.5), limits, motion) != Twist::STOP
        };
        assert!(moves(0.035) && !moves(0.01), "{} {}", moves(0.035), moves(0.01));
    }

    /// Its body is parallel to the wall. A tight arc leads a corner into it; reversing straight on keeps the gap.
    #[test]
    fn robot_along_a_wall_that_only_looks_for_room_leads_away_on_a_wide_arc() {
        let along = Pose::new(0.2, 0.0, core::f64::consts::FRAC_PI_2);
        let limits = Limits { min_vel_x: -0.3, ..Limits::default() };
        let wanted = |behind, last| {
            let motion = |state: &State<'_>| best_motion(state, behind, last);
            near_a_wall(0.05, &along, (0.7, 0.5), limits, motion)
        };
        let leaves = wanted(None, None);
        let curvature = leaves.angular / leaves.linear;
        assert!((0.05..0.25).contains(&curvature.abs()), "{leaves:?}");
        let mirrored = Twist::new(-leaves.linear, -leaves.angular);
        assert_eq!(wanted(None, Some(mirrored)), mirrored, "as good, and it has begun");
        let returns = wanted(Some(Point::new(0.2, -1.0)), Some(mirrored));
        assert!(returns.linear < 0.0, "{returns:?}");
    }

    #[test]
    fn breadcrumbs_lead_back_place_by_place() {
        let mut breadcrumbs = Breadcrumbs::default();
        for step in 0..31 {
            breadcrumbs.push(&Point::new(f64::from(step) * 0.1, 0.0));
        }
        let mut back_m = |x| {
            let robot = Point::new(x, 0.0);
            let behind = breadcrumbs.behind(&robot);
            breadcrumbs.forget_near(&robot);
            assert_eq!(behind, breadcrumbs.behind(&robot));
            behind.map(|point| x - point.x)
        };
        for x in [3.0, 2.0, 1.1, 0.7] {
            let back_m = back_m(x);
            assert!(
                back_m.is_some_and(|back_m| (0.5..0.9).contains(&back_m)),
                "from {x}: {back_m:?}"
            );
        }
        assert_eq!(back_m(0.2), None);
        assert_eq!(back_m(3.0), None);
    }
}
