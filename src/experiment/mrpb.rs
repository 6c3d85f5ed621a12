//! The worlds of MRPB 1.0 (Wen et al., "MRPB 1.0: A Unified Benchmark for the Evaluation of Mobile Robot Local Planning
//! Approaches", ICRA 2021): maps of rooms and mazes, each with three starts and goals.
//!
//! A folder of a world has `map.yaml` and `config.txt`, the arguments of MRPB's launch files. Where a world is called
//! `NAME_partially_unknown`, the robot has its map, and the obstacles are those of the world `NAME`. A file `NAME_dynamic.txt` has
//! starts and goals for the world `NAME` among people; the scripts of MRPB's people are not part of its maps.
//!
//! The robot is MRPB's Pioneer 3-DX with a Hokuyo UTM-30LX, with radius, speeds, accelerations, tolerances and control rate of the
//! parameters of its DWA (`move_base_benchmark/params`). Its planners go through unknown cells, and so does inbye here.

use core::f64::consts::PI;
use std::path::Path;
use std::sync::Arc;

use super::world::Route;
use super::{ExperimentError, World, WorldKind, WorldSettings};
use crate::base::CollisionMonitorSettings;
use crate::geometry::{Point, Pose};
use crate::input_file::list;
use crate::local::LocalSettings;
use crate::map::{LoadOptions, OccupancyGrid, UnknownPolicy, load};
use crate::navigator::{Goal, NavigatorSettings};
use crate::robot::{Footprint, Limits, RobotError};
use crate::runtime::{Config, RobotConfig, SimulationSettings};
use crate::sim::Lidar;

/// Ending of the name of a world whose map lacks obstacles.
const PARTIAL: &str = "_partially_unknown";
/// Ending of the name of a file with starts and goals among people.
const DYNAMIC: &str = "_dynamic";

/// Radius of the robot with its padding, metres, and the distance that it keeps beyond that.
const RADIUS_M: f64 = 0.26;
const MARGIN_M: f64 = 0.02;

/// The robot and its tolerances.
fn config() -> Result<Config, RobotError> {
    Ok(Config {
        unknown: UnknownPolicy::Free,
        robot: RobotConfig {
            footprint: Footprint::round(RADIUS_M)?,
            track_width_m: 0.33,
            limits: Limits {
                // Its DWA does not reverse, its TEB does, at this speed.
                min_vel_x: -0.2,
                max_vel_x: 0.55,
                max_vel_theta: 1.0,
                acc_lim_x: 2.5,
                decel_lim_x: -2.5,
                acc_lim_theta: 3.2,
                decel_lim_theta: -3.2,
            },
        },
        local: LocalSettings { control_period_s: 0.05, ..LocalSettings::default() },
        navigator: NavigatorSettings {
            xy_goal_tolerance: 0.2,
            yaw_goal_tolerance: 0.1,
            // It stops within these, as MRPB's planners do.
            xy_parking_tolerance: 0.2,
            yaw_parking_tolerance: 0.1,
            safety_margin_m: MARGIN_M,
            ..NavigatorSettings::default()
        },
        collision_monitor: CollisionMonitorSettings {
            margin_m: MARGIN_M,
            ..CollisionMonitorSettings::default()
        },
        simulation: SimulationSettings {
            lidar: Lidar {
                beams: 1081,
                field_of_view_rad: 1.5 * PI,
                range_max_m: 30.0,
                ..Lidar::default()
            },
            ..SimulationSettings::default()
        },
        ..Config::default()
    })
}

/// Start and goal of a test.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Test {
    start: Pose,
    goal: Pose,
}

/// Reads the worlds of a folder, in the order of their names: each test of each world. `people` walk in those among people.
///
/// # Errors
/// [`ExperimentError`] names the file and what is wrong with it.
pub(super) fn read_worlds(folder: &Path, people: usize) -> Result<Vec<World>, ExperimentError> {
    let paths = list(folder).map_err(|error| ExperimentError::file(folder, error.to_string()))?;
    let settings = config().map_err(|error| ExperimentError::file(folder, error.to_string()))?;
    let (settings, mut worlds) = (Arc::new(settings.into()), Vec::new());
    for path in paths {
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        if path.join("map.yaml").is_file() {
            let of_truth = name.strip_suffix(PARTIAL).map(|name| folder.join(name));
            let truth = of_truth.map(|truth| map(&truth)).transpose()?;
            let tests = tests(&path.join("config.txt"))?;
            worlds.extend(routes(&settings, &name, &map(&path)?, truth.as_ref(), &tests, 0));
        } else if let Some(of) = name.strip_suffix(DYNAMIC).filter(|_| path.is_file()) {
            let map = map(&folder.join(of))?;
            worlds.extend(routes(&settings, &name, &map, None, &tests(&path)?, people));
        }
    }
    if worlds.is_empty() {
        let reason = "no folder in it has a map.yaml: name the folder with the worlds of MRPB";
        return Err(ExperimentError::file(folder, reason));
    }
    Ok(worlds)
}

