//! The frames of `tf` and `tf_static`.

use std::collections::BTreeMap;

use super::error::MessageError;
use super::incoming::planar_pose;
use crate::geometry::Pose;
use crate::ros::msg::{self, Point, TFMessage};

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
            let pose =
                msg::Pose { position: Point { x, y, z }, orientation: stamped.transform.rotation };
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

/// The name of a frame without the leading slash of ROS 1.
///
/// # Errors
/// When the name is empty.
pub fn frame_name(field: &'static str, name: &str) -> Result<String, MessageError> {
    match name.strip_prefix('/').unwrap_or(name) {
        "" => Err(MessageError::NoFrame { field }),
        name => Ok(name.to_owned()),
    }
}
