//! Whether the robot's body fits at its goals with their yaws, among the obstacles of the map.

use core::f64::consts::PI;

use super::exact_clearance::ExactClearance;
use super::{Goal, NavigatorSettings, ObstacleModel, RobotModel};
use crate::geometry::{Point, Pose, wrap_angle};
use crate::global::PlanError;

/// Places on each circle around a goal that are tried.
const PLACES: u32 = 16;
/// Step between the yaws that are tried for a hint, radians.
const YAW_STEP: f64 = PI / 36.0;

/// Rejects a goal at which the body touches an obstacle of the map with the goal's yaw, anywhere within the goal's tolerances: the
/// robot would drive there and then find no room to turn.
///
/// # Errors
/// The first such goal, with the nearest yaw that fits.
pub(super) fn check_yaws(
    goals: &[Goal],
    obstacles: &ObstacleModel,
    robot: &RobotModel,
    settings: &NavigatorSettings,
) -> Result<(), PlanError> {
    goals.iter().try_for_each(|goal| check_yaw(goal, obstacles, robot, settings))
}

fn check_yaw(
    goal: &Goal,
    obstacles: &ObstacleModel,
    robot: &RobotModel,
    settings: &NavigatorSettings,
) -> Result<(), PlanError> {
    let footprint = &robot.footprint;
    let (place, tolerance_m) = (goal.position, settings.xy_goal_tolerance);
    let reach_m = footprint.body_radius_m() + tolerance_m;
    // A window that is too large is an error of the first decision.
    let (Some(yaw), Ok(field)) = (goal.yaw, obstacles.window(&place, reach_m)) else {
        return Ok(());
    };
    let clearance = ExactClearance::new(&field, &place, reach_m);
    let fits_at =
        |at: Point, yaw: f64| clearance.gap_m(footprint, &Pose::new(at.x, at.y, yaw)) > 0.0;
    let fits = |yaw: f64| {
        fits_at(place, yaw)
            || [0.5, 1.0]
                .into_iter()
                .any(|share| place.circle(share * tolerance_m, PLACES).any(|at| fits_at(at, yaw)))
    };
    if [0.0, settings.yaw_goal_tolerance, -settings.yaw_goal_tolerance]
        .iter()
        .any(|off| fits(yaw + off))
    {
        return Ok(());
    }
    Err(PlanError::GoalOccupied { place, why: no_room(yaw, |yaw| fits_at(place, yaw), || None) })
}

/// Why the robot cannot be at a place with a yaw, with the nearest yaw that fits there, radians; where none does, with a place nearby
/// if one is known.
pub(crate) fn no_room(
    yaw: f64,
    fits: impl Fn(f64) -> bool,
    nearby: impl FnOnce() -> Option<Point>,
) -> String {
    let steps = (PI / YAW_STEP) as u32;
    let nearest = (1..=steps)
        .flat_map(|step| [1.0, -1.0].map(|side| yaw + side * f64::from(step) * YAW_STEP))
        .find(|yaw| fits(*yaw));
    let hint = match nearest {
        Some(yaw) => format!("the nearest yaw that fits is {:.2}", wrap_angle(yaw)),
        None => nearby().map_or_else(
            || "no yaw fits there".to_owned(),
            |Point { x, y }| format!("no yaw fits there; it fits at ({x:.2}, {y:.2})"),
        ),
    };
    format!("has no room for the robot with yaw {yaw:.2}: {hint}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::{GridFrame, ObstacleGrid};
    use crate::robot::{Footprint, Limits, Polygon};

    /// A robot of 0.8 by 0.4 m in a corridor along x, 0.6 m wide.
    fn check(yaw: Option<f64>) -> Result<(), PlanError> {
        let frame = GridFrame::new(100, 26, 0.1, Pose::new(-5.0, -1.3, 0.0)).expect("a size");
        let ground = ObstacleGrid::from_fn(frame, |cell| !(10..16).contains(&cell.row));
        let body = Polygon::rectangle(0.8, 0.4).expect("a body");
        let robot = RobotModel { limits: Limits::default(), footprint: Footprint::covering(body) };
        let goal = Goal { position: Point::new(0.0, 0.0), yaw };
        check_yaws(&[goal], &ObstacleModel::new(ground), &robot, &NavigatorSettings::default())
    }

    #[test]
    fn goal_across_a_corridor_is_rejected_with_the_nearest_yaw_that_fits() {
        assert_eq!([check(None), check(Some(0.0)), check(Some(-3.0))], [Ok(()), Ok(()), Ok(())]);
        let error = check(Some(1.4)).expect_err("no room").to_string();
        assert!(error.starts_with("GOAL_OCCUPIED: goal (0.00, 0.00) has no room"), "{error}");
        assert!(error.ends_with("with yaw 1.40: the nearest yaw that fits is 0.27"), "{error}");
    }
}
