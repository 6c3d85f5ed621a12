//! The rules of a run, start, goal, end and score, and its grids: the truth with its cylinders, and the robot's empty map.

use std::sync::Arc;

use super::BarnWorld;
use crate::geometry::{Point, Pose, Vector};
use crate::map::{GridFrame, MapError, ObstacleGrid, OccupancyGrid};
use crate::navigator::Goal;
use crate::runtime::Mission;
use crate::sim::Simulation;

/// Start, goal and end conditions of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Course {
    /// Where the robot starts, standing.
    pub start: Pose,
    /// The goal.
    pub goal: Point,
    /// The goal is reached when the true pose is this close to it, metres.
    pub goal_radius_m: f64,
    /// The run ends after this time, seconds.
    pub time_limit_s: f64,
}

impl Course {
    /// BARN's course, the same in every world. Source: `run.py` of `Daffan/the-barn-challenge`, with the start at the centre of
    /// the walls, where the paths begin.
    pub const BARN: Self = Self {
        start: Pose::new(-2.25, 3.0, 1.57),
        goal: Point::new(-2.25, 13.0),
        goal_radius_m: 1.0,
        time_limit_s: 100.0,
    };
}

impl BarnWorld {
    /// The simulation of a seed: an empty map, and the cylinders as the truth.
    ///
    /// # Errors
    /// Fails when the world is too large for a grid.
    pub fn simulation(&self, seed: u64) -> Result<Simulation, MapError> {
        let course = &self.course;
        let goal = Goal::at(course.goal);
        let map = empty_map(&self.cylinders, course)?;
        Ok(Simulation {
            truth: Some(truth(&self.cylinders, course)?),
            seed,
            ..Simulation::new(Mission {
                time_limit_s: course.time_limit_s,
                done_within_m: Some(course.goal_radius_m),
                ..Mission::new(Arc::new(map), course.start, goal)
            })
        })
    }
}

/// The challenge's score of a run: zero unless it reached the goal, else `OT / clip(T, 2 OT, 8 OT)`, from 0.125 to 0.5.
/// `time_s` is T, `optimal_time_s` OT, above zero.
///
/// T counts from the first tick; the challenge's clock starts when the robot has moved 0.1 m.
#[must_use]
pub fn score(reached: bool, time_s: f64, optimal_time_s: f64) -> f64 {
    if !reached {
        return 0.0;
    }
    optimal_time_s / time_s.clamp(2.0 * optimal_time_s, 8.0 * optimal_time_s)
}

/// An upright cylinder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cylinder {
    /// Its axis along x, metres.
    pub x_m: f64,
    /// Its axis along y, metres.
    pub y_m: f64,
    /// Its radius, metres, above zero.
    pub radius_m: f64,
}

/// Side of a cell of the truth, metres. BARN's cylinders, 0.075 m in radius on a lattice of 0.15 m, grow by at most a
/// cell's diagonal, 0.014 m.
#[doc(hidden)]
pub const TRUTH_RESOLUTION_M: f64 = 0.01;
/// Side of a cell of the robot's own map, metres. The benchmark's paths keep 0.375 m to the cylinders: cells of 0.05 m and
/// the margins that go with them close the narrowest of them.
const MAP_RESOLUTION_M: f64 = 0.03;
/// Free margin around the cylinders, the start and the goal, metres: the area outside the grid is solid.
const MARGIN_M: f64 = 3.0;

/// Returns the truth: exactly the cells that a cylinder overlaps are solid. Touching a border or a corner is no overlap.
/// Outside the grid, 3 m from all cylinders and from start and goal, everything is solid.
///
/// # Errors
/// Fails when the world is too large for a grid.
pub fn truth(cylinders: &[Cylinder], course: &Course) -> Result<ObstacleGrid, MapError> {
    let frame = frame(cylinders, course, TRUTH_RESOLUTION_M)?;
    let mut grid = ObstacleGrid::filled(frame, false);
    for cylinder in cylinders {
        fill(&mut grid, cylinder);
    }
    Ok(grid)
}

/// Returns an empty map of the same extent.
///
/// # Errors
/// Fails when the world is too large for a grid.
pub fn empty_map(cylinders: &[Cylinder], course: &Course) -> Result<OccupancyGrid, MapError> {
    let frame = frame(cylinders, course, MAP_RESOLUTION_M)?;
    Ok(OccupancyGrid::filled(frame, 0))
}

/// A grid over all cylinders, the start and the goal, with a margin.
fn frame(
    cylinders: &[Cylinder],
    course: &Course,
    resolution_m: f64,
) -> Result<GridFrame, MapError> {
    let ends = [course.start.position(), course.goal].map(|end| (end, 0.0));
    let discs = cylinders.iter().map(|it| (it.axis(), it.radius_m));
    let corners = discs.chain(ends).flat_map(|(center, radius_m)| {
        let reach = Vector::new(radius_m + MARGIN_M, radius_m + MARGIN_M);
        [center - reach, center + reach]
    });
    let [low, high] = Point::bounds(corners).unwrap_or_default();
    let cells = |from: f64, to: f64| ((to - from) / resolution_m).ceil() as i32;
    GridFrame::new(
        cells(low.x, high.x),
        cells(low.y, high.y),
        resolution_m,
        Pose::new(low.x, low.y, 0.0),
    )
}

fn fill(grid: &mut ObstacleGrid, cylinder: &Cylinder) {
    let (frame, axis) = (*grid.frame(), cylinder.axis());
    frame
        .cells_around(&axis, cylinder.radius_m)
        .filter(|cell| frame.is_touched(cell, &axis, cylinder.radius_m))
        .for_each(|cell| grid.set(cell, true));
}

impl Cylinder {
    const fn axis(&self) -> Point {
        Point::new(self.x_m, self.y_m)
    }
}
