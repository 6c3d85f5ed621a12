//! The planning pipeline: search, prune, smooth; and the reachable cell nearest to a goal without a path.

use super::{
    ClearanceCosts, Path, PlanError, SearchMethod, Searcher, Settings, Spline, prune, smooth,
};
use crate::geometry::Point;
use crate::map::{Cell, FreeSpace, GridFrame};

/// The cells available to the planner.
///
/// The search keeps a larger clearance than the smoothed path needs, so that the curve can round corners. Both spaces may be
/// the same.
#[derive(Clone, Copy, Debug)]
pub struct PlanningSpace<'a> {
    /// Free cells for the search; a subset of `smoothing`.
    pub search: &'a FreeSpace,
    /// Free cells in which the smoothed path must stay.
    pub smoothing: &'a FreeSpace,
    /// Clearance costs of the same grid; none for the shortest path.
    pub costs: Option<&'a ClearanceCosts>,
}

/// Durations of the stages, seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct StageTimes {
    /// Duration of the search.
    pub search: f64,
    /// Duration of the pruning.
    pub prune: f64,
    /// Duration of the smoothing.
    pub smooth: f64,
}

impl core::ops::Add for StageTimes {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            search: self.search + other.search,
            prune: self.prune + other.prune,
            smooth: self.smooth + other.smooth,
        }
    }
}

/// A global path with its intermediate stages. All start at the start and end at the goal.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Plan {
    /// The searched path, through cell centres.
    pub raw: Path,
    /// The path without redundant nodes.
    pub pruned: Path,
    /// The path that the robot follows.
    pub smoothed: Path,
    /// The curve that `smoothed` samples.
    pub spline: Spline,
    /// Distance that `smoothed` keeps from obstacles, metres.
    pub radius_m: f64,
    /// Number of cells expanded by the search.
    pub expanded: u32,
    /// Durations of the stages.
    pub time_s: StageTimes,
}

impl Plan {
    /// The plan of a path that was planned elsewhere, at this distance from obstacles in metres: all its stages are this path.
    #[must_use]
    pub fn of_path(path: Path, radius_m: f64) -> Self {
        Self {
            radius_m,
            raw: path.clone(),
            pruned: path.clone(),
            spline: Spline::polyline(path.points()),
            smoothed: path,
            expanded: 0,
            time_s: StageTimes::default(),
        }
    }

    /// This plan with another path, which all stages are; effort and distance from obstacles remain.
    #[must_use]
    pub(crate) fn along(self, path: Path) -> Self {
        let (expanded, time_s) = (self.expanded, self.time_s);
        Self { expanded, time_s, ..Self::of_path(path, self.radius_m) }
    }
}

/// Plans a path from start to goal, metres in the map frame. The searcher provides reusable memory and does not affect the
/// result. `clock` is read between the stages, in seconds, for [`Plan::time_s`] only.
///
/// # Errors
/// Returns an error if an end is off the map or not free, no path connects them, or a setting is out of range.
pub fn plan(
    searcher: &mut Searcher,
    space: &PlanningSpace<'_>,
    start: Point,
    goal: Point,
    settings: &Settings,
    clock: &mut dyn FnMut() -> f64,
) -> Result<Plan, PlanError> {
    settings.validate()?;
    let free = space.search;
    let start_cell = free_cell(free, start).map_err(|error| match error {
        EndError::Outside(why) => PlanError::StartOutsideMap { place: start, why },
        EndError::Occupied(why) => PlanError::StartOccupied { place: start, why },
    })?;
    let goal_cell = free_goal_cell(free, goal)?;
    let started = clock();
    let found = match settings.search {
        SearchMethod::AStar => {
            let heuristic = settings.heuristic;
            searcher.astar(free, start_cell, goal_cell, heuristic, space.costs)
        }
        SearchMethod::JumpPoints => searcher.jump_points(free, start_cell, goal_cell),
    };
    let found = found.map_err(|no_path| {
        let nearest = nearest_reachable(free, start_cell, &goal);
        PlanError::NoValidPath {
            start,
            goal,
            radius_m: free.radius_m(),
            turning_radius_m: None,
            expanded: no_path.expanded,
            nearest: nearest.map(|cell| free.frame().center_of(cell)),
            reason: None,
        }
    })?;
    let raw = through_centers(free, start, found.cells, goal);
    let searched = clock();
    let pruned = prune(free, space.costs, &raw, settings.pruning);
    let pruned_at = clock();
    let (smoothed, spline) = smooth(space.smoothing, &pruned, settings.spline_degree);
    let time_s = StageTimes {
        search: searched - started,
        prune: pruned_at - searched,
        smooth: clock() - pruned_at,
    };
    let (radius_m, expanded) = (space.smoothing.radius_m(), found.expanded);
    Ok(Plan { raw, pruned, smoothed, spline, radius_m, expanded, time_s })
}

