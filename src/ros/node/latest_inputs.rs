//! The newest map, odometry, scan and frames.

mod map_frame;

use super::arrival_delay::ArrivalDelay;
use super::frames::{FramePose, Frames};
use super::incoming::{MapInput, OdometryInput, frame_name};
use super::notices::{MessageError, MissingInput};
use super::odometry_check::SpeedCheck;
use super::scan::{deskew, laser_scan, level_range, timed_scan};
use crate::geometry::{Pose, Twist, wrap_angle};
use crate::localization::{LostReason, PoseHistory};
use crate::map::{Scan, ScanChange, TimedScan};
use crate::navigator::Observation;
use crate::ros::msg::{LaserScan, Odometry, Time};

/// A stamp that is older than the last by at least this, seconds, means that the sender's clock was set.
const CLOCK_SET_S: f64 = 1.0;

/// A robot that moved by at most this, metres and radians, is at rest.
const REST_M: f64 = 1e-3;
const REST_RAD: f64 = 1e-3;

/// Largest ages of inputs and offset of clocks, seconds.
#[derive(Clone, Copy, Debug)]
#[expect(clippy::struct_field_names, reason = "the unit is part of each name")]
pub struct AgeLimits {
    pub odometry_s: f64,
    pub transform_s: f64,
    pub clock_ahead_s: f64,
}

/// The pose of the odometry's frame in the map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum OdometryFrame {
    /// Both frames are the same.
    IsMap,
    /// By `tf`.
    ByTransforms,
    /// By a localizer in this program.
    Measured {
        /// The pose.
        pose: Pose,
        /// Time of the measurement, seconds by the node's clock; minus infinity before the first.
        time_s: f64,
        /// Why the pose is not known, if it is not.
        lost: Option<LostReason>,
    },
}

/// The newest input of each kind. Times are seconds since 1970 by the node's clock, stamps those of the senders' clocks.
#[derive(Debug, Default)]
pub struct LatestInputs {
    pub map: Option<MapInput>,
    pub frames: Frames,
    pub odometry: Option<OdometryInput>,
    scan: Option<ScanInput>,
    /// Whether odometry and scan were there before the node forgot them.
    had_odometry: bool,
    had_scan: bool,
    scan_change: ScanChange,
    motion_check: SpeedCheck,
    /// The poses of the odometry by the sender's clock.
    history: PoseHistory,
    /// Delays of the streams of odometry and scans.
    pub odometry_delay: ArrivalDelay,
    pub scan_delay: ArrivalDelay,
}

/// A scan in the lidar's frame.
#[derive(Debug)]
struct ScanInput {
    /// Stamp of the latest scan that differed from the one before, seconds.
    changed_s: f64,
    stamp: Time,
    /// Stamp of the last beam, seconds.
    end_s: f64,
    frame: String,
    scan: Scan,
    /// The beams with their times by the sender's clock.
    timed: Option<TimedScan>,
}

/// The transforms of an observation at a tick.
#[derive(Clone, Copy, Debug)]
pub struct ReadyInputs {
    /// The pose of the odometry's frame in the map, its time, and why it is not known.
    frame: Pose,
    pose_s: f64,
    pub lost: Option<LostReason>,
    /// The lidar's pose on the robot.
    mount: Pose,
}

impl LatestInputs {
    /// Sets the map. Returns false if it equals the current map: some servers repeat theirs.
    pub fn set_map(&mut self, map: MapInput) -> bool {
        let is_new = self.map.as_ref() != Some(&map);
        self.map = Some(map);
        is_new
    }

    /// Forgets the robot's motion and surroundings. Map and frames remain.
    pub fn forget_motion(&mut self) {
        self.had_odometry |= self.odometry.is_some();
        self.had_scan |= self.scan.is_some();
        self.odometry = None;
        self.scan = None;
        self.history = PoseHistory::default();
    }

    /// Age of the newest scan, seconds; infinite without one.
    pub fn scan_age_s(&self, now_s: f64) -> f64 {
        let end_s = self.scan.as_ref().map_or(f64::NEG_INFINITY, |scan| scan.end_s);
        now_s - (end_s - self.scan_delay.ahead_s())
    }

    /// Whether there is a scan, of any age.
    pub const fn has_scan(&self) -> bool {
        self.scan.is_some()
    }

