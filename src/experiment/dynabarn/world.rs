//! A world of scripted cylinders: its file, its simulation, and the cause of a contact in it.

use std::path::Path;
use std::sync::Arc;

use serde::Deserialize;

use super::{ContactAttribution, State};
use crate::experiment::plan::require;
use crate::experiment::plan_worlds::select_worlds;
use crate::experiment::{ContactCause, ExperimentError};
use crate::geometry::{Point, Pose};
use crate::input_file::list;
use crate::map::{GridFrame, MapError, MovingDisc, OccupancyGrid};
use crate::navigator::Goal;
use crate::runtime::{Config, Contact, Mission, MissionResult, TraceRow};
use crate::settings::{KeyError, line_in_json};
use crate::sim::{MovingObstacle, MovingObstacles, Simulation, TimedPath};

/// The goal is reached when the true pose is this close to it, metres: the rule of the BARN Challenge.
const GOAL_RADIUS_M: f64 = 1.0;
/// A run ends after this time, seconds: also that challenge's rule.
const TIME_LIMIT_S: f64 = 100.0;
/// Side of a cell of the robot's map, metres.
const RESOLUTION_M: f64 = 0.05;
/// Free margin around start, goal and all keyframes, metres; the border beyond it is solid.
const MARGIN_M: f64 = 3.0;

/// A cylinder that repeats its script.
#[derive(Clone, Debug, PartialEq)]
pub struct ScriptedCylinder {
    /// Its radius, metres, above zero.
    pub radius_m: f64,
    /// Its positions over time; at the end it jumps back to the first.
    pub script: TimedPath,
}

/// A world.
#[derive(Clone, Debug, PartialEq)]
pub struct DynaBarnWorld {
    /// Its number in the benchmark.
    pub number: u32,
    /// Where the robot starts.
    pub start: Pose,
    /// The goal.
    pub goal: Point,
    /// The moving cylinders.
    pub cylinders: Vec<ScriptedCylinder>,
}

/// The file.
#[derive(Deserialize)]
struct WorldFile {
    world: u32,
    start_x_y_yaw: [f64; 3],
    goal_x_y: [f64; 2],
    obstacles: Vec<ObstacleFile>,
}

#[derive(Deserialize)]
struct ObstacleFile {
    radius_m: f64,
    loop_s: f64,
    keyframes_t_x_y: Vec<[f64; 3]>,
}

/// Reads the worlds of a folder, `world_*.json`, or those of the given numbers, in the order of their numbers.
///
/// # Errors
/// Fails when the folder cannot be read, holds no world or lacks a requested one, or a world is invalid.
pub fn read_worlds(
    folder: &Path,
    only: Option<&[u32]>,
) -> Result<Vec<DynaBarnWorld>, ExperimentError> {
    let mut files =
        list(folder).map_err(|error| ExperimentError::file(folder, error.to_string()))?;
    files.retain(|path| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        name.starts_with("world_") && path.extension().is_some_and(|ending| ending == "json")
    });
    if files.is_empty() {
        let reason = "holds no world_NN.json: check that it is the right folder";
        return Err(ExperimentError::file(folder, reason));
    }
    let worlds = files.iter().map(|file| read_world(file));
    let mut worlds = worlds.collect::<Result<Vec<_>, _>>()?;
    worlds.sort_by_key(|world| world.number);
    select_worlds(&mut worlds, |world| world.number, only, folder)?;
    Ok(worlds)
}

/// Reads a world.
///
/// # Errors
/// Fails when the file cannot be read, is no world, or has a number out of range; the message names the file and the number.
#[doc(hidden)]
pub fn read_world(file: &Path) -> Result<DynaBarnWorld, ExperimentError> {
    parse_world(&ExperimentError::read(file)?, file)
}

/// A world from the text of its file.
///
/// # Errors
/// Fails when it is no world, or has a number out of range; the message names the file and the number.
#[doc(hidden)]
pub fn parse_world(text: &str, file: &Path) -> Result<DynaBarnWorld, ExperimentError> {
    let read: WorldFile = serde_json::from_str(text).map_err(|error| {
        ExperimentError::file(file, format!("no world of moving cylinders: {error}"))
    })?;
    world(read).map_err(|error| {
        let line = error.key_path().and_then(|path| line_in_json(&path, text)).unwrap_or(1);
        ExperimentError::file(file, format!("line {line}: {error}"))
    })
}

/// The world of a file; an error names the key.
fn world(file: WorldFile) -> Result<DynaBarnWorld, ExperimentError> {
    all_near("start_x_y_yaw", &file.start_x_y_yaw)?;
    all_near("goal_x_y", &file.goal_x_y)?;
    let obstacles = file.obstacles.into_iter().enumerate();
    let cylinders = obstacles.map(|(index, obstacle)| {
        cylinder(obstacle).map_err(|error| error.in_table(&format!("obstacles.{index}")))
    });
    Ok(DynaBarnWorld {
        number: file.world,
        start: file.start_x_y_yaw.into(),
        goal: file.goal_x_y.into(),
        cylinders: cylinders.collect::<Result<_, _>>()?,
    })
}

