//! How fast to drive near people, who may turn round.
//!
//! Passive safety: whatever people do at the pace they have, the robot stands before one of them can reach it from where
//! the robot's own motion brings it nearer to him (Macek, Vasquez, Fraichard, Siegwart: Towards safe vehicle navigation in
//! dynamic urban scenarios, 2009). Who runs into a robot from behind, or into one that stands, is not prevented by it.

use crate::geometry::{Pose, Twist};
use crate::map::MovingDisc;
use crate::robot::{Footprint, Limits};

use super::navigator::Navigator;
use super::predicted_state::PredictedState;

/// Until the scans have shown that somebody turned, seconds: the tracker takes about half a second to be sure of a motion,
/// and most of that of a change.
const NOTICED_S: f64 = 0.4;
/// The robot stands this far off when somebody reaches it, metres.
const LEFT_M: f64 = 0.05;
/// Braking is looked over in such steps, seconds.
const STEP_S: f64 = 0.1;
/// Halvings of the range of speeds: a hundredth of it is near enough.
const HALVINGS: u32 = 7;

/// What a robot knows when it asks how fast it may drive.
pub(super) struct PassiveSafety<'a> {
    pub now: &'a PredictedState,
    pub footprint: &'a Footprint,
    pub limits: &'a Limits,
    /// From a decision to its effect, and to the next decision, seconds.
    pub delay_s: f64,
}

impl Navigator {
    /// How people are minded, by a robot that does.
    pub(super) fn caution<'a>(&'a self, now: &'a PredictedState) -> Option<PassiveSafety<'a>> {
        let period_s = self.planner.settings().control_period_s;
        self.settings
            .features
            .passive_safety
            .then_some(PassiveSafety {
                now,
                footprint: &self.robot.footprint,
                limits: &self.robot.limits,
                delay_s: self.settings.actuation_delay_s + period_s,
            })
    }

    /// Whether the robot may make for a velocity until the next tick.
    pub(super) fn is_safe_towards(&self, now: &PredictedState, wanted: &Twist) -> bool {
        let next = self.towards(now, wanted);
        self.caution(now)
            .is_none_or(|caution| caution.stands_in_time(&next))
    }

    /// The nearest to a velocity that is reached by the next tick, or braking where that would not be safe_towards people.
    pub(super) fn safe_towards(&self, now: &PredictedState, wanted: &Twist) -> Twist {
        if self.is_safe_towards(now, wanted) {
            self.towards(now, wanted)
        } else {
            self.brake(now)
        }
    }
}

