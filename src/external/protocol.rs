//! The messages between inbye and a program: one JSON object per line, answered by one line.

use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::geometry::{Point, Pose, Twist};
use crate::local::ClearanceField;
use crate::map::{GridFrame, MovingDisc, ObstacleGrid, Scan, is_measurement};
use crate::navigator::Goal;
use crate::robot::{Disc, Footprint, Limits, Polygon};

/// Version of the protocol.
pub const PROTOCOL: u32 = 1;

/// A message to the program.
#[derive(Serialize)]
#[serde(tag = "type", rename_all = "snake_case")]
pub(crate) enum Request<'a> {
    /// The first message; the answer is [`Ready`].
    Start(Start<'a>),
    /// A tick of a controller; the answer is a [`Velocity`].
    Tick(Box<Tick<'a>>),
    /// A path to plan; the answer is a [`PlannedPath`].
    Plan(PathRequest<'a>),
    /// The first message to a simulator; the answer is [`Ready`].
    Simulate(Box<Simulate<'a>>),
    /// A step of a simulator; the answer is a [`SimulatedState`].
    Step(Step),
}

impl Request<'_> {
    /// The number of a message, which its answer may repeat; none for the first message.
    pub const fn number(&self) -> Option<u64> {
        match self {
            Self::Start(_) | Self::Simulate(_) => None,
            Self::Tick(tick) => Some(tick.tick),
            Self::Plan(plan) => Some(plan.request),
            Self::Step(step) => Some(step.step),
        }
    }
}

/// The number of the message that an answer is for, where the answer repeats it.
#[derive(Deserialize)]
pub(crate) struct AnsweredNumber {
    #[serde(alias = "request", alias = "step", default, deserialize_with = "number")]
    pub tick: Option<u64>,
}

/// Reads a whole number, or none. In some languages every number has a fraction: 3.0 is the whole number 3, as in JSON Schema.
fn number<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<u64>, D::Error> {
    let number: Option<serde_json::Number> = Option::deserialize(deserializer)?;
    let whole = |number: serde_json::Number| {
        let from_fraction = |value: f64| {
            let is_whole = value.fract() == 0.0 && (0.0..=MAX_EXACT).contains(&value);
            is_whole.then_some(value as u64)
        };
        let whole = number.as_u64().or_else(|| number.as_f64().and_then(from_fraction));
        whole.ok_or_else(|| {
            D::Error::custom(format!(
                "invalid value: {number}, expected a whole number, at least 0"
            ))
        })
    };
    number.map(whole).transpose()
}

fn version<'de, D: Deserializer<'de>>(deserializer: D) -> Result<u64, D::Error> {
    number(deserializer)?
        .ok_or_else(|| D::Error::custom("invalid type: null, expected a whole number"))
}

/// Largest number up to which an `f64` has every whole number, 2^53.
const MAX_EXACT: f64 = 9_007_199_254_740_992.0;

/// What the program serves as.
#[derive(Clone, Copy, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Role {
    Controller,
    GlobalPlanner,
}

#[derive(Serialize)]
pub(crate) struct Start<'a> {
    pub protocol: u32,
    pub role: Role,
    /// Control period, seconds.
    pub period_s: f64,
    /// Longest time of an answer by the wall clock, seconds; none in simulated time.
    pub budget_s: Option<f64>,
    /// Distance, metres, and angle, radians, within which the robot is at a goal; none for a global planner.
    pub goal_tolerance: Option<[f64; 2]>,
    pub robot: Robot<'a>,
}

#[derive(Serialize)]
pub(crate) struct Robot<'a> {
    /// Corners `[x, y]` of the body in the robot's frame, metres; none for a body of discs.
    footprint: Option<&'a [Point]>,
    discs: &'a [Disc],
    /// Radius around the robot's origin that contains the body, metres.
    radius_m: f64,
    limits: &'a Limits,
}

impl<'a> Robot<'a> {
    pub fn new(footprint: &'a Footprint, limits: &'a Limits) -> Self {
        Self {
            footprint: footprint.body().map(Polygon::corners),
            discs: footprint.discs(),
            radius_m: footprint.body_radius_m(),
            limits,
        }
    }
}

/// A part of the input that a program gets only if it wants it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Want {
    /// The static obstacles around the robot, at each tick.
    LocalGrid,
    /// Tracked moving obstacles, at each tick.
    MovingObstacles,
    /// The map, at the first tick.
    Map,
}

