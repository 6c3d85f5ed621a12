//! The tree of frames by `tf` and `tf_static`. That of the node is bounded in memory.

use core::iter::successors;
use std::collections::BTreeMap;

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};

use super::incoming::{check_pose, frame_name, upright_yaw};
use super::notices::MessageError;
use crate::geometry::{Pose, Vector};
use crate::localization::PoseHistory;
use crate::ros::msg::{self, TFMessage};

/// Maximum number of frames. A robot has some dozens.
const MAX_FRAMES: usize = 512;
/// Maximum number of parents above a frame. A chain with more parents is a cycle.
const MAX_PARENTS: usize = 32;
/// A transform that is older than the newest of its frame by less than this, seconds, arrived out of order. An older one means
/// that the sender's clock was set.
const OUT_OF_ORDER_S: f64 = 1.0;

/// Largest tilt of a lidar, radians: 10 degrees. Beyond it a range in the plane is more than 1.5 % shorter than the measured one,
/// and the beams look at the floor or above obstacles.
const MAX_LIDAR_TILT: f64 = 0.175;

/// The poses of each frame in its parent frame: the recent ones, or those of a whole log.
#[derive(Clone, Debug, Default)]
pub struct Frames {
    links: BTreeMap<String, Link>,
    /// The empty history of a new frame.
    history: PoseHistory,
}

/// A frame below its parent.
#[derive(Clone, Debug)]
struct Link {
    parent: String,
    pose: LinkPose,
}

#[derive(Clone, Debug)]
enum LinkPose {
    /// From `tf_static`: it holds for all times.
    Static(Isometry3<f64>),
    /// From `tf`: the poses in the plane, and what the newest transform adds to its planar pose: height, roll and pitch.
    Dynamic { planar: PoseHistory, tilt: Isometry3<f64> },
    /// From `tf`, and so tilted that it has no yaw, like a wheel.
    Tilted,
}

/// Why a frame has no planar pose in another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoPose {
    /// No chain of transforms connects the two frames.
    Unconnected,
    /// One frame is tilted against the other.
    Tilted,
}

impl NoPose {
    /// What the pose of a lidar lacks, for a message after the name of its frame.
    pub fn of_lidar(self, base_frame: &str) -> String {
        match self {
            Self::Unconnected => format!(
                "which tf does not connect to `{base_frame}`: publish the lidar's pose on tf_static"
            ),
            Self::Tilted => {
                let degrees = MAX_LIDAR_TILT.to_degrees();
                format!(
                    "which is tilted against `{base_frame}`: the lidar must be level within {degrees:.0} degrees and upright"
                )
            }
        }
    }

    /// What the pose of the odometry's frame lacks, for a message after the name of that frame.
    pub fn of_odometry(self, map_frame: &str) -> String {
        match self {
            Self::Unconnected => format!(
                "and tf does not connect it to `{map_frame}`: start a localization node, set pose_source = \"scans\", or start the \
                 node with --odom-is-map"
            ),
            Self::Tilted => format!(
                "which tf tilts against `{map_frame}`: the robot drives in a plane, so both must have their z axis up"
            ),
        }
    }
}

/// The pose of a frame in another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FramePose {
    pub pose: Pose,
    /// Time of the oldest dynamic transform between the two frames, seconds; infinite if all are static.
    pub time_s: f64,
    /// The horizontal part of the other frame's upward axis in this frame: zero for a level frame.
    pub lean: Vector,
}

impl FramePose {
    /// Projects a pose on the other frame's plane.
    fn new(pose: &Isometry3<f64>, time_s: f64) -> Result<Self, NoPose> {
        let Quaternion { coords } = *pose.rotation.quaternion();
        let rotation = msg::Quaternion { x: coords.x, y: coords.y, z: coords.z, w: coords.w };
        let yaw = upright_yaw(&rotation).ok_or(NoPose::Tilted)?;
        let position = pose.translation.vector;
        Ok(Self { pose: Pose::new(position.x, position.y, yaw), time_s, lean: lean(&rotation) })
    }
}

impl Frames {
    /// Creates an empty tree that keeps all transforms, for logs.
    #[cfg(all(feature = "mcap", feature = "logs"))]
    pub fn of_log() -> Self {
        Self { history: PoseHistory::of_log(), ..Self::default() }
    }

