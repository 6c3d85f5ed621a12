//! Passive safety: how fast to drive near moving obstacles, which may turn.
//!
//! A moving obstacle may change its direction at any time, and speeds up as a walking person does. The robot stops before an
//! obstacle can reach a part of its outline that its own motion moves outward (Macek, Vasquez, Fraichard, Siegwart: Towards safe
//! vehicle navigation in dynamic urban scenarios, 2009). This prevents no contact with another part, or with a standing robot.

use super::predicted_state::PredictedState;
use crate::geometry::{Point, Pose, Twist};
use crate::map::MovingDisc;
use crate::robot::{Footprint, Limits};

/// Lag of the tracked velocity, seconds: a moving obstacle that speeds up is faster than tracked by what it gains in this time.
const TRACKING_S: f64 = 0.4;
/// Distance to a standing robot at which an obstacle may arrive, metres.
const MIN_GAP_M: f64 = 0.1;
/// A robot whose parts are all at most this fast may pass a person who stands, m/s: it stops within a few centimetres.
const SLOW: f64 = 0.15;
/// Time step of the prediction, seconds.
const STEP_S: f64 = 0.1;
/// Bisection steps in the range of speeds: the result is good to a hundredth of it.
const BISECTIONS: u32 = 7;

/// An obstacle at a place that may come at a speed, m/s. Its direction does not matter: the check takes it as unknown.
pub(super) const fn obstacle_that_may_come(place: Point, radius_m: f64, speed: f64) -> MovingDisc {
    MovingDisc { x: place.x, y: place.y, radius: radius_m, vx: speed, vy: 0.0 }
}

/// What the check depends on.
pub(super) struct PassiveSafety<'a> {
    pub now: &'a PredictedState,
    /// The obstacles that may come.
    pub obstacles: &'a [MovingDisc],
    pub footprint: &'a Footprint,
    pub limits: &'a Limits,
    /// Time for which the robot keeps its command until it brakes for one that comes, seconds.
    pub reaction_s: f64,
    /// Acceleration of the obstacles, m/s^2, up to a speed, m/s.
    pub acceleration: f64,
    pub top_speed: f64,
}

