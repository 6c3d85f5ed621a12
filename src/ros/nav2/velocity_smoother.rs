//! Nav2's velocity smoother: it limits what the controller asks for, so the tighter of the two limits is the robot's.

use super::draft::Draft;
use super::leftovers::{Rule, leave};
use super::section::{Given, Section};
use super::{Nav2Error, Why};

const MAPPED: [&str; 7] = [
    "max_velocity",
    "min_velocity",
    "max_accel",
    "max_decel",
    "smoothing_frequency",
    "velocity_timeout",
    "deadband_velocity",
];

const RULES: [Rule; 5] = [
    (
        "scale_velocities",
        Why::NoSuchThing,
        "the curvature is always kept where a track's limit is met",
    ),
    (
        "feedback",
        Why::NoSuchThing,
        "ramps always start from what was last sent",
    ),
    (
        "odom_duration",
        Why::NoSuchThing,
        "speeds are taken as the base reports them",
    ),
    (
        "enable_stamped_cmd_vel",
        Why::NoSuchThing,
        "no ROS messages",
    ),
    (
        "stamp_smoothed_velocity_with_smoothing_time",
        Why::NoSuchThing,
        "no ROS messages",
    ),
];

pub(super) fn read(mut section: Section, draft: &mut Draft) -> Result<(), Nav2Error> {
    let of = |given: &Given<[f64; 3]>, at: usize, sign: f64| Given {
        place: given.place.clone(),
        value: sign * given.value[at],
    };
    if let Some(most) = section.triple("max_velocity")? {
        draft.at_most("robot.limits.max_vel_x", of(&most, 0, 1.0), "along x");
        draft.at_most("robot.limits.max_vel_theta", of(&most, 2, 1.0), "about z");
    }
    if let Some(least) = section.triple("min_velocity")? {
        draft.at_least("robot.limits.min_vel_x", of(&least, 0, 1.0), "along x");
        draft.at_most(
            "robot.limits.max_vel_theta",
            of(&least, 2, -1.0),
            "about z, without its sign",
        );
    }
    if let Some(gain) = section.triple("max_accel")? {
        draft.at_most("robot.limits.acc_lim_x", of(&gain, 0, 1.0), "along x");
        draft.at_most("robot.limits.acc_lim_theta", of(&gain, 2, 1.0), "about z");
    }
    if let Some(brake) = section.triple("max_decel")? {
        draft.at_least("robot.limits.decel_lim_x", of(&brake, 0, 1.0), "along x");
        draft.at_least(
            "robot.limits.decel_lim_theta",
            of(&brake, 2, 1.0),
            "about z",
        );
    }
    if let Some(rate) = section.number("smoothing_frequency")? {
        draft.set("supervisor.rate_hz", rate, "");
    }
    if let Some(timeout) = section.number("velocity_timeout")? {
        draft.set("supervisor.target_timeout_s", timeout, "");
    }
    if let Some(deadband) = section.triple("deadband_velocity")? {
        draft.set(
            "base.tracks.deadband",
            of(&deadband, 0, 1.0),
            "that along x, for each track",
        );
    }
    leave(section, draft, &MAPPED, &[&RULES]);
    Ok(())
}
