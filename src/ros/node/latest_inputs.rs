//! The newest map, odometry, scan and frames.

use std::collections::BTreeMap;

use super::incoming::{MapInput, OdometryInput, frame_name, planar_pose};
use super::notices::{MessageError, MissingInput};
use super::scan::{deskew, laser_scan, timed_scan, to_robot_frame};
use crate::geometry::{Pose, wrap_angle};
use crate::localization::PoseHistory;
use crate::map::{Scan, TimedScan};
use crate::navigator::Observation;
use crate::ros::msg::{self, LaserScan, Odometry, TFMessage, Time};

/// A stamp that is older than the last by at least this, seconds, means that the sender's clock was set.
const CLOCK_SET_S: f64 = 1.0;

/// A robot that moved by at most this, metres and radians, is at rest.
const REST_M: f64 = 1e-3;
const REST_RAD: f64 = 1e-3;

/// Maximum number of parents above a frame. A chain with more parents is a cycle.
const MAX_PARENTS: usize = 32;

/// The newest planar pose of each frame in its parent frame. Their ages do not matter.
#[derive(Clone, Debug, Default)]
pub struct Frames(BTreeMap<String, (String, Pose)>);

impl Frames {
    /// Stores the transforms of a message.
    ///
    /// # Errors
    /// The first invalid transform; those before it are stored.
    pub fn update(&mut self, message: &TFMessage) -> Result<(), MessageError> {
        for stamped in &message.transforms {
            let msg::Vector3 { x, y, z } = stamped.transform.translation;
            let pose = msg::Pose {
                position: msg::Point { x, y, z },
                orientation: stamped.transform.rotation,
            };
            let pose = planar_pose("a transform", &pose)?;
            let child = frame_name("child_frame_id", &stamped.child_frame_id)?;
            let parent = frame_name("header.frame_id", &stamped.header.frame_id)?;
            self.0.insert(child, (parent, pose));
        }
        Ok(())
    }

    /// The pose of a frame in one of its ancestors, or nothing if they are not connected.
    #[must_use]
    pub fn pose_in(&self, ancestor: &str, frame: &str) -> Option<Pose> {
        let (mut at, mut pose) = (frame, Pose::default());
        for _ in 0..MAX_PARENTS {
            if at == ancestor {
                return Some(pose);
            }
            let (parent, in_parent) = self.0.get(at)?;
            pose = in_parent.transform_pose(&pose);
            at = parent;
        }
        None
    }
}

/// The newest input of each kind.
#[derive(Debug, Default)]
pub struct LatestInputs {
    pub map: Option<MapInput>,
    pub frames: Frames,
    /// The odometry and its time of arrival, seconds.
    pub odometry: Option<(f64, OdometryInput)>,
    scan: Option<ScanInput>,
    /// The poses of the odometry by the sender's clock.
    history: PoseHistory,
}

/// A scan in the lidar's frame.
#[derive(Debug)]
struct ScanInput {
    arrived_s: f64,
    stamp: Time,
    frame: String,
    scan: Scan,
    /// The beams with their times by the sender's clock, if the message has them.
    timed: Option<TimedScan>,
}

impl LatestInputs {
    /// Sets the map. Returns false if it equals the current map: some servers repeat theirs.
    pub fn set_map(&mut self, map: MapInput) -> bool {
        let is_new = self.map.as_ref() != Some(&map);
        self.map = Some(map);
        is_new
    }

    /// Sets the odometry, which arrived at a time, seconds.
    pub fn set_odometry(&mut self, now_s: f64, message: &Odometry) -> Result<(), MessageError> {
        let odometry = OdometryInput::new(message)?;
        let before = self.odometry.as_ref().map(|(_, before)| &before.frame);
        let stamp = message.header.stamp;
        // Poses in another frame or without a time do not continue the history.
        if stamp.is_zero() || before.is_some_and(|frame| *frame != odometry.frame) {
            self.history = PoseHistory::new();
        }
        if !stamp.is_zero() {
            self.history.record(stamp.seconds(), &odometry.pose);
        }
        self.odometry = Some((now_s, odometry));
        Ok(())
    }

