//! Nav2's rotation shim: a controller around another that first turns the robot in place, as the navigator does here.

use super::draft::Draft;
use super::leftovers::Rule;
use super::section::Section;
use super::{Nav2Error, Why};
use crate::navigator::NavigatorSettings;

pub(super) const PLUGIN: &str = "nav2_rotation_shim_controller::RotationShimController";

/// What says which controller is within.
pub(super) const PRIMARY: &str = "primary_controller";

pub(super) const MAPPED: [&str; 2] = ["angular_dist_threshold", "angular_disengage_threshold"];

pub(super) const RULES: [Rule; 9] = [
    (
        PRIMARY,
        Why::NoSuchThing,
        "it says which controller is read",
    ),
    (
        "forward_sampling_distance",
        Why::OtherMeaning,
        "the angle is that to the local target: navigator.lookahead_m",
    ),
    (
        "rotate_to_heading_angular_vel",
        Why::NoSuchThing,
        "it turns in place at up to robot.limits.max_vel_theta",
    ),
    (
        "max_angular_accel",
        Why::NoSuchThing,
        "it turns in place within robot.limits.acc_lim_theta",
    ),
    (
        "simulate_ahead_time",
        Why::NoSuchThing,
        "turns in place are checked as all motion is",
    ),
    (
        "rotate_to_goal_heading",
        Why::NoSuchThing,
        "it always turns to the yaw that a goal asks for",
    ),
    (
        "rotate_to_heading_once",
        Why::NoSuchThing,
        "it turns in place whenever it faces away",
    ),
    (
        "use_path_orientations",
        Why::NoSuchThing,
        "paths have no yaws of their own",
    ),
    (
        "closed_loop",
        Why::NoSuchThing,
        "decisions start from the speed that is measured",
    ),
];

pub(super) fn take(part: &mut Section, draft: &mut Draft) -> Result<(), Nav2Error> {
    let (from, until) = (
        "navigator.rotate_in_place_from",
        "navigator.rotate_in_place_until",
    );
    let begins = part.number("angular_dist_threshold")?;
    let ends = part.number("angular_disengage_threshold")?;
    if let Some(begins) = begins {
        // Ours must not be above it, and Nav2's default is half of it.
        if ends.is_none() && NavigatorSettings::default().rotate_in_place_until > begins.value {
            draft.set(until, begins.clone().map(|angle| angle / 2.0), "half of it");
        }
        draft.set(from, begins, "");
    }
    if let Some(ends) = ends {
        draft.set(until, ends, "");
    }
    Ok(())
}
