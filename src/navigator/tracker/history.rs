//! Scans of the last two seconds, to check whether a place was free.

use std::collections::VecDeque;

use super::super::scan_visibility::{StampedScan, proves_free};
use crate::geometry::{Point, Pose};
use crate::map::Scan;

/// Interval of the kept scans, seconds, and their number.
pub(super) const INTERVAL_S: f64 = 0.099;
pub(super) const KEPT: usize = 20;
/// Ages of the scans that are checked, seconds: the latest shows fast motion, and only the oldest slow motion.
pub(super) const AGES_S: [f64; 4] = [0.25, 0.5, 1.0, 1.7];
/// Distance that a beam must go beyond a place to show that it was free, metres, and its growth with the time between the two
/// scans, m/s: odometry drifts.
const FREE_MARGIN_M: f64 = 0.06;
const DRIFT: f64 = 0.05;

/// The margin for two scans this many seconds apart, metres.
pub(super) fn free_margin_m(apart_s: f64) -> f64 {
    FREE_MARGIN_M + DRIFT * apart_s
}

/// Earlier scans, the newest last.
#[derive(Debug, Default)]
pub(super) struct History {
    scans: VecDeque<(f64, StampedScan)>,
    /// Indices of the scans that are checked now, and their ages, seconds.
    selected: Vec<(usize, f64)>,
}

impl History {
    /// Forgets all scans.
    pub fn clear(&mut self) {
        self.scans.clear();
        self.selected.clear();
    }

    /// Selects the scans to check at a time, seconds.
    pub fn select(&mut self, time_s: f64) {
        self.selected.clear();
        for age_s in AGES_S {
            let old_enough = |(seen_s, _): &(f64, StampedScan)| time_s - seen_s >= age_s;
            if let Some(place) = self.scans.iter().rposition(old_enough)
                && !self.selected.iter().any(|&(other, _)| other == place)
            {
                self.selected.push((place, time_s - self.scans[place].0));
            }
        }
    }

    /// Whether a selected scan saw through a point.
    pub fn was_free(&self, point: &Point) -> bool {
        self.selected.iter().any(|&(place, age_s)| {
            let earlier = &self.scans[place].1;
            proves_free(&earlier.pose, &earlier.scan, point, free_margin_m(age_s))
        })
    }

    /// Keeps a scan.
    pub fn push(&mut self, time_s: f64, pose: &Pose, scan: &Scan) {
        if let Some((last_s, _)) = self.scans.back()
            && time_s - last_s < INTERVAL_S
        {
            return;
        }
        let mut kept = if self.scans.len() >= KEPT {
            self.scans.pop_front().map_or_else(StampedScan::default, |(_, oldest)| oldest)
        } else {
            StampedScan::default()
        };
        kept.copy(pose, scan);
        self.scans.push_back((time_s, kept));
    }
}