fn map(folder: &Path) -> Result<Arc<OccupancyGrid>, ExperimentError> {
    Ok(Arc::new(load(&folder.join("map.yaml"), &LoadOptions::default())?))
}

fn routes<'a>(
    settings: &'a Arc<WorldSettings>,
    name: &'a str,
    map: &'a Arc<OccupancyGrid>,
    truth: Option<&'a Arc<OccupancyGrid>>,
    tests: &'a [Test],
    people: usize,
) -> impl Iterator<Item = World> + 'a {
    tests.iter().enumerate().map(move |(index, test)| {
        let goal = Goal { position: test.goal.position(), yaw: Some(test.goal.yaw) };
        let route = Route {
            people,
            truth: truth.cloned(),
            ..Route::new(Arc::clone(map), test.start, goal)
        };
        let settings = Arc::clone(settings);
        World {
            settings,
            ..World::route(WorldKind::Mrpb, format!("{name} test {}", index + 1), route)
        }
    })
}

/// The tests of a file of launch arguments.
fn tests(file: &Path) -> Result<Vec<Test>, ExperimentError> {
    parse(&ExperimentError::read(file)?).map_err(|reason| ExperimentError::file(file, reason))
}

/// The arguments of a test, in any order; a repeated one begins the next test.
const ARGUMENTS: [&str; 6] = [
    "initial_pose_x",
    "initial_pose_y",
    "initial_pose_a",
    "goal_pose_x",
    "goal_pose_y",
    "goal_pose_a",
];

fn parse(text: &str) -> Result<Vec<Test>, String> {
    let mut tests = Vec::new();
    let mut values = [None; ARGUMENTS.len()];
    for (index, line) in text.lines().enumerate() {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let wrong = |what: &str| format!("line {}: {what}", index + 1);
        let quoted: Vec<&str> = line.split('"').collect();
        let &[begin, name, between, value, _] = quoted.as_slice() else {
            return Err(wrong("write <arg name=\"initial_pose_x\" default=\"1.0\"/>"));
        };
        if !begin.ends_with("name=") || !between.trim().eq("default=") {
            return Err(wrong("write <arg name=\"initial_pose_x\" default=\"1.0\"/>"));
        }
        let place = ARGUMENTS.iter().position(|argument| *argument == name);
        let place = place.ok_or_else(|| wrong(&format!("`{name}` is no start and no goal")))?;
        let number = value.parse().ok().filter(|number: &f64| number.abs() <= 1e6);
        let number = number.ok_or_else(|| wrong(&format!("`{value}` is no number")))?;
        if values[place].replace(number).is_some() {
            return Err(wrong(&format!("{name} occurs twice in a test")));
        }
        if let [Some(x), Some(y), Some(yaw), Some(goal_x), Some(goal_y), Some(goal_yaw)] = values {
            let (start, goal) = (Pose::new(x, y, yaw), Point::new(goal_x, goal_y));
            tests.push(Test { start, goal: Pose::new(goal.x, goal.y, goal_yaw) });
            values = [None; ARGUMENTS.len()];
        }
    }
    if values != [None; ARGUMENTS.len()] {
        return Err("the last test lacks some of its six arguments".to_owned());
    }
    if tests.is_empty() { Err("it has no test".to_owned()) } else { Ok(tests) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEST: &str = "# Test 1\n<arg name=\"initial_pose_x\" default=\"8.5\"/>\n<arg name=\"initial_pose_y\" default=\"-12\"/>\n\
        <arg name=\"initial_pose_a\" default=\"1.5\"/>\n\n<arg name=\"goal_pose_x\" default=\"2\"/>\n\
        <arg name=\"goal_pose_y\" default=\"10\"/>\n<arg name=\"goal_pose_a\" default=\"3\"/>\n";

    #[test]
    fn launch_arguments_give_a_start_and_a_goal_for_each_test() {
        let test = Test { start: Pose::new(8.5, -12.0, 1.5), goal: Pose::new(2.0, 10.0, 3.0) };
        assert_eq!(parse(TEST), Ok(vec![test]));
        assert_eq!(parse(&TEST.repeat(2)), Ok(vec![test; 2]));
    }

    #[test]
    fn malformed_launch_arguments_name_their_line() {
        let error = |from: &str, to: &str| parse(&TEST.replace(from, to)).expect_err("malformed");
        assert!(error("default=\"-12\"", "default=\"far\"").contains("line 3: `far` is no number"));
        assert!(error("goal_pose_x", "goal_x").contains("line 6: `goal_x`"));
        assert!(error("goal_pose_y", "goal_pose_x").contains("line 7: goal_pose_x occurs twice"));
        assert!(
            error("<arg name=\"initial_pose_y\" default", "<arg name=").contains("line 3: write")
        );
        assert!(error("<arg name=\"goal_pose_a\" default=\"3\"/>\n", "").contains("lacks some"));
        assert_eq!(parse("# nothing\n"), Err("it has no test".to_owned()));
    }
}
