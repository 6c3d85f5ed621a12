//! What the node knows: the newest map, motion, scan and frames.

use super::arrived::{Chart, Motion};
use super::frames::{Frames, compose};
use super::msg::{LaserScan, Time};
use super::scan::{from_origin, scan};
use super::{MessageError, Missing};
use crate::geometry::Pose;
use crate::map::Scan;
use crate::navigator::Observation;

/// A stamp this much before the last, seconds, is a clock that was set anew.
const CLOCK_SET_S: f64 = 1.0;

/// The newest of everything.
#[derive(Debug, Default)]
pub struct Heard {
    pub chart: Option<Chart>,
    pub frames: Frames,
    /// And when it came, seconds.
    pub motion: Option<(f64, Motion)>,
    scan: Option<Sensed>,
}

/// A scan in the lidar's frame.
#[derive(Debug)]
struct Sensed {
    at_s: f64,
    stamp: Time,
    frame: String,
    scan: Scan,
}

impl Heard {
    /// Takes a map; false where it is the one that it has: some servers repeat theirs.
    pub fn take_map(&mut self, chart: Chart) -> bool {
        let is_new = self.chart.as_ref() != Some(&chart);
        self.chart = Some(chart);
        is_new
    }

    /// Takes a scan that came at a time, seconds.
    pub fn take_scan(&mut self, now_s: f64, message: &LaserScan) -> Result<(), MessageError> {
        let stamp = message.header.stamp;
        if let Some(before) = self.scan.as_ref().map(|before| before.stamp) {
            let since_s = stamp.seconds() - before.seconds();
            let is_known = !stamp.is_zero() && !before.is_zero();
            if is_known && (stamp == before || (-CLOCK_SET_S..0.0).contains(&since_s)) {
                return Err(MessageError::NotNewer);
            }
        }
        let frame = &message.header.frame_id;
        self.scan = Some(Sensed {
            at_s: now_s,
            stamp,
            frame: frame.strip_prefix('/').unwrap_or(frame).to_owned(),
            scan: scan(message)?,
        });
        Ok(())
    }

    /// Where the lidar is on the robot: none where nobody has said.
    pub fn mount(&self) -> Option<Pose> {
        let (_, motion) = self.motion.as_ref()?;
        let sensed = self.scan.as_ref()?;
        self.frames.pose_in(&motion.base_frame, &sensed.frame)
    }

    /// All of it as an observation at a time. Odometry is not used when it came longer ago than the timeout, seconds; of the
    /// scan's age the navigator judges.
    pub fn observation(
        &self,
        now_s: f64,
        timeout_s: f64,
        odom_is_map: bool,
    ) -> Result<Observation, Missing> {
        let chart = self.chart.as_ref().ok_or(Missing::Map)?;
        let (motion_s, motion) = self.motion.as_ref().ok_or(Missing::Odometry)?;
        if now_s - motion_s > timeout_s {
            return Err(Missing::FreshOdometry);
        }
        let frame = if odom_is_map {
            Some(Pose::default())
        } else {
            self.frames.pose_in(&chart.frame, &motion.frame)
        };
        let frame = frame.ok_or_else(|| Missing::Transform {
            frame: motion.frame.clone(),
            map: chart.frame.clone(),
        })?;
        let sensed = self.scan.as_ref().ok_or(Missing::Scan)?;
        Ok(Observation {
            time_s: now_s,
            pose: compose(&frame, &motion.pose),
            lost: None,
            twist: motion.twist,
            scan: from_origin(sensed.scan.clone(), &self.mount().unwrap_or_default()),
            scan_s: sensed.at_s,
        })
    }
}
