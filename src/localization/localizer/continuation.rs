//! A localizer that continues with another map, with changes of its map, or with odometry in another frame.

use super::Localizer;
use crate::localization::PoseHistory;
#[cfg(feature = "sim")]
use crate::localization::SignedDistanceField;

impl Localizer {
    /// Continues with pose, odometry and status of a localizer on another map in the same frame.
    pub fn continue_from(&mut self, before: &Self) {
        let pose = self.map.to_grid(before.pose());
        let is_turned = self.map.frame.origin.yaw != before.map.frame.origin.yaw;
        self.ekf = before.ekf;
        self.ekf.pose = pose;
        if is_turned {
            self.ekf = before.ekf.reset_pose(pose, &self.settings);
        }
        self.odometry = before.odometry;
        self.history = before.history.clone();
        self.scan = before.scan.clone();
        self.rejections = before.rejections;
        self.lost_by = before.lost_by;
        self.has_sparse_scans = before.has_sparse_scans;
        self.stamp_noise = before.stamp_noise;
        self.searches.hint = before.searches.hint.map(|hint| hint.on(&self.map, &before.map));
        self.estimate = before.estimate;
        self.update_estimate();
    }

    /// Matches scans to the map with the changes that they showed; a map in another frame is ignored. The changes are still those of
    /// the map before.
    #[cfg(feature = "sim")]
    pub(crate) fn adopt_changes(&mut self, changed: SignedDistanceField) {
        if changed.frame != self.map.frame {
            return;
        }
        let before = core::mem::replace(&mut self.map, changed);
        self.original.get_or_insert(before);
        self.searches.restart();
    }

    /// Odometry starts in another frame: the next pose by odometry only sets the reference.
    pub fn restart_odometry(&mut self) {
        self.odometry = None;
        self.history = PoseHistory::new();
        self.anchor = None;
        self.motion_check.clear();
    }
}
