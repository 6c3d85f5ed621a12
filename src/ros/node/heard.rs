//! What the node knows: the newest map, motion, scan and frames.

use super::arrived::{Chart, Motion};
use super::frames::Frames;
use super::scan::{from_now, from_origin, scan, sweep};
use super::{MessageError, Missing};
use crate::geometry::{Pose, wrap_angle};
use crate::localization::PoseHistory;
use crate::map::{Scan, TimedScan};
use crate::navigator::Observation;
use crate::ros::msg::{LaserScan, Odometry, Time};

/// A stamp this much before the last, seconds, is a clock that was set anew.
const CLOCK_SET_S: f64 = 1.0;

/// A robot that has moved by less, metres and radians, stands.
const STANDS_M: f64 = 1e-3;
const STANDS_RAD: f64 = 1e-3;

/// The newest of everything.
#[derive(Debug, Default)]
pub struct Heard {
    pub chart: Option<Chart>,
    pub frames: Frames,
    /// And when it came, seconds.
    pub motion: Option<(f64, Motion)>,
    scan: Option<Sensed>,
    /// Where odometry had the robot, by the sender's clock.
    track: PoseHistory,
}

/// A scan in the lidar's frame.
#[derive(Debug)]
struct Sensed {
    at_s: f64,
    stamp: Time,
    frame: String,
    scan: Scan,
    /// Beam by beam, with the times of the sender's clock where it tells them.
    sweep: Option<TimedScan>,
}

impl Heard {
    /// Takes a map; false where it is the one that it has: some servers repeat theirs.
    pub fn take_map(&mut self, chart: Chart) -> bool {
        let is_new = self.chart.as_ref() != Some(&chart);
        self.chart = Some(chart);
        is_new
    }

    /// Takes odometry that came at a time, seconds.
    pub fn take_odometry(&mut self, now_s: f64, message: &Odometry) -> Result<(), MessageError> {
        let motion = Motion::of(message)?;
        let before = self.motion.as_ref().map(|(_, before)| &before.frame);
        let stamp = message.header.stamp;
        // Poses of another frame, or of no time, are no way that was driven.
        if stamp.is_zero() || before.is_some_and(|frame| *frame != motion.frame) {
            self.track = PoseHistory::new();
        }
        if !stamp.is_zero() {
            self.track.record(stamp.seconds(), &motion.pose);
        }
        self.motion = Some((now_s, motion));
        Ok(())
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
        let scan = scan(message)?;
        self.scan = Some(Sensed {
            at_s: now_s,
            stamp,
            frame: frame.strip_prefix('/').unwrap_or(frame).to_owned(),
            sweep: sweep(message, &scan),
            scan,
        });
        Ok(())
    }

    /// Where the lidar is on the robot: none where nobody has said.
    pub fn mount(&self) -> Option<Pose> {
        let (_, motion) = self.motion.as_ref()?;
        let sensed = self.scan.as_ref()?;
        self.frames.pose_in(&motion.base_frame, &sensed.frame)
    }

    /// A scan as from where the robot is now. It was elsewhere when the first beam was measured, unless it stood.
    fn seen_now(&self, sensed: &Sensed) -> Scan {
        let mount = self.mount().unwrap_or_default();
        let moved = sensed.sweep.as_ref().filter(|sweep| {
            let first_s = sweep.beams.first().map(|beam| beam.time_s);
            let then = first_s.and_then(|first_s| self.track.at(first_s));
            then.zip(self.track.newest())
                .is_some_and(|(then, (_, now))| has_moved(&then, &now))
        });
        match moved {
            Some(sweep) => from_now(&sensed.scan, sweep, &mount, &self.track),
            None => from_origin(sensed.scan.clone(), &mount),
        }
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
            pose: frame.transform_pose(&motion.pose),
            lost: None,
            twist: motion.twist,
            scan: self.seen_now(sensed),
            scan_s: sensed.at_s,
        })
    }
}

