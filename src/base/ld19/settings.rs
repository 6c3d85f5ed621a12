//! Mounting and timeout of a lidar.

use serde::{Deserialize, Serialize};

use crate::geometry::Pose;
use crate::settings::settings;

settings! {
    /// Mounting and timeout of a lidar on the robot.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct LidarSettings {
        /// Position ahead of the robot's origin.
        pub mount_x_m: f64 = 0.0, ["m", -5 to 5];
        /// Position to the left of the robot's origin.
        pub mount_y_m: f64 = 0.0, ["m", -5 to 5];
        /// Direction of the sensor's front, counter-clockwise from the robot's.
        pub mount_yaw_rad: f64 = 0.0, ["rad", -3.2 to 3.2];
        /// Whether the sensor is mounted upside down. Default false.
        pub upside_down: bool = false;
        /// Shortest valid range; nearer returns are the robot itself. Default 0.1 m.
        pub range_min_m: f64 = 0.1, ["m", 0 to 5];
        /// Time without a complete revolution after which the lidar counts as silent. Default 0.5 s, five
        /// revolutions.
        pub timeout_s: f64 = 0.5, ["s", above 0 to 10];
    }
}

impl LidarSettings {
    /// Pose of the sensor in the robot's frame.
    #[must_use]
    pub const fn mount(&self) -> Pose {
        Pose::new(self.mount_x_m, self.mount_y_m, self.mount_yaw_rad)
    }
}
