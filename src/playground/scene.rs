//! The scenes of the playground: a map and an initial situation.

use std::sync::Arc;

use hyper::body::Bytes;
use serde_json::{Value, json};

use crate::geometry::{Point, Pose, Vector, wrap_angle};
use crate::local::{ClearanceField, ProblemError};
use crate::map::{
    Cell, FreeSpace, MovingDisc, ObstacleGrid, OccupancyGrid, UNKNOWN, UnknownPolicy, Zones,
};
use crate::runtime::Config;
use crate::sim::{self, SCENE_NAMES};

/// Maximum number of cells: the field of such a map is well below the buffer size that every browser supports.
const MAX_CELLS: usize = 1 << 24;

/// Value of a cell in a closed zone, in the grid of zones.
const CLOSED: i8 = 100;
/// The control period of the initial problem, seconds: its dynamic window shows a wide fan.
const INITIAL_PERIOD_S: f64 = 0.5;
/// The initial forward speed of a robot that can drive so fast, m/s.
const INITIAL_SPEED_M_S: f64 = 0.5;
/// Farthest initial goal, metres.
const GOAL_DISTANCE_M: f64 = 5.0;
/// Number of directions in which an initial goal is searched.
const DIRECTIONS: u32 = 32;

/// Why a map cannot be a scene.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// The map has too many cells.
    #[error(
        "the map has {cells} cells, the playground supports {MAX_CELLS}: use a part of the map"
    )]
    TooLarge {
        /// Number of cells.
        cells: usize,
    },
    /// The resolution of the map is out of range.
    #[error(transparent)]
    Field(#[from] ProblemError),
}

/// A map to evaluate decisions on.
pub struct Scene {
    /// One word, used in problems and paths.
    pub(super) name: String,
    /// One line.
    pub(super) title: String,
    pub(super) field: Arc<ClearanceField>,
    /// How the field treats unknown cells.
    pub(super) unknown: UnknownPolicy,
    /// A byte for each cell, lowest row first: 0 free, 1 occupied, 2 unknown, 3 in a closed zone, 4 with a speed limit.
    pub(super) cells: Bytes,
    /// The field as the shaders read it: two cells a word.
    pub(super) field_bytes: Bytes,
    /// The initial problem, in the format of `problem.json`.
    pub(super) problem: Value,
    pub(super) map: Arc<OccupancyGrid>,
    pub(super) zones: Option<Arc<Zones>>,
    pub(super) config: Config,
    /// The arguments of `inbye drive` for this map and its settings.
    pub(super) arguments: String,
}

/// The initial state of a scene.
struct DecisionInput {
    pose: Pose,
    goal: Point,
    obstacles: Vec<MovingDisc>,
}

impl DecisionInput {
    /// The situation of a built-in scene: the robot's pose, the goal, and x, y, vx, vy of an obstacle.
    fn built_in(name: &str) -> Option<Self> {
        let (pose, [goal_x, goal_y], [x, y, vx, vy]) = match name {
            "roadway" => ([9.6, 3.7, 0.0], [14.4, 4.0], [13.1, 4.6, -0.4, 0.0]),
            "crossing" => ([2.3, 8.7, 0.0], [7.4, 8.9], [4.9, 9.3, -0.3, -0.1]),
            "dead_end" => ([9.2, 7.3, 0.0], [13.2, 7.3], [12.0, 8.0, -0.4, -0.2]),
            "mine" => ([49.0, 6.0, 0.0], [56.0, 6.2], [53.6, 6.8, -0.4, -0.1]),
            _ => return None,
        };
        let radius = 0.3;
        Some(Self {
            pose: Pose::from(pose),
            goal: Point::new(goal_x, goal_y),
            obstacles: vec![MovingDisc { x, y, radius, vx, vy }],
        })
    }
}

impl Scene {
    /// The name of the scene: one word.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// All built-in scenes. `settings` are the arguments of `inbye drive` for the configuration.
    ///
    /// # Errors
    /// Never: the built-in maps are small enough.
    pub fn all_built_in(config: &Config, settings: &str) -> Result<Vec<Self>, SceneError> {
        let scenes = SCENE_NAMES.into_iter().filter_map(sim::scene);
        scenes.map(|scene| Self::built_in(scene, None, config, settings)).collect()
    }

    /// A built-in scene with zones on its map. `settings` are the arguments of `inbye drive` for the zones and the configuration.
    ///
    /// # Errors
    /// Never: the built-in maps are small enough.
    pub fn built_in(
        scene: sim::Scene,
        zones: Option<Arc<Zones>>,
        config: &Config,
        settings: &str,
    ) -> Result<Self, SceneError> {
        let situation = DecisionInput::built_in(scene.name);
        let arguments = format!("--scene {}{settings}", scene.name);
        Self::new(scene.name, scene.title, (scene.map, zones), config, situation, arguments)
    }

    /// A scene on a map of the user, with zones on it. The robot is where it has most clearance. `arguments` are those of `inbye
    /// drive` for the map, the zones and the configuration.
    ///
    /// # Errors
    /// When the map has too many cells or its resolution is out of range.
    pub fn from_map(
        title: &str,
        map: OccupancyGrid,
        zones: Option<Arc<Zones>>,
        config: &Config,
        arguments: String,
    ) -> Result<Self, SceneError> {
        Self::new("map", title, (map, zones), config, None, arguments)
    }

