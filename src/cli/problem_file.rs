//! Parses `problem.json`: the input of one decision.

use std::path::Path;
use std::sync::Arc;

use anyhow::{Context, anyhow, bail, ensure};
use inbye::geometry::{Point, Pose, Twist};
use inbye::input_file::read_text;
use inbye::local::{
    ClearanceField, DecisionInput, LocalSettings, Normalization, Outside, Problem, Sampler,
    Stopping, Weights,
};
use inbye::map::{MovingDisc, OccupancyGrid, UnknownPolicy, has_own_resolution};
use inbye::robot::{Footprint, Limits};
use inbye::runtime::plain_message;
use inbye::settings::{KeyError, SettingError, line_in_json, read_json};
use serde::Deserialize;

/// The text under `inbye evaluate --help`.
pub const HELP: &str = concat!(
    "Example:\n  inbye evaluate --problem problem.json --samples --json\n\nproblem.json:\n",
    include_str!("problem_example.json"),
    "\nRows run from the largest y down: # wall, . free, ? unknown; or \"map\": {\"file\": \"mine.yaml\"}.\n\
     map, robot.pose and target are required; key_node is the target when left out, and every other key has a default. Poses are metres and radians, x forward, y left, yaw counter-clockwise.\n\
     Exit status 1: no sample is admissible."
);

/// Longest quotation of a line in an error, up to the place of the error, characters.
const MAX_QUOTE: usize = 40;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object with map, robot and target")]
struct ProblemFile {
    map: MapSource,
    robot: RobotState,
    #[serde(default)]
    limits: Limits,
    vx_samples: Option<u32>,
    vtheta_samples: Option<u32>,
    #[serde(default)]
    sampler: Sampler,
    ramp_time_s: Option<f64>,
    sampler_seed: Option<u32>,
    control_period_s: Option<f64>,
    sim_time_s: Option<f64>,
    sim_step_s: Option<f64>,
    max_clearance_m: Option<f64>,
    #[serde(default)]
    outside: Outside,
    #[serde(default)]
    unknown: UnknownPolicy,
    #[serde(default)]
    obstacles: Vec<MovingDisc>,
    target: [f64; 2],
    key_node: Option<[f64; 2]>,
    #[serde(default)]
    weights: Weights,
    #[serde(default)]
    normalization: Normalization,
    #[serde(default)]
    stopping: Stopping,
}

/// The map of a problem: rows of text or a file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MapSource {
    resolution_m: Option<f64>,
    origin: Option<Vec<f64>>,
    rows: Option<Vec<String>>,
    file: Option<String>,
}

impl MapSource {
    /// The keys that only a map of rows has are errors with a file: they would do nothing.
    fn check(&self) -> anyhow::Result<()> {
        ensure!(
            self.name().is_none() || self.origin.is_none(),
            "map.origin: it is only for map.rows: leave it out"
        );
        Ok(())
    }

    /// Whether the size of a cell is stated.
    #[cfg(feature = "playground")]
    pub const fn has_resolution(&self) -> bool {
        self.resolution_m.is_some()
    }

