//! The local costmap: there is none here, but the robot's shape stands in it.

use serde_json::Value;

use super::draft::Draft;
use super::footprint::cover;
use super::leftovers::{Rule, leave};
use super::section::{Given, Section};
use super::{Nav2Error, Why};
use crate::map::yaml;
use crate::robot::Disc;

const MAPPED: [&str; 3] = ["footprint", "robot_radius", "footprint_padding"];

/// Most numbers of a footprint.
const MAX_NODES: usize = 3000;

/// Farthest corner, metres.
const FARTHEST: f64 = 100.0;

const FIELD: &str =
    "no costmap: the local field is as fine as the map, and as wide as the horizon needs";
const LAYERS: &str = "no layers: map and scans are always marked, and moving obstacles tracked";

const RULES: [Rule; 30] = [
    ("robot_radius", Why::NotInForce, "footprint takes its place"),
    ("footprint", Why::NotInForce, "empty"),
    (
        "footprint_padding",
        Why::NotInForce,
        "there is no footprint to pad",
    ),
    (
        "inflation_radius",
        Why::OtherMeaning,
        "distances to obstacles are weighed as they are, up to local.max_clearance_m",
    ),
    (
        "cost_scaling_factor",
        Why::OtherMeaning,
        "distances to obstacles are weighed as they are, up to local.max_clearance_m",
    ),
    (
        "*.inflation_radius",
        Why::OtherMeaning,
        "distances to obstacles are weighed as they are, up to local.max_clearance_m",
    ),
    (
        "*.cost_scaling_factor",
        Why::OtherMeaning,
        "distances to obstacles are weighed as they are, up to local.max_clearance_m",
    ),
    (
        "*obstacle_max_range",
        Why::OtherMeaning,
        "the scan's own range counts; that of the simulated one is lidar.range_max_m",
    ),
    (
        "*raytrace_max_range",
        Why::OtherMeaning,
        "the scan's own range counts; that of the simulated one is lidar.range_max_m",
    ),
    (
        "*obstacle_min_range",
        Why::OtherMeaning,
        "the scan's own range counts; that of the simulated one is lidar.range_min_m",
    ),
    (
        "*raytrace_min_range",
        Why::OtherMeaning,
        "the scan's own range counts; that of the simulated one is lidar.range_min_m",
    ),
    ("width", Why::NoSuchThing, FIELD),
    ("height", Why::NoSuchThing, FIELD),
    ("resolution", Why::NoSuchThing, FIELD),
    ("origin_x", Why::NoSuchThing, FIELD),
    ("origin_y", Why::NoSuchThing, FIELD),
    ("rolling_window", Why::NoSuchThing, FIELD),
    (
        "update_frequency",
        Why::NoSuchThing,
        "the field is made anew for each decision",
    ),
    ("publish_frequency", Why::NoSuchThing, "no ROS topics"),
    (
        "always_send_full_costmap",
        Why::NoSuchThing,
        "no ROS topics",
    ),
    (
        "track_unknown_space",
        Why::OtherMeaning,
        "unknown = \"blocked\" or \"free\" says what unknown ground counts as",
    ),
    ("unknown_cost_value", Why::NoSuchThing, LAYERS),
    (
        "lethal_cost_threshold",
        Why::NoSuchThing,
        "the thresholds are the map file's",
    ),
    (
        "trinary_costmap",
        Why::NoSuchThing,
        "the mode is the map file's",
    ),
    (
        "initial_transform_timeout",
        Why::NoSuchThing,
        "no tf: the planner is given poses",
    ),
    ("map_vis_z", Why::NoSuchThing, "no ROS topics"),
    ("plugins", Why::NoSuchThing, LAYERS),
    ("filters", Why::NoSuchThing, LAYERS),
    ("observation_sources", Why::NoSuchThing, LAYERS),
    (
        "subscribe_to_stamped_footprint",
        Why::NoSuchThing,
        "no ROS topics",
    ),
];

/// Anything else that is nested is a layer's.
const OF_LAYERS: [Rule; 1] = [("*.*", Why::NoSuchThing, LAYERS)];

pub(super) fn read(mut section: Section, draft: &mut Draft) -> Result<(), Nav2Error> {
    let empty = section
        .text("footprint")
        .is_some_and(|text| text.trim().trim_matches(['[', ']']).trim().is_empty());
    let polygon = if empty {
        None
    } else {
        section.take(
            "footprint",
            "at least three corners within 100 m, such as \"[[0.3, 0.2], [0.3, -0.2], [-0.3, -0.2], [-0.3, 0.2]]\"",
            corners,
        )?
    };
    let how;
    let (place, mut discs) = if let Some(Given { place, value }) = polygon {
        how = "covered by discs";
        (place, cover(&value))
    } else {
        let radius = section.take(
            "robot_radius",
            "a number of metres, above zero and at most 100",
            |value| {
                value
                    .as_f64()
                    .filter(|&radius| radius > 0.0 && radius <= FARTHEST)
            },
        )?;
        let Some(Given {
            place,
            value: radius,
        }) = radius
        else {
            leave(section, draft, &MAPPED, &[&RULES, &OF_LAYERS]);
            return Ok(());
        };
        how = "one disc";
        (
            place,
            vec![Disc {
                x: 0.0,
                y: 0.0,
                radius,
            }],
        )
    };
    let padding = section.take(
        "footprint_padding",
        "a number of metres, 0 to 100",
        |value| {
            value
                .as_f64()
                .filter(|padding| (0.0..=FARTHEST).contains(padding))
        },
    )?;
    for disc in &mut discs {
        disc.radius += padding.as_ref().map_or(0.0, |padding| padding.value);
    }
    draft.set(
        "robot.footprint",
        Given {
            place,
            value: table(&discs),
        },
        how,
    );
    if let Some(Given { place, .. }) = padding {
        draft.also_from("robot.footprint", place, "added to each radius");
    }
    leave(section, draft, &MAPPED, &[&RULES, &OF_LAYERS]);
    Ok(())
}

/// Corners of a polygon, from a text as Nav2 has it, or from a list.
fn corners(value: &Value) -> Option<Vec<[f64; 2]>> {
    let corners: Vec<[f64; 2]> = match value {
        Value::String(text) => yaml::parse(text, MAX_NODES).ok()?,
        list => serde_json::from_value(list.clone()).ok()?,
    };
    let near = |corner: &[f64; 2]| corner.iter().all(|number| number.abs() <= FARTHEST);
    (corners.len() >= 3 && corners.iter().all(near)).then_some(corners)
}

fn table(discs: &[Disc]) -> toml::Value {
    let disc = |disc: &Disc| {
        let numbers = [("x", disc.x), ("y", disc.y), ("radius", disc.radius)];
        let entries = numbers.map(|(name, number)| (name.to_owned(), toml::Value::Float(number)));
        toml::Value::Table(entries.into_iter().collect())
    };
    toml::Value::Array(discs.iter().map(disc).collect())
}
