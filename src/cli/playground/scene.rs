//! Grounds to play on, each with the situation that it begins with.

use std::sync::Arc;

use hyper::body::Bytes;
use inbye::geometry::{Point, Pose, Vector};
use inbye::local::{ClearanceField, LocalSettings};
use inbye::map::{Cell, MovingDisc, ObstacleGrid, OccupancyGrid, UNKNOWN, UnknownPolicy};
use inbye::robot::Footprint;
use inbye::runtime::Config;
use inbye::sim;
use serde_json::{Value, json};

/// Largest map, cells: its field stays well within the buffer that every browser grants.
const MOST_CELLS: usize = 1 << 24;

/// The window of the first picture, seconds: wide enough to see a fan.
const FIRST_WINDOW_S: f64 = 0.5;
/// How far ahead the first goal is looked for, metres.
const GOAL_AHEAD_M: f64 = 5.0;
/// Directions in which it is looked for.
const DIRECTIONS: u32 = 32;

/// A ground.
pub struct Scene {
    /// One word, in problems and paths.
    pub name: String,
    /// One line.
    pub title: String,
    /// What engines read of it.
    pub field: Arc<ClearanceField>,
    /// What unknown cells count as in that.
    pub unknown: UnknownPolicy,
    /// A byte for each cell, lowest row first: 0 free, 1 rock, 2 unknown.
    pub cells: Bytes,
    /// The field as the shaders read it: two cells a word.
    pub field_bytes: Bytes,
    /// The problem that it begins with, as `problem.json` has it.
    pub problem: Value,
}

/// Where things are at first.
struct Situation {
    pose: Pose,
    goal: Point,
    obstacles: Vec<MovingDisc>,
}

/// The built-in scenes.
pub fn built_in(config: &Config) -> anyhow::Result<Vec<Scene>> {
    let places = [
        (
            "roadway",
            [9.6, 3.7, 0.0],
            [14.4, 4.0],
            [13.1, 4.6, -0.4, 0.0],
        ),
        (
            "crossing",
            [2.3, 8.7, 0.0],
            [7.4, 8.9],
            [4.9, 9.3, -0.3, -0.1],
        ),
        (
            "dead_end",
            [9.2, 7.3, 0.0],
            [13.2, 7.3],
            [12.0, 8.0, -0.4, -0.2],
        ),
    ];
    let scene = |scene: sim::Scene| {
        let place = places.iter().find(|(name, ..)| *name == scene.name);
        let (_, pose, [goal_x, goal_y], [x, y, vx, vy]) =
            *place.ok_or_else(|| anyhow::anyhow!("the scene {} has no place", scene.name))?;
        let radius = 0.3;
        let situation = Situation {
            pose: Pose::from(pose),
            goal: Point::new(goal_x, goal_y),
            obstacles: vec![MovingDisc {
                x,
                y,
                radius,
                vx,
                vy,
            }],
        };
        make(scene.name, scene.title, &scene.map, config, Some(situation))
    };
    sim::scenes().into_iter().map(scene).collect()
}

/// A map of the user's own, with the robot where there is most room.
pub fn of_map(title: &str, map: &OccupancyGrid, config: &Config) -> anyhow::Result<Scene> {
    make("map", title, map, config, None)
}

fn make(
    name: &str,
    title: &str,
    map: &OccupancyGrid,
    config: &Config,
    situation: Option<Situation>,
) -> anyhow::Result<Scene> {
    let frame = map.frame();
    anyhow::ensure!(
        frame.len() <= MOST_CELLS,
        "{title}: the playground shows at most {MOST_CELLS} cells, and this map has {}: cut out a part of it",
        frame.len()
    );
    let obstacles = map.obstacles(config.unknown);
    let field = ClearanceField::new(&obstacles)?;
    let footprint = &config.robot.footprint;
    let situation = situation.unwrap_or_else(|| roomiest(&field, footprint));
    Ok(Scene {
        name: name.to_owned(),
        title: title.to_owned(),
        unknown: config.unknown,
        cells: cells(map, &obstacles),
        field_bytes: field_bytes(&field),
        problem: problem(name, config, &situation),
        field: Arc::new(field),
    })
}

fn cells(map: &OccupancyGrid, obstacles: &ObstacleGrid) -> Bytes {
    let both = map.cells().iter().zip(obstacles.cells());
    both.map(|(&value, &blocked)| match (value, blocked) {
        (UNKNOWN, _) => 2,
        (_, blocked) => u8::from(blocked),
    })
    .collect()
}

fn field_bytes(field: &ClearanceField) -> Bytes {
    let units = field.units().iter().flat_map(|units| units.to_le_bytes());
    let mut bytes: Vec<u8> = units.collect();
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    bytes.into()
}

/// The place farthest from all obstacles, facing where there is room ahead longest, and a goal there.
fn roomiest(field: &ClearanceField, footprint: &Footprint) -> Situation {
    let frame = field.frame();
    let units = field.units().iter().enumerate();
    // Of equal ones the one nearest to the middle, so that an empty map begins there.
    let middle = frame.index(Cell::new(frame.width / 2, frame.height / 2));
    let best =
        units.max_by_key(|(index, units)| (**units, core::cmp::Reverse(index.abs_diff(middle))));
    let center = frame.center_of(frame.cell_at(best.map_or(0, |(index, _)| index)));
    let room = footprint.circumscribed_radius_m();
    let step = frame.resolution_m.min(room);
    let ahead = |yaw: f64| {
        let (sine, cosine) = libm::sincos(yaw);
        let mut way = 0.0;
        loop {
            let next = way + step;
            let at = center + Vector::new(cosine, sine) * next;
            let free = frame.cell_of(&at).is_some_and(|cell| {
                f64::from(field.units()[frame.index(cell)]) * field.unit_m() > room
            });
            if !free || next > GOAL_AHEAD_M {
                return way;
            }
            way = next;
        }
    };
    let yaws = (0..DIRECTIONS).map(|part| {
        let yaw = inbye::geometry::wrap_angle(
            core::f64::consts::TAU * f64::from(part) / f64::from(DIRECTIONS),
        );
        (yaw, ahead(yaw))
    });
    // The first of the longest.
    let (yaw, way) = yaws.fold(
        (0.0, -1.0),
        |best, next| if next.1 > best.1 { next } else { best },
    );
    let pose = Pose::new(center.x, center.y, yaw);
    Situation {
        pose,
        goal: pose.transform(&Point::new(way.max(step), 0.0)),
        obstacles: Vec::new(),
    }
}

fn problem(name: &str, config: &Config, situation: &Situation) -> Value {
    let LocalSettings {
        vx_samples,
        vtheta_samples,
        sim_time_s,
        sim_step_s,
        max_clearance_m,
        outside,
        weights,
        normalization,
        stopping,
        ..
    } = config.local;
    let Pose { x, y, yaw } = situation.pose;
    json!({
        "map": { "file": name },
        "unknown": config.unknown,
        "robot": {
            "pose": [x, y, yaw],
            "velocity": [0.5, 0.0],
            "footprint": config.robot.footprint,
        },
        "limits": config.robot.limits,
        "vx_samples": vx_samples,
        "vtheta_samples": vtheta_samples,
        "control_period_s": FIRST_WINDOW_S,
        "sim_time_s": sim_time_s,
        "sim_step_s": sim_step_s,
        "max_clearance_m": max_clearance_m,
        "outside": outside,
        "obstacles": situation.obstacles,
        "target": [situation.goal.x, situation.goal.y],
        "weights": weights,
        "normalization": normalization,
        "stopping": stopping,
    })
}