impl PassiveSafety<'_> {
    /// The highest forward speed up to one, m/s, from which the robot stands in time. A robot that follows somebody keeps its
    /// distance by it.
    pub fn fastest(&self, most: f64) -> f64 {
        let at = |speed: f64| self.stands_in_time(&Twist::new(speed, self.now.twist.angular));
        if self.now.moving.is_empty() || at(most) {
            return most;
        }
        let (mut safe, mut unsafe_from) = (0.0, most);
        for _ in 0..HALVINGS {
            let speed = f64::midpoint(safe, unsafe_from);
            if at(speed) {
                safe = speed;
            } else {
                unsafe_from = speed;
            }
        }
        safe
    }

    /// Whether a robot that makes for a velocity, until it notices that somebody turned to it, and then brakes, stands before
    /// anybody can reach a part of it that came nearer to him by the robot's own motion.
    pub fn stands_in_time(&self, wanted: &Twist) -> bool {
        let now = self.now;
        let at_first_m: Vec<f64> = self.gaps_m(&now.pose).collect();
        let is_safe_at = |pose: &Pose, time_s: f64| {
            let near = now.moving.iter().zip(&at_first_m).zip(self.gaps_m(pose));
            near.into_iter().all(|((disc, &at_first_m), gap_m)| {
                let reach_m = libm::hypot(disc.vx, disc.vy) * time_s;
                gap_m >= at_first_m || gap_m - reach_m >= LEFT_M
            })
        };
        let noticed_s = self.delay_s + NOTICED_S;
        let going_on = (noticed_s / STEP_S).ceil() as u32;
        let (mut pose, mut twist) = (now.pose, now.twist);
        for step in 1..=going_on {
            let step_s = noticed_s / f64::from(going_on);
            (pose, twist) = self.limits.advance(&pose, &twist, wanted, step_s);
            if !is_safe_at(&pose, f64::from(step) * step_s) {
                return false;
            }
        }
        let mut time_s = noticed_s;
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
        let gap = |disc: &MovingDisc| {
            let center = disc.center();
            self.footprint.gap_to_disc_m(pose, &center, disc.radius)
        };
        self.now.moving.iter().map(gap)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DELAY_S: f64 = 0.1;

    fn outlook(x: f64, y: f64, vx: f64) -> PredictedState {
        let disc = MovingDisc {
            x,
            y,
            radius: 0.3,
            vx,
            vy: 0.0,
        };
        PredictedState {
            time_s: 0.0,
            pose: Pose::default(),
            twist: Twist::STOP,
            moving: vec![disc],
        }
    }

    fn fastest(now: &PredictedState, most: f64) -> f64 {
        let footprint = Footprint::round(0.3).expect("a sound radius");
        let limits = Limits {
            max_vel_x: 2.0,
            acc_lim_x: 100.0,
            ..Limits::default()
        };
        let caution = PassiveSafety {
            now,
            footprint: &footprint,
            limits: &limits,
            delay_s: DELAY_S,
        };
        caution.fastest(most)
    }

    #[test]
    fn both_together_use_up_the_gap() {
        for (x, vx) in [(1.2, 0.0), (1.6, 0.75), (3.0, -0.5), (4.0, 1.5)] {
            let speed = fastest(&outlook(x, 0.0, vx), 2.0);
            let stopping_s = DELAY_S + NOTICED_S + speed;
            // It gains its speed within the first step, at half of it on average.
            let way_m = speed * (DELAY_S + NOTICED_S - STEP_S / 2.0) + speed * speed / 2.0;
            let used_m = way_m + libm::fabs(vx) * stopping_s;
            let had_m = x - 0.6 - LEFT_M;
            // Halving and steps leave some of it, and take no more.
            assert!(
                (-0.2..=0.01).contains(&(used_m - had_m)),
                "{x}, {vx}: {speed}, {used_m} of {had_m}"
            );
        }
    }

    #[test]
    fn who_is_behind_is_no_reason_to_slow_down_and_who_could_step_in_is() {
        assert_eq!(fastest(&outlook(-0.7, 0.0, 1.0), 1.0), 1.0);
        assert_eq!(fastest(&outlook(0.5, 3.0, -1.0), 1.0), 1.0);
        let beside = fastest(&outlook(0.6, 1.2, -0.7), 1.0);
        assert!((0.05..0.7).contains(&beside), "{beside}");
        assert!(fastest(&outlook(0.7, 0.0, -1.0), 1.0) < 0.02);
        // Somebody who stands beside the way does not come.
        assert_eq!(fastest(&outlook(0.6, 0.8, 0.0), 1.0), 1.0);
    }

    #[test]
    fn backing_away_is_always_safe_and_backing_into_somebody_never() {
        let now = outlook(0.8, 0.0, -0.5);
        let footprint = Footprint::round(0.3).expect("a sound radius");
        let limits = Limits {
            min_vel_x: -0.5,
            ..Limits::default()
        };
        let caution = |now| PassiveSafety {
            now,
            footprint: &footprint,
            limits: &limits,
            delay_s: DELAY_S,
        };
        assert!(caution(&now).stands_in_time(&Twist::new(-0.5, 0.0)));
        assert!(!caution(&outlook(-0.8, 0.0, 0.5)).stands_in_time(&Twist::new(-0.5, 0.0)));
    }
}
