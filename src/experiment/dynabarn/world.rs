//! A world of scripted cylinders, read from JSON.

use std::fs;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::DynaBarnError;
use crate::experiment::world_numbers::select_worlds;
use crate::geometry::{Point, Pose};
use crate::map::MovingDisc;
use crate::sim::TimedPath;

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
) -> Result<Vec<DynaBarnWorld>, DynaBarnError> {
    let unreadable = |error: std::io::Error| DynaBarnError::Unreadable {
        file: folder.to_owned(),
        reason: error.to_string(),
    };
    let mut files: Vec<PathBuf> = Vec::new();
    for entry in fs::read_dir(folder).map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let is_json = path.extension().is_some_and(|ending| ending == "json");
        if name.starts_with("world_") && is_json {
            files.push(path);
        }
    }
    if files.is_empty() {
        let folder = folder.to_owned();
        return Err(DynaBarnError::NoWorld { folder });
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
pub fn read_world(file: &Path) -> Result<DynaBarnWorld, DynaBarnError> {
    let text = fs::read_to_string(file).map_err(|error| DynaBarnError::Unreadable {
        file: file.to_owned(),
        reason: error.to_string(),
    })?;
    parse_world(&text, file)
}

/// A world from the text of its file.
///
/// # Errors
/// Fails when it is no world, or has a number out of range; the message names the file and the number.
pub fn parse_world(text: &str, file: &Path) -> Result<DynaBarnWorld, DynaBarnError> {
    let read: WorldFile = serde_json::from_str(text).map_err(|error| DynaBarnError::NotAWorld {
        file: file.to_owned(),
        reason: error.to_string(),
    })?;
    let check = Check { file };
    for (name, value) in ["x", "y", "yaw"].iter().zip(read.start_x_y_yaw) {
        check.near(format!("start {name}"), value)?;
    }
    for (name, value) in ["x", "y"].iter().zip(read.goal_x_y) {
        check.near(format!("goal {name}"), value)?;
    }
    let obstacles = read.obstacles.into_iter().enumerate();
    Ok(DynaBarnWorld {
        number: read.world,
        start: read.start_x_y_yaw.into(),
        goal: read.goal_x_y.into(),
        cylinders: obstacles
            .map(|(index, obstacle)| check.cylinder(index, obstacle))
            .collect::<Result<_, _>>()?,
    })
}

/// Checks the numbers of a file.
struct Check<'a> {
    file: &'a Path,
}

impl Check<'_> {
    fn cylinder(
        &self,
        index: usize,
        obstacle: ObstacleFile,
    ) -> Result<ScriptedCylinder, DynaBarnError> {
        let of = |what: &str| format!("obstacle {index}: {what}");
        let above_zero = "above zero and at most 1000";
        let fits = |value: f64| value > 0.0 && value <= 1000.0;
        let ObstacleFile { radius_m, loop_s, keyframes_t_x_y } = obstacle;
        self.number(of("radius_m"), radius_m, fits(radius_m), above_zero)?;
        let count = keyframes_t_x_y.len();
        self.number(of("number of keyframes"), count as f64, count > 0, "at least one")?;
        let mut latest_s = -1.0;
        for (key, &[time_s, x, y]) in keyframes_t_x_y.iter().enumerate() {
            let of = |what: &str| format!("obstacle {index}: keyframe {key}: {what}");
            let ascends = time_s >= 0.0 && time_s > latest_s;
            let expected = "at least zero and after the one before";
            self.number(of("time"), time_s, ascends, expected)?;
            self.near(of("x"), x)?;
            self.near(of("y"), y)?;
            latest_s = time_s;
        }
        let lasts = fits(loop_s) && loop_s >= latest_s;
        let expected = "above zero, at most 1000 and not before the last keyframe";
        self.number(of("loop_s"), loop_s, lasts, expected)?;
        let key = |[time_s, x, y]: [f64; 3]| (time_s, Point::new(x, y));
        let keys: Vec<_> = keyframes_t_x_y.into_iter().map(key).collect();
        let script =
            TimedPath::new(&keys, Some(loop_s)).map_err(|error| DynaBarnError::NotAWorld {
                file: self.file.to_owned(),
                reason: format!("obstacle {index}: {error}"),
            })?;
        Ok(ScriptedCylinder { radius_m, script: script.on_spline() })
    }

    fn near(&self, place: String, value: f64) -> Result<(), DynaBarnError> {
        self.number(place, value, value.abs() <= 1000.0, "-1000 to 1000")
    }

    fn number(
        &self,
        place: String,
        value: f64,
        fits: bool,
        expected: &'static str,
    ) -> Result<(), DynaBarnError> {
        if fits {
            return Ok(());
        }
        Err(DynaBarnError::BadNumber { file: self.file.to_owned(), place, value, expected })
    }
}

impl ScriptedCylinder {
    /// The cylinder's position and velocity at a time, seconds, at least zero.
    #[must_use]
    pub fn at(&self, time_s: f64) -> MovingDisc {
        let (place, velocity) = self.script.at(time_s);
        MovingDisc { x: place.x, y: place.y, radius: self.radius_m, vx: velocity.x, vy: velocity.y }
    }
}
