//! Localization errors of a drive, tick by tick.

use super::LocalizationRow;
use crate::geometry::{Pose, wrap_angle};
use crate::localization::LocalizationStatus;
use crate::runtime::TickEvent;

/// Time in which the robot must detect a fault, seconds.
const DETECTION_S: f64 = 1.0;

/// Below this speed the robot stands, m/s.
const STANDING_M_S: f64 = 0.02;

/// Accumulates errors tick by tick.
pub(super) struct ErrorMonitor {
    fault_s: f64,
    row: LocalizationRow,
    squares: f64,
    known_ticks: u64,
    ticks: u64,
    unseen: u64,
    lost_s: Option<f64>,
    /// Distance since the fault, and the robot's pose at the previous tick.
    driven_m: f64,
    before: Option<Pose>,
    has_stood: bool,
}

impl ErrorMonitor {
    pub fn new(fault_s: f64) -> Self {
        Self {
            fault_s,
            row: LocalizationRow { least_agreement: 1.0, ..LocalizationRow::default() },
            squares: 0.0,
            known_ticks: 0,
            ticks: 0,
            unseen: 0,
            lost_s: None,
            driven_m: 0.0,
            before: None,
            has_stood: false,
        }
    }

    pub fn on_tick(&mut self, moment: &TickEvent<'_>) {
        let Some(fix) = moment.fix else {
            return;
        };
        let (truth, now_s) = (&moment.row.pose, moment.row.time_s);
        let is_undetected = self.is_undetected(now_s);
        let row = &mut self.row;
        let off = |pose: &Pose| {
            let off_m = (pose.position() - truth.position()).norm();
            (off_m, wrap_angle(pose.yaw - truth.yaw).abs())
        };
        self.ticks += 1;
        self.unseen += u64::from(fix.unobservable_directions > 0);
        row.sigma_m = row.sigma_m.max(fix.sigma_m());
        row.least_agreement = row.least_agreement.min(fix.agreement.matching_fraction());
        match fix.status {
            LocalizationStatus::Lost(why) => {
                row.lost_ticks += 1;
                if self.lost_s.is_none() {
                    self.lost_s = Some(now_s);
                    row.lost_reason = Some(why.to_string());
                    row.lost_after_s = Some(now_s - self.fault_s);
                }
            }
            // The robot cannot detect the fault before the next scan, so there is no error.
            _ if is_undetected => {}
            LocalizationStatus::Tracking | LocalizationStatus::Uncertain => {
                row.uncertain_ticks += u64::from(fix.status == LocalizationStatus::Uncertain);
                if let Some(lost_s) = self.lost_s {
                    row.found_after_s.get_or_insert(now_s - lost_s);
                }
                let ((off_m, off_rad), (drift_m, drift_rad)) =
                    (off(&moment.row.belief), off(&moment.odometry.pose));
                if fix.status == LocalizationStatus::Tracking {
                    row.worst_tracking_m = row.worst_tracking_m.max(off_m);
                }
                row.worst_m = row.worst_m.max(off_m);
                row.worst_rad = row.worst_rad.max(off_rad);
                row.odometry_worst_m = row.odometry_worst_m.max(drift_m);
                row.odometry_worst_rad = row.odometry_worst_rad.max(drift_rad);
                self.squares += off_m * off_m;
                self.known_ticks += 1;
            }
        }
        // The jump at the tick of the fault does not count as distance driven.
        if let Some(before) = self.before.filter(|_| now_s > self.fault_s + 0.15) {
            self.driven_m += (truth.position() - before.position()).norm();
        }
        self.before = Some(*truth);
        let is_over = moment.row.twist.linear.abs() < STANDING_M_S || row.found_after_s.is_some();
        if self.lost_s.is_some() && is_over && !self.has_stood {
            self.has_stood = true;
            row.driven_on_m = Some(self.driven_m);
        }
    }

    /// Whether a fault has just happened and the robot has not detected it yet.
    fn is_undetected(&self, now_s: f64) -> bool {
        let since_s = now_s - self.fault_s;
        self.fault_s > 0.0 && self.lost_s.is_none() && (0.0..DETECTION_S).contains(&since_s)
    }

    pub fn row(self) -> LocalizationRow {
        LocalizationRow {
            rms_m: (self.squares / self.known_ticks.max(1) as f64).sqrt(),
            unseen_share: self.unseen as f64 / self.ticks.max(1) as f64,
            ..self.row
        }
    }
}