/// The answer to the first message.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object with `protocol`")]
pub(crate) struct Ready {
    #[serde(deserialize_with = "version")]
    pub protocol: u64,
    pub name: Option<String>,
    #[serde(default)]
    pub wants: Vec<Want>,
}

#[derive(Serialize)]
#[expect(clippy::struct_field_names, reason = "the number of a tick has its name in the protocol")]
pub(crate) struct Tick<'a> {
    /// Number of earlier ticks of this message.
    pub tick: u64,
    pub time_s: f64,
    pub pose: Pose,
    #[serde(serialize_with = "twist")]
    pub twist: Twist,
    pub odometry_s: f64,
    pub predicted_pose: Pose,
    #[serde(serialize_with = "twist")]
    pub predicted_twist: Twist,
    #[serde(serialize_with = "twist")]
    pub last_command: Twist,
    pub limits: &'a Limits,
    #[serde(serialize_with = "goal")]
    pub goal: Goal,
    pub local_target: Point,
    /// The path where it is new.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub path: Option<Vec<Point>>,
    pub path_progress_m: f64,
    /// Whether another goal begins with this tick.
    pub reset: bool,
    pub scan: ScanMessage<'a>,
    pub scan_s: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub moving_obstacles: Option<&'a [MovingDisc]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub local_grid: Option<GridMessage>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map: Option<&'a GridMessage>,
}

/// The answer to a tick: a velocity in m/s and rad/s, or why there is none.
#[derive(Deserialize)]
#[serde(try_from = "VelocityFields")]
pub(crate) enum Velocity {
    Velocity { linear: f64, angular: f64 },
    Error { error: String },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object with `linear` and `angular`, or `error`")]
struct VelocityFields {
    /// See [`AnsweredNumber`].
    #[serde(rename = "tick", default, deserialize_with = "number")]
    _tick: Option<u64>,
    linear: Option<f64>,
    angular: Option<f64>,
    error: Option<String>,
}

impl TryFrom<VelocityFields> for Velocity {
    type Error = &'static str;

    fn try_from(fields: VelocityFields) -> Result<Self, &'static str> {
        let VelocityFields { linear, angular, error, .. } = fields;
        match (linear, angular, error) {
            (Some(linear), Some(angular), None) => Ok(Self::Velocity { linear, angular }),
            (None, None, Some(error)) => Ok(Self::Error { error }),
            _ => Err("write either `linear` and `angular`, or `error`"),
        }
    }
}

#[derive(Serialize)]
pub(crate) struct PathRequest<'a> {
    /// Number of earlier requests.
    pub request: u64,
    pub start: Point,
    pub goal: Point,
    /// The distance that the path is to keep from obstacles, metres.
    pub radius_m: f64,
    pub grid: &'a GridMessage,
}

/// The answer to a request for a path: its points, or why there is none.
#[derive(Deserialize)]
#[serde(try_from = "PathFields")]
pub(crate) enum PlannedPath {
    Path(Vec<Point>),
    /// There is no path, for this reason: usually a text.
    Error(serde_json::Value),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object with `path`, or `error`")]
struct PathFields {
    /// See [`AnsweredNumber`].
    #[serde(rename = "request", default, deserialize_with = "number")]
    _request: Option<u64>,
    path: Option<Vec<Vec<f64>>>,
    error: Option<serde_json::Value>,
}

impl TryFrom<PathFields> for PlannedPath {
    type Error = String;

    fn try_from(fields: PathFields) -> Result<Self, String> {
        let point = |(index, numbers): (usize, Vec<f64>)| match *numbers {
            [x, y] => Ok(Point::new(x, y)),
            _ => {
                Err(format!("point {index} of `path` has {} numbers: write [x, y]", numbers.len()))
            }
        };
        let PathFields { path, error, .. } = fields;
        match (path, error) {
            (Some(path), None) => {
                path.into_iter().enumerate().map(point).collect::<Result<_, _>>().map(Self::Path)
            }
            (None, Some(error)) => Ok(Self::Error(error)),
            _ => Err("write either `path` or `error`".to_owned()),
        }
    }
}

/// A world and a robot to simulate.
#[derive(Serialize)]
pub(crate) struct Simulate<'a> {
    pub protocol: u32,
    pub period_s: f64,
    pub seed: u64,
    pub robot: Robot<'a>,
    pub track_width_m: f64,
    /// Pose of the robot, which stands.
    pub start: Pose,
    #[serde(serialize_with = "goal")]
    pub goal: Goal,
    pub lidar: LidarMessage,
    /// The true static obstacles.
    pub obstacles: GridMessage,
}

