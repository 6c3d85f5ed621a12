//! Limits the speed by what the scan shows: a person may come out of each hidden place, and each object that stands alone may be
//! a person who starts to walk.

use super::super::Fault;
use super::super::occlusion::hidden_people;
use super::super::state::State;
use super::{Behaviour, Proposal};

/// Slows down so that the robot stands before such a person can reach it.
#[derive(Debug, Default)]
pub(super) struct OcclusionSpeed;

impl Behaviour for OcclusionSpeed {
    fn propose(&mut self, state: &State<'_>) -> Result<Option<Proposal>, Fault> {
        let Some(room) = state.standing_room else {
            return Ok(None);
        };
        let settings = state.settings;
        let moving = &state.now.moving;
        let mut people = hidden_people(&state.visible, room, moving, settings.pedestrian_speed);
        people.extend(&state.now.may_start);
        let fastest = state.safety_from(&people).fastest(state.robot.limits.max_vel_x);
        Ok(Some(Proposal::SpeedLimit(fastest.max(settings.occlusion_min_speed))))
    }
}

#[cfg(test)]
mod tests {
    use std::sync::OnceLock;

    use super::super::super::occlusion::standing_room;
    use super::super::super::passive_safety::obstacle_that_may_come;
    use super::super::super::predicted_state::PredictedState;
    use super::super::super::test_state::{standing_at, with_state};
    use super::super::super::{NavigatorSettings, RobotModel};
    use super::*;
    use crate::geometry::{Point, Pose, Twist};
    use crate::map::{FreeSpace, GridFrame, ObstacleGrid};
    use crate::robot::{Footprint, Limits};

    static ROOM: OnceLock<Option<FreeSpace>> = OnceLock::new();

    /// The speed limit of a robot at 0.6 m/s along x with an object at a place, m/s.
    fn limit_at(x: f64, y: f64) -> f64 {
        let settings = NavigatorSettings::default();
        let footprint = Footprint::round(0.3).expect("a radius");
        let robot = RobotModel { footprint, limits: Limits::default() };
        let frame = GridFrame::new(200, 200, 0.1, Pose::new(-10.0, -10.0, 0.0)).expect("a size");
        let ground = ObstacleGrid::filled(frame, false);
        let object = obstacle_that_may_come(Point::new(x, y), settings.pedestrian_radius_m, 0.0);
        let twist = Twist::new(0.6, 0.0);
        let now = PredictedState { twist, may_start: vec![object], ..standing_at(Pose::default()) };
        with_state(&settings, &robot, &ground, &now, (twist, twist), |state| {
            state.standing_room = ROOM.get_or_init(|| standing_room(&ground, &settings)).as_ref();
            match OcclusionSpeed.propose(state).expect("no fault") {
                Some(Proposal::SpeedLimit(limit)) => limit,
                other => panic!("{other:?}"),
            }
        })
    }

    #[test]
    fn object_that_may_be_a_person_limits_the_speed_near_the_path_only() {
        let near = limit_at(1.2, 0.8);
        assert!((0.3..0.8).contains(&near), "{near}");
        assert_eq!(limit_at(0.7, 0.6), 0.3, "the lowest limit");
        let free = Limits::default().max_vel_x;
        assert_eq!([limit_at(1.2, 2.5), limit_at(-2.0, 0.6)], [free, free]);
    }
}
