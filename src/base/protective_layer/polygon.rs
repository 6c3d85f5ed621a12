//! Fixed zones in the robot's frame, as in Nav2's `collision_monitor`.

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use thiserror::Error;

use super::raw_scan::RawPoint;
use crate::geometry::{Point, Pose, Twist, is_in_polygon};
use crate::settings::{Range, choices, range, setting_schema};

/// Most zones.
const MAX_ZONES: usize = 32;

/// Coordinates of corners, metres.
const COORDINATE: Range = range!(-10000 to 10000);

/// A key with a number, its range, and its value in a zone.
type Number = (&'static str, Range, fn(&ZonePolygon) -> f64);

const NUMBERS: [Number; 5] = [
    ("min_points", range!(at_least 1), |zone| zone.min_points as f64),
    ("slowdown_ratio", range!(0 to 1), |zone| zone.slowdown_ratio),
    ("linear_limit", range!(0 to 10000), |zone| zone.linear_limit),
    ("angular_limit", range!(0 to 10000), |zone| zone.angular_limit),
    ("time_before_collision", range!(above 0 to 10), |zone| zone.time_before_collision),
];

/// What a zone does while it holds enough returns.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum ActionType {
    /// The robot stops.
    Stop,
    /// The command is multiplied by `slowdown_ratio`.
    Slowdown,
    /// The command is limited to `linear_limit` and `angular_limit`; its curvature stays.
    Limit,
    /// The zone is the body: the command is reduced so that a collision is at least `time_before_collision` away.
    Approach,
}

/// A fixed zone in the robot's frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ZonePolygon {
    /// Name of the zone, for diagnostics.
    pub name: String,
    /// What the zone does.
    pub action_type: ActionType,
    /// Corners, metres, in order.
    pub points: Vec<Point>,
    /// Returns from which the zone acts, at least 1.
    #[serde(default = "default_min_points")]
    pub min_points: usize,
    /// Factor of a slowdown, 0 to 1.
    #[serde(default = "default_slowdown_ratio")]
    pub slowdown_ratio: f64,
    /// Highest speed of a limit, m/s, at least zero.
    #[serde(default = "default_limit")]
    pub linear_limit: f64,
    /// Highest turn rate of a limit, rad/s, at least zero.
    #[serde(default = "default_limit")]
    pub angular_limit: f64,
    /// Time of an approach, seconds, above zero.
    #[serde(default = "default_time_before_collision")]
    pub time_before_collision: f64,
    /// Whether the zone acts.
    #[serde(default = "default_enabled")]
    pub enabled: bool,
}

/// Nav2's default.
const fn default_min_points() -> usize {
    4
}

/// Nav2's default.
const fn default_slowdown_ratio() -> f64 {
    0.5
}

/// Nav2's default of both limits.
const fn default_limit() -> f64 {
    0.5
}

/// Nav2's default.
const fn default_time_before_collision() -> f64 {
    2.0
}

const fn default_enabled() -> bool {
    true
}

/// A zone has a number out of range.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("the zone `{name}` has {key} = {value}: it must be {expected}")]
pub struct ZoneError {
    name: String,
    key: &'static str,
    value: f64,
    expected: &'static str,
}

impl ZonePolygon {
    fn check(&self) -> Result<(), ZoneError> {
        let count = self.points.len() as f64;
        let corners = self.points.iter().flat_map(|corner| [corner.x, corner.y]);
        let corners = corners.map(|value| ("points", COORDINATE, value));
        let numbers = NUMBERS.map(|(key, range, value)| (key, range, value(self)));
        let mut checks = [("number of points", range!(3 to 64), count)]
            .into_iter()
            .chain(corners)
            .chain(numbers);
        match checks.find(|(_, range, value)| !range.contains(*value)) {
            None => Ok(()),
            Some((key, range, value)) => {
                Err(ZoneError { name: self.name.clone(), key, value, expected: range.text })
            }
        }
    }