    fn new(
        name: &str,
        title: &str,
        (map, zones): (OccupancyGrid, Option<Arc<Zones>>),
        config: &Config,
        situation: Option<DecisionInput>,
        arguments: String,
    ) -> Result<Self, SceneError> {
        if map.frame().len() > MAX_CELLS {
            let cells = map.frame().len();
            return Err(SceneError::TooLarge { cells });
        }
        let obstacles = map.obstacles(config.unknown);
        let cells = cells(&map, &obstacles, zones.as_deref());
        let closed = zones.as_deref().map(|zones| zones.with_obstacles(&obstacles));
        let closed = closed.as_ref().unwrap_or(&obstacles);
        let field = ClearanceField::new(closed)?;
        let situation = situation.unwrap_or_else(|| most_clearance(&field, closed, config));
        Ok(Self {
            name: name.to_owned(),
            title: title.to_owned(),
            unknown: config.unknown,
            cells,
            field_bytes: field_bytes(&field),
            problem: problem(name, config, &situation),
            field: Arc::new(field),
            map: Arc::new(map),
            zones,
            config: config.clone(),
            arguments,
        })
    }
}

fn cells(map: &OccupancyGrid, obstacles: &ObstacleGrid, zones: Option<&Zones>) -> Bytes {
    let zone = |index: usize| zones.map_or(0, |zones| zones.grid().cells()[index]);
    let both = map.cells().iter().zip(obstacles.cells()).enumerate();
    both.map(|(index, (&value, &blocked))| match (value, blocked, zone(index)) {
        (UNKNOWN, ..) => 2,
        (_, true, _) => 1,
        (.., 0) => 0,
        (.., CLOSED) => 3,
        _ => 4,
    })
    .collect()
}

fn field_bytes(field: &ClearanceField) -> Bytes {
    let units = field.units().iter().flat_map(|units| units.to_le_bytes());
    let mut bytes: Vec<u8> = units.collect();
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    bytes.into()
}

/// A robot at the position farthest from all obstacles and from the edge of the map, in the direction with the longest free path, and a
/// goal there, in a cell that global planning accepts.
fn most_clearance(
    field: &ClearanceField,
    obstacles: &ObstacleGrid,
    config: &Config,
) -> DecisionInput {
    let frame = field.frame();
    // Of equal cells the one nearest to the middle: on an empty map the robot starts there.
    let middle = frame.index(Cell::new(frame.width / 2, frame.height / 2));
    let best = frame.cells().max_by(|&one, &other| {
        let to_middle = |cell| frame.index(cell).abs_diff(middle);
        let by_clearance = clearance_m(field, one).total_cmp(&clearance_m(field, other));
        by_clearance.then(to_middle(other).cmp(&to_middle(one)))
    });
    let center = frame.center_of(best.unwrap_or(frame.cell_at(0)));
    let planner = config.route_planner(frame.resolution_m);
    let free = FreeSpace::new(obstacles, planner.least_radius_m());
    let step = frame.resolution_m.min(config.robot.footprint.circumscribed_radius_m());
    let ahead = |yaw: f64| {
        let (sine, cosine) = libm::sincos(yaw);
        let direction = Vector::new(cosine, sine);
        let is_free = |point: &Point| frame.cell_of(point).is_some_and(|cell| free.is_free(cell));
        free_way_m(is_free, &center, &direction, step, GOAL_DISTANCE_M)
    };
    let yaws = (0..DIRECTIONS).map(|part| {
        let yaw = wrap_angle(core::f64::consts::TAU * f64::from(part) / f64::from(DIRECTIONS));
        (yaw, ahead(yaw))
    });
    // Of equal distances the first.
    let (yaw, distance) =
        yaws.fold((0.0, -1.0), |best, next| if next.1 > best.1 { next } else { best });
    let pose = Pose::new(center.x, center.y, yaw);
    DecisionInput {
        pose,
        goal: pose.transform(&Point::new(distance.max(step), 0.0)),
        obstacles: Vec::new(),
    }
}

/// Distance of the centre of a cell from the nearest obstacle and from the edge of the map, metres.
pub(super) fn clearance_m(field: &ClearanceField, cell: Cell) -> f64 {
    let frame = field.frame();
    let to_edge_m = f64::from(frame.cells_to_edge(cell)) * frame.resolution_m;
    (f64::from(field.units()[frame.index(cell)]) * field.unit_m()).min(to_edge_m)
}

/// How far free points follow one another in a direction, a unit vector, in steps up to a distance, metres.
pub(super) fn free_way_m(
    is_free: impl Fn(&Point) -> bool,
    from: &Point,
    direction: &Vector,
    step_m: f64,
    most_m: f64,
) -> f64 {
    // Products, not sums: 120 steps of 0.05 m are 6 m.
    let steps = (1_u32..).map(|count| f64::from(count) * step_m);
    let free = steps.take_while(|&way_m| way_m <= most_m && is_free(&(*from + *direction * way_m)));
    free.last().unwrap_or_default()
}

fn problem(name: &str, config: &Config, situation: &DecisionInput) -> Value {
    let local = &config.local;
    let Pose { x, y, yaw } = situation.pose;
    json!({
        "map": { "file": name },
        "unknown": config.unknown,
        "robot": {
            "pose": [x, y, yaw],
            "velocity": [INITIAL_SPEED_M_S.min(config.robot.limits.max_vel_x), 0.0],
            "footprint": config.robot.footprint,
        },
        "limits": config.robot.limits,
        "vx_samples": local.vx_samples,
        "vtheta_samples": local.vtheta_samples,
        "sampler": local.sampler,
        "control_period_s": INITIAL_PERIOD_S,
        "sim_time_s": local.sim_time_s,
        "sim_step_s": local.sim_step_s,
        "max_clearance_m": local.max_clearance_m,
        "outside": local.outside,
        "obstacles": situation.obstacles,
        "target": situation.goal,
        "weights": local.weights,
        "normalization": local.normalization,
        "stopping": local.stopping,
    })
}
