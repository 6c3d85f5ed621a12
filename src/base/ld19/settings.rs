//! Mounting and timeout of a lidar.

use serde::{Deserialize, Serialize};

use crate::base::BaseError;
use crate::base::settings::require;
use crate::documented::documented;
use crate::geometry::Pose;

documented! {
    /// Mounting and timeout of a lidar on the robot.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct LidarSettings {
        /// Position ahead of the robot's origin, metres, -5 to 5.
        pub mount_x_m: f64,
        /// Position to the left of the robot's origin, metres, -5 to 5.
        pub mount_y_m: f64,
        /// Direction of the sensor's front, radians counter-clockwise from the robot's, -3.2 to 3.2.
        pub mount_yaw_rad: f64,
        /// Whether the sensor is mounted upside down. Default false.
        pub upside_down: bool,
        /// Shortest valid range, metres, 0 to 5; nearer returns are the robot itself. Default 0.1 m.
        pub range_min_m: f64,
        /// Time without a complete revolution after which the lidar counts as silent, seconds, above zero and at most 10. Default
        /// 0.5 s, five revolutions.
        pub timeout_s: f64,
    }
}

impl Default for LidarSettings {
    fn default() -> Self {
        Self {
            mount_x_m: 0.0,
            mount_y_m: 0.0,
            mount_yaw_rad: 0.0,
            upside_down: false,
            range_min_m: 0.1,
            timeout_s: 0.5,
        }
    }
}

impl LidarSettings {
    /// Checks every number.
    ///
    /// # Errors
    /// [`BaseError::BadSetting`] for the first number out of range.
    pub fn validate(&self) -> Result<(), BaseError> {
        for (name, value, max, expected) in [
            ("mount_x_m", self.mount_x_m, 5.0, "-5 to 5"),
            ("mount_y_m", self.mount_y_m, 5.0, "-5 to 5"),
            ("mount_yaw_rad", self.mount_yaw_rad, 3.2, "-3.2 to 3.2"),
        ] {
            require(value.abs() <= max, name, value, expected)?;
        }
        let range_min_m = self.range_min_m;
        require(
            (0.0..=5.0).contains(&range_min_m),
            "range_min_m",
            range_min_m,
            "0 to 5",
        )?;
        let timeout_s = self.timeout_s;
        require(
            timeout_s > 0.0 && timeout_s <= 10.0,
            "timeout_s",
            timeout_s,
            "above zero and at most 10",
        )
    }

    /// Pose of the sensor in the robot's frame.
    #[must_use]
    pub const fn mount(&self) -> Pose {
        Pose::new(self.mount_x_m, self.mount_y_m, self.mount_yaw_rad)
    }
}
