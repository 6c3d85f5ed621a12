//! `tf2_msgs`.

use serde::{Deserialize, Serialize};

use super::TransformStamped;

/// `tf2_msgs/TFMessage`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TFMessage {
    /// Frames, each in its parent.
    pub transforms: Vec<TransformStamped>,
}
