//! A localizer that continues with another map, with changes of its map, or with odometry in another frame.

use super::{Anchor, FoundPlace, Localizer};
use crate::geometry::Pose;
use crate::localization::PoseHistory;
#[cfg(feature = "sim")]
use crate::localization::SignedDistanceField;

impl Localizer {
    /// Continues with pose, odometry, status and checks of a localizer on another map in the same frame. Searches begin again.
    pub fn continue_from(&mut self, before: &Self) {
        // All fields are named, so that none is forgotten.
        let Self {
            map,
            // What was contradicted in the map before may be right in this one.
            original: _,
            changes: _,
            settings: _,
            ekf,
            odometry,
            history,
            scan,
            rejections,
            confirmations,
            searches,
            lost_by,
            anchor,
            motion_check,
            found,
            is_proven,
            has_given_up,
            has_sparse_scans,
            stamp_noise,
            estimate,
        } = before;
        let on_this = |pose: &Pose| self.map.to_grid(&map.to_map(pose));
        let pose = on_this(&ekf.pose);
        let is_turned = self.map.frame.origin.yaw != map.frame.origin.yaw;
        self.ekf = if is_turned { ekf.reset_pose(pose, &self.settings) } else { *ekf };
        self.ekf.pose = pose;
        self.anchor = anchor.map(|it| Anchor { matched: on_this(&it.matched), ..it });
        self.found = found.map(|it| FoundPlace { pose: on_this(&it.pose), ..it });
        self.motion_check = motion_check.on(on_this);
        let scores = self.searches.scores.take();
        self.searches = searches.restarted(on_this);
        self.searches.scores = scores;
        self.odometry = *odometry;
        self.history = history.clone();
        self.scan = scan.clone();
        self.rejections = *rejections;
        self.confirmations = *confirmations;
        self.lost_by = *lost_by;
        (self.is_proven, self.has_given_up) = (*is_proven, *has_given_up);
        self.has_sparse_scans = *has_sparse_scans;
        self.stamp_noise = *stamp_noise;
        self.estimate = *estimate;
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
        self.searches = self.searches.restarted(|pose| *pose);
    }

    /// Odometry starts in another frame: the next pose by odometry only sets the reference.
    pub fn restart_odometry(&mut self) {
        self.odometry = None;
        self.history = PoseHistory::new();
        self.anchor = None;
        self.motion_check.clear();
    }
}

#[cfg(test)]
mod tests {
    use core::f64::consts::FRAC_PI_2;

    use super::*;
    use crate::localization::LocalizationSettings;
    use crate::map::{GridFrame, ObstacleGrid};

    /// A localizer on an empty map with this origin.
    fn on_map(origin: Pose) -> Localizer {
        let frame = GridFrame::new(40, 40, 0.1, origin).expect("a valid size");
        let settings = LocalizationSettings::default();
        Localizer::without_pose(&ObstacleGrid::filled(frame, false), settings)
            .expect("valid settings")
    }

    #[test]
    fn checks_continue_on_a_map_with_another_origin() {
        let mut before = on_map(Pose::default());
        let (at, odometry) = (Pose::new(1.0, 2.0, 0.5), Pose::new(7.0, 0.0, 1.0));
        before.anchor = Some(Anchor { odometry, matched: at, agreement: 0.9 });
        before.found = Some(FoundPlace { pose: at, odometry, losses: 1 });
        before.confirmations = Some(2);
        (before.is_proven, before.has_given_up) = (true, true);
        let mut after = on_map(Pose::new(1.0, 0.0, FRAC_PI_2));
        after.continue_from(&before);
        let expected = Pose::new(2.0, 0.0, 0.5 - FRAC_PI_2);
        let is_expected = |pose: &Pose| {
            (pose.position() - expected.position()).norm() < 1e-12
                && (pose.yaw - expected.yaw).abs() < 1e-12
        };
        let anchor = after.anchor.expect("it is kept");
        assert!(is_expected(&anchor.matched) && anchor.odometry == odometry, "{anchor:?}");
        let found = after.found.expect("it is kept");
        assert!(is_expected(&found.pose) && found.losses == 1, "{found:?}");
        assert!(after.is_proven && after.has_given_up && after.confirmations == Some(2));
    }

    /// A mapping node sends a map each metre. Its origin moves and turns.
    #[test]
    fn turned_lidar_and_bogged_robot_show_although_the_map_changes() {
        let mut localizer = on_map(Pose::default());
        let (sin, cos) = libm::sincos(0.2);
        let (mut turned_m, mut stuck_m) = (None, None);
        for step in 0..80 {
            let driven_m = 0.1 * f64::from(step);
            if step % 10 == 4 {
                let mut next = on_map(Pose::new(-driven_m, 0.3, 0.1 * driven_m));
                next.continue_from(&localizer);
                localizer = next;
            }
            // After 6 m the belts slip.
            let moved_m = driven_m.min(6.0);
            let matched = Pose::new(moved_m * cos, moved_m * sin, 0.0);
            let matched = localizer.map.to_grid(&matched);
            let odometry = Pose::new(driven_m, 0.0, 0.0);
            let check = &mut localizer.motion_check;
            if check.mount.is_turned(&odometry, &matched) {
                turned_m = turned_m.or(Some(driven_m));
            }
            if check.is_stuck(driven_m, &odometry, &matched) {
                stuck_m = stuck_m.or(Some(driven_m));
            }
        }
        // Of each 0.4 m, 0.3 m count as a piece.
        assert!(turned_m.is_some_and(|m| (3.8..4.3).contains(&m)), "{turned_m:?}");
        assert!(stuck_m.is_some_and(|m| (6.3..7.0).contains(&m)), "{stuck_m:?}");
    }
}