    /// Sets the odometry, which arrived at a time, seconds.
    pub fn set_odometry(
        &mut self,
        now_s: f64,
        message: &Odometry,
        limits: &AgeLimits,
    ) -> Result<(), MessageError> {
        let odometry = OdometryInput::new(message)?;
        if self.motion_check.lacks_speed(&odometry) {
            return Err(MessageError::NoSpeed);
        }
        let before = self.odometry.as_ref();
        check_stamp(message.header.stamp, before.map(|before| before.stamp))?;
        let stamp_s = odometry.stamp.seconds();
        check_clock(now_s, stamp_s, limits)?;
        // Poses in another frame do not continue the history.
        if before.is_some_and(|before| before.frame != odometry.frame) {
            self.history = PoseHistory::new();
        }
        self.history.record(stamp_s, &odometry.pose);
        self.odometry_delay.record(now_s, stamp_s);
        self.odometry = Some(odometry);
        Ok(())
    }

    /// Sets the scan, which arrived at a time, seconds.
    pub fn set_scan(
        &mut self,
        now_s: f64,
        message: &LaserScan,
        limits: &AgeLimits,
    ) -> Result<(), MessageError> {
        let stamp = message.header.stamp;
        check_stamp(stamp, self.scan.as_ref().map(|before| before.stamp))?;
        let frame = frame_name("header.frame_id", &message.header.frame_id)?;
        let mut scan = laser_scan(message)?;
        if let Some(OdometryInput { base_frame, .. }) = &self.odometry {
            match self.frames.lidar_in(base_frame, &frame, stamp.seconds()) {
                Ok(FramePose { lean, .. }) => {
                    for beam in 0..scan.ranges.len() {
                        scan.ranges[beam] = level_range(scan.angle(beam), scan.ranges[beam], &lean);
                    }
                }
                Err(reason) => {
                    let base_frame = base_frame.clone();
                    return Err(MessageError::LidarMount { frame, base_frame, reason });
                }
            }
        }
        let timed = timed_scan(message, &scan).filter(|_| !stamp.is_zero());
        let stamp_s = stamp.seconds();
        check_clock(now_s, stamp_s, limits)?;
        // No beam is later than the arrival: some drivers stamp the end of a revolution.
        let end_s = timed.as_ref().and_then(TimedScan::end_s).unwrap_or(stamp_s);
        let end_s = end_s.min(now_s.max(stamp_s));
        self.scan_delay.record(now_s, end_s);
        let changed_s = self.scan_change.update(end_s, scan.ranges.iter().copied());
        self.scan = Some(ScanInput { changed_s, stamp, end_s, frame, scan, timed });
        Ok(())
    }

    /// The scan in the robot's current frame. If the robot moved since the first beam, its motion is compensated.
    fn current_scan(&self, input: &ScanInput, mount: &Pose) -> Scan {
        let moved = input.timed.as_ref().filter(|timed| {
            let first_s = timed.beams.first().map(|beam| beam.time_s);
            let then = first_s.and_then(|first_s| self.history.at(first_s));
            then.zip(self.history.newest()).is_some_and(|(then, (_, now))| has_moved(&then, &now))
        });
        match moved {
            Some(timed) => deskew(timed, mount, &self.history),
            None => input.scan.clone().from_mount(mount),
        }
    }

    /// The newest scan as measured, in the robot's frame at the time of each beam, with times by the node's clock; none while tf
    /// does not give the lidar's recent pose.
    pub fn raw_scan(&self, now_s: f64, limits: &AgeLimits) -> Option<TimedScan> {
        let (scan, odometry) = (self.scan.as_ref()?, self.odometry.as_ref()?);
        let timed = scan.timed.as_ref()?;
        let mount = self.mount(now_s, scan, &odometry.base_frame, limits).ok()?;
        let later_s = scan.end_s - self.scan_delay.ahead_s() - timed.end_s()?;
        let mut scan = timed.clone().from_mount(&mount);
        scan.beams.iter_mut().for_each(|beam| beam.time_s += later_s);
        Some(scan)
    }

    /// The newest measured motion and its time by the node's clock, seconds.
    pub fn motion(&self) -> Option<(Twist, f64)> {
        let odometry = self.odometry.as_ref()?;
        Some((odometry.twist, odometry.stamp.seconds() - self.odometry_delay.ahead_s()))
    }

    /// The lidar's pose on the robot.
    fn mount(
        &self,
        now_s: f64,
        scan: &ScanInput,
        base_frame: &str,
        limits: &AgeLimits,
    ) -> Result<Pose, MissingInput> {
        let mount = self.frames.lidar_in(base_frame, &scan.frame, scan.stamp.seconds());
        let mount = mount.map_err(|reason| MissingInput::LidarMount {
            frame: scan.frame.clone(),
            base_frame: base_frame.to_owned(),
            reason,
        })?;
        fresh(now_s, &mount, limits, &scan.frame, base_frame)
    }

