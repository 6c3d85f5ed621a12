//! Localization errors of a drive, tick by tick.

use crate::experiment::RunRow;
use crate::geometry::{Pose, Twist, wrap_angle};
use crate::localization::LocalizationStatus;
use crate::runtime::TickEvent;
use crate::sim::FaultInjection;

/// Time in which the robot must detect a fault, seconds.
const DETECTION_S: f64 = 1.0;

/// Adds the errors of each tick to a row, for a pose from scans.
#[derive(Default)]
pub(in crate::experiment) struct LocalizationMonitor {
    /// Time of the first injected fault, seconds; zero without one.
    fault_s: f64,
    squares: f64,
    known_ticks: u64,
    ticks: u64,
    unobserved: u64,
    lost_s: Option<f64>,
    /// Distance since the fault, and the robot's pose at the previous tick.
    driven_m: f64,
    before: Option<Pose>,
    has_stood: bool,
}

impl LocalizationMonitor {
    pub fn new(faults: &[FaultInjection]) -> Self {
        let fault_s =
            faults.iter().map(FaultInjection::from_s).reduce(f64::min).unwrap_or_default();
        Self { fault_s, ..Self::default() }
    }

    pub fn on_tick(&mut self, row: &mut RunRow, event: &TickEvent<'_>) {
        let Some(fix) = event.fix else {
            return;
        };
        let (truth, now_s) = (&event.row.pose, event.row.time_s);
        let off = |pose: &Pose| {
            let off_m = (pose.position() - truth.position()).norm();
            (off_m, wrap_angle(pose.yaw - truth.yaw).abs())
        };
        let is_lost = matches!(fix.status, LocalizationStatus::Lost(_));
        // The robot cannot detect a fault before the next scan, so there is no error.
        let is_known = !is_lost && !self.is_undetected(now_s);
        self.ticks += 1;
        self.unobserved += u64::from(fix.unobservable_directions > 0);
        if let LocalizationStatus::Lost(why) = fix.status
            && self.lost_s.is_none()
        {
            self.lost_s = Some(now_s);
            row.lost_reason = Some(why.to_string());
            row.lost_after_s = Some(now_s - self.fault_s);
        }
        let ((off_m, off_rad), (drift_m, drift_rad)) = if is_known {
            (off(&event.row.belief), off(&event.odometry.pose))
        } else {
            ((0.0, 0.0), (0.0, 0.0))
        };
        let is_tracking = is_known && fix.status == LocalizationStatus::Tracking;
        if is_known {
            if let Some(lost_s) = self.lost_s {
                row.found_after_s.get_or_insert(now_s - lost_s);
            }
            self.squares += off_m * off_m;
            self.known_ticks += 1;
        }
        for (figure, value) in [
            (&mut row.pose_error_max_m, off_m),
            (&mut row.pose_error_max_rad, off_rad),
            (&mut row.tracking_error_max_m, if is_tracking { off_m } else { 0.0 }),
            (&mut row.odometry_error_max_m, drift_m),
            (&mut row.odometry_error_max_rad, drift_rad),
            (&mut row.pose_sigma_max_m, fix.sigma_m()),
        ] {
            *figure = Some(figure.unwrap_or_default().max(value));
        }
        let agreement = row.agreement_min_share.unwrap_or(1.0);
        row.agreement_min_share = Some(agreement.min(fix.agreement.matching_fraction()));
        let is_uncertain = is_known && fix.status == LocalizationStatus::Uncertain;
        *row.uncertain_ticks.get_or_insert(0) += u64::from(is_uncertain);
        *row.lost_ticks.get_or_insert(0) += u64::from(is_lost);
        row.pose_error_rms_m = Some((self.squares / self.known_ticks.max(1) as f64).sqrt());
        row.unobserved_share = Some(self.unobserved as f64 / self.ticks as f64);
        // The jump at the tick of the fault does not count as distance driven.
        if let Some(before) = self.before.filter(|_| now_s > self.fault_s + 0.15) {
            self.driven_m += (truth.position() - before.position()).norm();
        }
        self.before = Some(*truth);
        let is_over = event.row.twist.linear.abs() < Twist::STANDING || row.found_after_s.is_some();
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
}
