//! The ranges from which a simulated robot is drawn that differs from the navigator's model of it.

use serde::{Deserialize, Serialize};

use crate::settings::{choices, setting_schema, settings};

/// Whether the simulated robot agrees with the navigator's model.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum PlantKind {
    /// The simulated robot is as the settings describe it.
    #[default]
    Agreeing,
    /// The true values of each mission are drawn from ranges.
    Disagreeing,
}

setting_schema! {
    PlantKind: choices::<Self>();
}

settings! {
    /// Least and largest true values of a disagreeing plant. Each mission draws its own uniformly (domain randomisation). The
    /// navigator keeps the values of its own settings.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct PlantRanges {
        /// Time until the base acts on a command. With `sensing_delay_s` the total latency is 0.05 to 0.3 s.
        pub command_delay_s: [f64; 2] = [0.02, 0.15], ["s", 0 to 2];
        /// Age of scan, odometry and fixes when the control loop gets them. The default range is cut to what the time between two
        /// scans leaves of `navigator.scan_timeout_s`; another range must leave that time.
        pub sensing_delay_s: [f64; 2] = [0.03, 0.15], ["s", 0 to 0.8];
        /// Time constant of the motors: a payload makes them slower.
        pub motor_lag_s: [f64; 2] = [0.05, 0.15], ["s", 0 to 2];
        /// Acceleration over that of the robot's limits.
        pub acceleration_ratio: [f64; 2] = [0.7, 1.1], ["", above 0 to 10];
        /// Deceleration over that of the robot's limits.
        pub braking_ratio: [f64; 2] = [0.7, 1.1], ["", above 0 to 10];
        /// Belt speed below which a motor stands still.
        pub deadband_m_s: [f64; 2] = [0.0, 0.02], ["m/s", 0 to 1];
        /// Effective over geometric track width. The base's controller keeps its calibrated ratio.
        pub width_ratio: [f64; 2] = [1.2, 1.8], ["", above 0 to 10];
        /// Slope of the ground, in a random direction; 0.0873 rad are 5 degrees.
        pub slope_rad: [f64; 2] = [0.0, 0.0873], ["rad", 0 to 0.5];
        /// Factor of every standard deviation of odometry, ranges and fixes.
        pub noise_ratio: [f64; 2] = [1.0, 3.0], ["", 0 to 100];
        /// Fraction of the beams that return from dust.
        pub ghosts: [f64; 2] = [0.0, 0.002], ["", 0 to 1];
        /// Fraction of the beams at edges with a range in between.
        pub mixed_pixels: [f64; 2] = [0.0, 0.5], ["", 0 to 1];
        /// Error of the map: see `simulation.map_error_m`.
        pub map_error_m: [f64; 2] = [0.0, 0.05], ["m", 0 to 1];
        /// Share of the missions in which a sector of the lidar, in a random direction, sees no surface for a while.
        pub blind_share: f64 = 0.25, ["", 0 to 1];
        /// Start of that time.
        pub blind_start_s: [f64; 2] = [5.0, 40.0], ["s", 0 to 3600];
        /// Its duration.
        pub blind_time_s: [f64; 2] = [1.0, 8.0], ["s", 0 to 3600];
        /// Width of the sector; 1.57 rad are 90 degrees.
        pub blind_width_rad: [f64; 2] = [0.35, 1.57], ["rad", 0 to 6.3];
        /// Speeds of pedestrians: 1.6 m/s is the approach speed of ISO 13855.
        pub pedestrian_speed_m_s: [f64; 2] = [0.5, 1.6], ["m/s", above 0 to 1000];
        /// Diameter of pedestrians' legs at the height of the lidar. IEC 61496-3 tests the detection of legs with 0.07 m.
        pub leg_diameter_m: [f64; 2] = [0.05, 0.08], ["m", above 0 to 0.3];
    }
}
