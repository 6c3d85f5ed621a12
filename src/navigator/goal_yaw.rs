//! Whether and where the robot's body fits at its goals with their yaws, among the obstacles of the map.

use core::f64::consts::PI;

use super::exact_clearance::ExactClearance;
use super::{Goal, NavigatorSettings, ObstacleModel, RobotModel};
use crate::geometry::{Point, Pose, wrap_angle};
use crate::global::PlanError;
use crate::robot::Footprint;

/// Places on each circle around a goal that are tried.
const PLACES: u32 = 16;
/// Radii of these circles, as shares of the goal's tolerance.
const SHARES: [f64; 3] = [0.25, 0.5, 0.75];
/// What a place has beyond the safety margin, metres: a parked robot is off by a centimetre.
const ROOM_M: f64 = 0.02;
/// Distance between two checked places of a line, metres.
const STEP_M: f64 = 0.05;
/// Step between the yaws that are tried for a hint, radians.
const YAW_STEP: f64 = PI / 36.0;

/// The goals as the robot parks there: one whose exact place does not leave the safety margin around the body with the goal's yaw is
/// moved to the nearest place that does, within its tolerance and in sight of it.
pub(super) fn goals_with_room(
    goals: &[Goal],
    obstacles: &ObstacleModel,
    robot: &RobotModel,
    settings: &NavigatorSettings,
) -> Vec<Goal> {
    let moved = |goal: &Goal| place_with_room(goal, obstacles, &robot.footprint, settings);
    goals
        .iter()
        .map(|goal| Goal { position: moved(goal).unwrap_or(goal.position), ..*goal })
        .collect()
}

/// `None` where the goal stays where it is.
fn place_with_room(
    goal: &Goal,
    obstacles: &ObstacleModel,
    footprint: &Footprint,
    settings: &NavigatorSettings,
) -> Option<Point> {
    let NavigatorSettings { safety_margin_m, xy_goal_tolerance, .. } = *settings;
    let (place, yaw, margin_m) = (goal.position, goal.yaw?, safety_margin_m + ROOM_M);
    let reach_m = footprint.body_radius_m() + xy_goal_tolerance + margin_m;
    let field = obstacles.window(&place, reach_m).ok()?;
    let clearance = ExactClearance::new(&field, &place, reach_m);
    let has_room =
        |at: &Point| clearance.keeps_gap(footprint, &Pose::new(at.x, at.y, yaw), margin_m);
    if has_room(&place) {
        return None;
    }
    // Not beyond a thin wall.
    let disc = Footprint::round(footprint.inscribed_radius_m()).ok()?;
    let is_in_sight = |at: &Point| {
        let steps = ((at - place).norm() / STEP_M).ceil().max(1.0);
        (0..=steps as u32).all(|step| {
            let between = place + (at - place) * (f64::from(step) / steps);
            clearance.keeps_gap(&disc, &Pose::new(between.x, between.y, 0.0), 0.0)
        })
    };
    // In front of a wall the robot stands straight behind its goal, not beside it.
    let gap_m = |at: &Point| clearance.gap_m(footprint, &Pose::new(at.x, at.y, yaw));
    SHARES.into_iter().find_map(|share| {
        let places = place.circle(share * xy_goal_tolerance, PLACES);
        let usable = places.filter(|at| has_room(at) && is_in_sight(at));
        usable.max_by(|one, other| gap_m(one).total_cmp(&gap_m(other)))
    })
}

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
    use crate::robot::{Limits, Polygon};

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

    /// The same robot beside a wall at y = 0.3 m. With yaw 0.5 its corner needs 0.37 m, and the margin.
    #[test]
    fn goal_too_near_to_a_wall_for_its_yaw_moves_away_from_it_within_its_tolerance() {
        let frame = GridFrame::new(100, 40, 0.1, Pose::new(-5.0, -2.0, 0.0)).expect("a size");
        let ground = ObstacleGrid::from_fn(frame, |cell| cell.row == 23);
        let body = Polygon::rectangle(0.8, 0.4).expect("a body");
        let robot = RobotModel { limits: Limits::default(), footprint: Footprint::covering(body) };
        let settings = NavigatorSettings::default();
        let placed = |y: f64, yaw: Option<f64>| {
            let goal = Goal { position: Point::new(0.0, y), yaw };
            goals_with_room(&[goal], &ObstacleModel::new(ground.clone()), &robot, &settings)[0]
        };
        assert_eq!(placed(0.0, None).position, Point::new(0.0, 0.0));
        assert_eq!(placed(0.0, Some(0.0)).position, Point::new(0.0, 0.0));
        assert_eq!(placed(-0.3, Some(0.5)).position, Point::new(0.0, -0.3));
        let moved = placed(0.0, Some(0.5));
        assert_eq!(moved.yaw, Some(0.5));
        assert!(moved.position.y < -0.1, "{moved:?}");
        assert!(moved.position.to_vector().norm() < settings.xy_goal_tolerance, "{moved:?}");
        // From beyond the wall it does not move to this side.
        assert!(placed(0.7, Some(0.5)).position.y > 0.7);
        // Where there is no room within the tolerance, it stays.
        assert_eq!(placed(0.35, Some(0.0)).position, Point::new(0.0, 0.35));
    }
}
