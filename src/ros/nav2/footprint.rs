//! The footprint: a polygon covered by discs, or one disc.

use std::collections::BTreeMap;

use serde_json::Value;

use super::Nav2Error;
use super::config_builder::ConfigBuilder;
use super::parameter_file::{Parameter, Parameters};
use crate::map::yaml;
use crate::robot::Disc;

/// Maximum number of discs of the planner.
const MAX_DISCS: usize = 8;
/// Maximum number of values in the text of a polygon.
const MAX_VALUES: usize = 3000;
/// Largest coordinate, radius and padding, metres.
const MAX_METRES: f64 = 100.0;

/// The footprint follows from the polygon, or from the radius without one, and from the padding.
pub(super) fn import_footprint(
    parameters: &mut Parameters,
    builder: &mut ConfigBuilder,
) -> Result<(), Nav2Error> {
    let is_empty = parameters
        .peek_text("footprint")
        .is_some_and(|text| text.trim().trim_matches(['[', ']']).trim().is_empty());
    let polygon = if is_empty {
        None
    } else {
        parameters.take(
            "footprint",
            "at least three corners within 100 m, such as \"[[0.3, 0.2], [0.3, -0.2], [-0.3, -0.2], [-0.3, 0.2]]\"",
            corners,
        )?
    };
    let (discs, note) = if let Some(polygon) = polygon {
        (Some(polygon.map(|corners| cover(&corners))), "covered by discs")
    } else {
        let expected = "a number of metres, above zero and at most 100";
        let is_valid = |radius: &f64| *radius > 0.0 && *radius <= MAX_METRES;
        let radius =
            parameters.take("robot_radius", expected, |value| value.as_f64().filter(is_valid))?;
        let disc = |radius| vec![Disc { x: 0.0, y: 0.0, radius }];
        (radius.map(|radius| radius.map(disc)), "one disc")
    };
    let Some(mut discs) = discs else {
        return Ok(());
    };
    let expected = "a number of metres, 0 to 100";
    let padding = parameters.take("footprint_padding", expected, |value| {
        value.as_f64().filter(|padding| (0.0..=MAX_METRES).contains(padding))
    })?;
    for disc in &mut discs.value {
        disc.radius += padding.as_ref().map_or(0.0, |padding| padding.value);
    }
    let value = toml_array(&discs.value);
    let padding = padding.map(|Parameter { path, .. }| Parameter { path, value: value.clone() });
    builder.set("robot.footprint", discs.map(|_| value), note);
    if let Some(padding) = padding {
        builder.set("robot.footprint", padding, "added to each radius");
    }
    Ok(())
}

/// The corners of a polygon, in a text as in Nav2, or in a list.
fn corners(value: &Value) -> Option<Vec<[f64; 2]>> {
    let corners: Vec<[f64; 2]> = match value {
        Value::String(text) => yaml::parse(text, MAX_VALUES).ok()?,
        list => serde_json::from_value(list.clone()).ok()?,
    };
    let is_near = |corner: &[f64; 2]| corner.iter().all(|number| number.abs() <= MAX_METRES);
    (corners.len() >= 3 && corners.iter().all(is_near)).then_some(corners)
}

fn toml_array(discs: &[Disc]) -> toml::Value {
    let disc =
        |disc: &Disc| BTreeMap::from([("x", disc.x), ("y", disc.y), ("radius", disc.radius)]);
    toml::Value::from(discs.iter().map(disc).collect::<Vec<_>>())
}

/// Covers a polygon of at least one corner, metres, with discs. The result is its circumscribed circle, or a row of discs along
/// the longer side of its bounding box if that is narrower.
fn cover(corners: &[[f64; 2]]) -> Vec<Disc> {
    let range = |axis: usize| {
        let along = || corners.iter().map(move |corner| corner[axis]);
        (along().fold(f64::INFINITY, f64::min), along().fold(f64::NEG_INFINITY, f64::max))
    };
    let [(back, front), (right, left)] = [range(0), range(1)];
    let (length, width) = (front - back, left - right);
    let (x, y) = (f64::midpoint(back, front), f64::midpoint(right, left));
    let distance = |corner: &[f64; 2]| libm::hypot(corner[0] - x, corner[1] - y);
    let circumradius = corners.iter().map(distance).fold(0.0, f64::max);
    let (longer, shorter) = (length.max(width), length.min(width));
    // One disc more than squares fit: it halves the overhang of the discs.
    let squares = (longer / shorter.max(longer / MAX_DISCS as f64)).ceil();
    let count = (squares as usize + 1).clamp(2, MAX_DISCS);
    let spacing = longer / count as f64;
    let radius = libm::hypot(spacing / 2.0, shorter / 2.0);
    if circumradius <= radius {
        return vec![Disc { x, y, radius: circumradius }];
    }
    let disc = |index: usize| {
        let along = (index as f64 + 0.5) * spacing - longer / 2.0;
        let (x, y) = if length >= width { (x + along, y) } else { (x, y + along) };
        Disc { x, y, radius }
    };
    (0..count).map(disc).collect()
}
