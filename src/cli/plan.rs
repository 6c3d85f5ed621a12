//! `inbye plan`.

use std::path::PathBuf;

use anyhow::anyhow;
use clap::Args;
use inbye::geometry::{MAX_COORDINATE, Point};
use inbye::global::PlanError;
use inbye::map::{FreeSpace, OccupancyGrid, UNKNOWN, UnknownPolicy};
use inbye::navigator::NavigationMap;
use inbye::runtime::Config;
use serde_json::{Value, json};

use super::arguments::{Place, real};
use super::files::all_written;
use super::map_file::{self, EndArguments, MapArguments, MapInput};
use super::output;
use super::own_programs::GlobalPlannerArgument;
use super::plan_drawing::Drawing;
use super::plan_result::{self, LegFailure, PlanResult, PlanTask};

/// `inbye plan`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  inbye plan --scene mine\n  \
    inbye plan --scene mine --start 10,5 --via 20,30 --via 60,31 --goal 80,40 --svg tour.svg\n  \
    inbye plan --map mine.yaml --start 10,5 --goal 80,40\n\n\
    With --via all figures are those of the whole path, and `legs` has those of each leg. If the goal cannot be reached, \
    `nearest_reachable` is the reachable point nearest to it; --svg and --png show it.\n\
    `curvature` compares the smoothed path with the robot's limits: the share of the path that the base can follow at max_vel_x, \
    and its highest speed in the tightest bend; 0 if it must turn in place.\n\
    With --global-planner the path is that of the program, and its time counts as that of the search.")]
pub struct PlanArguments {
    #[command(flatten)]
    pub map: MapArguments,
    #[command(flatten)]
    pub ends: EndArguments,
    /// An intermediate stop, metres; repeat --via for each stop in the order of the visit. The path does not depend on yaws.
    #[arg(long, value_name = "X,Y[,YAW]", allow_hyphen_values = true)]
    pub via: Vec<Place>,
    /// Distance to keep from every obstacle, metres [default: the robot's circle and margins].
    #[arg(long, allow_negative_numbers = true, value_parser = real(0.0..=MAX_COORDINATE, "metres, 0 to 1e9"))]
    pub radius: Option<f64>,
    #[command(flatten)]
    pub global_planner: GlobalPlannerArgument,
    /// Draw the map with the plan into this file.
    #[arg(long, value_name = "FILE.svg")]
    pub svg: Option<PathBuf>,
    /// The same picture as pixels, 1440 wide.
    #[arg(long, value_name = "FILE.png")]
    pub png: Option<PathBuf>,
}

/// Finds a path. Returns false if there is none.
pub fn run(arguments: &PlanArguments) -> anyhow::Result<bool> {
    let mut input = map_file::read(&arguments.map, None)?;
    arguments.global_planner.set(&mut input.config);
    let (start, goal) = arguments.ends.resolve(input.scene.as_ref(), true)?;
    let task = PlanTask { start, goal, via: &arguments.via, radius_m: arguments.radius };
    let MapInput { map, zones, config, .. } = &input;
    arguments.map.zones.check(zones.as_deref(), (&start, &goal), &arguments.via)?;
    let known =
        NavigationMap { obstacles: map.obstacles(config.unknown), zones: zones.clone() }.closed();
    let drawing = Drawing::create(arguments)?;
    let plan = plan_result::plan(&task, config, &known);
    // The result comes first: a picture that cannot be written must not cost it.
    let answered = answer(&plan, &input, arguments);
    let is_found = matches!(answered, Ok(true));
    all_written([answered.map(drop), drawing.write(&task, &input, &plan)])?;
    Ok(is_found)
}

/// Prints the path, or that there is none. Returns whether there is one.
fn answer(plan: &PlanResult, input: &MapInput, arguments: &PlanArguments) -> anyhow::Result<bool> {
    if let Some(failure) = &plan.failure {
        return no_path(failure, input, arguments);
    }
    let MapInput { map, config, .. } = input;
    let mut object = plan.object();
    object["unknown"] = map_file::unknown_cells_json(map, config.unknown);
    let unknown = map_file::unknown_cells_text(map, config.unknown);
    let unknown = unknown.map(|text| format!("unknown   {text}"));
    output::result(&object, unknown.into_iter().chain(plan.lines()))?;
    Ok(true)
}

