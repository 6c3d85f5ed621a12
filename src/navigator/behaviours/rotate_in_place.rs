//! Rotates in place towards the local target where there is room for it.

use core::f64::consts::{PI, TAU};

use super::super::exact_clearance::ExactClearance;
use super::super::staging::LeadingEnd;
use super::super::state::State;
use super::super::{Decision, Fault, Mode};
use super::{Behaviour, Override, Proposal};
use crate::geometry::{Pose, Twist, wrap_angle};
use crate::robot::Limits;

/// A robot above this speed does not begin to rotate in place, m/s.
const MAX_SPEED: f64 = 0.2;
/// Turn rate for each radian, 1/s. Slow enough for a base that answers within 0.2 s.
pub(super) const RATE_PER_RAD: f64 = 2.5;
/// A creeping robot rotates until its target lies within this of its heading, radians.
const CREEPING_UNTIL: f64 = 0.05;
/// Step of the collision check, radians: 4 cm at the ends of a robot of 0.84 m.
const STEP_RAD: f64 = 0.1;
/// Least distance to static obstacles while rotating, metres. It covers a pose error of a centimetre, and the motion between
/// two steps.
const MIN_GAP_M: f64 = 0.03;

/// Turns a robot that faces away from its target, or that only creeps towards it.
#[derive(Debug, Default)]
pub(super) struct RotateInPlace {
    /// The present rotation ends when the target lies within this of the heading, radians.
    until: f64,
    /// As `until`, for the rotation proposed at this tick.
    proposed_until: f64,
}

impl Behaviour for RotateInPlace {
    fn propose(&mut self, state: &State<'_>) -> Result<Option<Proposal>, Fault> {
        let settings = state.settings;
        let is_rotating = state.mode == Mode::Rotating;
        let from = if is_rotating { self.until } else { settings.rotate_in_place_from };
        if !settings.features.recovery || aiming_error(state).abs() <= from {
            return Ok(None);
        }
        let Some(angle) = clear_rotation(state) else {
            return Ok(None);
        };
        // A faster robot first slows down: it may be avoiding something, or turn by itself soon.
        if state.now.twist.linear.abs() >= MAX_SPEED {
            return Ok(Some(Proposal::SpeedLimit(MAX_SPEED / 2.0)));
        }
        let rotation = decision(state, angle);
        // Where people forbid the rotation, the robot may still drive to its target, unless it faces away from it.
        if rotation.command == Twist::STOP
            && aiming_error(state).abs() <= settings.rotate_in_place_from
        {
            return Ok(None);
        }
        self.proposed_until = if is_rotating { self.until } else { settings.rotate_in_place_until };
        Ok(Some(Proposal::Decide(rotation, Override::ByEvasion)))
    }
}

impl RotateInPlace {
    /// Updates the memory with the decision of the tick.
    pub fn observe(&mut self, decision: &Decision) {
        if decision.mode == Mode::Rotating {
            self.until = self.proposed_until;
        }
    }

    /// A decision to rotate a robot that creeps along its path by this command; `None` where it faces its target, has no room, or
    /// turns away from its target. It then drives around something, and would undo the rotation at the next tick.
    pub fn replacement(
        &mut self,
        state: &State<'_>,
        allowed: Override,
        command: &Twist,
    ) -> Option<Decision> {
        let may_rotate = state.settings.features.recovery
            && allowed == Override::ByEvasionOrRotation
            && aiming_error(state).abs() > CREEPING_UNTIL
            && command.angular * aiming_error(state) >= 0.0;
        if !may_rotate {
            return None;
        }
        let rotation = decision(state, clear_rotation(state)?);
        if rotation.command == Twist::STOP && *command != Twist::STOP {
            return None;
        }
        self.proposed_until = CREEPING_UNTIL;
        Some(rotation)
    }
}

/// Angle from the end of the robot that drives ahead, its nose or its tail, to the local target, radians.
fn aiming_error(state: &State<'_>) -> f64 {
    match state.leading_end {
        LeadingEnd::Nose => state.heading_error,
        LeadingEnd::Tail => wrap_angle(state.heading_error + PI),
    }
}

fn decision(state: &State<'_>, angle: f64) -> Decision {
    let command =
        state.without_slow_turn(state.safe_towards(&rotation(angle, &state.robot.limits)));
    Decision::new(command, Mode::Rotating, state.local_target)
}

