//! The tree of frames by `tf` and `tf_static`, bounded in memory.

use std::collections::BTreeMap;

use super::incoming::{frame_name, planar_pose};
use super::notices::MessageError;
use crate::geometry::Pose;
use crate::localization::PoseHistory;
use crate::ros::msg::{self, TFMessage};

/// Maximum number of frames. A robot has some dozens.
const MAX_FRAMES: usize = 512;
/// Maximum number of parents above a frame. A chain with more parents is a cycle.
const MAX_PARENTS: usize = 32;
/// A transform that is older than the newest of its frame by less than this, seconds, arrived out of order. An older one means
/// that the sender's clock was set.
const OUT_OF_ORDER_S: f64 = 1.0;

/// The recent planar poses of each frame in its parent frame.
#[derive(Clone, Debug, Default)]
pub struct Frames(BTreeMap<String, Link>);

/// A frame below its parent.
#[derive(Clone, Debug)]
struct Link {
    parent: String,
    pose: LinkPose,
}

#[derive(Clone, Debug)]
enum LinkPose {
    /// From `tf_static`: it holds for all times.
    Static(Pose),
    /// From `tf`.
    Dynamic(PoseHistory),
}

/// The pose of a frame in another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FramePose {
    pub pose: Pose,
    /// Time of the oldest dynamic transform between the two frames, seconds; infinite if all are static.
    pub time_s: f64,
}

impl Frames {
    /// Stores the transforms of a message that arrived at a time, seconds. A dynamic transform counts from its stamp, or from its
    /// arrival if the stamp is later: localization nodes date their transforms ahead.
    ///
    /// # Errors
    /// The first invalid transform; those before it are stored.
    pub fn update(
        &mut self,
        now_s: f64,
        message: &TFMessage,
        is_static: bool,
    ) -> Result<(), MessageError> {
        for stamped in &message.transforms {
            let msg::Vector3 { x, y, z } = stamped.transform.translation;
            let pose = msg::Pose {
                position: msg::Point { x, y, z },
                orientation: stamped.transform.rotation,
            };
            let pose = planar_pose("a transform", &pose)?;
            let child = frame_name("child_frame_id", &stamped.child_frame_id)?;
            let parent = frame_name("header.frame_id", &stamped.header.frame_id)?;
            if self.0.len() >= MAX_FRAMES && !self.0.contains_key(&child) {
                return Err(MessageError::TooManyFrames { max: MAX_FRAMES });
            }
            if is_static {
                self.0.insert(child, Link { parent, pose: LinkPose::Static(pose) });
                continue;
            }
            let stamp = stamped.header.stamp;
            if stamp.is_zero() {
                return Err(MessageError::NoStamp);
            }
            let time_s = stamp.seconds().min(now_s);
            self.record(child, parent, time_s, &pose)?;
        }
        Ok(())
    }

    fn record(
        &mut self,
        child: String,
        parent: String,
        time_s: f64,
        pose: &Pose,
    ) -> Result<(), MessageError> {
        if let Some(Link { parent: before, pose: LinkPose::Dynamic(history) }) =
            self.0.get_mut(&child)
            && *before == parent
        {
            let newest_s = history.newest().map_or(f64::NEG_INFINITY, |(newest_s, _)| newest_s);
            if (-OUT_OF_ORDER_S..0.0).contains(&(time_s - newest_s)) {
                return Err(MessageError::NotNewer);
            }
            history.record(time_s, pose);
            return Ok(());
        }
        let mut history = PoseHistory::default();
        history.record(time_s, pose);
        self.0.insert(child, Link { parent, pose: LinkPose::Dynamic(history) });
        Ok(())
    }

    /// The pose of a frame in one of its ancestors at a time, seconds, or nothing if they are not connected. Between two
    /// transforms it is interpolated; outside their times it is the nearest.
    #[must_use]
    pub fn pose_in(&self, ancestor: &str, frame: &str, time_s: f64) -> Option<FramePose> {
        let mut at = frame;
        let mut found = FramePose { pose: Pose::default(), time_s: f64::INFINITY };
        for _ in 0..MAX_PARENTS {
            if at == ancestor {
                return Some(found);
            }
            let link = self.0.get(at)?;
            let in_parent = match &link.pose {
                LinkPose::Static(pose) => *pose,
                LinkPose::Dynamic(history) => {
                    let (newest_s, _) = history.newest()?;
                    found.time_s = found.time_s.min(newest_s);
                    history.at(time_s)?
                }
            };
            found.pose = in_parent.transform_pose(&found.pose);
            at = &link.parent;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ros::msg::{Header, Time, Transform, TransformStamped};

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
        assert_eq!(frames.pose_in("map", "odom", 10.1).map(|found| found.pose.x), Some(1.0));
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
        assert_eq!(frames.pose_in("map", "a", 1.0), None);
    }
}