/// Joins start, cell centres and goal. A centre equal to an end up to rounding is omitted, since the step between them has
/// no meaningful direction. Within one cell the way is straight.
fn through_centers(space: &FreeSpace, start: Point, cells: &[Cell], goal: Point) -> Path {
    let frame = space.frame();
    let cells = if cells.len() == 1 { &[] } else { cells };
    let same_m = 1e-6 * frame.resolution_m;
    let is_apart =
        |center: &Point| (center - start).norm() > same_m && (center - goal).norm() > same_m;
    let centers = cells.iter().map(|&cell| frame.center_of(cell)).filter(is_apart);
    Path::new(core::iter::once(start).chain(centers).chain(core::iter::once(goal)).collect())
}

/// Why an end of the path is not usable.
enum EndError {
    Outside(String),
    Occupied(String),
}

/// The free cell that contains a goal, or why there is none.
pub(crate) fn free_goal_cell(space: &FreeSpace, goal: Point) -> Result<Cell, PlanError> {
    free_cell(space, goal).map_err(|error| match error {
        EndError::Outside(why) => PlanError::GoalOutsideMap { place: goal, why },
        EndError::Occupied(why) => PlanError::GoalOccupied { place: goal, why },
    })
}

/// The free cell that contains a point, or the cause and the nearest free point.
fn free_cell(space: &FreeSpace, point: Point) -> Result<Cell, EndError> {
    if !point.is_finite() {
        let why = "is not finite: both coordinates must be finite numbers";
        return Err(EndError::Outside(why.to_owned()));
    }
    let Some(cell) = space.frame().cell_of(&point) else {
        let (extent, hint) = (extent(space.frame()), nearest_free(space, &point));
        return Err(EndError::Outside(format!("is off the map, {extent}: {hint}")));
    };
    if space.is_free(cell) {
        return Ok(cell);
    }
    let radius_m = space.radius_m();
    let hint = nearest_free(space, &point);
    Err(EndError::Occupied(if space.is_obstacle(cell) {
        format!("is in an obstacle: {hint}")
    } else {
        format!("{}: {hint}", too_near(space.frame(), cell, radius_m))
    }))
}

/// What is wrong with a cell that is nearer than a distance, metres, to an obstacle or to the edge of the map.
pub(crate) fn too_near(frame: &GridFrame, cell: Cell, radius_m: f64) -> String {
    let is_at_edge = f64::from(frame.cells_to_edge(cell)) * frame.resolution_m < radius_m;
    let what = if is_at_edge { "an obstacle or the edge of the map" } else { "an obstacle" };
    format!("is in a cell less than {radius_m:.3} m from {what}")
}

/// Where a grid is in the map frame. The bounding box of a turned grid contains points that are off the grid.
fn extent(frame: &GridFrame) -> String {
    let corners = frame.corners();
    let text = |corner: &Point| format!("({:.2}, {:.2})", corner.x, corner.y);
    if frame.origin.yaw == 0.0 {
        return format!("which spans {} to {}", text(&corners[0]), text(&corners[2]));
    }
    let yaw = frame.origin.yaw;
    format!(
        "which is turned by {yaw:.3} rad and has the corners {}",
        corners.each_ref().map(text).join(", ")
    )
}

/// Names the centre of the nearest free cell, to the millimetre. This is in the cell, whose side is rarely below a
/// centimetre.
pub(crate) fn nearest_free(space: &FreeSpace, point: &Point) -> String {
    let frame = space.frame();
    space.nearest_free(point).map_or_else(
        || {
            // The centre of an open cell of this size keeps the radius, but not all points of the cell do.
            let is_open = |cell| !space.is_obstacle(cell);
            let is_coarse = frame.resolution_m > 2.0 * space.radius_m();
            let remedy = if is_coarse && frame.cells().any(is_open) {
                format!("cells of {} m are too coarse for it, use smaller ones", frame.resolution_m)
            } else {
                "a smaller radius (that of the footprint and its margins) may have one".to_owned()
            };
            format!("the map has no free cell for a radius of {:.3} m; {remedy}", space.radius_m())
        },
        |cell| {
            let center = frame.center_of(cell);
            format!("the nearest free point is ({:.3}, {:.3})", center.x, center.y)
        },
    )
}

/// The free cell that is reachable from `start` and nearest to `goal` by its centre; ties go to the first in storage order.
/// None if the start is not free or outside the grid.
#[must_use]
pub fn nearest_reachable(space: &FreeSpace, start: Cell, goal: &Point) -> Option<Cell> {
    nearest_reachable_within(space, space, start, goal)
}

/// As [`nearest_reachable`], of the cells that are free in another space too.
pub(crate) fn nearest_reachable_within(
    space: &FreeSpace,
    within: &FreeSpace,
    start: Cell,
    goal: &Point,
) -> Option<Cell> {
    if !space.is_free(start) {
        return None;
    }
    let frame = space.frame();
    let goal = frame.to_cell_units(goal);
    let squared = |cell: Cell| (cell.center() - goal).norm_squared();
    let mut is_seen = vec![false; frame.len()];
    space
        .flood(start, &mut is_seen)
        .map(|(cell, _)| cell)
        .filter(|&cell| within.is_free(cell))
        .min_by(|&one, &other| {
            let by_distance = squared(one).total_cmp(&squared(other));
            by_distance.then(frame.index(one).cmp(&frame.index(other)))
        })
}