impl PassiveSafety<'_> {
    /// The highest forward speed up to a limit, m/s, from which the robot stops in time. It also keeps the distance of a
    /// robot that follows an obstacle.
    pub fn fastest(&self, limit: f64) -> f64 {
        let at = |speed: f64| self.stops_in_time(&Twist::new(speed, self.now.twist.angular));
        if self.obstacles.is_empty() || at(limit) {
            return limit;
        }
        let (mut safe, mut not_safe) = (0.0, limit);
        for _ in 0..BISECTIONS {
            let speed = f64::midpoint(safe, not_safe);
            if at(speed) {
                safe = speed;
            } else {
                not_safe = speed;
            }
        }
        safe
    }

    /// Whether the robot stops in time if it drives towards a velocity until it notices a turn, and then brakes: before an
    /// obstacle can reach a part of its outline that moves outward.
    pub fn stops_in_time(&self, wanted: &Twist) -> bool {
        let now = self.now;
        // Since the scan an obstacle may have moved otherwise than predicted.
        let head_start_s = now.since_scan_s;
        let is_slow = self.is_slow(&now.twist) && self.is_slow(wanted);
        let is_safe_at = |pose: &Pose, twist: &Twist, time_s: f64| {
            self.obstacles.iter().all(|disc| {
                let gap_m = self.footprint.leading_gap_m(pose, twist, disc);
                let speed = libm::hypot(disc.vx, disc.vy);
                if is_slow && speed == 0.0 {
                    let first_m = self.footprint.leading_gap_m(&now.pose, twist, disc);
                    return gap_m >= first_m.min(MIN_GAP_M);
                }
                gap_m - self.reach_m(speed, head_start_s + time_s) >= MIN_GAP_M
            })
        };
        let reaction_s = self.reaction_s;
        let steps = (reaction_s / STEP_S).ceil() as u32;
        let (mut pose, mut twist) = (now.pose, now.twist);
        for step in 1..=steps {
            let step_s = reaction_s / f64::from(steps);
            (pose, twist) = self.limits.advance(&pose, &twist, wanted, step_s);
            if !is_safe_at(&pose, &twist, f64::from(step) * step_s) {
                return false;
            }
        }
        let mut time_s = reaction_s;
        for (pose, then) in self.limits.braking(pose, twist, STEP_S).skip(1) {
            time_s += STEP_S;
            if !is_safe_at(&pose, &twist, time_s) {
                return false;
            }
            twist = then;
        }
        twist == Twist::STOP
    }

    /// Whether no part of the robot is faster than a robot may be next to a person who stands.
    fn is_slow(&self, twist: &Twist) -> bool {
        self.footprint.fastest_part(twist) <= SLOW
    }

    /// Longest distance, metres, of an obstacle at a speed, m/s, within a time, seconds.
    fn reach_m(&self, speed: f64, time_s: f64) -> f64 {
        let lag_s = if speed > 0.0 { TRACKING_S } else { 0.0 };
        let speed = speed.max(self.top_speed.min(speed + self.acceleration * lag_s));
        let gained = self.top_speed - speed;
        if gained <= 0.0 || self.acceleration <= 0.0 {
            return speed * time_s;
        }
        let speeding_s = time_s.min(gained / self.acceleration);
        let gained_m = self.acceleration * speeding_s * (time_s - speeding_s / 2.0);
        speed * time_s + gained_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const REACTION_S: f64 = 0.5;

    fn at(x: f64, y: f64, vx: f64) -> PredictedState {
        let disc = MovingDisc { x, y, radius: 0.3, vx, vy: 0.0 };
        PredictedState {
            time_s: 0.0,
            pose: Pose::default(),
            twist: Twist::STOP,
            moving: vec![disc],
            walkers: Vec::new(),
            may_come: vec![disc],
            near_turn: vec![disc],
            may_start: Vec::new(),
            since_scan_s: 0.0,
        }
    }

    /// A check of obstacles that keep their speed.
    fn safety<'a>(
        now: &'a PredictedState,
        footprint: &'a Footprint,
        limits: &'a Limits,
    ) -> PassiveSafety<'a> {
        PassiveSafety {
            now,
            obstacles: &now.moving,
            footprint,
            limits,
            reaction_s: REACTION_S,
            acceleration: 0.0,
            top_speed: 0.0,
        }
    }

    fn fastest(now: &PredictedState, most: f64) -> f64 {
        let footprint = Footprint::round(0.3).expect("a valid radius");
        let limits = Limits { max_vel_x: 2.0, acc_lim_x: 100.0, ..Limits::default() };
        safety(now, &footprint, &limits).fastest(most)
    }

    #[test]
    fn fastest_speed_and_approach_use_up_the_gap() {
        for (x, vx) in [(1.2, 0.0), (1.6, 0.75), (3.0, -0.5), (4.0, 1.5)] {
            let speed = fastest(&at(x, 0.0, vx), 2.0);
            let stopping_s = REACTION_S + speed;
            // The robot gains its speed within the first step, at half of it on average.
            let driven_m = speed * (REACTION_S - STEP_S / 2.0) + speed * speed / 2.0;
            let used_m = driven_m + libm::fabs(vx) * stopping_s;
            let had_m = x - 0.6 - MIN_GAP_M;
            // Bisection and steps leave a part of the gap, and never exceed it.
            assert!(
                (-0.2..=0.01).contains(&(used_m - had_m)),
                "{x}, {vx}: {speed}, {used_m} of {had_m}"
            );
        }
    }

    #[test]
    fn fastest_slows_down_for_an_obstacle_that_may_come_in_front() {
        // It may pass the robot from behind, or from the side.
        assert_eq!(fastest(&at(-3.0, 0.0, 1.0), 1.0), 1.0);
        assert!(fastest(&at(-1.2, 0.0, 1.5), 1.0) < 0.1);
        assert_eq!(fastest(&at(0.5, 3.0, -1.0), 1.0), 1.0);
        let crossing = fastest(&at(0.6, 1.2, -0.7), 1.0);
        assert!((0.05..0.7).contains(&crossing), "{crossing}");
        let next_to_it = fastest(&at(0.0, 1.3, 0.7), 1.0);
        assert!((0.05..0.7).contains(&next_to_it), "{next_to_it}");
        assert!(fastest(&at(0.7, 0.0, -1.0), 1.0) < 0.05);
        // An obstacle that stands next to the path does not approach.
        assert_eq!(fastest(&at(0.6, 0.8, 0.0), 1.0), 1.0);
    }

    #[test]
    fn reversing_away_is_safe_and_reversing_towards_an_obstacle_is_not() {
        let now = at(0.8, 0.0, -0.5);
        let footprint = Footprint::round(0.3).expect("a valid radius");
        let limits = Limits { min_vel_x: -0.5, ..Limits::default() };
        let safety = |now| safety(now, &footprint, &limits);
        assert!(safety(&now).stops_in_time(&Twist::new(-0.5, 0.0)));
        assert!(!safety(&at(-0.8, 0.0, 0.5)).stops_in_time(&Twist::new(-0.5, 0.0)));
    }

    /// Such a robot needs more steps than any check may take.
    #[test]
    fn robot_that_takes_too_long_to_brake_is_not_safe() {
        let far = at(-1e12, 0.0, -0.1);
        let footprint = Footprint::round(0.3).expect("a valid radius");
        let weak = Limits { decel_lim_x: -1e-9, ..Limits::default() };
        let forward = Twist::new(0.5, 0.0);
        assert!(!safety(&far, &footprint, &weak).stops_in_time(&forward));
        assert!(safety(&far, &footprint, &Limits::default()).stops_in_time(&forward));
        let huge = PredictedState { twist: Twist::new(1e300, 0.0), ..far };
        assert!(!safety(&huge, &footprint, &Limits::default()).stops_in_time(&forward));
    }

    #[test]
    fn standing_person_may_start_to_walk() {
        let now = at(0.9, 0.7, 0.0);
        let footprint = Footprint::round(0.3).expect("a valid radius");
        let limits = Limits { max_vel_x: 2.0, acc_lim_x: 100.0, ..Limits::default() };
        let standing = safety(&now, &footprint, &limits);
        let person = PassiveSafety { acceleration: 1.0, top_speed: 1.6, ..standing };
        assert!(person.fastest(1.0) < 0.5, "{}", person.fastest(1.0));
        // 1.6 m/s after 1.6 s and 1.28 m; one who walks may be faster by 0.4 m/s than tracked.
        assert!((person.reach_m(0.0, 1.0) - 0.5).abs() < 1e-12);
        assert!((person.reach_m(0.0, 2.6) - 2.88).abs() < 1e-12);
        assert!((person.reach_m(0.2, 1.0) - 1.1).abs() < 1e-12);
        assert_eq!(person.reach_m(2.0, 1.5), 3.0);
        // Farther away there is time to stop.
        let far = at(3.0, 2.5, 0.0);
        let far = PassiveSafety { now: &far, obstacles: &far.moving, ..person };
        assert_eq!(far.fastest(1.0), 1.0);
    }

    /// A post that the robot passes at 2 cm, or at 15 cm, before it brakes.
    #[test]
    fn obstacle_that_is_passed_during_the_reaction_counts() {
        let footprint = Footprint::round(0.3).expect("a valid radius");
        let limits =
            Limits { max_vel_x: 2.0, acc_lim_x: 100.0, decel_lim_x: -100.0, ..Limits::default() };
        for (y, expected) in [(0.62, false), (0.75, true)] {
            let now = PredictedState { twist: Twist::new(2.0, 0.0), ..at(0.5, y, 0.0) };
            let stops = safety(&now, &footprint, &limits).stops_in_time(&Twist::new(2.0, 0.0));
            assert_eq!(stops, expected, "{y} m");
        }
    }
}