/// Prints that there is no path, which is an answer; an invalid start or goal is unusable input.
fn no_path(
    failure: &LegFailure,
    input: &MapInput,
    arguments: &PlanArguments,
) -> anyhow::Result<bool> {
    let reason = failure.reason() + arguments.map.zones.note(&failure.error);
    if !matches!(failure.error, PlanError::NoValidPath { .. }) {
        let MapInput { name, map, config, .. } = input;
        return Err(unusable(&failure.error, &reason, name, map, config, arguments.radius));
    }
    let mut object = no_path_json(&failure.error, &reason);
    object["stop"] = json!(failure.stop);
    output::result(&object, [reason])?;
    Ok(false)
}

/// The JSON object for a missing path, for this reason.
pub fn no_path_json(error: &PlanError, reason: &str) -> Value {
    let (expanded, nearest) = match error {
        PlanError::NoValidPath { expanded, nearest, .. } => (Some(expanded), nearest.as_ref()),
        _ => (None, None),
    };
    json!({
        "found": false,
        "path": [],
        "length_m": null,
        "expanded": expanded,
        "error": output::error_object(error.code(), reason, None),
        "nearest_reachable": nearest,
    })
}

/// A place with a free point within this distance is no mistake of the axes, metres.
const NEAR_FREE_M: f64 = 0.5;

/// Whether an invalid start or goal, off the map or deep in an obstacle, is in free space if its coordinates are swapped. `radius_m` as
/// in [`unusable`].
fn is_free_with_swapped_axes(
    error: &PlanError,
    map: &OccupancyGrid,
    config: &Config,
    radius_m: Option<f64>,
) -> bool {
    let (PlanError::StartOccupied { place, .. }
    | PlanError::GoalOccupied { place, .. }
    | PlanError::StartOutsideMap { place, .. }
    | PlanError::GoalOutsideMap { place, .. }) = error
    else {
        return false;
    };
    let swapped = Point::new(place.y, place.x);
    if swapped == *place {
        return false;
    }
    let least_m = || config.route_planner(map.frame().resolution_m).least_radius_m();
    let obstacles = map.obstacles(config.unknown);
    if map.frame().cell_of(place).is_some_and(|cell| !obstacles.is_blocked(cell)) {
        return false;
    }
    let space = FreeSpace::new(&obstacles, radius_m.unwrap_or_else(least_m));
    let is_near_free = space
        .nearest_free(place)
        .is_some_and(|cell| (map.frame().center_of(cell) - place).norm() <= NEAR_FREE_M);
    !is_near_free && map.frame().cell_of(&swapped).is_some_and(|cell| space.is_free(cell))
}

/// The error for an invalid start or goal, with the name of the map, or for a planner of the user's own. `radius_m` is the
/// distance to keep from obstacles, metres; none for that of the robot.
pub fn unusable(
    error: &PlanError,
    reason: &str,
    map_name: &str,
    map: &OccupancyGrid,
    config: &Config,
    radius_m: Option<f64>,
) -> anyhow::Error {
    let place = match error {
        PlanError::InvalidPlanner { .. } | PlanError::Interrupted { .. } => {
            return anyhow!("{reason}");
        }
        PlanError::StartOccupied { place, .. } | PlanError::GoalOccupied { place, .. } => {
            map.frame().cell_of(place)
        }
        _ => None,
    };
    let unknown = config.unknown == UnknownPolicy::Blocked
        && place.and_then(|cell| map.get(cell)) == Some(&UNKNOWN);
    let hint = if unknown {
        "; this cell is unknown in the map: --unknown free counts unknown cells as free"
    } else if is_free_with_swapped_axes(error, map, config, radius_m) {
        "; with x and y swapped it is free: write X,Y"
    } else {
        ""
    };
    anyhow!("{map_name}: {reason}{hint}")
}