/// The lidar to simulate: beams at equal angles around the robot's x axis.
#[derive(Serialize)]
pub(crate) struct LidarMessage {
    pub beams: usize,
    pub field_of_view_rad: f64,
    pub range_max_m: f64,
    pub range_sigma_m: f64,
}

/// A command for a time, seconds; zero seconds for the state at the start.
#[derive(Serialize)]
#[expect(clippy::struct_field_names, reason = "the number of a step has its name in the protocol")]
pub(crate) struct Step {
    /// Number of earlier steps.
    pub step: u64,
    pub period_s: f64,
    pub linear: f64,
    pub angular: f64,
}

/// The state of a simulated robot after a step.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object with `odometry`, `scan` and `truth`")]
pub(crate) struct SimulatedState {
    /// See [`AnsweredNumber`].
    #[serde(rename = "step", default, deserialize_with = "number")]
    _step: Option<u64>,
    pub odometry: SimulatedMotion,
    pub scan: SimulatedScan,
    /// Pose in the map by positioning of the robot's own.
    pub pose: Option<[f64; 3]>,
    pub truth: SimulatedTruth,
}

/// Pose `[x, y, yaw]` and velocity `[linear, angular]`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SimulatedMotion {
    pub pose: [f64; 3],
    pub twist: [f64; 2],
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SimulatedTruth {
    pub pose: [f64; 3],
    pub twist: [f64; 2],
    /// Whether the robot has touched anything since the last step.
    pub contact: bool,
    /// Moving obstacles `[x, y, radius]`, the same ones at each step.
    #[serde(default)]
    pub moving: Vec<[f64; 3]>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SimulatedScan {
    /// Place of the lidar in the robot's frame, metres.
    #[serde(default)]
    pub origin: [f64; 2],
    pub angle_min: f64,
    pub angle_increment: f64,
    pub range_max: f64,
    /// `null` for no measurement, `range_max` or more for nothing within it.
    pub ranges: Vec<Option<f64>>,
}

impl SimulatedScan {
    pub fn into_scan(self) -> Scan {
        let Self { origin: [x, y], angle_min, angle_increment, range_max, ranges } = self;
        let range = |range: Option<f64>| match range {
            Some(range) if range >= range_max => f64::INFINITY,
            Some(range) => range,
            None => f64::NAN,
        };
        Scan {
            origin: Point::new(x, y),
            angle_min,
            angle_increment,
            range_max,
            ranges: ranges.into_iter().map(range).collect(),
        }
    }
}

#[derive(Serialize)]
pub(crate) struct ScanMessage<'a> {
    /// Place of the lidar in the robot's frame, metres.
    origin: [f64; 2],
    angle_min: f64,
    angle_increment: f64,
    range_max: f64,
    #[serde(serialize_with = "ranges")]
    ranges: (&'a [f64], f64),
}

impl<'a> ScanMessage<'a> {
    pub fn new(scan: &'a Scan) -> Self {
        let Scan { origin: Point { x, y }, angle_min, angle_increment, range_max, ref ranges } =
            *scan;
        Self { origin: [x, y], angle_min, angle_increment, range_max, ranges: (ranges, range_max) }
    }
}

/// A grid of occupied cells, by the lengths of its runs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct GridMessage {
    width: i32,
    height: i32,
    resolution_m: f64,
    /// Pose of the corner of the first cell in the map frame.
    origin: [f64; 3],
    /// Numbers of cells that are free, occupied, free, ... in turn, from the first cell on, row by row along x.
    runs: Vec<u32>,
}

impl GridMessage {
    pub fn of_grid(grid: &ObstacleGrid) -> Self {
        Self::new(grid.frame(), grid.cells().iter().copied())
    }

    pub fn of_field(field: &ClearanceField) -> Self {
        Self::new(field.frame(), field.units().iter().map(|units| *units == 0))
    }

