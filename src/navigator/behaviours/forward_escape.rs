//! Escapes on a base that cannot reverse: the robot turns on the spot to a heading with room ahead, and drives there.

use core::f64::consts::{PI, TAU};

use super::super::exact_clearance::ExactClearance;
use super::super::state::State;
use super::escape::{ENOUGH_GAP_M, RANGE_M, RETURN_WEIGHT, least_gap_m, leaves_if_near};
use super::rotate_in_place::rotation;
use crate::geometry::{Point, Pose, Twist};

/// Number of headings that are tried.
const HEADINGS: u32 = 24;
/// Distance that is driven ahead in the prediction, and distance between two checked poses, metres.
const AHEAD_M: f64 = 0.4;
const STEP_M: f64 = 0.05;
/// Angle between two checked poses of a rotation, radians.
const STEP_RAD: f64 = 0.1;
/// The robot drives where the heading lies within this, radians.
const AIMED: f64 = 0.1;
/// Clearance that is worth as much as a smaller turn of one radian, metres. The choice is then kept from tick to tick.
const TURN_WEIGHT: f64 = 0.02;

/// The next velocity of a turn and a straight motion that approach nothing, towards where the robot came from if it came from
/// anywhere; `None` where every heading is blocked. A place behind a robot that has not moved is none: it would turn with the robot.
pub(super) fn motion(state: &State<'_>, came_from: Option<Point>) -> Option<Twist> {
    let footprint = &state.robot.footprint;
    let pose = &state.now.pose;
    let reach_m = footprint.circumscribed_radius_m() + RANGE_M;
    let clearance = ExactClearance::new(state.field, &pose.position(), reach_m);
    let present_m = clearance.gap_m(footprint, pose);
    let least_m = least_gap_m(state, present_m);
    let is_clear = |there: &Pose| {
        clearance.keeps_gap(footprint, there, least_m)
            && state.inflated.is_clear_of_moving(there, 0.0)
    };
    let mut best: Option<(f64, f64)> = None;
    for heading in 0..HEADINGS {
        let angle = TAU * f64::from(heading) / f64::from(HEADINGS) - PI;
        if !turn(pose, angle).all(|there| is_clear(&there)) {
            continue;
        }
        let facing = Pose { yaw: pose.yaw + angle, ..*pose };
        let drive = |metres: f64| {
            let there = facing.transform(&Point::new(metres, 0.0));
            Pose::new(there.x, there.y, facing.yaw)
        };
        let steps = (AHEAD_M / STEP_M).round() as u32;
        if !(1..=steps).all(|step| is_clear(&drive(f64::from(step) * STEP_M))) {
            continue;
        }
        let end = drive(AHEAD_M);
        let gap_m = clearance.gap_m(footprint, &end).min(ENOUGH_GAP_M);
        if !leaves_if_near(state, present_m, gap_m) {
            continue;
        }
        let away_m = came_from.map_or(0.0, |place| (place - end.position()).norm());
        let score = gap_m - RETURN_WEIGHT * away_m - TURN_WEIGHT * angle.abs();
        if best.is_none_or(|(most, _)| score > most) {
            best = Some((score, angle));
        }
    }
    let (_, angle) = best?;
    let wanted = if angle.abs() > AIMED {
        rotation(angle, &state.robot.limits)
    } else {
        Twist::new(state.settings.escape_speed.min(state.robot.limits.max_vel_x), 0.0)
    };
    (state.is_safe_towards(&wanted) && state.is_path_visible(&wanted)).then_some(wanted)
}

/// The poses of a rotation in place by an angle.
fn turn(pose: &Pose, angle: f64) -> impl Iterator<Item = Pose> {
    let steps = (angle.abs() / STEP_RAD).ceil();
    (1..=steps as u32)
        .map(move |step| Pose { yaw: pose.yaw + angle * f64::from(step) / steps, ..*pose })
}
