//! Consistency of the motion by matched scans with the motion by odometry: a bogged robot, and one with a frozen lidar, drives
//! by its odometry alone.

use std::collections::VecDeque;

use super::mount_check::MountCheck;
use crate::geometry::{Pose, wrap_angle};

/// Matched poses are compared with odometry over this time, seconds.
const WINDOW_S: f64 = 5.0;
/// Largest number of matched poses.
const MAX_ROWS: usize = 256;
/// The motion by odometry from which it is compared, metres and radians: more than any correction of the pose.
const COMPARED_M: f64 = 0.5;
const COMPARED_RAD: f64 = 0.9;
/// A robot that moves by less than this share of its odometry does not move.
const MIN_SHARE: f64 = 0.25;

/// Pose by odometry and by the map at the same time. The yaw angles are unwrapped.
#[derive(Clone, Copy, Debug)]
struct Row {
    time_s: f64,
    odometry: Pose,
    matched: Pose,
}

/// Compares matched poses with odometry.
#[derive(Clone, Debug, Default)]
pub(super) struct MotionCheck {
    rows: VecDeque<Row>,
    /// The direction of the motion.
    pub mount: MountCheck,
}

impl MotionCheck {
    /// Adds a matched pose with its time, seconds. Returns whether the robot moved by its odometry alone.
    pub fn is_stuck(&mut self, time_s: f64, odometry: &Pose, matched: &Pose) -> bool {
        let unwrapped = |before: &Pose, now: &Pose| Pose {
            yaw: before.yaw + wrap_angle(now.yaw - before.yaw),
            ..*now
        };
        let row = self.rows.back().map_or(
            Row { time_s, odometry: *odometry, matched: *matched },
            |last| Row {
                time_s,
                odometry: unwrapped(&last.odometry, odometry),
                matched: unwrapped(&last.matched, matched),
            },
        );
        let is_old = |first: &Row| !(0.0..=WINDOW_S).contains(&(time_s - first.time_s));
        while self.rows.len() >= MAX_ROWS || self.rows.front().is_some_and(is_old) {
            self.rows.pop_front();
        }
        self.rows.push_back(row);
        self.rows.iter().any(|first| {
            let distance_m = |from: &Pose, to: &Pose| (to.position() - from.position()).norm();
            let driven_m = distance_m(&first.odometry, &row.odometry);
            let turned_rad = (row.odometry.yaw - first.odometry.yaw).abs();
            let is_driven = driven_m >= COMPARED_M
                && distance_m(&first.matched, &row.matched) < MIN_SHARE * driven_m;
            let is_turned = turned_rad >= COMPARED_RAD
                && (row.matched.yaw - first.matched.yaw).abs() < MIN_SHARE * turned_rad;
            is_driven || is_turned
        })
    }

    /// The check on another map, to whose grid a function converts poses.
    pub fn on(&self, converted: impl Fn(&Pose) -> Pose) -> Self {
        // A conversion wraps yaw angles.
        let turn = converted(&Pose::default()).yaw;
        let row = |row: &Row| {
            let matched = Pose { yaw: row.matched.yaw + turn, ..converted(&row.matched) };
            Row { matched, ..*row }
        };
        Self { rows: self.rows.iter().map(row).collect(), mount: self.mount.on(converted) }
    }

    /// Forgets all poses: the robot was found at another place.
    pub fn clear(&mut self) {
        self.rows.clear();
        self.mount.begin_again();
    }
}