    fn new(frame: &GridFrame, occupied: impl Iterator<Item = bool>) -> Self {
        let mut runs = vec![0];
        let mut is_occupied = false;
        for occupied in occupied {
            if occupied != is_occupied {
                runs.push(0);
                is_occupied = occupied;
            }
            if let Some(run) = runs.last_mut() {
                *run += 1;
            }
        }
        let GridFrame { width, height, resolution_m, origin } = *frame;
        Self { width, height, resolution_m, origin: [origin.x, origin.y, origin.yaw], runs }
    }
}

fn twist<S: Serializer>(twist: &Twist, out: S) -> Result<S::Ok, S::Error> {
    [twist.linear, twist.angular].serialize(out)
}

fn goal<S: Serializer>(goal: &Goal, out: S) -> Result<S::Ok, S::Error> {
    (goal.position.x, goal.position.y, goal.yaw).serialize(out)
}

/// Ranges in metres: `null` for no measurement, `range_max` for nothing within it. JSON has neither NaN nor infinity.
fn ranges<S: Serializer>((ranges, range_max): &(&[f64], f64), out: S) -> Result<S::Ok, S::Error> {
    let measured = |range: &f64| is_measurement(*range).then(|| range.min(*range_max));
    out.collect_seq(ranges.iter().map(measured))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grid_message_holds_alternating_runs_from_a_free_one() {
        let frame = GridFrame::new(3, 2, 0.5, Pose::new(1.0, 2.0, 0.0)).expect("a size");
        let runs = |cells: [bool; 6]| GridMessage::new(&frame, cells.into_iter()).runs;
        assert_eq!(runs([false; 6]), [6]);
        assert_eq!(runs([true; 6]), [0, 6]);
        assert_eq!(runs([false, true, true, false, false, true]), [1, 2, 2, 1]);
    }

    #[test]
    fn scan_message_has_null_without_measurement_and_the_largest_range_without_return() {
        let scan = Scan {
            angle_min: -1.0,
            angle_increment: 0.5,
            range_max: 8.0,
            ranges: vec![0.25, f64::NAN, f64::INFINITY, 9.0, -1.0],
            ..Scan::default()
        };
        let text = serde_json::to_string(&ScanMessage::new(&scan)).expect("JSON");
        assert_eq!(
            text,
            r#"{"origin":[0.0,0.0],"angle_min":-1.0,"angle_increment":0.5,"range_max":8.0,"ranges":[0.25,null,8.0,8.0,null]}"#
        );
    }

    #[test]
    fn answers_with_unknown_or_missing_fields_are_rejected() {
        let is_velocity = |text: &str| serde_json::from_str::<Velocity>(text).is_ok();
        assert!(is_velocity(r#"{"linear": 0.5, "angular": -1}"#));
        assert!(is_velocity(r#"{"error": "no way out"}"#));
        for wrong in ["{}", "3", r#"{"linear": 0.5}"#, r#"{"linear": 0.5, "angular": null}"#] {
            assert!(!is_velocity(wrong), "{wrong}");
        }
        let is_ready = |text: &str| serde_json::from_str::<Ready>(text).is_ok();
        assert!(is_ready(r#"{"protocol": 1, "wants": ["map", "local_grid"]}"#));
        assert!(!is_ready(r#"{"protocol": 1, "wants": ["maps"]}"#));
        assert!(!is_ready(r#"{"protocol": 1, "need": []}"#));
    }

    #[test]
    fn wrong_path_answers_say_what_is_wrong() {
        let error = |text: &str| match serde_json::from_str::<PlannedPath>(text) {
            Ok(_) => String::new(),
            Err(error) => error.to_string(),
        };
        assert_eq!(error(r#"{"path": [[1, 2], [3, 4]]}"#), "");
        assert_eq!(error(r#"{"error": "no way"}"#), "");
        for (answer, expected) in [
            (r#"{"path": [[1, 2], [3, 4, 0]]}"#, "point 1 of `path` has 3 numbers: write [x, y]"),
            (
                r#"{"path": [[1, 2]], "cost": 3}"#,
                "unknown field `cost`, expected one of `request`, `path`, `error`",
            ),
            (r#"{"path": [[1, 2]], "error": "a"}"#, "write either `path` or `error`"),
            ("{}", "write either `path` or `error`"),
        ] {
            assert!(error(answer).starts_with(expected), "{answer}: {}", error(answer));
        }
    }
}
