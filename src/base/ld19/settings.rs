//! Where a lidar sits, and when it counts as silent.

use serde::{Deserialize, Serialize};

use crate::base::BaseError;
use crate::base::settings::require;
use crate::documented::documented;
use crate::geometry::Pose;

documented! {
    /// A lidar on the robot.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct LidarSettings {
        /// Where it sits ahead of the robot's origin, metres, -5 to 5.
        pub mount_x_m: f64,
        /// Where it sits to the left of the robot's origin, metres, -5 to 5.
        pub mount_y_m: f64,
        /// Where its front points to, radians counter-clockwise from the robot's, -3.2 to 3.2.
        pub mount_yaw_rad: f64,
        /// Whether it hangs upside down. Default false.
        pub upside_down: bool,
        /// What is nearer to it is the robot itself, metres, 0 to 5. Default 0.1 m.
        pub range_min_m: f64,
        /// It is silent when it has made no whole turn for so long, seconds, above zero and at most 10. Default 0.5 s, five turns.
        pub silent_after_s: f64,
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
            silent_after_s: 0.5,
        }
    }
}

impl LidarSettings {
    /// Checks every number.
    ///
    /// # Errors
    /// [`BaseError::BadSetting`] names the first that is out of range.
    pub fn validate(&self) -> Result<(), BaseError> {
        for (name, value, most, expected) in [
            ("mount_x_m", self.mount_x_m, 5.0, "-5 to 5"),
            ("mount_y_m", self.mount_y_m, 5.0, "-5 to 5"),
            ("mount_yaw_rad", self.mount_yaw_rad, 3.2, "-3.2 to 3.2"),
        ] {
            require(value.abs() <= most, name, value, expected)?;
        }
        let nearest = self.range_min_m;
        require(
            (0.0..=5.0).contains(&nearest),
            "range_min_m",
            nearest,
            "0 to 5",
        )?;
        let silent = self.silent_after_s;
        require(
            silent > 0.0 && silent <= 10.0,
            "silent_after_s",
            silent,
            "above zero and at most 10",
        )
    }

    /// Its pose in the robot's frame.
    #[must_use]
    pub const fn mount(&self) -> Pose {
        Pose::new(self.mount_x_m, self.mount_y_m, self.mount_yaw_rad)
    }
}
