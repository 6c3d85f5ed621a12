//! The trace of a drive: one row for each tick.

use super::GroundTruth;
use crate::digest::BitDigest;
use crate::geometry::{Point, Pose, Twist};
use crate::navigator::{Decision, Mode, Observation};
use serde::Serialize;

/// Below this turn rate the robot drives straight, rad/s: noise and small corrections of the heading stay below it.
const STRAIGHT: f64 = 0.05;

/// A step that is longer than the motion explains, by this much, is a correction of the pose, metres: a robot that was carried finds itself
/// elsewhere.
const CORRECTION_M: f64 = 0.1;

/// The true state and the decision of one tick.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TraceRow {
    /// Time at the start of the tick, seconds.
    pub time_s: f64,
    /// True pose.
    pub pose: Pose,
    /// Estimated pose.
    pub belief: Pose,
    /// True motion.
    pub twist: Twist,
    /// The command sent to the base.
    pub command: Twist,
    /// The local target.
    pub local_target: Point,
    /// Smallest gap between the footprint and anything solid, metres; contact at or below zero. Infinite where a robot without a true
    /// pose is lost.
    pub gap_m: f64,
    /// Number of admissible samples of the dynamic window.
    pub admissible: u32,
    /// Number of evaluated samples; zero if the decision needed none.
    pub samples: u32,
    /// Mode of the navigator.
    pub mode: Mode,
    /// Index of the path in [`Trace::paths`].
    pub path: usize,
    /// Centre of each moving obstacle; none for one that has not yet appeared.
    pub moving: Vec<Option<Point>>,
}

/// A whole drive.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Trace {
    /// One row for each tick, in order.
    pub rows: Vec<TraceRow>,
    /// The global paths that the robot followed, in order of planning.
    pub paths: Vec<Vec<Point>>,
    /// Radius of each moving obstacle, metres, in the order of [`TraceRow::moving`].
    pub moving_radii: Vec<f64>,
}

impl Trace {
    /// Returns a digest of the exact bits of every row and path. It does not depend on the duration of decisions.
    #[must_use]
    pub fn digest(&self) -> String {
        let mut digest = BitDigest::default();
        self.rows.iter().for_each(|row| row.add_to(&mut digest));
        for path in &self.paths {
            digest.wide(path.len() as u64);
            path.iter().for_each(|point| add_point(&mut digest, point));
        }
        self.moving_radii.iter().for_each(|&radius| digest.real(radius));
        digest.hex()
    }

    /// Distance driven, metres: the sum over the ticks. Where the pose jumps, the speed counts in its place.
    #[must_use]
    pub fn travelled_m(&self) -> f64 {
        let step = |pair: &[TraceRow]| {
            let step_m = (pair[1].pose.position() - pair[0].pose.position()).norm();
            let speed = pair[0].twist.linear.abs().max(pair[1].twist.linear.abs());
            let driven_m = speed * (pair[1].time_s - pair[0].time_s);
            if step_m > driven_m + CORRECTION_M { driven_m } else { step_m }
        };
        self.rows.windows(2).map(step).fold(0.0, |sum, step_m| sum + step_m)
    }

    /// Returns how often the true turn rate changes its sign. Turn rates of at most 0.05 rad/s count as none: a robot that turns
    /// left, drives straight and turns right changes once.
    #[must_use]
    pub fn omega_sign_changes(&self) -> usize {
        let turns =
            self.rows.iter().map(|row| row.twist.angular).filter(|rate| rate.abs() > STRAIGHT);
        turns.clone().zip(turns.skip(1)).filter(|(one, next)| one * next < 0.0).count()
    }
}

impl TraceRow {
    /// The row of a decision with the state of the robot, the smallest gap in metres, and the index of the path.
    pub(crate) fn new(
        observation: &Observation,
        decision: &Decision,
        truth: GroundTruth,
        gap_m: f64,
        path: usize,
    ) -> Self {
        let counts = decision.counts.unwrap_or_default();
        Self {
            time_s: observation.time_s,
            pose: truth.pose,
            belief: observation.pose,
            twist: truth.twist,
            command: decision.command,
            local_target: decision.local_target,
            gap_m,
            admissible: counts.admissible,
            samples: counts.to_array().iter().sum(),
            mode: decision.mode,
            path,
            moving: truth.moving,
        }
    }

    fn add_to(&self, digest: &mut BitDigest) {
        let Self { pose, twist, command, .. } = self;
        for value in [
            self.time_s,
            pose.x,
            pose.y,
            pose.yaw,
            self.belief.x,
            self.belief.y,
            self.belief.yaw,
            twist.linear,
            twist.angular,
            command.linear,
            command.angular,
            self.gap_m,
        ] {
            digest.real(value);
        }
        add_point(digest, &self.local_target);
        digest.word(self.admissible);
        digest.word(self.samples);
        digest.word(self.mode as u32);
        digest.wide(self.path as u64);
        // No centre is NaN, so this value is distinct from every centre.
        let absent = Point::new(f64::NAN, f64::NAN);
        self.moving.iter().for_each(|center| add_point(digest, center.as_ref().unwrap_or(&absent)));
    }
}

fn add_point(digest: &mut BitDigest, point: &Point) {
    digest.real(point.x);
    digest.real(point.y);
}

#[cfg(test)]
impl TraceRow {
    /// The row of a robot that drives with nothing near it.
    pub(crate) fn driving(pose: Pose, twist: Twist) -> Self {
        Self {
            time_s: 0.0,
            pose,
            belief: pose,
            twist,
            command: Twist::STOP,
            local_target: Point::default(),
            gap_m: 1.0,
            admissible: 0,
            samples: 0,
            mode: Mode::Driving,
            path: 0,
            moving: Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ten steps of 0.05 m, a jump of 8 m in the middle, and corrections of a centimetre.
    #[test]
    fn distance_driven_has_no_jumps_of_the_pose() {
        let row = |step: u32| {
            let jump_m = if step >= 5 { 8.0 } else { 0.0 };
            let pose = Pose::new(0.05 * f64::from(step), jump_m + 0.01 * f64::from(step % 2), 0.0);
            let time_s = 0.1 * f64::from(step);
            TraceRow { time_s, ..TraceRow::driving(pose, Twist::new(0.5, 0.0)) }
        };
        let travelled_m =
            Trace { rows: (0..=10).map(row).collect(), ..Trace::default() }.travelled_m();
        assert!((0.5..0.52).contains(&travelled_m), "{travelled_m}");
    }

    #[test]
    fn sign_changes_of_omega_ignore_rates_within_the_dead_band() {
        let changes = |rates: &[f64]| {
            let row = |&rate: &f64| TraceRow::driving(Pose::default(), Twist::new(0.5, rate));
            Trace { rows: rates.iter().map(row).collect(), ..Trace::default() }.omega_sign_changes()
        };
        assert_eq!(changes(&[]), 0);
        assert_eq!(changes(&[0.3, 0.0, 0.3]), 0);
        assert_eq!(changes(&[0.3, 0.04, -0.05, 0.0, -0.3]), 1);
        assert_eq!(changes(&[0.04, -0.04, 0.04]), 0);
        assert_eq!(changes(&[0.1, -0.1, 0.1, -0.1]), 3);
    }
}
