//! Speed and acceleration limits, named as in Nav2.

use core::iter::successors;

use serde::{Deserialize, Serialize};

use super::TickTime;
use crate::geometry::{Pose, Twist};
use crate::settings::settings;

/// Most steps in which a predicted robot brakes to a standstill: one that takes longer counts as not safe.
const MAX_BRAKING_STEPS: usize = 1000;

settings! {
    /// Limits of the base. Names and signs follow Nav2's DWB: decelerations are negative.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct Limits {
        /// Smallest forward speed; a negative value permits reversing. Every robot may stand.
        pub min_vel_x: f64 = 0.0, ["m/s", -15.99 to 0];
        /// Largest forward speed; above zero for a robot that drives to goals.
        pub max_vel_x: f64 = 1.0, ["m/s", 0 to 15.99];
        /// Largest turn rate in both directions.
        pub max_vel_theta: f64 = 1.0, ["rad/s", above 0];
        /// Largest forward acceleration.
        pub acc_lim_x: f64 = 1.0, ["m/s^2", above 0];
        /// Largest forward deceleration.
        pub decel_lim_x: f64 = -1.0, ["m/s^2", below 0];
        /// Largest angular acceleration.
        pub acc_lim_theta: f64 = 2.0, ["rad/s^2", above 0];
        /// Largest angular deceleration.
        pub decel_lim_theta: f64 = -2.0, ["rad/s^2", below 0];
    }
}

impl Limits {
    /// Clamps a twist to the speed limits.
    #[must_use]
    pub fn clamp(&self, target: &Twist) -> Twist {
        Twist {
            linear: target.linear.clamp(self.min_vel_x, self.max_vel_x),
            angular: target.angular.clamp(-self.max_vel_theta, self.max_vel_theta),
        }
    }

    /// The twist nearest to `target` that the base can reach from `current` within a time, seconds, or at a tick of a control
    /// loop. The further braking of a late tick ends at zero.
    #[must_use]
    pub fn reachable(&self, current: &Twist, target: &Twist, time: impl Into<TickTime>) -> Twist {
        let time = time.into();
        let (gain_s, braking_s) = (time.accelerating_s(), time.braking_s());
        let step = |from: f64, to: f64, acceleration: f64, deceleration: f64| {
            // Braking is any change towards zero.
            if from >= 0.0 {
                let braked = (from + deceleration * braking_s).max(0.0);
                let low = (from + deceleration * gain_s).min(braked);
                to.clamp(low, from + acceleration * gain_s)
            } else {
                let braked = (from - deceleration * braking_s).min(0.0);
                let high = (from - deceleration * gain_s).max(braked);
                to.clamp(from - acceleration * gain_s, high)
            }
        };
        let Self { acc_lim_x, decel_lim_x, acc_lim_theta, decel_lim_theta, .. } = *self;
        Twist {
            linear: step(current.linear, target.linear, acc_lim_x, decel_lim_x),
            angular: step(current.angular, target.angular, acc_lim_theta, decel_lim_theta),
        }
    }

    /// These limits with a lower largest speed, m/s, in both directions, for a robot with this velocity: widened by what braking needs
    /// to get there, so that the robot reaches every velocity within them.
    #[must_use]
    pub fn slowed_to(&self, fastest: f64, twist: &Twist, time: impl Into<TickTime>) -> Self {
        let time = time.into();
        let within = |speed: f64| speed.clamp(self.min_vel_x, self.max_vel_x);
        let in_reach = |speed: f64| self.reachable(twist, &Twist::new(speed, 0.0), time).linear;
        // Never -0.
        let backwards = 0.0 - fastest;
        Self {
            min_vel_x: within(backwards.min(in_reach(backwards))),
            max_vel_x: within(fastest.max(in_reach(fastest))),
            ..*self
        }
    }

    /// The twist after braking for a time, seconds, or at a tick of a control loop, with the largest deceleration. The curvature is kept as far as the limits
    /// allow: a braking robot stays on its arc, which was checked, and does not leave it towards an obstacle.
    #[must_use]
    pub fn brake(&self, twist: &Twist, time: impl Into<TickTime>) -> Twist {
        let hardest = self.reachable(twist, &Twist::STOP, time);
        if twist.linear == 0.0 {
            return hardest;
        }
        let on_arc = twist.angular * (hardest.linear / twist.linear);
        Twist::new(hardest.linear, on_arc.abs().max(hardest.angular.abs()).copysign(twist.angular))
    }

    /// Pose and twist after a time, seconds, of motion towards a target twist. The twist changes linearly to the reachable one;
    /// the pose follows the mean of both.
    pub(crate) fn advance(
        &self,
        pose: &Pose,
        twist: &Twist,
        target: &Twist,
        time_s: f64,
    ) -> (Pose, Twist) {
        let then = self.reachable(twist, target, time_s);
        (pose.after(&twist.mean(&then), time_s), then)
    }

    /// The poses and twists of a robot that brakes as in [`Self::brake`] until it stands, from the present ones on, at intervals of
    /// a time, seconds. A robot that takes very long never stands.
    pub(crate) fn braking(
        &self,
        pose: Pose,
        twist: Twist,
        step_s: f64,
    ) -> impl Iterator<Item = (Pose, Twist)> {
        let next = move |(pose, twist): &(Pose, Twist)| {
            let then = self.brake(twist, step_s);
            (*twist != Twist::STOP).then(|| (pose.after(&twist.mean(&then), step_s), then))
        };
        successors(Some((pose, twist)), next).take(MAX_BRAKING_STEPS + 1)
    }
}
