//! The poses of frames in the map.

use std::collections::BTreeSet;

use super::{AgeLimits, LatestInputs, OdometryFrame, fresh};
use crate::geometry::Pose;

impl LatestInputs {
    /// The planar pose of a frame in the map at a time, seconds: by the odometry, or by tf alone. None if it is not known, or no
    /// longer.
    pub fn pose_in_map(
        &self,
        frame: &str,
        time_s: f64,
        now_s: f64,
        limits: &AgeLimits,
        odometry_frame: Option<&OdometryFrame>,
    ) -> Option<Pose> {
        let map = &self.map.as_ref()?.frame;
        if frame == map {
            return Some(Pose::default());
        }
        let by_tf = |other: &str, frame: &str| {
            let found = self.frames.pose_in(other, frame, time_s).ok()?;
            fresh(now_s, &found, limits, frame, other).ok()
        };
        let by_odometry = || {
            let odometry = self.odometry.as_ref()?;
            let odometry_in_map = match odometry_frame? {
                OdometryFrame::IsMap => Pose::default(),
                OdometryFrame::ByTransforms => by_tf(map, &odometry.frame)?,
                OdometryFrame::Measured { lost: Some(_), .. } => return None,
                OdometryFrame::Measured { pose, .. } => *pose,
            };
            if frame == odometry.frame {
                return Some(odometry_in_map);
            }
            let (_, odometry_s) = self.motion()?;
            let is_recent = now_s - odometry_s <= limits.odometry_s;
            let base = self.history.at(time_s).filter(|_| is_recent)?;
            let on_robot = if frame == odometry.base_frame {
                Pose::default()
            } else {
                by_tf(&odometry.base_frame, frame)?
            };
            Some(odometry_in_map.transform_pose(&base.transform_pose(&on_robot)))
        };
        by_odometry().or_else(|| by_tf(map, frame))
    }

    /// The frames that messages have named, in alphabetical order.
    pub fn frame_names(&self) -> BTreeSet<&str> {
        let odometry = self.odometry.iter().flat_map(|it| [&*it.frame, &*it.base_frame]);
        let map = self.map.iter().map(|map| &*map.frame);
        self.frames.names().chain(odometry).chain(map).collect()
    }
}
