//! The scans of the last two seconds: was a place free a moment ago?

use std::collections::VecDeque;

use super::super::scan_visibility::{StampedScan, proves_free};
use crate::geometry::{Point, Pose};
use crate::map::Scan;

/// Scans are kept at intervals of this, seconds, and for so long.
pub(super) const INTERVAL_S: f64 = 0.099;
pub(super) const KEPT: usize = 20;
/// Ages of the scans that are asked, seconds: something fast is proved to move by the latest, something slow by the
/// oldest only.
pub(super) const AGES_S: [f64; 4] = [0.25, 0.5, 1.0, 1.7];
/// How far beyond a place, metres, a beam must have gone to prove that it was free; and how much further for each second
/// between the two looks, m/s: odometry goes astray.
const FREE_MARGIN_M: f64 = 0.06;
const ASTRAY: f64 = 0.05;

/// The margin for two looks that lie so many seconds apart.
pub(super) fn free_margin_m(apart_s: f64) -> f64 {
    FREE_MARGIN_M + ASTRAY * apart_s
}

/// Views, the newest last.
#[derive(Debug, Default)]
pub(super) struct History {
    views: VecDeque<(f64, StampedScan)>,
    /// Those that are asked now, and how old they are, seconds.
    asked: Vec<(usize, f64)>,
}

impl History {
    /// Forgets everything.
    pub fn clear(&mut self) {
        self.views.clear();
        self.asked.clear();
    }

    /// Chooses whom to ask at a time, seconds.
    pub fn look_back_from(&mut self, time_s: f64) {
        self.asked.clear();
        for age_s in AGES_S {
            let old_enough = |(seen_s, _): &(f64, StampedScan)| time_s - seen_s >= age_s;
            if let Some(place) = self.views.iter().rposition(old_enough)
                && !self.asked.iter().any(|&(other, _)| other == place)
            {
                self.asked.push((place, time_s - self.views[place].0));
            }
        }
    }

    /// Whether some earlier scan saw through a point.
    pub fn was_free(&self, point: &Point) -> bool {
        self.asked.iter().any(|&(place, age_s)| {
            let view = &self.views[place].1;
            proves_free(&view.pose, &view.scan, point, free_margin_m(age_s))
        })
    }

    /// Remembers a scan.
    pub fn push(&mut self, time_s: f64, pose: &Pose, scan: &Scan) {
        if let Some((last_s, _)) = self.views.back()
            && time_s - last_s < INTERVAL_S
        {
            return;
        }
        let mut view = if self.views.len() >= KEPT {
            self.views
                .pop_front()
                .map_or_else(StampedScan::default, |(_, view)| view)
        } else {
            StampedScan::default()
        };
        view.copy(pose, scan);
        self.views.push_back((time_s, view));
    }
}