    /// Stores the transforms of a message that arrived at a time, seconds. A dynamic transform counts from its stamp, or from its
    /// arrival if the stamp is later: localization nodes date their transforms ahead.
    ///
    /// # Errors
    /// The first invalid transform; all others are stored, because one message may have the frames of the whole robot.
    pub fn update(
        &mut self,
        now_s: f64,
        message: &TFMessage,
        is_static: bool,
    ) -> Result<(), MessageError> {
        let mut outcome = Ok(());
        for stamped in &message.transforms {
            outcome = outcome.and(self.store(now_s, stamped, is_static));
        }
        outcome
    }

    fn store(
        &mut self,
        now_s: f64,
        stamped: &msg::TransformStamped,
        is_static: bool,
    ) -> Result<(), MessageError> {
        let child = frame_name("child_frame_id", &stamped.child_frame_id)?;
        let parent = frame_name("header.frame_id", &stamped.header.frame_id)?;
        let msg::Vector3 { x, y, z } = stamped.transform.translation;
        let position = msg::Point { x, y, z };
        let pose = msg::Pose { position, orientation: stamped.transform.rotation };
        check_pose("a transform", &pose)?;
        if self.links.len() >= MAX_FRAMES && !self.links.contains_key(&child) {
            return Err(MessageError::TooManyFrames { max: MAX_FRAMES });
        }
        if is_static {
            self.links.insert(child, Link { parent, pose: LinkPose::Static(isometry(&pose)) });
            return Ok(());
        }
        let Some(yaw) = upright_yaw(&pose.orientation) else {
            self.links.insert(child, Link { parent, pose: LinkPose::Tilted });
            return Ok(());
        };
        let stamp = stamped.header.stamp;
        if stamp.is_zero() {
            return Err(MessageError::NoStamp);
        }
        let planar = Pose::new(x, y, yaw);
        let tilt = planar_isometry(&planar).inv_mul(&isometry(&pose));
        self.record(child, parent, stamp.seconds().min(now_s), (&planar, tilt))
    }

    fn record(
        &mut self,
        child: String,
        parent: String,
        time_s: f64,
        (pose, tilt): (&Pose, Isometry3<f64>),
    ) -> Result<(), MessageError> {
        if let Some(Link { parent: before, pose: LinkPose::Dynamic { planar, tilt: newest } }) =
            self.links.get_mut(&child)
            && *before == parent
        {
            let newest_s = planar.newest().map_or(f64::NEG_INFINITY, |(newest_s, _)| newest_s);
            if (-OUT_OF_ORDER_S..0.0).contains(&(time_s - newest_s)) {
                return Err(MessageError::NotNewer);
            }
            planar.record(time_s, pose);
            *newest = tilt;
            return Ok(());
        }
        let mut planar = self.history.clone();
        planar.record(time_s, pose);
        self.links.insert(child, Link { parent, pose: LinkPose::Dynamic { planar, tilt } });
        Ok(())
    }

    /// The pose of a frame in another at a time, seconds, by the nearest frame that is above both. Between two transforms it is
    /// interpolated; outside their times it is the nearest. The frames between the two may be tilted: only the pose at the end of
    /// the chain is projected on the plane.
    ///
    /// # Errors
    /// When the two frames are not connected, or one is tilted against the other by more than 60 degrees.
    pub fn pose_in(&self, other: &str, frame: &str, time_s: f64) -> Result<FramePose, NoPose> {
        let is_above_other = |name: &&str| self.with_parents(other).any(|above| above == *name);
        let common = self.with_parents(frame).find(is_above_other).ok_or(NoPose::Unconnected)?;
        let (of_frame, frame_s) = self.pose_above(common, frame, time_s)?;
        let (of_other, other_s) = self.pose_above(common, other, time_s)?;
        FramePose::new(&of_other.inv_mul(&of_frame), frame_s.min(other_s))
    }

    /// The pose of a lidar on the robot, as [`Self::pose_in`].
    ///
    /// # Errors
    /// As [`Self::pose_in`], and when the lidar is tilted too much.
    pub fn lidar_in(&self, base: &str, lidar: &str, time_s: f64) -> Result<FramePose, NoPose> {
        let found = self.pose_in(base, lidar, time_s)?;
        let is_level = found.lean.norm() <= libm::sin(MAX_LIDAR_TILT);
        if is_level { Ok(found) } else { Err(NoPose::Tilted) }
    }