    /// Checks that an observation can be made at a time. Odometry and dynamic transforms that are too old by their stamps are
    /// missing; the navigator checks the scan's age.
    pub fn ready(
        &self,
        now_s: f64,
        limits: &AgeLimits,
        odometry_frame: &OdometryFrame,
    ) -> Result<ReadyInputs, MissingInput> {
        let map = self.map.as_ref().ok_or(MissingInput::Map)?;
        let odometry = self.odometry.as_ref().ok_or(if self.had_odometry {
            MissingInput::SincePause("odometry")
        } else {
            MissingInput::Odometry
        })?;
        let odometry_s = odometry.stamp.seconds();
        if now_s - (odometry_s - self.odometry_delay.ahead_s()) > limits.odometry_s {
            let is_received = self.odometry_delay.is_recent(now_s, limits.odometry_s);
            return Err(if is_received {
                MissingInput::OldOdometry
            } else {
                MissingInput::RecentOdometry
            });
        }
        let (frame, pose_s, lost) = match *odometry_frame {
            OdometryFrame::IsMap => (Pose::default(), now_s, None),
            OdometryFrame::ByTransforms => {
                let found = self.frames.pose_in(&map.frame, &odometry.frame, odometry_s);
                let found = found.map_err(|reason| MissingInput::Transform {
                    odometry: odometry.frame.clone(),
                    map: map.frame.clone(),
                    reason,
                })?;
                let pose = fresh(now_s, &found, limits, &odometry.frame, &map.frame)?;
                (pose, found.time_s.min(now_s), None)
            }
            OdometryFrame::Measured { pose, time_s, lost } => (pose, time_s.min(now_s), lost),
        };
        let scan = self.scan.as_ref().ok_or(if self.had_scan {
            MissingInput::SincePause("scan")
        } else {
            MissingInput::Scan
        })?;
        let mount = self.mount(now_s, scan, &odometry.base_frame, limits)?;
        Ok(ReadyInputs { frame, pose_s, lost, mount })
    }

    /// The observation at a time for which the inputs are ready; none without them.
    pub fn observation(&self, now_s: f64, ready: &ReadyInputs) -> Option<Observation> {
        let ReadyInputs { frame, pose_s, lost, mount } = *ready;
        let (odometry, scan) = (self.odometry.as_ref()?, self.scan.as_ref()?);
        Some(Observation {
            time_s: now_s,
            pose: frame.transform_pose(&odometry.pose),
            pose_s,
            lost,
            twist: odometry.twist,
            odometry_s: odometry.stamp.seconds() - self.odometry_delay.ahead_s(),
            scan: self.current_scan(scan, &mount),
            scan_s: scan.end_s - self.scan_delay.ahead_s(),
            scan_changed_s: scan.changed_s - self.scan_delay.ahead_s(),
            sent: None,
        })
    }
}

/// Rejects a stamp of zero, and one that is not after the stamp before.
fn check_stamp(stamp: Time, before: Option<Time>) -> Result<(), MessageError> {
    if stamp.is_zero() {
        return Err(MessageError::NoStamp);
    }
    let is_older = |before: Time| {
        let since_s = stamp.seconds() - before.seconds();
        stamp == before || (-CLOCK_SET_S..0.0).contains(&since_s)
    };
    if before.is_some_and(is_older) { Err(MessageError::NotNewer) } else { Ok(()) }
}

/// Rejects a stamp from the future: the age of the message is unknown.
fn check_clock(now_s: f64, stamp_s: f64, limits: &AgeLimits) -> Result<(), MessageError> {
    let ahead_s = stamp_s - now_s;
    if ahead_s > limits.clock_ahead_s {
        return Err(MessageError::ClockAhead { ahead_s, limit_s: limits.clock_ahead_s });
    }
    Ok(())
}

/// The pose of a frame, unless a dynamic transform is too old.
fn fresh(
    now_s: f64,
    found: &FramePose,
    limits: &AgeLimits,
    frame: &str,
    ancestor: &str,
) -> Result<Pose, MissingInput> {
    if now_s - found.time_s > limits.transform_s {
        let (frame, ancestor) = (frame.to_owned(), ancestor.to_owned());
        return Err(MissingInput::RecentTransform { frame, ancestor });
    }
    Ok(found.pose)
}

fn has_moved(from: &Pose, to: &Pose) -> bool {
    (to.position() - from.position()).norm() > REST_M
        || wrap_angle(to.yaw - from.yaw).abs() > REST_RAD
}

