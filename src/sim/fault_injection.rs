//! Faults that are injected into a simulated drive.

use crate::geometry::Pose;

/// A fault that happens to the simulated robot.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum FaultInjection {
    /// The robot is moved to another pose of the map; its odometry does not measure this.
    Kidnapped {
        /// Time of the fault, seconds.
        at_s: f64,
        /// The new pose.
        to: Pose,
    },
    /// The lidar measures no surface within its range, as behind a fogged window.
    LidarOccluded {
        /// Begin, seconds.
        from_s: f64,
        /// End, seconds; infinite for the rest of the drive.
        to_s: f64,
    },
    /// The lidar returns no measurement.
    LidarSilent {
        /// Begin, seconds.
        from_s: f64,
        /// End, seconds; infinite for the rest of the drive.
        to_s: f64,
    },
}

/// Transforms a base's own pose into the map, after all kidnappings so far.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Kidnapping {
    /// The pose of the base's own frame in the map.
    frame: Pose,
    until_s: f64,
}

impl Kidnapping {
    /// Applies the faults up to a time, seconds, which must not descend from call to call; returns the pose in the map.
    pub fn pose(&mut self, faults: &[FaultInjection], time_s: f64, own: &Pose) -> Pose {
        for fault in faults {
            if let FaultInjection::Kidnapped { at_s, to } = fault
                && (self.until_s..time_s).contains(at_s)
            {
                self.frame = to.frame_origin(own);
            }
        }
        self.until_s = self.until_s.max(time_s);
        self.pose_in_map(own)
    }

    /// The pose in the map after the faults that were applied so far.
    pub fn pose_in_map(&self, own: &Pose) -> Pose {
        if self.frame == Pose::default() {
            return *own;
        }
        self.frame.transform_pose(own)
    }
}

/// Returns a range that was measured at a time, seconds, as the faults change it.
pub(super) fn degraded_range(faults: &[FaultInjection], time_s: f64, range: f64) -> f64 {
    let mut range = range;
    for fault in faults {
        match fault {
            FaultInjection::LidarOccluded { from_s, to_s }
                if (*from_s..*to_s).contains(&time_s) =>
            {
                range = f64::INFINITY;
            }
            FaultInjection::LidarSilent { from_s, to_s } if (*from_s..*to_s).contains(&time_s) => {
                range = f64::NAN;
            }
            _ => {}
        }
    }
    range
}
