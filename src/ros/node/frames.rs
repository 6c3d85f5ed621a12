//! Which frame lies where in which: what `tf` and `tf_static` say.

use std::collections::BTreeMap;

use super::{MessageError, plane};
use crate::geometry::Pose;
use crate::ros::msg::TFMessage;

/// So many parents above a frame are looked through: more is a circle.
const DEEPEST: usize = 32;

/// The newest place of each frame in its parent, on the ground. Their ages are not looked at.
#[derive(Clone, Debug, Default)]
pub struct Frames(BTreeMap<String, (String, Pose)>);

impl Frames {
    /// Takes in what was said.
    ///
    /// # Errors
    /// The first transform that is none; those before it are taken.
    pub fn hear(&mut self, message: &TFMessage) -> Result<(), MessageError> {
        for said in &message.transforms {
            let transform = &said.transform;
            let place = plane::pose("a transform", &transform.translation, &transform.rotation)?;
            let child = frame_name("child_frame_id", &said.child_frame_id)?;
            let parent = frame_name("header.frame_id", &said.header.frame_id)?;
            self.0.insert(child, (parent, place));
        }
        Ok(())
    }

    /// The pose of a frame in one above it; none where nobody has said how they are connected.
    #[must_use]
    pub fn pose_in(&self, above: &str, frame: &str) -> Option<Pose> {
        let (mut at, mut pose) = (frame, Pose::default());
        for _ in 0..DEEPEST {
            if at == above {
                return Some(pose);
            }
            let (parent, place) = self.0.get(at)?;
            pose = place.transform_pose(&pose);
            at = parent;
        }
        None
    }
}

/// The name of a frame without the slash that ROS 1 put before it.
///
/// # Errors
/// Where nothing is left.
pub fn frame_name(field: &'static str, name: &str) -> Result<String, MessageError> {
    match name.strip_prefix('/').unwrap_or(name) {
        "" => Err(MessageError::NoFrame { field }),
        name => Ok(name.to_owned()),
    }
}