    /// Sets the scan, which arrived at a time, seconds.
    pub fn set_scan(&mut self, now_s: f64, message: &LaserScan) -> Result<(), MessageError> {
        let stamp = message.header.stamp;
        if let Some(before) = self.scan.as_ref().map(|before| before.stamp) {
            let since_s = stamp.seconds() - before.seconds();
            let is_known = !stamp.is_zero() && !before.is_zero();
            if is_known && (stamp == before || (-CLOCK_SET_S..0.0).contains(&since_s)) {
                return Err(MessageError::NotNewer);
            }
        }
        let frame = &message.header.frame_id;
        let scan = laser_scan(message)?;
        self.scan = Some(ScanInput {
            arrived_s: now_s,
            stamp,
            frame: frame.strip_prefix('/').unwrap_or(frame).to_owned(),
            timed: timed_scan(message, &scan),
            scan,
        });
        Ok(())
    }

    /// The pose of the lidar on the robot, or nothing if it is unknown.
    pub fn lidar_mount(&self) -> Option<Pose> {
        let (_, odometry) = self.odometry.as_ref()?;
        let scan = self.scan.as_ref()?;
        self.frames.pose_in(&odometry.base_frame, &scan.frame)
    }

    /// The scan in the robot's current frame. If the robot moved since the first beam, its motion is compensated.
    fn current_scan(&self, input: &ScanInput) -> Scan {
        let mount = self.lidar_mount().unwrap_or_default();
        let moved = input.timed.as_ref().filter(|timed| {
            let first_s = timed.beams.first().map(|beam| beam.time_s);
            let then = first_s.and_then(|first_s| self.history.at(first_s));
            then.zip(self.history.newest()).is_some_and(|(then, (_, now))| has_moved(&then, &now))
        });
        match moved {
            Some(timed) => deskew(&input.scan, timed, &mount, &self.history),
            None => to_robot_frame(input.scan.clone(), &mount),
        }
    }

    /// The observation at a time. Odometry older than the timeout, seconds, is missing; the navigator checks the scan's age.
    pub fn observation(
        &self,
        now_s: f64,
        timeout_s: f64,
        odom_is_map: bool,
    ) -> Result<Observation, MissingInput> {
        let map = self.map.as_ref().ok_or(MissingInput::Map)?;
        let (arrived_s, odometry) = self.odometry.as_ref().ok_or(MissingInput::Odometry)?;
        if now_s - arrived_s > timeout_s {
            return Err(MissingInput::RecentOdometry);
        }
        let frame = if odom_is_map {
            Some(Pose::default())
        } else {
            self.frames.pose_in(&map.frame, &odometry.frame)
        };
        let frame = frame.ok_or_else(|| MissingInput::Transform {
            odometry: odometry.frame.clone(),
            map: map.frame.clone(),
        })?;
        let scan = self.scan.as_ref().ok_or(MissingInput::Scan)?;
        Ok(Observation {
            time_s: now_s,
            pose: frame.transform_pose(&odometry.pose),
            lost: None,
            twist: odometry.twist,
            scan: self.current_scan(scan),
            scan_s: scan.arrived_s,
        })
    }
}

