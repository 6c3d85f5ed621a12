//! The missions of the fault matrix, and obstacles that appear around the robot.

use core::f64::consts::FRAC_PI_2;
use std::sync::Arc;

use crate::experiment::ExperimentError;
use crate::geometry::{Point, Pose};
use crate::local::CpuEngine;
use crate::map::{GridFrame, OccupancyGrid};
use crate::navigator::Goal;
use crate::runtime::{Config, Mission, Observer, ObstacleGap};
use crate::sim::{
    MovingObstacle, MovingObstacles, SimError, Simulation, SpawnTrigger, crossing, roadway,
};

/// Begin of each fault, seconds: the robot has its cruising speed.
pub(super) const AT_S: f64 = 6.0;
/// Longest duration of a drive, seconds: the navigator gives up after 90 s without progress.
const TIME_LIMIT_S: f64 = 240.0;
/// Radius of an obstacle that appears, metres.
const BODY_RADIUS_M: f64 = 0.3;
/// Step of the search for a place with a gap, metres.
const STEP_M: f64 = 0.005;
/// Gap to the wall of a robot that starts nearer to it than a path may be, metres. The planner refuses a start at which a disc
/// of the footprint touches a wall.
const NEAR_WALL_M: f64 = 0.15;

/// Size of the hall, metres, and of its cells.
const HALL_M: (f64, f64) = (20.0, 10.0);
const RESOLUTION_M: f64 = 0.05;
/// The robot drives along the middle of the hall between these places, metres.
const HALL_START_X_M: f64 = 2.0;
const HALL_GOAL_X_M: f64 = 18.0;
/// The wall with a door in the middle: its place and thickness, and the width of the door, metres.
const WALL_X_M: f64 = 14.0;
const WALL_M: f64 = 0.3;
const DOOR_M: f64 = 2.0;
/// The trap is open towards the robot: from here to here along the hall, and this wide inside, metres.
const TRAP_X_M: (f64, f64) = (9.0, 12.0);
const TRAP_WIDTH_M: f64 = 3.0;

/// A drive through the scene of the mine's roadways.
pub(super) fn roadway_mission(seed: u64) -> Simulation {
    let scene = roadway();
    mission(scene.map, scene.start, scene.goal, seed)
}

/// The same, from a start with a wall next to the robot's left side.
pub(super) fn start_near_wall(simulation: &mut Simulation, config: &Config) {
    let gap = ObstacleGap::new(simulation.mission.map.obstacles(config.unknown));
    let footprint = &config.robot.footprint;
    let start = &mut simulation.mission.start;
    while gap.gap_m(footprint, start) > NEAR_WALL_M {
        *start = Pose { y: start.y + STEP_M, ..*start };
    }
}

/// A drive in the roadways by the map of another mine, in which start and goal are free too.
pub(super) fn on_wrong_map(simulation: &mut Simulation, config: &Config) {
    let truth = roadway().map.obstacles(config.unknown);
    let scene = crossing();
    let start = Pose::new(2.4, 3.0, FRAC_PI_2);
    *simulation =
        Simulation { truth: Some(truth), ..mission(scene.map, start, scene.goal, simulation.seed) };
}

/// A drive through the only door of a hall; bodies close the door at the time of the fault.
pub(super) fn door_that_closes(simulation: &mut Simulation) -> Result<(), ExperimentError> {
    let is_wall = |point: &Point| {
        (WALL_X_M..WALL_X_M + WALL_M).contains(&point.x)
            && (point.y - HALL_M.1 / 2.0).abs() > DOOR_M / 2.0
    };
    *simulation = hall_mission(is_wall, simulation.seed)?;
    let count = (DOOR_M / BODY_RADIUS_M).ceil();
    let place = |index: u32| {
        let y = HALL_M.1 / 2.0 + DOOR_M * (f64::from(index) / count - 0.5);
        body_at(Point::new(WALL_X_M + WALL_M / 2.0, y))
    };
    let bodies: Result<_, _> = (0..=count as u32).map(place).collect();
    simulation.moving_obstacles = MovingObstacles::new(bodies?);
    Ok(())
}

