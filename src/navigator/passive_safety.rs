//! Passive safety: how fast to drive near moving obstacles, which may turn.
//!
//! A moving obstacle may change its direction at any time, but not its speed. The robot stops before an obstacle can reach a
//! part of it that the robot's own motion brings nearer (Macek, Vasquez, Fraichard, Siegwart: Towards safe vehicle navigation
//! in dynamic urban scenarios, 2009). This prevents no contact with an obstacle that comes from behind, or at a standing robot.

use super::state::PredictedState;
use crate::geometry::{Pose, Twist};
use crate::robot::{Footprint, Limits};

/// Time until the scans show that an obstacle turned, seconds. The tracker needs about half a second to establish a motion,
/// and most of that to establish a change.
const REACTION_S: f64 = 0.4;
/// Distance to a standing robot at which an obstacle may arrive, metres.
const MIN_GAP_M: f64 = 0.05;
/// Time step of the prediction, seconds.
const STEP_S: f64 = 0.1;
/// Bisection steps in the range of speeds: the result is good to a hundredth of it.
const BISECTIONS: u32 = 7;

/// What the check depends on.
pub(super) struct PassiveSafety<'a> {
    pub now: &'a PredictedState,
    pub footprint: &'a Footprint,
    pub limits: &'a Limits,
    /// Time from a decision to its effect plus that to the next decision, seconds.
    pub delay_s: f64,
}

impl PassiveSafety<'_> {
    /// The highest forward speed up to a limit, m/s, from which the robot stops in time. It also keeps the distance of a
    /// robot that follows an obstacle.
    pub fn fastest(&self, limit: f64) -> f64 {
        let at = |speed: f64| self.stops_in_time(&Twist::new(speed, self.now.twist.angular));
        if self.now.moving.is_empty() || at(limit) {
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
    /// obstacle can reach a part of it that came nearer by the robot's own motion.
    pub fn stops_in_time(&self, wanted: &Twist) -> bool {
        let now = self.now;
        let at_first_m: Vec<f64> = self.gaps_m(&now.pose).collect();
        let is_safe_at = |pose: &Pose, time_s: f64| {
            let near = now.moving.iter().zip(&at_first_m).zip(self.gaps_m(pose));
            near.into_iter().all(|((disc, &at_first_m), gap_m)| {
                let reach_m = libm::hypot(disc.vx, disc.vy) * time_s;
                gap_m >= at_first_m || gap_m - reach_m >= MIN_GAP_M
            })
        };
        let reaction_s = self.delay_s + REACTION_S;
        let steps = (reaction_s / STEP_S).ceil() as u32;
        let (mut pose, mut twist) = (now.pose, now.twist);
        for step in 1..=steps {
            let step_s = reaction_s / f64::from(steps);
            (pose, twist) = self.limits.advance(&pose, &twist, wanted, step_s);
            if !is_safe_at(&pose, f64::from(step) * step_s) {
                return false;
            }
        }
        let mut time_s = reaction_s;
        while twist != Twist::STOP {
            (pose, twist) = self.limits.advance_braking(&pose, &twist, STEP_S);
            time_s += STEP_S;
            if !is_safe_at(&pose, time_s) {
                return false;
            }
        }
        true
    }

    fn gaps_m(&self, pose: &Pose) -> impl Iterator<Item = f64> {
        self.now.moving.iter().map(|disc| self.footprint.gap_to_moving_m(pose, disc))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::MovingDisc;

    const DELAY_S: f64 = 0.1;

    fn at(x: f64, y: f64, vx: f64) -> PredictedState {
        let disc = MovingDisc { x, y, radius: 0.3, vx, vy: 0.0 };
        PredictedState {
            time_s: 0.0,
            pose: Pose::default(),
            twist: Twist::STOP,
            moving: vec![disc],
        }
    }

    fn fastest(now: &PredictedState, most: f64) -> f64 {
        let footprint = Footprint::round(0.3).expect("a valid radius");
        let limits = Limits { max_vel_x: 2.0, acc_lim_x: 100.0, ..Limits::default() };
        let safety =
            PassiveSafety { now, footprint: &footprint, limits: &limits, delay_s: DELAY_S };
        safety.fastest(most)
    }

    #[test]
    fn fastest_speed_and_approach_use_up_the_gap() {
        for (x, vx) in [(1.2, 0.0), (1.6, 0.75), (3.0, -0.5), (4.0, 1.5)] {
            let speed = fastest(&at(x, 0.0, vx), 2.0);
            let stopping_s = DELAY_S + REACTION_S + speed;
            // The robot gains its speed within the first step, at half of it on average.
            let driven_m = speed * (DELAY_S + REACTION_S - STEP_S / 2.0) + speed * speed / 2.0;
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
    fn fastest_slows_down_for_an_obstacle_ahead_and_not_for_one_behind() {
        assert_eq!(fastest(&at(-0.7, 0.0, 1.0), 1.0), 1.0);
        assert_eq!(fastest(&at(0.5, 3.0, -1.0), 1.0), 1.0);
        let crossing = fastest(&at(0.6, 1.2, -0.7), 1.0);
        assert!((0.05..0.7).contains(&crossing), "{crossing}");
        assert!(fastest(&at(0.7, 0.0, -1.0), 1.0) < 0.02);
        // An obstacle that stands next to the path does not approach.
        assert_eq!(fastest(&at(0.6, 0.8, 0.0), 1.0), 1.0);
    }

    #[test]
    fn reversing_away_is_safe_and_reversing_towards_an_obstacle_is_not() {
        let now = at(0.8, 0.0, -0.5);
        let footprint = Footprint::round(0.3).expect("a valid radius");
        let limits = Limits { min_vel_x: -0.5, ..Limits::default() };
        let safety =
            |now| PassiveSafety { now, footprint: &footprint, limits: &limits, delay_s: DELAY_S };
        assert!(safety(&now).stops_in_time(&Twist::new(-0.5, 0.0)));
        assert!(!safety(&at(-0.8, 0.0, 0.5)).stops_in_time(&Twist::new(-0.5, 0.0)));
    }
}
