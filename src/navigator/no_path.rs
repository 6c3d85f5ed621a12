//! Why no path to the goal remained during a mission.

use super::ObstacleModel;
use super::replanning::Reason;
use super::state::State;
use crate::geometry::Point;
use crate::global::PlanError;
use crate::map::MovingDisc;

/// Distance between two points of the path to which distances are measured, metres.
const PATH_STEP_M: f64 = 0.1;

/// Why no path remained.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum NoPath {
    /// There is none, even without moving obstacles.
    Static(PlanError),
    /// There is none around the moving obstacles where they are now. The place of the one nearest to the path.
    Moving(Point),
}

impl NoPath {
    /// Why no path remained, from the error of a plan among the obstacles that scans showed. The map itself had a path: what the search
    /// says about map, goal and radius would point to a wrong cause.
    pub fn new(
        error: PlanError,
        reason: Reason,
        state: &State<'_>,
        obstacles: &ObstacleModel,
    ) -> Self {
        let is_by_search = matches!(
            error,
            PlanError::GoalOccupied { .. } | PlanError::NoValidPath { reason: None, .. }
        );
        if !is_by_search || matches!(reason, Reason::NewMap | Reason::MapAlone) {
            return Self::Static(error);
        }
        let path: Vec<Point> = state.route.ahead(state.route.left_m(), PATH_STEP_M).collect();
        let apart_m =
            |place: &Point| path.iter().map(|at| (at - *place).norm()).fold(f64::MAX, f64::min);
        let nearer = |one: &Point, other: &Point| apart_m(one).total_cmp(&apart_m(other));
        if reason == Reason::HeldUp
            && let Some(place) = state.now.moving.iter().map(MovingDisc::center).min_by(nearer)
        {
            return Self::Moving(place);
        }
        Self::Static(match obstacles.marks().min_by(nearer) {
            Some(Point { x, y }) => PlanError::NoValidPath {
                start: state.now.pose.position(),
                goal: state.goal.position,
                radius_m: state.route.radius_m,
                turning_radius_m: None,
                expanded: 0,
                nearest: None,
                reason: Some(format!(
                    "keeps clear of the obstacles that the map does not show: the one nearest to the last path is at ({x:.2}, {y:.2})"
                )),
            },
            None => error,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::NavigatorSettings;
    use super::super::predicted_state::PredictedState;
    use super::super::state::RobotModel;
    use super::super::test_state::{standing_at, with_state};
    use super::*;
    use crate::geometry::{Pose, Twist};
    use crate::map::{GridFrame, ObstacleGrid};
    use crate::robot::{Footprint, Limits};

    /// Why no path remained to a robot on its path along x, with people at these places, for an error of the search.
    fn why(reason: Reason, people: &[(f64, f64)]) -> NoPath {
        let footprint = Footprint::round(0.3).expect("a radius");
        let robot = RobotModel { footprint, limits: Limits::default() };
        let frame = GridFrame::new(100, 100, 0.1, Pose::new(-5.0, -5.0, 0.0)).expect("a size");
        let ground = ObstacleGrid::filled(frame, false);
        let person = |&(x, y): &(f64, f64)| MovingDisc { x, y, radius: 0.3, vx: 0.0, vy: 0.0 };
        let moving = people.iter().map(person).collect();
        let now = PredictedState { moving, ..standing_at(Pose::default()) };
        let stands = (Twist::STOP, Twist::STOP);
        with_state(&NavigatorSettings::default(), &robot, &ground, &now, stands, |state| {
            let model = ObstacleModel::new(ground.clone());
            let (place, why) = (state.goal.position, "is occupied".to_owned());
            NoPath::new(PlanError::GoalOccupied { place, why }, reason, state, &model)
        })
    }

    #[test]
    fn people_in_the_way_are_the_reason_and_not_the_map_or_the_goal() {
        let people = [(1.0, 2.0), (2.0, 0.5), (-2.0, 0.0)];
        assert_eq!(why(Reason::HeldUp, &people), NoPath::Moving(Point::new(2.0, 0.5)));
        let is_of_the_goal =
            |why: &NoPath| matches!(why, NoPath::Static(PlanError::GoalOccupied { .. }));
        assert!(is_of_the_goal(&why(Reason::HeldUp, &[])), "nothing is in the way");
        assert!(is_of_the_goal(&why(Reason::Blocked, &people)), "planned without people");
    }
}
