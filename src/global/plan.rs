//! Search, prune, smooth: in that order.

use super::spline::smooth_with_spline;
use super::{
    ClearanceCosts, Path, PlanError, SearchMethod, Searcher, Settings, Spline, nearest_reachable,
    prune,
};
use crate::geometry::Point;
use crate::map::{Cell, FreeSpace, GridFrame};

/// The ground that a path may use.
///
/// Searching keeps a larger distance than the smoothed path must prove, so that the curve has room to round corners; the
/// two may be the same.
#[derive(Clone, Copy, Debug)]
pub struct PlanningSpace<'a> {
    /// Where the search may go; part of `smoothing`.
    pub search: &'a FreeSpace,
    /// Where the smoothed path is proved to stay.
    pub smoothing: &'a FreeSpace,
    /// What ground costs; nothing for the shortest path. Of the same grid.
    pub costs: Option<&'a ClearanceCosts>,
}

/// Time of each stage, seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StageTimes {
    /// Of the search.
    pub search: f64,
    /// Of the pruning.
    pub prune: f64,
    /// Of the smoothing.
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

/// A global path through its three stages. All begin at the start and end at the goal.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Through cell centres, as searched.
    pub raw: Path,
    /// Without redundant nodes.
    pub pruned: Path,
    /// What the robot follows.
    pub smoothed: Path,
    /// The curve whose chords that is.
    pub spline: Spline,
    /// Cells expanded by the search.
    pub expanded: u32,
    /// Time of each stage.
    pub time_s: StageTimes,
}

/// A path from start to goal, in metres in the map frame. The searcher lends its memory and leaves no trace in the answer;
/// `clock` is read between the stages, in seconds; it decides
/// nothing.
///
/// # Errors
/// When an end is off the map or not free, when no path joins the two, or a setting is out of range.
pub fn plan(
    searcher: &mut Searcher,
    ground: &PlanningSpace<'_>,
    start: Point,
    goal: Point,
    settings: &Settings,
    clock: &mut dyn FnMut() -> f64,
) -> Result<Plan, PlanError> {
    settings.validate()?;
    let space = ground.search;
    let start_cell = free_cell(space, start).map_err(|refusal| match refusal {
        Refusal::Outside(why) => PlanError::StartOutsideMap { place: start, why },
        Refusal::Occupied(why) => PlanError::StartOccupied { place: start, why },
    })?;
    let goal_cell = free_cell(space, goal).map_err(|refusal| match refusal {
        Refusal::Outside(why) => PlanError::GoalOutsideMap { place: goal, why },
        Refusal::Occupied(why) => PlanError::GoalOccupied { place: goal, why },
    })?;
    let began = clock();
    let found = match settings.search {
        SearchMethod::AStar => {
            let heuristic = settings.heuristic;
            searcher.astar(space, start_cell, goal_cell, heuristic, ground.costs)
        }
        SearchMethod::JumpPoints => searcher.jump_points(space, start_cell, goal_cell),
    };
    let found = found.map_err(|not_found| {
        let nearest = nearest_reachable(space, start_cell, &goal);
        PlanError::NoValidPath {
            start,
            goal,
            radius_m: space.radius_m(),
            expanded: not_found.expanded,
            nearest: nearest.map(|cell| space.frame().center_of(cell)),
        }
    })?;
    let raw = through_centers(space, start, found.cells, goal);
    let searched = clock();
    let pruned = prune(space, ground.costs, &raw, settings.pruning);
    let pruned_at = clock();
    let (smoothed, spline) = smooth_with_spline(ground.smoothing, &pruned, settings.spline_degree);
    let time_s = StageTimes {
        search: searched - began,
        prune: pruned_at - searched,
        smooth: clock() - pruned_at,
    };
    Ok(Plan {
        raw,
        pruned,
        smoothed,
        spline,
        expanded: found.expanded,
        time_s,
    })
}

/// Start, cell centres, goal. A centre that is an end up to rounding is left out, lest the path take a step there that has
/// no meaningful direction.
fn through_centers(space: &FreeSpace, start: Point, cells: &[Cell], goal: Point) -> Path {
    let frame = space.frame();
    let same_m = 1e-6 * frame.resolution_m;
    let is_apart =
        |center: &Point| (center - start).norm() > same_m && (center - goal).norm() > same_m;
    let centers = cells
        .iter()
        .map(|&cell| frame.center_of(cell))
        .filter(is_apart);
    Path::new(
        core::iter::once(start)
            .chain(centers)
            .chain(core::iter::once(goal))
            .collect(),
    )
}

/// What is wrong with an end of the path, and how to mend it.
enum Refusal {
    Outside(String),
    Occupied(String),
}

/// The free cell under a point, or what to tell the user.
fn free_cell(space: &FreeSpace, point: Point) -> Result<Cell, Refusal> {
    if !(point.x.is_finite() && point.y.is_finite()) {
        let why = "is no place: both coordinates must be finite numbers";
        return Err(Refusal::Outside(why.to_owned()));
    }
    let Some(cell) = space.frame().cell_of(&point) else {
        let extent = extent(space.frame());
        let mend = nearest_free(space, &point);
        return Err(Refusal::Outside(format!(
            "is off the map, which spans {extent}: {mend}"
        )));
    };
    if space.is_free(cell) {
        return Ok(cell);
    }
    let radius_m = space.radius_m();
    let mend = nearest_free(space, &point);
    Err(Refusal::Occupied(if space.is_obstacle(cell) {
        format!("is in an obstacle: {mend}")
    } else {
        format!("is less than {radius_m:.3} m from an obstacle: {mend}")
    }))
}

/// The corners of the smallest upright rectangle around a grid.
fn extent(frame: &GridFrame) -> String {
    let corners = frame.corners();
    let low = corners
        .iter()
        .fold(corners[0], |low, corner| low.inf(corner));
    let high = corners
        .iter()
        .fold(corners[0], |high, corner| high.sup(corner));
    format!(
        "({:.2}, {:.2}) to ({:.2}, {:.2})",
        low.x, low.y, high.x, high.y
    )
}

/// Names the nearest free cell's centre, to the millimetre: near enough to lie in that cell, whose side is rarely less than
/// a centimetre.
fn nearest_free(space: &FreeSpace, point: &Point) -> String {
    space.nearest_free(point).map_or_else(
        || {
            format!(
                "the map has no free point at all for a radius of {:.3} m; a smaller radius may find one",
                space.radius_m()
            )
        },
        |cell| {
            let center = space.frame().center_of(cell);
            format!(
                "the nearest free point is ({:.3}, {:.3})",
                center.x, center.y
            )
        },
    )
}
