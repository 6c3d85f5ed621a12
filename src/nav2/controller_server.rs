//! The controller server: its rate, the checkers of progress and of goals, and the one controller that is read.

use core::f64::consts::PI;

use super::draft::Draft;
use super::leftovers::{Rule, leave};
use super::parameters::Section;
use super::{Nav2Error, Why, dwb, mppi, rotation_shim};

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
        "there the controller gives up; here the robot brakes at once, and tries something else after navigator.patience_s",
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
        "there a recovery begins; here after navigator.patience_s, and navigator.give_up_after_s ends the mission",
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
        draft.set("navigator.senses_timeout_s", timeout, "");
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
            give_way(&mut section, draft, names, &first);
        }
    }
    controllers(&mut section, draft)?;
    leave(section, draft, &MAPPED, &[&RULES]);
    Ok(())
}

/// Names of the plugins of a kind that have parameters: those that a list names, in its order, else all of that kind.
fn plugins(section: &Section, lists: &[&str], is_kind: impl Fn(&str) -> bool) -> Vec<String> {
    let parts = section.parts();
    let listed = lists.iter().flat_map(|list| {
        let single = section.text(list).map(str::to_owned);
        section.texts(list).into_iter().chain(single)
    });
    let mut names: Vec<String> = listed.filter(|name| parts.contains(name)).collect();
    let of_kind = |name: &String| {
        let plugin = section.text(&format!("{name}.plugin"));
        plugin.is_some_and(&is_kind)
    };
    for name in parts.iter().filter(|name| of_kind(name)) {
        if !names.contains(name) {
            names.push(name.clone());
        }
    }
    names
}

/// Lists all parameters of plugins that another takes the place of.
fn give_way(
    section: &mut Section,
    draft: &mut Draft,
    names: impl Iterator<Item = String>,
    taken: &str,
) {
    for name in names {
        for (_, place) in section.part(&name).rest() {
            draft.leave(
                place,
                Why::NotInForce,
                format!("{taken} is read, and only one of its kind"),
            );
        }
    }
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

/// Reads the first controller that is known, and leaves the others.
fn controllers(section: &mut Section, draft: &mut Draft) -> Result<(), Nav2Error> {
    let is_controller =
        |plugin: &str| plugin.ends_with("Controller") || plugin.ends_with("LocalPlanner");
    let names = plugins(section, &["controller_plugins"], is_controller);
    let mut read: Option<String> = None;
    for name in names {
        let mut part = section.part(&name);
        let known = Kind::of(&part);
        match (&read, known) {
            (None, Some(kind)) => {
                kind.take(part, draft)?;
                read = Some(name);
            }
            (Some(taken), Some(_)) => {
                let reason = format!("{taken} is read, and only one of its kind");
                for (_, place) in part.rest() {
                    draft.leave(place, Why::NotInForce, reason.clone());
                }
            }
            (_, None) => {
                let plugin = part.take("plugin", "a text", |value| {
                    value.as_str().map(str::to_owned)
                })?;
                let kind = plugin.as_ref().map_or("no plugin", |given| &given.value);
                let reason = format!("of {kind}: only DWB and MPPI are taken over");
                let place = plugin.as_ref().map(|given| given.place.clone());
                for place in part.rest().map(|(_, place)| place).chain(place) {
                    draft.leave(place, Why::NotYet, reason.clone());
                }
            }
        }
    }
    Ok(())
}

/// A controller that is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Controller {
    Dwb,
    Mppi,
}

/// A controller, and where its parameters are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Kind {
    controller: Controller,
    /// Within a rotation shim.
    in_shim: bool,
    /// With the parameters nested under the shim's `primary_controller`, not beside them.
    nested: bool,
}

impl Kind {
    fn of(part: &Section) -> Option<Self> {
        let plugin = part.text("plugin")?;
        let in_shim = plugin == rotation_shim::PLUGIN;
        let within = format!("{}.plugin", rotation_shim::PRIMARY);
        let beside = part.text(rotation_shim::PRIMARY);
        let nested = in_shim && beside.is_none();
        let name = match (in_shim, beside) {
            (false, _) => plugin,
            (true, Some(primary)) => primary,
            (true, None) => part.text(&within)?,
        };
        let controller = match name {
            dwb::PLUGIN => Controller::Dwb,
            mppi::PLUGIN => Controller::Mppi,
            _ => return None,
        };
        Some(Self {
            controller,
            in_shim,
            nested,
        })
    }

    fn take(self, mut part: Section, draft: &mut Draft) -> Result<(), Nav2Error> {
        let shim_rules: &[Rule] = if self.in_shim {
            &rotation_shim::RULES
        } else {
            &[]
        };
        if self.in_shim {
            rotation_shim::take(&mut part, draft)?;
        }
        if self.nested {
            let inner = part.part(rotation_shim::PRIMARY);
            leave(part, draft, &rotation_shim::MAPPED, &[shim_rules]);
            part = inner;
        }
        match self.controller {
            Controller::Dwb => {
                dwb::take(&mut part, draft)?;
                leave(
                    part,
                    draft,
                    &dwb::MAPPED,
                    &[shim_rules, &dwb::RULES, &dwb::CRITICS],
                );
            }
            Controller::Mppi => {
                mppi::take(&mut part, draft)?;
                leave(
                    part,
                    draft,
                    &mppi::MAPPED,
                    &[shim_rules, &mppi::RULES, &mppi::CRITICS],
                );
            }
        }
        Ok(())
    }
}