    /// The frames and their parents.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.links.iter().flat_map(|(frame, link)| [&**frame, &*link.parent])
    }

    /// A frame and those above it.
    fn with_parents<'a>(&'a self, frame: &'a str) -> impl Iterator<Item = &'a str> {
        let parent = |name: &&str| self.links.get(*name).map(|link| &*link.parent);
        successors(Some(frame), parent).take(MAX_PARENTS + 1)
    }

    /// The pose of a frame in one that is above it, and the time of the oldest dynamic transform between the two, seconds.
    fn pose_above(
        &self,
        ancestor: &str,
        frame: &str,
        time_s: f64,
    ) -> Result<(Isometry3<f64>, f64), NoPose> {
        let (mut at, mut found, mut oldest_s) = (frame, Isometry3::identity(), f64::INFINITY);
        while at != ancestor {
            let link = self.links.get(at).ok_or(NoPose::Unconnected)?;
            let (in_parent, newest_s) = link.pose.at(time_s)?;
            (at, found, oldest_s) = (&link.parent, in_parent * found, oldest_s.min(newest_s));
        }
        Ok((found, oldest_s))
    }

    /// Whether the dynamic transforms above a frame had begun at a time, seconds.
    #[cfg(all(feature = "mcap", feature = "logs"))]
    pub fn have_begun(&self, frame: &str, time_s: f64) -> bool {
        let above = |link: &&Link| self.links.get(&link.parent);
        let links = successors(self.links.get(frame), above);
        links.take(MAX_PARENTS).all(|link| match &link.pose {
            LinkPose::Dynamic { planar, .. } => {
                planar.oldest().is_some_and(|(oldest_s, _)| oldest_s <= time_s)
            }
            LinkPose::Static(_) | LinkPose::Tilted => true,
        })
    }
}

impl LinkPose {
    /// The pose in the parent at a time, seconds, and the time of the newest transform.
    fn at(&self, time_s: f64) -> Result<(Isometry3<f64>, f64), NoPose> {
        match self {
            Self::Static(pose) => Ok((*pose, f64::INFINITY)),
            Self::Dynamic { planar, tilt } => {
                let (newest_s, _) = planar.newest().ok_or(NoPose::Unconnected)?;
                let pose = planar.at(time_s).ok_or(NoPose::Unconnected)?;
                Ok((planar_isometry(&pose) * tilt, newest_s))
            }
            Self::Tilted => Err(NoPose::Tilted),
        }
    }
}

/// A pose whose numbers are checked. Rounded quaternions get unit length.
fn isometry(pose: &msg::Pose) -> Isometry3<f64> {
    let msg::Point { x, y, z } = pose.position;
    let translation = Translation3::new(x, y, z);
    let msg::Quaternion { x, y, z, w } = pose.orientation;
    let rotation = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
    Isometry3::from_parts(translation, rotation)
}

fn planar_isometry(pose: &Pose) -> Isometry3<f64> {
    isometry(&msg::Pose::from(pose))
}

