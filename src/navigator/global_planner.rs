//! The interface of global planners, in the words of `nav2_core::GlobalPlanner`.

use crate::geometry::Point;
use crate::global::{Path, Plan, PlanError};
use crate::map::{MovingDisc, ObstacleGrid};

/// Largest distance of the ends of a path from start and goal, metres. A planner may plan between centres of cells.
pub(crate) const END_TOLERANCE_M: f64 = 0.25;
/// Distance between two checked points of a path, cells.
const CHECK_STEP_CELLS: f64 = 0.5;

/// Plans the paths that the navigator follows, first on the map and later with the obstacles that the scans showed.
pub trait GlobalPlanner: Send {
    /// Plans a path between two points, metres in the map frame. Cells outside the grid are obstacles. Those within the discs of
    /// `transient` may not stay, such as people who stand: a planner may keep farther from them. It may time its stages by
    /// `clock`, in seconds.
    ///
    /// The path [`Plan::smoothed`] is on the grid and crosses no occupied cell. It begins and ends within 0.25 m of start and goal,
    /// or within [`Self::least_radius_m`] if that is more. The navigator rejects any other path as
    /// [`PlanError::InvalidPlanner`].
    ///
    /// # Errors
    /// When there is no path, or the planner cannot go on.
    fn plan(
        &mut self,
        obstacles: &ObstacleGrid,
        transient: &[MovingDisc],
        start: Point,
        goal: Point,
        clock: &mut dyn FnMut() -> f64,
    ) -> Result<Plan, PlanError>;

    /// The distance that the planner keeps between a path and every obstacle, metres, finite and at least zero. The navigator
    /// replans where an obstacle is nearer.
    fn least_radius_m(&self) -> f64;

    /// Whether it runs outside this process: the end of a mission then waits for [`Self::finish`].
    fn is_external(&self) -> bool {
        false
    }

    /// Ends the mission: no further request follows.
    ///
    /// # Errors
    /// [`PlanError::InvalidPlanner`] if it turns out that its paths were not valid. The mission then has failed.
    fn finish(&mut self) -> Result<(), PlanError> {
        Ok(())
    }
}

/// Plans a path, and rejects one that the robot cannot follow.
///
/// # Errors
/// As [`GlobalPlanner::plan`], and [`PlanError::InvalidPlanner`].
pub(super) fn checked_plan(
    planner: &mut dyn GlobalPlanner,
    obstacles: &ObstacleGrid,
    transient: &[MovingDisc],
    [start, goal]: [Point; 2],
    clock: &mut dyn FnMut() -> f64,
) -> Result<Plan, PlanError> {
    let plan = planner.plan(obstacles, transient, start, goal, clock)?;
    let least_m = planner.least_radius_m();
    let check = || {
        if [least_m, plan.radius_m].iter().any(|radius_m| !radius_m.is_finite() || *radius_m < 0.0)
        {
            return Err("its distance to obstacles must be finite and at least zero".to_owned());
        }
        check_ends(plan.smoothed.points(), [start, goal], least_m.max(END_TOLERANCE_M))?;
        check_cells(&plan.smoothed, obstacles)
    };
    match check() {
        Ok(()) => Ok(plan),
        Err(reason) => {
            Err(PlanError::InvalidPlanner { name: "the global planner".to_owned(), reason })
        }
    }
}

/// Rejects points that are not finite, and ends of a path farther than a tolerance, metres, from start and goal.
pub(crate) fn check_ends(
    points: &[Point],
    [start, goal]: [Point; 2],
    tolerance_m: f64,
) -> Result<(), String> {
    if points.iter().any(|point| !point.is_finite()) {
        return Err("all points of a path must be finite".to_owned());
    }
    let ends = [(points.first(), start, "begins", "start"), (points.last(), goal, "ends", "goal")];
    for (point, end, verb, name) in ends {
        let off_m = point.map_or(f64::INFINITY, |point| (point - end).norm());
        if off_m > tolerance_m {
            return Err(format!(
                "the path {verb} {off_m:.2} m from the {name}; at most {tolerance_m} m are allowed"
            ));
        }
    }
    Ok(())
}

/// Rejects a path of finite points that leaves the grid or crosses an occupied cell.
pub(crate) fn check_cells(path: &Path, obstacles: &ObstacleGrid) -> Result<(), String> {
    let frame = obstacles.frame();
    // A straight line between two points of the map is on the map, and so of finite length.
    if let Some(index) = path.points().iter().position(|point| frame.cell_of(point).is_none()) {
        return Err(format!("point {index} of the path is not on the map"));
    }
    let is_blocked =
        |point: &Point| frame.cell_of(point).is_none_or(|cell| obstacles.is_blocked(cell));
    let blocked = path.samples(CHECK_STEP_CELLS * frame.resolution_m).find(is_blocked);
    blocked.map_or(Ok(()), |Point { x, y }| {
        Err(format!("the path crosses an obstacle at ({x:.2}, {y:.2})"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;
    use crate::map::GridFrame;

    /// Returns the same path for every request.
    struct Fixed(Vec<Point>, f64);

    impl GlobalPlanner for Fixed {
        fn plan(
            &mut self,
            _obstacles: &ObstacleGrid,
            _transient: &[MovingDisc],
            _start: Point,
            _goal: Point,
            _clock: &mut dyn FnMut() -> f64,
        ) -> Result<Plan, PlanError> {
            Ok(Plan::of_path(Path::new(self.0.clone()), self.1))
        }

        fn least_radius_m(&self) -> f64 {
            0.4
        }
    }

    fn check(points: &[(f64, f64)], radius_m: f64) -> Result<Plan, PlanError> {
        let frame = GridFrame::new(60, 40, 0.1, Pose::default()).expect("a valid size");
        let is_wall = |index: usize| frame.cell_at(index).row == 30;
        let obstacles = ObstacleGrid::new(frame, (0..frame.len()).map(is_wall).collect());
        let points = points.iter().map(|&(x, y)| Point::new(x, y)).collect();
        let ends = [Point::new(1.0, 2.0), Point::new(5.0, 2.0)];
        checked_plan(&mut Fixed(points, radius_m), &obstacles, &[], ends, &mut || 0.0)
    }

    #[test]
    fn path_that_the_robot_cannot_follow_is_rejected() {
        assert!(check(&[(1.0, 2.3), (3.0, 1.0), (5.0, 2.0)], 0.4).is_ok());
        let direct = [(1.0, 2.0), (5.0, 2.0)];
        for (points, radius_m, reason) in [
            (&[(1.0, 2.0), (f64::NAN, 1.0), (5.0, 2.0)][..], 0.4, "must be finite"),
            (&direct, f64::NAN, "finite and at least zero"),
            (&[(1.0, 1.0), (5.0, 2.0)], 0.4, "begins 1.00 m from the start; at most 0.4 m"),
            (&[(1.0, 2.0), (1.0, 3.0)], 0.4, "ends 4.12 m from the goal"),
            (&[(1.0, 2.0), (1e200, 2.0), (5.0, 2.0)], 0.4, "point 1 of the path is not on the map"),
            (&[(1.0, 2.0), (3.0, 3.5), (5.0, 2.0)], 0.4, "crosses an obstacle at ("),
        ] {
            let error = check(points, radius_m).expect_err(reason).to_string();
            assert!(error.starts_with("INVALID_PLANNER: the global planner: "), "{error}");
            assert!(error.contains(reason), "{error}");
        }
    }
}
