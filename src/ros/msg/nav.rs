//! `nav_msgs`.

use serde::{Deserialize, Serialize};

use super::{Header, Pose, PoseStamped, PoseWithCovariance, Time, TwistWithCovariance};

/// `nav_msgs/MapMetaData`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MapMetaData {
    /// When the map was loaded.
    pub map_load_time: Time,
    /// Side of a cell, metres.
    pub resolution: f32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Lower-left corner of cell (0, 0) in the map's frame.
    pub origin: Pose,
}

/// `nav_msgs/OccupancyGrid`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct OccupancyGrid {
    /// Time and frame.
    pub header: Header,
    /// Size and place.
    pub info: MapMetaData,
    /// Percent occupied, 0 to 100, or -1 for unknown; row by row from the lowest.
    pub data: Vec<i8>,
}

/// `nav_msgs/Odometry`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Odometry {
    /// Time, and the frame of the pose.
    pub header: Header,
    /// The frame of the twist: the robot's own.
    pub child_frame_id: String,
    /// Where the robot is.
    pub pose: PoseWithCovariance,
    /// How fast it moves.
    pub twist: TwistWithCovariance,
}

/// `nav_msgs/Path`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Path {
    /// Time and frame.
    pub header: Header,
    /// The way, from its start.
    pub poses: Vec<PoseStamped>,
}