/// The rotation to the local target that touches nothing, radians: the shorter one, else the longer one.
fn clear_rotation(state: &State<'_>) -> Option<f64> {
    let footprint = &state.robot.footprint;
    let pose = state.now.pose;
    let reach_m = footprint.body_radius_m() + MIN_GAP_M;
    let clearance = ExactClearance::new(state.field, &pose.position(), reach_m);
    let has_room = |there: &Pose| state.inflated.is_clear_of_static(state.field, there);
    // Discs that cover a body need more room than the body, which is checked below.
    let must_have_room = footprint.body().is_some() && has_room(&pose);
    let is_clear = |angle: &f64| {
        // The dynamic window must be able to drive on from there.
        if must_have_room && !has_room(&Pose { yaw: pose.yaw + angle, ..pose }) {
            return false;
        }
        let takes_s = angle.abs() / state.robot.limits.max_vel_theta;
        let steps = (angle.abs() / STEP_RAD).ceil().max(1.0);
        (1..=steps as u32).all(|step| {
            let yaw = pose.yaw + angle * f64::from(step) / steps;
            let there = Pose { yaw, ..pose };
            let time_s = takes_s * f64::from(step) / steps;
            // A moving obstacle may go on, or stop where it is.
            clearance.keeps_gap(footprint, &there, MIN_GAP_M)
                && state.inflated.is_clear_of_moving(&there, 0.0)
                && state.inflated.is_clear_of_moving(&there, time_s)
        })
    };
    let angle = aiming_error(state);
    [angle, angle - TAU.copysign(angle)].into_iter().find(is_clear)
}

/// A rotation in place by an angle, at a rate from which the robot stops in time.
pub(super) fn rotation(angle: f64, limits: &Limits) -> Twist {
    let rate = (-limits.decel_lim_theta * angle.abs())
        .sqrt()
        .min(RATE_PER_RAD * angle.abs())
        .min(limits.max_vel_theta);
    Twist::new(0.0, rate.copysign(angle))
}

#[cfg(test)]
mod tests {
    use super::super::super::passive_safety::obstacle_that_may_come;
    use super::super::super::predicted_state::PredictedState;
    use super::super::super::test_state::{standing_at, with_state};
    use super::super::super::{NavigatorSettings, RobotModel};
    use super::*;
    use crate::geometry::Point;
    use crate::map::{GridFrame, MovingDisc, ObstacleGrid};
    use crate::robot::{Footprint, Polygon};

    /// The result of a call with the state of a standing robot whose target lies off its heading by an angle, radians, next to
    /// these people.
    fn with_target_at<R>(
        heading_error: f64,
        people: &[MovingDisc],
        call: impl FnOnce(&mut State<'_>) -> R,
    ) -> R {
        let settings = NavigatorSettings::default();
        let body = Polygon::rectangle(0.7, 0.5).expect("a rectangle");
        let robot = RobotModel { footprint: Footprint::covering(body), limits: Limits::default() };
        let frame = GridFrame::new(100, 100, 0.1, Pose::new(-5.0, -5.0, 0.0)).expect("a size");
        let ground = ObstacleGrid::filled(frame, false);
        let (may_come, near_turn) = (people.to_vec(), people.to_vec());
        let now = PredictedState { may_come, near_turn, ..standing_at(Pose::default()) };
        with_state(&settings, &robot, &ground, &now, (Twist::STOP, Twist::STOP), |state| {
            state.heading_error = heading_error;
            call(state)
        })
    }

    fn replaces(command: Twist, people: &[MovingDisc]) -> bool {
        with_target_at(0.3, people, |state| {
            let allowed = Override::ByEvasionOrRotation;
            RotateInPlace::default().replacement(state, allowed, &command).is_some()
        })
    }

    /// A walker next to a corner that a turn in place moves towards this person.
    fn walker() -> [MovingDisc; 1] {
        [obstacle_that_may_come(Point::new(-0.5, -0.7), 0.3, 1.6)]
    }

    #[test]
    fn creeping_robot_rotates_unless_it_drives_around_something() {
        assert!(replaces(Twist::STOP, &[]));
        assert!(replaces(Twist::new(0.03, 0.1), &[]), "towards its target");
        assert!(!replaces(Twist::new(0.03, -0.1), &[]), "away from its target");
    }

    #[test]
    fn creeping_robot_drives_on_where_people_forbid_the_rotation() {
        assert!(!replaces(Twist::new(0.03, 0.1), &walker()));
        assert!(replaces(Twist::STOP, &walker()), "it stands and waits");
    }

    #[test]
    fn rotating_robot_drives_where_people_forbid_the_rotation_unless_it_faces_away() {
        let proposes = |heading_error, people: &[MovingDisc]| {
            with_target_at(heading_error, people, |state| {
                let mut rotate = RotateInPlace { until: 0.05, proposed_until: 0.05 };
                state.mode = Mode::Rotating;
                rotate.propose(state).expect("no fault").is_some()
            })
        };
        assert!(proposes(0.3, &[]) && !proposes(0.3, &walker()));
        assert!(proposes(2.0, &[]) && proposes(2.0, &walker()));
    }
}
