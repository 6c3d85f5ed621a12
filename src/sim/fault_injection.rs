//! What befalls a robot that its tracks do not feel.

use crate::geometry::Pose;
use crate::map::Scan;

/// Something that befalls the simulated robot, at its time in seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FaultInjection {
    /// It is carried to another pose of the map, which its odometry does not notice.
    Kidnapped {
        /// When.
        at_s: f64,
        /// Where to.
        to: Pose,
    },
    /// Its lidar sees nothing within its range: a window that fogged up, say.
    LidarOccluded {
        /// From when on.
        from_s: f64,
        /// Until when; infinite for the rest of the time.
        to_s: f64,
    },
    /// Its lidar measures nothing at all.
    LidarSilent {
        /// From when on.
        from_s: f64,
        /// Until when; infinite for the rest of the time.
        to_s: f64,
    },
}

/// Where a vehicle is of which that thinks so, after all that carried it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Carried {
    /// The pose of the vehicle's own frame in the map's.
    frame: Pose,
    until_s: f64,
}

impl Carried {
    /// The vehicle's pose in the map at a time, seconds, that does not descend.
    pub fn pose(&mut self, faults: &[FaultInjection], time_s: f64, own: &Pose) -> Pose {
        for mishap in faults {
            if let FaultInjection::Kidnapped { at_s, to } = mishap
                && (self.until_s..time_s).contains(at_s)
            {
                self.frame = to.frame_origin(own);
            }
        }
        self.until_s = self.until_s.max(time_s);
        self.here(own)
    }

    /// The same at the last time.
    pub fn here(&self, own: &Pose) -> Pose {
        if self.frame == Pose::default() {
            return *own;
        }
        self.frame.transform_pose(own)
    }
}

/// What is left of a range that was measured at a time, seconds.
pub(crate) fn spoilt(faults: &[FaultInjection], time_s: f64, range: f64) -> f64 {
    let mut range = range;
    for mishap in faults {
        match mishap {
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

/// The same of a whole scan.
pub(crate) fn spoil(faults: &[FaultInjection], time_s: f64, scan: &mut Scan) {
    for range in &mut scan.ranges {
        *range = spoilt(faults, time_s, *range);
    }
}