/// The horizontal part of the parent's upward axis in a frame with this rotation.
fn lean(rotation: &msg::Quaternion) -> Vector {
    let msg::Quaternion { x, y, z, w } = *rotation;
    Vector::new(2.0 * (x * z - w * y), 2.0 * (y * z + w * x))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ros::msg::{Header, Time, Transform, TransformStamped};
    use crate::ros::node::scan::level_range;

    fn message(parent: &str, child: &str, stamp_s: f64, x: f64) -> TFMessage {
        TFMessage {
            transforms: vec![TransformStamped {
                header: Header { stamp: Time::from_seconds(stamp_s), frame_id: parent.to_owned() },
                child_frame_id: child.to_owned(),
                transform: Transform::from(&Pose::new(x, 0.0, 0.0)),
            }],
        }
    }

    #[test]
    fn transform_is_interpolated_at_the_requested_time() {
        let mut frames = Frames::default();
        for (time_s, x) in [(10.0, 0.0), (10.5, 1.0)] {
            frames.update(10.6, &message("base", "mast", time_s, x), false).expect("valid");
        }
        frames.update(10.6, &message("mast", "laser", 0.0, 0.25), true).expect("valid");
        for (time_s, x) in [(9.0, 0.25), (10.25, 0.75), (11.0, 1.25)] {
            let found = frames.pose_in("base", "laser", time_s).expect("connected");
            assert!((found.pose.x - x).abs() < 1e-9, "{time_s}: {found:?}");
            assert_eq!(found.time_s, 10.5);
        }
    }

    #[test]
    fn transform_dated_ahead_counts_from_its_arrival() {
        let mut frames = Frames::default();
        frames.update(10.0, &message("map", "odom", 11.0, 0.0), false).expect("valid");
        frames.update(10.1, &message("map", "odom", 11.1, 1.0), false).expect("valid");
        let found = frames.pose_in("map", "odom", 10.1).expect("connected");
        assert_eq!((found.pose.x, found.time_s), (1.0, 10.1));
    }

    #[test]
    fn late_transform_does_not_replace_a_newer_one() {
        let mut frames = Frames::default();
        frames.update(10.0, &message("map", "odom", 10.0, 1.0), false).expect("valid");
        let late = frames.update(10.1, &message("map", "odom", 9.8, 2.0), false);
        assert!(matches!(late, Err(MessageError::NotNewer)), "{late:?}");
        assert_eq!(frames.pose_in("map", "odom", 10.1).map(|found| found.pose.x), Ok(1.0));
    }

    /// `robot_state_publisher` sends all fixed frames in one message, and a camera's optical frame is tilted.
    #[test]
    fn tilted_and_invalid_transforms_keep_no_other_from_being_stored() {
        let mut camera = message("base", "camera", 0.0, 0.0).transforms;
        camera[0].transform.rotation = msg::Quaternion { x: -0.5, y: 0.5, z: -0.5, w: 0.5 };
        let mut broken = message("base", "broken", 0.0, 0.0).transforms;
        broken[0].transform.rotation = msg::Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 0.0 };
        let sensor = message("camera", "sensor", 0.0, 0.1).transforms;
        let laser = message("base", "laser", 0.0, 0.2).transforms;
        let transforms = [camera, broken, sensor, laser].concat();
        let mut frames = Frames::default();
        let outcome = frames.update(1.0, &TFMessage { transforms }, true);
        assert!(matches!(outcome, Err(MessageError::BadQuaternion { .. })), "{outcome:?}");
        assert_eq!(frames.pose_in("base", "laser", 1.0).map(|found| found.pose.x), Ok(0.2));
        for tilted in ["camera", "sensor"] {
            assert_eq!(frames.pose_in("base", tilted, 1.0), Err(NoPose::Tilted), "{tilted}");
        }
        assert_eq!(frames.pose_in("base", "broken", 1.0), Err(NoPose::Unconnected));
        assert_eq!(frames.pose_in("map", "sensor", 1.0), Err(NoPose::Unconnected));
    }

    /// A level lidar on a bracket that is pitched by 45 degrees, and one that is mounted upside down twice: the chain is projected
    /// once, not link by link.
    #[test]
    fn height_above_a_tilted_bracket_moves_the_lidar() {
        let rotation = |roll: f64, pitch: f64| {
            let ((sr, cr), (sp, cp)) = (libm::sincos(roll / 2.0), libm::sincos(pitch / 2.0));
            msg::Quaternion { x: sr * cp, y: cr * sp, z: -sr * sp, w: cr * cp }
        };
        let diagonal_m = 0.4 * core::f64::consts::FRAC_1_SQRT_2;
        let (tilt, over) = (core::f64::consts::FRAC_PI_4, core::f64::consts::PI);
        for (roll, pitch, is_static, expected) in [
            (0.0, tilt, true, Ok(Pose::new(1.2 + diagonal_m, 0.0, 0.0))),
            (0.0, tilt, false, Ok(Pose::new(1.2 + diagonal_m, 0.0, 0.0))),
            (tilt, 0.0, true, Ok(Pose::new(1.2, -diagonal_m, 0.0))),
            (over, 0.0, true, Ok(Pose::new(1.2, 0.0, 0.0))),
            // Its yaw would be that of a wheel.
            (over, 0.0, false, Err(NoPose::Tilted)),
        ] {
            let mut bracket = message("base", "bracket", 1.0, 0.2);
            bracket.transforms[0].transform.rotation = rotation(roll, pitch);
            let mut laser = message("bracket", "laser", 0.0, 0.0);
            laser.transforms[0].transform.translation.z = 0.4;
            laser.transforms[0].transform.rotation = rotation(-roll, -pitch);
            let mut frames = Frames::default();
            frames.update(1.0, &message("chassis", "base", 0.0, 1.0), true).expect("valid");
            frames.update(1.0, &bracket, is_static).expect("valid");
            frames.update(1.0, &laser, true).expect("valid");
            let found = frames.lidar_in("chassis", "laser", 1.0);
            let errors = match (found, expected) {
                (Ok(FramePose { pose, lean, .. }), Ok(expected)) => {
                    [(pose.position() - expected.position()).norm(), pose.yaw, lean.norm()]
                }
                (found, expected) => {
                    assert_eq!(found.map(|found| found.pose), expected);
                    [0.0; 3]
                }
            };
            assert!(errors.iter().all(|error| error.abs() < 1e-9), "{roll} {pitch}: {found:?}");
        }
    }

    /// A lidar that is pitched on a turned mast: the ranges in the plane are those of the rotations themselves.
    #[test]
    fn range_of_a_tilted_lidar_is_its_part_in_the_plane() {
        let (yaw, pitch) = (0.8_f64, 0.15_f64);
        let turned = |yaw: f64, pitch: f64| {
            let ((sz, cz), (sy, cy)) = (libm::sincos(yaw / 2.0), libm::sincos(pitch / 2.0));
            msg::Quaternion { x: -sz * sy, y: cz * sy, z: sz * cy, w: cz * cy }
        };
        let mut transforms = message("base", "mast", 0.0, 0.3).transforms;
        transforms[0].transform.rotation = turned(yaw, 0.0);
        let mut lidar = message("mast", "laser", 0.0, 0.0).transforms;
        lidar[0].transform.rotation = turned(0.0, pitch);
        transforms.extend(lidar);
        transforms.extend(message("base", "foot", 0.0, 0.0).transforms);
        let mut frames = Frames::default();
        frames.update(1.0, &TFMessage { transforms }, true).expect("valid");
        for base in ["base", "foot"] {
            let found = frames.lidar_in(base, "laser", 1.0).expect("level enough");
            assert!((found.pose.yaw - yaw).abs() < 1e-9);
            for angle in [0.0, 0.7, 1.6, 3.0] {
                let (sin, cos) = libm::sincos(angle);
                let in_plane = libm::hypot(cos * libm::cos(pitch), sin);
                let found = level_range(angle, 4.0, &found.lean);
                assert!((found - 4.0 * in_plane).abs() < 1e-9, "{angle}: {found}");
            }
        }
        assert_eq!(
            frames.lidar_in("laser", "base", 1.0).map(|found| found.time_s),
            Ok(f64::INFINITY)
        );
        assert_eq!(level_range(1.0, 4.0, &Vector::ZERO), 4.0);
    }

    #[test]
    fn number_of_frames_is_bounded() {
        let mut frames = Frames::default();
        let add = |frames: &mut Frames, number: usize| {
            frames.update(10.0, &message("map", &format!("f{number}"), 10.0, 0.0), false)
        };
        for number in 0..MAX_FRAMES {
            add(&mut frames, number).expect("room for it");
        }
        let refused = add(&mut frames, MAX_FRAMES);
        assert!(matches!(refused, Err(MessageError::TooManyFrames { .. })), "{refused:?}");
        frames.update(10.1, &message("map", "f7", 10.1, 3.0), false).expect("a known frame");
    }

    #[test]
    fn cycle_of_frames_has_no_pose() {
        let mut frames = Frames::default();
        frames.update(1.0, &message("a", "b", 1.0, 0.0), false).expect("valid");
        frames.update(1.0, &message("b", "a", 1.0, 0.0), false).expect("valid");
        assert_eq!(frames.pose_in("map", "a", 1.0), Err(NoPose::Unconnected));
    }
}