fn has_moved(from: &Pose, to: &Pose) -> bool {
    (to.position() - from.position()).norm() > REST_M
        || wrap_angle(to.yaw - from.yaw).abs() > REST_RAD
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Point, Twist};
    use crate::map::{GridFrame, OccupancyGrid};
    use crate::ros::msg::{Header, Transform, TransformStamped};

    /// Radius of a circular wall about the origin, metres.
    const RADIUS_M: f64 = 5.0;
    const BEAMS: usize = 720;
    const VELOCITY: Twist = Twist::new(1.0, 0.8);
    const START_S: f64 = 100.0;
    const BEAM_S: f64 = 0.1 / BEAMS as f64;

    fn pose_at(time_s: f64) -> Pose {
        Pose::new(0.5, -1.0, 2.0).after(&VELOCITY, time_s - START_S)
    }

    fn header(frame_id: &str, time_s: f64) -> Header {
        Header { stamp: Time::from_seconds(time_s), frame_id: frame_id.to_owned() }
    }

    /// A revolution of a moving lidar.
    fn revolution(mount: &Pose, clockwise: bool) -> LaserScan {
        let step = if clockwise { -1.0 } else { 1.0 } * core::f64::consts::TAU / BEAMS as f64;
        let range = |beam: usize| {
            let robot = pose_at(START_S + beam as f64 * BEAM_S);
            let lidar = robot.transform(&mount.position());
            let (sin, cos) = libm::sincos(robot.yaw + mount.yaw + beam as f64 * step);
            let ahead = lidar.x * cos + lidar.y * sin;
            let left = RADIUS_M * RADIUS_M - lidar.to_vector().norm_squared() + ahead * ahead;
            (left.sqrt() - ahead) as f32
        };
        LaserScan {
            header: header("laser", START_S),
            angle_max: (step * (BEAMS - 1) as f64) as f32,
            angle_increment: step as f32,
            time_increment: BEAM_S as f32,
            range_max: 12.0,
            ranges: (0..BEAMS).map(range).collect(),
            ..LaserScan::default()
        }
    }

    /// The largest distance of the scan's points from the wall, metres, 0.15 s after the start of the revolution.
    fn error_m(mount: &Pose, message: &LaserScan) -> f64 {
        let frame = GridFrame::new(1, 1, 1.0, Pose::default()).expect("a frame");
        let mut inputs = LatestInputs {
            map: Some(MapInput {
                frame: "odom".to_owned(),
                grid: OccupancyGrid::new(frame, vec![0]),
            }),
            ..LatestInputs::default()
        };
        let mounted = TransformStamped {
            header: header("base_link", START_S),
            child_frame_id: "laser".to_owned(),
            transform: Transform::from(mount),
        };
        let transforms = vec![mounted];
        inputs.frames.update(&TFMessage { transforms }).expect("valid");
        for tick in -5..=15 {
            let time_s = START_S + 0.01 * f64::from(tick);
            let mut odometry = Odometry {
                header: header("odom", time_s),
                child_frame_id: "base_link".to_owned(),
                ..Odometry::default()
            };
            odometry.pose.pose = msg::Pose::from(&pose_at(time_s));
            inputs.set_odometry(time_s, &odometry).expect("valid");
        }
        let now_s = START_S + 0.15;
        inputs.set_scan(now_s, message).expect("valid");
        let observation = inputs.observation(now_s, 0.3, false).expect("all inputs");
        let hits: Vec<Point> = observation.scan.hits(&observation.pose).collect();
        assert!(hits.len() > BEAMS / 2, "{}", hits.len());
        let errors = hits.iter().map(|hit| (hit.to_vector().norm() - RADIUS_M).abs());
        errors.fold(0.0, f64::max)
    }

    #[test]
    fn scan_is_compensated_for_motion() {
        for mount in [Pose::default(), Pose::new(0.3, -0.1, 1.0)] {
            for clockwise in [false, true] {
                let mut message = revolution(&mount, clockwise);
                let error = error_m(&mount, &message);
                assert!(error < 0.02, "{mount:?}, clockwise {clockwise}: {error}");
                // Without the time between beams, or without a stamp, there is no compensation.
                message.time_increment = 0.0;
                let without_increment = error_m(&mount, &message);
                message.header.stamp = Time::default();
                let without_stamp = error_m(&mount, &message);
                assert!(
                    without_increment > 0.05 && without_stamp > 0.1,
                    "{without_increment}, {without_stamp}"
                );
            }
        }
    }
}
