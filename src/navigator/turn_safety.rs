//! Turns in place next to people.
//!
//! A turn in place passes no person and gains little, and it leads a corner of the body sideways, to where a person may walk. So it
//! needs more certainty than driving that a person stands, and a slow turn is not worth its risk.

use super::state::{CREEP, State};
use crate::geometry::Twist;
use crate::map::MovingDisc;

impl State<'_> {
    /// The people from whom a motion towards a velocity must keep away.
    pub(super) fn people_near(&self, wanted: &Twist) -> &[MovingDisc] {
        let is_careful = self.turns_in_place(wanted) && !self.is_held_up();
        if is_careful { &self.now.near_turn } else { &self.now.may_come }
    }

    /// Whether the robot has been held up for long. People who seem to stand then count as standing: they may wait for the robot,
    /// as it waits for them.
    fn is_held_up(&self) -> bool {
        self.stuck_s > self.settings.stuck_patience_s
    }

    /// Whether a velocity turns the robot about a point within the circle of its body, so that some corner moves sideways or back.
    fn turns_in_place(&self, twist: &Twist) -> bool {
        twist.linear.abs() < twist.angular.abs() * self.robot.footprint.body_radius_m()
    }

    /// Braking instead of a turn in place that lets a robot only creep next to a person.
    pub(super) fn without_slow_turn(&self, turn: Twist) -> Twist {
        let creeps = self.robot.footprint.fastest_part(&turn) <= CREEP;
        let is_on = self.settings.features.passive_safety && !self.is_held_up();
        if is_on && creeps && self.waits_for_people() { self.brake() } else { turn }
    }
}

#[cfg(test)]
mod tests {
    use super::super::predicted_state::PredictedState;
    use super::super::test_state::{standing_at, with_state};
    use super::super::{NavigatorSettings, RobotModel};
    use super::*;
    use crate::geometry::Pose;
    use crate::map::{GridFrame, ObstacleGrid};
    use crate::robot::{Footprint, Limits, Polygon};

    /// Whether a standing robot with a corner at (-0.35, -0.25) may move next to a person behind it to the right.
    fn may_move(wanted: Twist, person_speed: f64, speed_near_turn: f64) -> bool {
        may_move_with(&NavigatorSettings::default(), wanted, person_speed, speed_near_turn)
    }

    fn may_move_with(
        settings: &NavigatorSettings,
        wanted: Twist,
        person_speed: f64,
        speed_near_turn: f64,
    ) -> bool {
        let body = Polygon::rectangle(0.7, 0.5).expect("a rectangle");
        let limits = Limits { min_vel_x: -0.3, ..Limits::default() };
        let robot = RobotModel { footprint: Footprint::covering(body), limits };
        let frame = GridFrame::new(100, 100, 0.1, Pose::new(-5.0, -5.0, 0.0)).expect("a size");
        let ground = ObstacleGrid::filled(frame, false);
        let person = |speed| MovingDisc { x: -0.3, y: -0.8, radius: 0.3, vx: speed, vy: 0.0 };
        let now = PredictedState {
            may_come: vec![person(person_speed)],
            near_turn: vec![person(speed_near_turn)],
            ..standing_at(Pose::default())
        };
        let motion = (Twist::STOP, Twist::STOP);
        with_state(settings, &robot, &ground, &now, motion, |state| state.is_safe_towards(&wanted))
    }

    /// Turning to the left leads that corner to the right, towards the person.
    #[test]
    fn turn_next_to_a_person_who_may_walk_is_not_safe() {
        let turn = Twist::new(0.0, 0.25);
        assert!(may_move(turn, 0.0, 0.0), "the person stands");
        assert!(!may_move(turn, 0.0, 1.6), "the person seems to stand");
        assert!(!may_move(Twist::new(0.05, 0.25), 0.0, 1.6), "a tight arc is a turn");
        let held_up = NavigatorSettings { stuck_patience_s: -1.0, ..NavigatorSettings::default() };
        assert!(may_move_with(&held_up, turn, 0.0, 1.6), "both wait for each other");
        assert!(!may_move_with(&held_up, turn, 1.6, 1.6), "the person walks");
        assert!(may_move(Twist::new(0.05, 0.05), 0.0, 1.6), "it drives by");
        assert!(!may_move(Twist::new(-0.05, 0.05), 1.6, 0.0), "it drives to a walker");
    }

    #[test]
    fn turn_next_to_a_person_stands_instead_of_creeping() {
        let mut settings = NavigatorSettings::default();
        let footprint = Footprint::round(0.5).expect("a radius");
        let robot = RobotModel { footprint, limits: Limits::default() };
        let frame = GridFrame::new(100, 100, 0.1, Pose::new(-5.0, -5.0, 0.0)).expect("a size");
        let ground = ObstacleGrid::filled(frame, false);
        let turn = |settings: &NavigatorSettings, rate, person_m| {
            let person = MovingDisc { x: 0.8 + person_m, y: 0.0, radius: 0.3, vx: 0.0, vy: 0.0 };
            let now = PredictedState { may_come: vec![person], ..standing_at(Pose::default()) };
            let motion = (Twist::STOP, Twist::STOP);
            with_state(settings, &robot, &ground, &now, motion, |state| {
                state.without_slow_turn(Twist::new(0.0, rate)).angular
            })
        };
        assert_eq!(turn(&settings, 0.1, 1.9), 0.0);
        assert_eq!(turn(&settings, 0.12, 1.9), 0.12, "not a creep");
        assert_eq!(turn(&settings, 0.1, 2.1), 0.1, "no person is near");
        settings.features.passive_safety = false;
        assert_eq!(turn(&settings, 0.1, 1.9), 0.1, "the feature is off");
        // Held up at once.
        settings = NavigatorSettings { stuck_patience_s: -1.0, ..NavigatorSettings::default() };
        assert_eq!(turn(&settings, 0.1, 1.9), 0.1, "it is held up");
    }
}