#[cfg(test)]
mod ages;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Point, Vector};
    use crate::map::{GridFrame, OccupancyGrid};
    use crate::ros::msg::{self, Header, TFMessage, Transform, TransformStamped};

    /// Radius of a circular wall about the origin, metres.
    const RADIUS_M: f64 = 5.0;
    const BEAMS: usize = 720;
    const VELOCITY: Twist = Twist::new(1.0, 0.8);
    const START_S: f64 = 100.0;
    const BEAM_S: f64 = 0.1 / BEAMS as f64;
    const LIMITS: AgeLimits = AgeLimits { odometry_s: 0.3, transform_s: 0.3, clock_ahead_s: 0.1 };

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

    /// The inputs of a moving robot 0.15 s after the start of a revolution.
    fn inputs(mount: &Pose, message: &LaserScan) -> LatestInputs {
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
        inputs.frames.update(START_S, &TFMessage { transforms }, true).expect("valid");
        for tick in -5..=15 {
            let time_s = START_S + 0.01 * f64::from(tick);
            let mut odometry = Odometry {
                header: header("odom", time_s),
                child_frame_id: "base_link".to_owned(),
                ..Odometry::default()
            };
            odometry.pose.pose = msg::Pose::from(&pose_at(time_s));
            odometry.twist.twist.linear.x = VELOCITY.linear;
            odometry.twist.twist.angular.z = VELOCITY.angular;
            inputs.set_odometry(time_s, &odometry, &LIMITS).expect("valid");
        }
        let now_s = START_S + 0.15;
        inputs.set_scan(now_s, message, &LIMITS).expect("valid");
        inputs
    }

    /// The largest distance of the scan's points from the wall, metres.
    fn error_m(mount: &Pose, message: &LaserScan) -> f64 {
        let (inputs, now_s) = (inputs(mount, message), START_S + 0.15);
        let ready = inputs.ready(now_s, &LIMITS, &OdometryFrame::ByTransforms).expect("all inputs");
        let observation = inputs.observation(now_s, &ready).expect("a scan");
        let hits: Vec<Point> = observation.scan.hits(&observation.pose).collect();
        assert!(hits.len() > BEAMS / 2, "{}", hits.len());
        let errors = hits.iter().map(|hit| (hit.to_vector().norm() - RADIUS_M).abs());
        errors.fold(0.0, f64::max)
    }

    #[test]
    fn raw_scan_has_each_beam_in_the_robots_frame_at_its_time() {
        for mount in [Pose::default(), Pose::new(0.3, -0.1, 1.0)] {
            for clockwise in [false, true] {
                let mut message = revolution(&mount, clockwise);
                let raw = inputs(&mount, &message).raw_scan(START_S + 0.15, &LIMITS);
                let raw = raw.expect("a scan and the lidar's pose");
                assert_eq!(raw.beams.len(), BEAMS);
                for beam in &raw.beams {
                    let (sin, cos) = libm::sincos(beam.angle);
                    let point = raw.origin + Vector::new(cos, sin) * beam.range;
                    let hit = pose_at(beam.time_s).transform(&point);
                    let error_m = (hit.to_vector().norm() - RADIUS_M).abs();
                    assert!(error_m < 1e-4, "{mount:?}, clockwise {clockwise}: {error_m}");
                }
                // A driver that stamps the end of a revolution: no beam is later than the arrival.
                message.header = header("laser", START_S + 0.1);
                let raw = inputs(&mount, &message).raw_scan(START_S + 0.15, &LIMITS);
                let (first, end_s) = raw.map(|raw| (raw.beams[0], raw.end_s())).expect("a scan");
                let times_s = (first.time_s - START_S, end_s.expect("beams") - START_S);
                assert!((times_s.0 - 0.05).abs() < 1e-3, "{times_s:?}");
                assert!((times_s.1 - 0.15).abs() < 1e-6, "{times_s:?}");
            }
        }
    }

    #[test]
    fn scan_is_compensated_for_motion() {
        for mount in [Pose::default(), Pose::new(0.3, -0.1, 1.0)] {
            for clockwise in [false, true] {
                let mut message = revolution(&mount, clockwise);
                let error = error_m(&mount, &message);
                assert!(error < 0.02, "{mount:?}, clockwise {clockwise}: {error}");
                // Without the time between beams there is no compensation within the revolution.
                message.time_increment = 0.0;
                let without_increment = error_m(&mount, &message);
                assert!(without_increment > 0.05, "{without_increment}");
            }
        }
    }
}
