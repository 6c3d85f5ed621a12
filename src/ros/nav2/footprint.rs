//! The footprint: a polygon, which the settings cover with discs, or one disc.

use std::collections::BTreeMap;

use serde_json::Value;

use super::Nav2Error;
use super::config_builder::ConfigBuilder;
use super::parameter_file::{Parameter, Parameters};
use super::rules::NAV2_DEFAULT;
use crate::geometry::Point;
use crate::map::yaml;
use crate::robot::Polygon;

/// The setting that follows from the parameters.
pub(super) const FOOTPRINT: &str = "robot.footprint";
/// Maximum number of values in the text of a polygon.
const MAX_VALUES: usize = 3000;
/// Nav2's default of `footprint_padding`, metres.
const DEFAULT_PADDING_M: f64 = 0.01;
/// Largest radius and padding, metres.
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
        let corners = parameters.take(
            "footprint",
            "at least three corners within 100 m, such as \"[[0.3, 0.2], [0.3, -0.2], [-0.3, -0.2], [-0.3, 0.2]]\"",
            corners,
        )?;
        corners.map(polygon).transpose()?
    };
    let shape = if let Some(polygon) = polygon {
        Some(polygon.map(Shape::Polygon))
    } else {
        let expected = "a number of metres, above zero and at most 100";
        let is_valid = |radius: &f64| *radius > 0.0 && *radius <= MAX_METRES;
        let radius =
            parameters.take("robot_radius", expected, |value| value.as_f64().filter(is_valid))?;
        radius.map(|radius| radius.map(Shape::Round))
    };
    let Some(shape) = shape else {
        return Ok(());
    };
    let expected = "a number of metres, 0 to 100";
    let padding = parameters.take("footprint_padding", expected, |value| {
        value.as_f64().filter(|padding| (0.0..=MAX_METRES).contains(padding))
    })?;
    let padding_m = padding.as_ref().map_or(DEFAULT_PADDING_M, |padding| padding.value);
    let (value, note, padding_note) = match &shape.value {
        Shape::Polygon(polygon) => {
            (toml_polygon(&padded(polygon, padding_m)), "covered by discs", "added to each corner")
        }
        Shape::Round(radius) => (toml_disc(radius + padding_m), "one disc", "added to the radius"),
    };
    builder.set(FOOTPRINT, shape.map(|_| value.clone()), note);
    if let Some(padding) = padding {
        builder.set(FOOTPRINT, padding.map(|_| value), padding_note);
    } else if let Some(path) = parameters.path_of("footprint_padding") {
        let note = format!("{NAV2_DEFAULT}, {DEFAULT_PADDING_M} m, {padding_note}");
        builder.set_default(FOOTPRINT, Parameter { path, value }, &note);
    }
    Ok(())
}

/// The shape of a robot in a parameter file.
enum Shape {
    Polygon(Polygon),
    /// Radius, metres.
    Round(f64),
}

/// The corners of a polygon, in a text as in Nav2, or in a list.
fn corners(value: &Value) -> Option<Vec<Point>> {
    match value {
        Value::String(text) => yaml::parse(text, MAX_VALUES).ok(),
        list => serde_json::from_value(list.clone()).ok(),
    }
}

fn polygon(corners: Parameter<Vec<Point>>) -> Result<Parameter<Polygon>, Nav2Error> {
    let Parameter { path, value } = corners;
    match Polygon::new(value) {
        Ok(value) => Ok(Parameter { path, value }),
        Err(error) => Err(Nav2Error::BadFootprint { parameter: path, reason: error.to_string() }),
    }
}

/// A polygon with each corner moved away from both axes, as Nav2 pads it.
fn padded(polygon: &Polygon, padding: f64) -> Vec<[f64; 2]> {
    let away = |at: f64| if at == 0.0 { at } else { at + padding.copysign(at) };
    polygon.corners().iter().map(|corner| [away(corner.x), away(corner.y)]).collect()
}

fn toml_polygon(corners: &[[f64; 2]]) -> toml::Value {
    toml::Value::from(corners.iter().map(|corner| corner.to_vec()).collect::<Vec<_>>())
}

fn toml_disc(radius: f64) -> toml::Value {
    let disc = BTreeMap::from([("x", 0.0), ("y", 0.0), ("radius", radius)]);
    toml::Value::from(vec![disc])
}
