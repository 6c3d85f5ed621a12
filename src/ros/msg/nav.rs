//! `nav_msgs` and `sensor_msgs/LaserScan`.

use super::common::{Header, Time};
use super::declaration::messages;
use super::geometry::{Pose, PoseStamped, PoseWithCovariance, TwistWithCovariance};

messages! {
    /// Size and position of a map.
    #[derive(Copy, Default)]
    nav_msgs / MapMetaData {
        /// Time at which the map was loaded.
        map_load_time: Time,
        /// Side of a cell, metres.
        resolution: f32,
        /// Number of columns.
        width: u32,
        /// Number of rows.
        height: u32,
        /// Pose of the lower left corner of cell (0, 0).
        origin: Pose,
    }

    /// An occupancy grid map.
    #[derive(Default)]
    nav_msgs / OccupancyGrid {
        /// Time and frame.
        header: Header,
        /// Size and position.
        info: MapMetaData,
        /// Occupancy in percent, 0 to 100, or -1 for unknown; row by row, the lowest first.
        data: Vec<i8>,
    }

    /// Pose and velocity of a robot.
    #[derive(Default)]
    nav_msgs / Odometry {
        /// Time, and frame of the pose.
        header: Header,
        /// Frame of the velocity: the robot's base frame.
        child_frame_id: String,
        /// Pose of the robot.
        pose: PoseWithCovariance,
        /// Velocity of the robot.
        twist: TwistWithCovariance,
    }

    /// A path.
    #[derive(Default)]
    nav_msgs / Path {
        /// Time and frame.
        header: Header,
        /// Poses from the start to the goal.
        poses: Vec<PoseStamped>,
    }

    /// A scan of a planar lidar.
    #[derive(Default)]
    sensor_msgs / LaserScan {
        /// Time of the first beam, and frame of the lidar.
        header: Header,
        /// Angle of the first beam, radians.
        angle_min: f32,
        /// Angle of the last beam, radians.
        angle_max: f32,
        /// Angle between two beams, radians.
        angle_increment: f32,
        /// Time between two beams, seconds.
        time_increment: f32,
        /// Time between two scans, seconds.
        scan_time: f32,
        /// Shortest measurable range, metres.
        range_min: f32,
        /// Longest measurable range, metres.
        range_max: f32,
        /// Range of each beam, metres; infinite for no return, NaN for no measurement (REP-117).
        ranges: Vec<f32>,
        /// Strength of each return.
        intensities: Vec<f32>,
    }
}
