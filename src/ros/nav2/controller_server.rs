//! The controller server: its rate, the checkers of progress and of goals, and its controllers.

use core::f64::consts::PI;

use super::draft::Draft;
use super::leftovers::{Rule, leave};
use super::plugins::{give_way, plugins};
use super::section::Section;
use super::{Nav2Error, Why, controllers};

const MAPPED: [&str; 2] = ["controller_frequency", "costmap_update_timeout"];

const NAMES: &str = "it names the plugins that are read";
const STANDSTILL: &str = "speeds are taken as the base reports them";

const RULES: [Rule; 13] = [
    ("min_x_velocity_threshold", Why::NoSuchThing, STANDSTILL),
    ("min_y_velocity_threshold", Why::NoSuchThing, STANDSTILL),
    ("min_theta_velocity_threshold", Why::NoSuchThing, STANDSTILL),
    (
        "failure_tolerance",
        Why::OtherMeaning,
        "there the controller gives up; here the robot brakes at once, and tries something else after navigator.stuck_patience_s",
    ),
    ("progress_checker_plugin", Why::NoSuchThing, NAMES),
    ("progress_checker_plugins", Why::NoSuchThing, NAMES),
    ("goal_checker_plugin", Why::NoSuchThing, NAMES),
    ("goal_checker_plugins", Why::NoSuchThing, NAMES),
    ("controller_plugins", Why::NoSuchThing, NAMES),
    (
        "publish_zero_velocity",
        Why::NoSuchThing,
        "the base is always told to stand at the end",
    ),
    (
        "action_server_result_timeout",
        Why::NoSuchThing,
        "no ROS actions",
    ),
    (
        "enable_stamped_cmd_vel",
        Why::NoSuchThing,
        "no ROS messages",
    ),
    (
        "search_window",
        Why::NoSuchThing,
        "the path is followed by progress along it",
    ),
];

const PROGRESS: [Rule; 2] = [
    (
        "movement_time_allowance",
        Why::OtherMeaning,
        "there a recovery begins; here after navigator.stuck_patience_s, and navigator.movement_time_allowance ends the mission",
    ),
    (
        "required_movement_angle",
        Why::NoSuchThing,
        "progress is measured along the path",
    ),
];

const GOAL: [Rule; 4] = [
    (
        "stateful",
        Why::NoSuchThing,
        "arrival is judged by position and yaw at once",
    ),
    (
        "trans_stopped_velocity",
        Why::NoSuchThing,
        "the robot parks, and stands when it has arrived",
    ),
    (
        "rot_stopped_velocity",
        Why::NoSuchThing,
        "the robot parks, and stands when it has arrived",
    ),
    (
        "path_length_tolerance",
        Why::NoSuchThing,
        "the path is followed by progress along it",
    ),
];

pub(super) fn read(mut section: Section, draft: &mut Draft) -> Result<(), Nav2Error> {
    let frequency = section.take(
        "controller_frequency",
        "a number of Hz above zero",
        |value| {
            value
                .as_f64()
                .filter(|&hertz| hertz > 0.0 && hertz.is_finite())
        },
    )?;
    if let Some(frequency) = frequency {
        draft.set(
            "local.control_period_s",
            frequency.map(f64::recip),
            "1 / controller_frequency",
        );
    }
    if let Some(timeout) = section.number("costmap_update_timeout")? {
        draft.set("navigator.scan_timeout_s", timeout, "");
    }
    let is = |kind: &'static str| move |plugin: &str| plugin.contains(kind);
    for (lists, kind, take) in [
        (
            ["progress_checker_plugins", "progress_checker_plugin"],
            "ProgressChecker",
            progress as fn(Section, &mut Draft) -> Result<(), Nav2Error>,
        ),
        (
            ["goal_checker_plugins", "goal_checker_plugin"],
            "GoalChecker",
            goal,
        ),
    ] {
        let mut names = plugins(&section, &lists, is(kind)).into_iter();
        if let Some(first) = names.next() {
            take(section.part(&first), draft)?;
            for name in names {
                give_way(section.part(&name), draft, &first);
            }
        }
    }
    controllers::read(&mut section, draft)?;
    leave(section, draft, &MAPPED, &[&RULES]);
    Ok(())
}

fn progress(mut part: Section, draft: &mut Draft) -> Result<(), Nav2Error> {
    if let Some(radius) = part.number("required_movement_radius")? {
        draft.set("navigator.required_movement_radius", radius, "");
    }
    leave(part, draft, &["required_movement_radius"], &[&PROGRESS]);
    Ok(())
}

fn goal(mut part: Section, draft: &mut Draft) -> Result<(), Nav2Error> {
    if let Some(tolerance) = part.number("xy_goal_tolerance")? {
        draft.set("navigator.xy_goal_tolerance", tolerance, "");
    }
    if let Some(tolerance) = part.number("yaw_goal_tolerance")? {
        let how = if tolerance.value > PI {
            "above pi: any yaw"
        } else {
            ""
        };
        draft.set(
            "navigator.yaw_goal_tolerance",
            tolerance.map(|angle| angle.min(PI)),
            how,
        );
    }
    leave(
        part,
        draft,
        &["xy_goal_tolerance", "yaw_goal_tolerance"],
        &[&GOAL],
    );
    Ok(())
}