    /// The file name; none if the map is given as rows.
    pub fn name(&self) -> Option<&str> {
        match self {
            Self { rows: None, file: Some(name), .. } => Some(name),
            _ => None,
        }
    }
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RobotState {
    pose: [f64; 3],
    #[serde(default)]
    velocity: [f64; 2],
    last_command: Option<[f64; 2]>,
    footprint: Option<Footprint>,
}

/// Reads a problem and its map. `load` gets the file of a map and the resolution for formats without their own.
pub fn read(
    file: &Path,
    load: impl Fn(&Path, f64) -> anyhow::Result<OccupancyGrid>,
) -> anyhow::Result<(Problem, OccupancyGrid)> {
    let text = read_text(file).with_context(|| format!("--problem {}", file.display()))?;
    // The map is relative to the problem, like a map's image to its YAML file.
    let folder = file.parent().unwrap_or(Path::new(""));
    parse(&text, |map, resolution_m| load(&folder.join(map), resolution_m))
        .with_context(|| file.display().to_string())
}

/// Parses the text of a problem. `load` loads a map file.
pub fn parse(
    text: &str,
    load: impl Fn(&str, f64) -> anyhow::Result<OccupancyGrid>,
) -> anyhow::Result<(Problem, OccupancyGrid)> {
    let mut map = None;
    let problem = parse_on(text, |source, unknown| {
        let map = map.insert(occupancy(source, load)?);
        Ok(Arc::new(ClearanceField::new(&map.obstacles(unknown))?))
    })?;
    Ok((problem, map.context("the problem has no map")?))
}

/// Like [`parse`], with a function that returns the clearance field for a map and the policy for unknown cells.
pub fn parse_on(
    text: &str,
    field: impl FnOnce(&MapSource, UnknownPolicy) -> anyhow::Result<Arc<ClearanceField>>,
) -> anyhow::Result<Problem> {
    let file: ProblemFile = read_json(text).map_err(|error| anyhow!(one_line(&error, text)))?;
    let at = |key: &str| format!("line {}", line_in_json(key, text).unwrap_or(1));
    let field = file.map.check().and_then(|()| field(&file.map, file.unknown));
    let field = field.with_context(|| at("map"))?;
    problem(file, &field).map_err(|error| {
        let place = at(&error.key_path().unwrap_or_default());
        anyhow!(error).context(place)
    })
}

fn one_line(error: &serde_json::Error, text: &str) -> String {
    if text.trim().is_empty() {
        return "it is empty: write an object with map, robot and target".to_owned();
    }
    let (line, column) = (error.line(), error.column());
    let read: Vec<char> =
        text.lines().nth(line.saturating_sub(1)).unwrap_or_default().chars().take(column).collect();
    let quote: String = read[read.len().saturating_sub(MAX_QUOTE)..].iter().collect();
    let text = error.to_string();
    let message = text.rsplit_once(" at line ").map_or(&*text, |(message, _)| message);
    let message = plain_message(message, |_| None);
    format!("line {line}, column {column}, after `{}`: {message}", quote.trim())
}

fn problem(file: ProblemFile, field: &Arc<ClearanceField>) -> Result<Problem, SettingError> {
    file.limits.validate().map_err(|error| error.in_table("limits"))?;
    let mut settings = LocalSettings::default();
    settings.vx_samples = file.vx_samples.unwrap_or(settings.vx_samples);
    settings.vtheta_samples = file.vtheta_samples.unwrap_or(settings.vtheta_samples);
    settings.sampler = file.sampler;
    settings.ramp_time_s = file.ramp_time_s.unwrap_or(settings.ramp_time_s);
    settings.sampler_seed = file.sampler_seed.unwrap_or(settings.sampler_seed);
    settings.control_period_s = file.control_period_s.unwrap_or(settings.control_period_s);
    settings.sim_time_s = file.sim_time_s.unwrap_or(settings.sim_time_s);
    settings.sim_step_s = file.sim_step_s.unwrap_or(settings.sim_step_s);
    settings.max_clearance_m = file.max_clearance_m.unwrap_or(settings.max_clearance_m);
    settings.outside = file.outside;
    settings.weights = file.weights;
    settings.normalization = file.normalization;
    settings.stopping = file.stopping;
    settings.validate()?;
    let velocity = |[linear, angular]: [f64; 2]| Twist::new(linear, angular);
    let twist = velocity(file.robot.velocity);
    let default_footprint = || inbye::runtime::RobotConfig::default().footprint;
    let footprint = file.robot.footprint.unwrap_or_else(default_footprint);
    let point = |[x, y]: [f64; 2]| Point::new(x, y);
    let input = DecisionInput {
        field,
        pose: Pose::from(file.robot.pose),
        twist,
        last_command: file.robot.last_command.map_or(twist, velocity),
        obstacles: &file.obstacles,
        target: point(file.target),
        key_node: point(file.key_node.unwrap_or(file.target)),
        limits: file.limits,
        footprint: &footprint,
        weights: settings.weights,
    };
    Ok(input.problem(&settings))
}

fn occupancy(
    source: &MapSource,
    load: impl Fn(&str, f64) -> anyhow::Result<OccupancyGrid>,
) -> anyhow::Result<OccupancyGrid> {
    if let Some(file) = source.name() {
        ensure!(
            source.resolution_m.is_none() || !has_own_resolution(Path::new(file)),
            "map.resolution_m: {file} states its own resolution: leave it out"
        );
        return load(file, source.resolution_m.unwrap_or(1.0));
    }
    let MapSource { rows: Some(rows), file: None, .. } = source else {
        bail!("map needs either `rows` or `file`");
    };
    let origin = match source.origin.as_deref() {
        None => Pose::default(),
        Some(&[x, y]) => Pose::new(x, y, 0.0),
        Some(&[x, y, yaw]) => Pose::new(x, y, yaw),
        Some(_) => bail!("map.origin must be [x, y] or [x, y, yaw]"),
    };
    let Some(resolution_m) = source.resolution_m else {
        bail!("map.rows needs map.resolution_m, the side of a cell in metres");
    };
    OccupancyGrid::from_rows(rows, resolution_m, origin).context("map.rows")
}