/// Checks that coordinates are within 1000 m.
fn all_near(key: &str, values: &[f64]) -> Result<(), ExperimentError> {
    values.iter().enumerate().try_for_each(|(index, value)| {
        require(value.abs() <= 1000.0, &format!("{key}.{index}"), value, "-1000 to 1000")
    })
}

fn cylinder(obstacle: ObstacleFile) -> Result<ScriptedCylinder, ExperimentError> {
    let fits = |value: f64| value > 0.0 && value <= 1000.0;
    let ObstacleFile { radius_m, loop_s, keyframes_t_x_y } = obstacle;
    require(fits(radius_m), "radius_m", radius_m, "above zero and at most 1000")?;
    require(!keyframes_t_x_y.is_empty(), "keyframes_t_x_y", "empty", "at least one keyframe")?;
    let mut latest_s = -1.0;
    for (index, &[time_s, x, y]) in keyframes_t_x_y.iter().enumerate() {
        let key = format!("keyframes_t_x_y.{index}");
        let ascends = time_s >= 0.0 && time_s > latest_s;
        require(
            ascends,
            &key,
            time_s,
            "a time of at least zero and after the one before, and x, y",
        )?;
        all_near(&key, &[time_s, x, y])?;
        latest_s = time_s;
    }
    let lasts = fits(loop_s) && loop_s >= latest_s;
    let expected = "above zero, at most 1000 and not before the last keyframe";
    require(lasts, "loop_s", loop_s, expected)?;
    let key = |[time_s, x, y]: [f64; 3]| (time_s, Point::new(x, y));
    let keys: Vec<_> = keyframes_t_x_y.into_iter().map(key).collect();
    let script = TimedPath::new(&keys, Some(loop_s)).map_err(|error| {
        let (place, reason) = ("keyframes_t_x_y".to_owned(), error.to_string());
        ExperimentError::Unusable { place, reason }
    })?;
    Ok(ScriptedCylinder { radius_m, script: script.on_spline() })
}

impl ScriptedCylinder {
    /// The cylinder's position and velocity at a time, seconds, at least zero.
    #[must_use]
    pub fn at(&self, time_s: f64) -> MovingDisc {
        let (place, velocity) = self.script.at(time_s);
        MovingDisc { x: place.x, y: place.y, radius: self.radius_m, vx: velocity.x, vy: velocity.y }
    }
}

impl DynaBarnWorld {
    /// The simulation of a seed: an empty map, which is also the truth, and the moving cylinders.
    ///
    /// # Errors
    /// Fails when the world is too large for a grid, or a cylinder cannot move as described.
    pub fn simulation(&self, seed: u64) -> Result<Simulation, ExperimentError> {
        let map = empty_map(self)?;
        let moving = self.cylinders.iter().map(|cylinder| {
            // It ignores the robot.
            MovingObstacle::timed_path(cylinder.radius_m, cylinder.script.clone())
        });
        let moving = moving.collect::<Result<Vec<_>, _>>()?;
        let goal = Goal::at(self.goal);
        Ok(Simulation {
            moving_obstacles: MovingObstacles::new(moving),
            seed,
            ..Simulation::new(Mission {
                time_limit_s: TIME_LIMIT_S,
                done_within_m: Some(GOAL_RADIUS_M),
                ..Mission::new(Arc::new(map), self.start, goal)
            })
        })
    }

    /// The cause of the contact that ended a run; none without contact.
    pub(in crate::experiment) fn contact_cause(
        &self,
        result: &MissionResult,
        config: &Config,
    ) -> Option<ContactCause> {
        let rows = &result.trace.rows;
        let last = rows.last().filter(|_| result.collided)?;
        let attribution = ContactAttribution {
            footprint: &config.robot.footprint,
            limits: &config.robot.limits,
            moving: &|time_s| self.moving(time_s),
        };
        let states: Vec<State> = rows.iter().map(state).collect();
        let cause = |Contact { time_s, pose, .. }| {
            let contact = State { time_s, pose, ..state(last) };
            let before = ContactAttribution::before(&states, &contact)?;
            Some(attribution.cause(before, &contact))
        };
        Some(result.contact.and_then(cause).unwrap_or(ContactCause::Robot))
    }

    /// The true positions of the cylinders at a time, seconds.
    fn moving(&self, time_s: f64) -> Vec<MovingDisc> {
        let at = |cylinder: &ScriptedCylinder| cylinder.at(time_s);
        self.cylinders.iter().map(at).collect()
    }
}

/// An empty map with a margin around everything that happens on it.
fn empty_map(world: &DynaBarnWorld) -> Result<OccupancyGrid, MapError> {
    let ends = [world.start.position(), world.goal];
    let keys = world.cylinders.iter().flat_map(|it| it.script.keys());
    let [low, high] = Point::bounds(keys.map(|key| key.1).chain(ends)).unwrap_or_default();
    let cells = |from: f64, to: f64| ((to - from + 2.0 * MARGIN_M) / RESOLUTION_M).ceil() as i32;
    let frame = GridFrame::new(
        cells(low.x, high.x),
        cells(low.y, high.y),
        RESOLUTION_M,
        [low.x - MARGIN_M, low.y - MARGIN_M, 0.0].into(),
    )?;
    Ok(OccupancyGrid::filled(frame, 0))
}

const fn state(row: &TraceRow) -> State {
    State { time_s: row.time_s, pose: row.pose, twist: row.twist }
}
