//! Search, prune, smooth: in that order.

use super::{Path, PlanError, Settings, astar, prune, smooth};
use crate::geometry::Point;
use crate::map::{Cell, FreeSpace};

/// The ground that a path may use.
///
/// Searching keeps a larger distance than the smoothed path must prove, so that the curve has room to round corners; the
/// two may be the same.
#[derive(Clone, Copy, Debug)]
pub struct Ground<'a> {
    /// Where the search may go; part of `proof`.
    pub search: &'a FreeSpace,
    /// Where the smoothed path is proved to stay.
    pub proof: &'a FreeSpace,
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

/// A global path through its three stages. All begin at the start and end at the goal.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Through cell centres, as searched.
    pub raw: Path,
    /// Without redundant nodes.
    pub pruned: Path,
    /// What the robot follows.
    pub smoothed: Path,
    /// Cells expanded by the search.
    pub expanded: u32,
    /// Time of each stage.
    pub time_s: StageTimes,
}

/// A path from start to goal. `clock` is read between the stages, in seconds; it decides nothing.
///
/// # Errors
/// When an end is off the map or not free, when no path joins the two, or a setting is out of range.
pub fn plan(
    ground: &Ground<'_>,
    start: Point,
    goal: Point,
    settings: &Settings,
    clock: &mut dyn FnMut() -> f64,
) -> Result<Plan, PlanError> {
    settings.validate()?;
    let space = ground.search;
    let start_cell = free_cell(space, start).map_err(|refusal| match refusal {
        Refusal::Outside(extent) => PlanError::StartOutsideMap {
            place: start,
            extent,
        },
        Refusal::Occupied(why) => PlanError::StartOccupied { place: start, why },
    })?;
    let goal_cell = free_cell(space, goal).map_err(|refusal| match refusal {
        Refusal::Outside(extent) => PlanError::GoalOutsideMap {
            place: goal,
            extent,
        },
        Refusal::Occupied(why) => PlanError::GoalOccupied { place: goal, why },
    })?;
    let began = clock();
    let found = astar(space, start_cell, goal_cell, settings.heuristic).map_err(|not_found| {
        let expanded = not_found.expanded;
        PlanError::NoValidPath {
            start,
            goal,
            radius_m: space.radius_m(),
            expanded,
        }
    })?;
    let raw = through_centers(space, start, &found.cells, goal);
    let searched = clock();
    let pruned = prune(space, &raw);
    let pruned_at = clock();
    let smoothed = smooth(ground.proof, &pruned, settings.spline_degree);
    let time_s = StageTimes {
        search: searched - began,
        prune: pruned_at - searched,
        smooth: clock() - pruned_at,
    };
    Ok(Plan {
        raw,
        pruned,
        smoothed,
        expanded: found.expanded,
        time_s,
    })
}

fn through_centers(space: &FreeSpace, start: Point, cells: &[Cell], goal: Point) -> Path {
    let centers = cells.iter().map(|&cell| space.frame().center_of(cell));
    Path::new(
        core::iter::once(start)
            .chain(centers)
            .chain(core::iter::once(goal))
            .collect(),
    )
}

enum Refusal {
    Outside(String),
    Occupied(String),
}

/// The free cell under a point, or what to tell the user.
fn free_cell(space: &FreeSpace, point: Point) -> Result<Cell, Refusal> {
    let frame = space.frame();
    let Some(cell) = frame.cell_of(&point) else {
        let low = frame.origin.position();
        let corner = Point::new(f64::from(frame.width), f64::from(frame.height));
        let high = frame.from_cell_units(&corner);
        let extent = format!(
            "({:.2}, {:.2}) to ({:.2}, {:.2})",
            low.x, low.y, high.x, high.y
        );
        return Err(Refusal::Outside(extent));
    };
    if space.is_free(cell) {
        return Ok(cell);
    }
    let mend = space.nearest_free(cell).map_or_else(
        || "there is no free point on the map".to_owned(),
        |cell| {
            let center = frame.center_of(cell);
            format!(
                "the nearest free point is ({:.2}, {:.2})",
                center.x, center.y
            )
        },
    );
    let radius_m = space.radius_m();
    Err(Refusal::Occupied(if space.is_obstacle(cell) {
        format!("is in an obstacle: {mend}")
    } else {
        format!("is less than {radius_m:.2} m from an obstacle: {mend}")
    }))
}