    /// Whether a point of the robot's frame lies in the zone: the even-odd rule.
    #[must_use]
    pub fn contains(&self, point: &Point) -> bool {
        is_in_polygon(&self.points, point)
    }

    /// Whether enough returns lie in the zone of a robot at a pose.
    fn acts(&self, points: &[RawPoint], pose: &Pose) -> bool {
        let inside = |point: &&RawPoint| self.contains(&pose.inverse_transform(&point.place));
        let counts = points.iter().filter(inside).map(|point| point.beams);
        counts.sum::<usize>() >= self.min_points
    }

    /// Factor of a command, 0 to 1, with which the zone permits it; 1 if the zone does not act. `step_s` is the step of the
    /// simulated motion, seconds.
    pub(super) fn factor(&self, points: &[RawPoint], command: &Twist, step_s: f64) -> f64 {
        if !self.enabled {
            return 1.0;
        }
        if self.action_type == ActionType::Approach {
            let time_s = self.time_to_collision(points, command, step_s);
            return (time_s / self.time_before_collision).min(1.0);
        }
        if !self.acts(points, &Pose::default()) {
            return 1.0;
        }
        let share = |limit: f64, rate: f64| if rate > limit { limit / rate } else { 1.0 };
        match self.action_type {
            ActionType::Slowdown => self.slowdown_ratio,
            ActionType::Limit => share(self.linear_limit, command.linear.abs())
                .min(share(self.angular_limit, command.angular.abs())),
            ActionType::Stop | ActionType::Approach => 0.0,
        }
    }

    /// Time for which a command keeps the zone clear, seconds; infinite beyond `time_before_collision`.
    fn time_to_collision(&self, points: &[RawPoint], command: &Twist, step_s: f64) -> f64 {
        let steps = (self.time_before_collision / step_s).ceil() as usize;
        (0..=steps)
            .map(|step| step as f64 * step_s)
            .find(|time_s| self.acts(points, &Pose::default().after(command, *time_s)))
            .unwrap_or(f64::INFINITY)
    }
}

/// The fixed zones of a robot.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Vec<ZonePolygon>")]
pub struct Polygons(Vec<ZonePolygon>);

impl Polygons {
    /// Creates the zones.
    ///
    /// # Errors
    /// Names the first zone with a number out of range, or too many zones.
    pub fn new(zones: Vec<ZonePolygon>) -> Result<Self, ZoneError> {
        if let Some(zone) = zones.get(MAX_ZONES) {
            let (name, value) = (zone.name.clone(), zones.len() as f64);
            return Err(ZoneError { name, key: "number of zones", value, expected: "at most 32" });
        }
        zones.iter().try_for_each(ZonePolygon::check)?;
        Ok(Self(zones))
    }

    /// The zones.
    #[must_use]
    pub fn zones(&self) -> &[ZonePolygon] {
        &self.0
    }
}

impl TryFrom<Vec<ZonePolygon>> for Polygons {
    type Error = ZoneError;

    fn try_from(zones: Vec<ZonePolygon>) -> Result<Self, ZoneError> {
        Self::new(zones)
    }
}

setting_schema! {
    Polygons: json!({ "type": "array", "maxItems": MAX_ZONES, "items": zone_schema() });
}

fn zone_schema() -> Value {
    let coordinate = COORDINATE.schema(json!({ "type": "number" }));
    let point = json!({ "type": "array", "minItems": 2, "maxItems": 2, "items": coordinate });
    let mut properties = json!({
        "name": { "type": "string" },
        "action_type": choices::<ActionType>(),
        "points": { "type": "array", "minItems": 3, "maxItems": 64, "items": point },
        "enabled": { "type": "boolean" },
    });
    for (key, range, _) in NUMBERS {
        let kind = if key == "min_points" { "integer" } else { "number" };
        properties[key] = range.schema(json!({ "type": kind }));
    }
    json!({
        "type": "object",
        "properties": properties,
        "required": ["name", "action_type", "points"],
        "additionalProperties": false,
    })
}