/// A drive through a hall towards a trap of walls that the map does not show, with room around it.
pub(super) fn trap(simulation: &mut Simulation, config: &Config) -> Result<(), ExperimentError> {
    *simulation = hall_mission(|_| false, simulation.seed)?;
    let aside = |point: &Point| (point.y - HALL_M.1 / 2.0).abs() - TRAP_WIDTH_M / 2.0;
    let is_trap = |point: &Point| {
        let is_side = (0.0..WALL_M).contains(&aside(point));
        let is_end = aside(point) < WALL_M && point.x > TRAP_X_M.1 - WALL_M;
        (TRAP_X_M.0..TRAP_X_M.1).contains(&point.x) && (is_side || is_end)
    };
    simulation.truth = Some(hall(is_trap)?.obstacles(config.unknown));
    Ok(())
}

fn hall_mission(
    is_wall: impl Fn(&Point) -> bool,
    seed: u64,
) -> Result<Simulation, ExperimentError> {
    let middle_m = HALL_M.1 / 2.0;
    let start = Pose::new(HALL_START_X_M, middle_m, 0.0);
    Ok(mission(hall(is_wall)?, start, Point::new(HALL_GOAL_X_M, middle_m), seed))
}

/// A rectangular hall with walls inside.
fn hall(is_wall: impl Fn(&Point) -> bool) -> Result<OccupancyGrid, ExperimentError> {
    let (width, height) = ((HALL_M.0 / RESOLUTION_M) as i32, (HALL_M.1 / RESOLUTION_M) as i32);
    let frame = GridFrame::new(width, height, RESOLUTION_M, Pose::default())?;
    Ok(OccupancyGrid::from_fn(frame, |cell| {
        let is_border =
            cell.column == 0 || cell.row == 0 || cell.column == width - 1 || cell.row == height - 1;
        if is_border || is_wall(&frame.center_of(cell)) { 100 } else { 0 }
    }))
}

fn mission(map: OccupancyGrid, start: Pose, goal: Point, seed: u64) -> Simulation {
    let goal = Goal::at(goal);
    let mission =
        Mission { time_limit_s: TIME_LIMIT_S, ..Mission::new(Arc::new(map), start, goal) };
    Simulation { seed, ..Simulation::new(mission) }
}

/// Lets standing obstacles appear around the robot at the time of the fault, each at a gap, metres, to its outline in a direction
/// of its frame, radians. The robot is where it drives to without them and without faults.
pub(super) fn appear_around(
    simulation: &mut Simulation,
    config: &Config,
    sides: &[(f64, f64)],
) -> Result<(), SimError> {
    let mut no_clock = || 0.0;
    let mut observer = Observer { clock: &mut no_clock, on_tick: &mut |_| {} };
    let engine = Box::new(CpuEngine::single_threaded());
    let mut undisturbed = Simulation { faults: Vec::new(), ..simulation.clone() };
    // A mission of less than a tick more has the same rows.
    undisturbed.mission.time_limit_s = AT_S + config.local.control_period_s;
    let rows = undisturbed.run(config, engine, &mut observer)?.trace.rows;
    let robot =
        rows.iter().find(|row| row.time_s >= AT_S).map_or(simulation.mission.start, |row| row.pose);
    let footprint = &config.robot.footprint;
    let body = |&(gap_m, direction): &(f64, f64)| {
        let (sin, cos) = libm::sincos(direction);
        let away_m = footprint.distance_with_gap_m(direction, BODY_RADIUS_M, gap_m);
        body_at(robot.transform(&Point::new(away_m * cos, away_m * sin)))
    };
    let bodies: Vec<MovingObstacle> = sides.iter().map(body).collect::<Result<_, _>>()?;
    simulation.moving_obstacles = MovingObstacles::new(bodies);
    Ok(())
}

/// A body that appears at a place at the time of the fault, and stands.
fn body_at(place: Point) -> Result<MovingObstacle, SimError> {
    let stands = MovingObstacle::patrol(BODY_RADIUS_M, 0.0, vec![place])?;
    stands.yielding(false).spawned_by(SpawnTrigger::AtTime(AT_S))
}