fn has_moved(from: &Pose, to: &Pose) -> bool {
    (to.position() - from.position()).norm() > STANDS_M
        || wrap_angle(to.yaw - from.yaw).abs() > STANDS_RAD
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Point, Twist};
    use crate::map::{GridFrame, OccupancyGrid};
    use crate::ros::msg::{Header, TFMessage, Transform, TransformStamped};
    use crate::ros::node::plane::in_space;

    /// A round room, metres, about the origin.
    const RADIUS_M: f64 = 5.0;
    const BEAMS: usize = 720;
    const DRIVES: Twist = Twist::new(1.0, 0.8);
    const BEGAN_S: f64 = 100.0;
    const BEAM_S: f64 = 0.1 / BEAMS as f64;

    fn pose_at(time_s: f64) -> Pose {
        Pose::new(0.5, -1.0, 2.0).after(&DRIVES, time_s - BEGAN_S)
    }

    fn header(frame_id: &str, time_s: f64) -> Header {
        let nanoseconds = (time_s * 1e9).round();
        Header {
            stamp: Time {
                sec: (nanoseconds / 1e9) as i32,
                nanosec: (nanoseconds % 1e9) as u32,
            },
            frame_id: frame_id.to_owned(),
        }
    }

    /// A turn of a lidar, each beam from where it is by then.
    fn turn(mount: &Pose, clockwise: bool) -> LaserScan {
        let step = if clockwise { -1.0 } else { 1.0 } * core::f64::consts::TAU / BEAMS as f64;
        let range = |beam: usize| {
            let robot = pose_at(BEGAN_S + beam as f64 * BEAM_S);
            let eye = robot.transform(&mount.position());
            let (sin, cos) = libm::sincos(robot.yaw + mount.yaw + beam as f64 * step);
            let ahead = eye.x * cos + eye.y * sin;
            let left = RADIUS_M * RADIUS_M - eye.coords.norm_squared() + ahead * ahead;
            (left.sqrt() - ahead) as f32
        };
        LaserScan {
            header: header("laser", BEGAN_S),
            angle_max: (step * (BEAMS - 1) as f64) as f32,
            angle_increment: step as f32,
            time_increment: BEAM_S as f32,
            range_max: 12.0,
            ranges: (0..BEAMS).map(range).collect(),
            ..LaserScan::default()
        }
    }

    /// How far the scan's points are from the wall at the worst, metres, seen 0.15 s after the turn began.
    fn off_m(mount: &Pose, message: &LaserScan) -> f64 {
        let frame = GridFrame::new(1, 1, 1.0, Pose::default()).expect("a frame");
        let mut heard = Heard {
            chart: Some(Chart {
                frame: "odom".to_owned(),
                grid: OccupancyGrid::new(frame, vec![0]),
            }),
            ..Heard::default()
        };
        let place = in_space(mount);
        let mounted = TransformStamped {
            header: header("base_link", BEGAN_S),
            child_frame_id: "laser".to_owned(),
            transform: Transform {
                translation: place.position,
                rotation: place.orientation,
            },
        };
        let transforms = vec![mounted];
        heard.frames.hear(&TFMessage { transforms }).expect("sound");
        for tick in -5..=15 {
            let time_s = BEGAN_S + 0.01 * f64::from(tick);
            let mut odometry = Odometry {
                header: header("odom", time_s),
                child_frame_id: "base_link".to_owned(),
                ..Odometry::default()
            };
            odometry.pose.pose = in_space(&pose_at(time_s));
            heard.take_odometry(time_s, &odometry).expect("sound");
        }
        let now_s = BEGAN_S + 0.15;
        heard.take_scan(now_s, message).expect("sound");
        let seen = heard.observation(now_s, 0.3, false).expect("all is there");
        let hits: Vec<Point> = seen.scan.hits(&seen.pose).collect();
        assert!(hits.len() > BEAMS / 2, "{}", hits.len());
        let off = hits.iter().map(|hit| (hit.coords.norm() - RADIUS_M).abs());
        off.fold(0.0, f64::max)
    }

    #[test]
    fn a_scan_is_seen_from_where_the_robot_is_now() {
        for mount in [Pose::default(), Pose::new(0.3, -0.1, 1.0)] {
            for clockwise in [false, true] {
                let mut message = turn(&mount, clockwise);
                let off = off_m(&mount, &message);
                assert!(off < 0.02, "{mount:?}, clockwise {clockwise}: {off}");
                // One that took no time, and one of no known time, are smeared.
                message.time_increment = 0.0;
                let at_once = off_m(&mount, &message);
                message.header.stamp = Time::default();
                let untimed = off_m(&mount, &message);
                assert!(at_once > 0.05 && untimed > 0.1, "{at_once}, {untimed}");
            }
        }
    }
}
