//! Where the node has the pose of the odometry in the map from.

use super::NodeCore;
use crate::geometry::Pose;
use crate::localization::PoseHint;
use crate::ros::msg::{self, Header, Time};
use crate::ros::node::latest_inputs::OdometryFrame;
use crate::ros::node::notices::{MessageError, MissingInput};

impl NodeCore {
    /// Lets the localisation search near a pose.
    pub(super) fn set_hint(
        &mut self,
        (found, hint): (String, PoseHint),
    ) -> Result<(), MessageError> {
        self.check_map_frame(&found)?;
        let Some(localization) = &mut self.localization else {
            return Err(MessageError::NotLocalizing);
        };
        localization.set_hint(&found, hint)?;
        let Pose { x, y, yaw } = hint.pose;
        self.notices.push(format!("searching the pose near ({x:.2}, {y:.2}, {yaw:.2})"));
        Ok(())
    }

    pub(super) fn odometry_frame(&self) -> Result<OdometryFrame, MissingInput> {
        match &self.localization {
            Some(_) if self.inputs.map.is_none() => Err(MissingInput::Map),
            Some(_) if self.inputs.odometry.is_none() => Err(MissingInput::Odometry),
            Some(localization) => localization.odometry_frame(),
            None if self.settings.odom_is_map => Ok(OdometryFrame::IsMap),
            None => Ok(OdometryFrame::ByTransforms),
        }
    }

    /// Another node must not publish the transform that this node measures.
    pub(super) fn check_own_transform(&mut self, now_s: f64, message: &msg::TFMessage) {
        let (Some(_), Some(odometry)) = (&self.localization, &self.inputs.odometry) else {
            return;
        };
        let is_own = |it: &msg::TransformStamped| {
            it.child_frame_id.trim_start_matches('/') == odometry.frame
        };
        if message.transforms.iter().any(is_own) {
            self.conflicts.set_transform(now_s);
        }
    }

    /// The transform that this node measured. Until the next tick it holds for every time.
    pub(super) fn transforms(
        &self,
        now_s: f64,
        frame: &Result<OdometryFrame, MissingInput>,
    ) -> Option<msg::TFMessage> {
        let Ok(OdometryFrame::Measured { pose, lost: None, .. }) = frame else {
            return None;
        };
        let (map, odometry) = (self.inputs.map.as_ref()?, self.inputs.odometry.as_ref()?);
        let stamp = Time::from_seconds(now_s + self.period_s());
        let transforms = vec![msg::TransformStamped {
            header: Header { stamp, frame_id: map.frame.clone() },
            child_frame_id: odometry.frame.clone(),
            transform: msg::Transform::from(pose),
        }];
        Some(msg::TFMessage { transforms })
    }
}
