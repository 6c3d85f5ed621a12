//! What is seen of a drive, tick by tick.

use super::LocalizationRow;
use crate::geometry::{Pose, wrap_angle};
use crate::localization::LocalizationStatus;
use crate::runtime::TickEvent;

/// Within so long a mishap is to be noticed, seconds.
const NOTICED_S: f64 = 1.0;

/// A robot slower than this stands, m/s.
const STANDS: f64 = 0.02;

/// Errors as they come.
pub(super) struct Watch {
    mishap_s: f64,
    row: LocalizationRow,
    squares: f64,
    known_ticks: u64,
    ticks: u64,
    unseen: u64,
    lost_s: Option<f64>,
    /// Way since the mishap, and where the robot was at the tick before.
    driven_m: f64,
    before: Option<Pose>,
    has_stood: bool,
}

impl Watch {
    pub fn new(mishap_s: f64) -> Self {
        Self {
            mishap_s,
            row: LocalizationRow {
                case: String::new(),
                map: String::new(),
                seed: 0,
                slip: 0.0,
                reached: false,
                collided: false,
                travelled_m: 0.0,
                time_s: 0.0,
                worst_m: 0.0,
                worst_rad: 0.0,
                worst_tracking_m: 0.0,
                rms_m: 0.0,
                odometry_worst_m: 0.0,
                odometry_worst_rad: 0.0,
                sigma_m: 0.0,
                unseen_share: 0.0,
                least_agreement: 1.0,
                uncertain_ticks: 0,
                lost_ticks: 0,
                lost_why: None,
                lost_after_s: None,
                driven_on_m: None,
                found_after_s: None,
                fault: None,
                trace_digest: String::new(),
            },
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

    pub fn see(&mut self, moment: &TickEvent<'_>) {
        let Some(fix) = moment.fix else {
            return;
        };
        let (truth, now_s) = (&moment.row.pose, moment.row.time_s);
        let is_unnoticed = self.is_unnoticed(now_s);
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
                    row.lost_why = Some(why.to_string());
                    row.lost_after_s = Some(now_s - self.mishap_s);
                }
            }
            // What nobody can know before it has been looked at is no error.
            _ if is_unnoticed => {}
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
        // The tick of the mishap is a leap and no way.
        if let Some(before) = self.before.filter(|_| now_s > self.mishap_s + 0.15) {
            self.driven_m += (truth.position() - before.position()).norm();
        }
        self.before = Some(*truth);
        let is_over = moment.row.twist.linear.abs() < STANDS || row.found_after_s.is_some();
        if self.lost_s.is_some() && is_over && !self.has_stood {
            self.has_stood = true;
            row.driven_on_m = Some(self.driven_m);
        }
    }

    /// Whether a mishap has happened that the robot has not yet noticed, and is about to.
    fn is_unnoticed(&self, now_s: f64) -> bool {
        let since_s = now_s - self.mishap_s;
        self.mishap_s > 0.0 && self.lost_s.is_none() && (0.0..NOTICED_S).contains(&since_s)
    }

    pub fn row(self) -> LocalizationRow {
        LocalizationRow {
            rms_m: (self.squares / self.known_ticks.max(1) as f64).sqrt(),
            unseen_share: self.unseen as f64 / self.ticks.max(1) as f64,
            ..self.row
        }
    }
}
