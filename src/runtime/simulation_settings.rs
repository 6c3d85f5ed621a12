//! Settings of the simulated robot and its world. The module `sim` simulates by them.

use core::f64::consts::TAU;

use serde::{Deserialize, Serialize};

use super::plant_settings::{PlantKind, PlantRanges};
use crate::geometry::Pose;
use crate::settings::{choices, require, setting_schema, settings};

settings! {
    /// A simulated robot and its world.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct SimulationSettings {
        /// The simulated lidar.
        pub lidar: Lidar = Lidar::default();
        /// The simulated base.
        pub dynamics: DriveDynamics = DriveDynamics::default();
        /// Errors of the simulated odometry.
        pub odometry: OdometryNoise = OdometryNoise::default();
        /// Simulated position fixes.
        pub fixes: Fixes = Fixes::default();
        /// Simulated pedestrians.
        pub pedestrians: PedestrianSettings = PedestrianSettings::default();
        /// A planner that is wrong on purpose and replaces the navigator's commands, to test the protective layer: `off`,
        /// `obstacles` (drives at walls and people), `random`, `old` (commands of ten seconds ago), `not_finite`, `too_fast`, or
        /// `mixed` (one of the first three by the seed).
        pub wrong_planner: WrongPlanner = WrongPlanner::default();
        /// Error of the map: walls of the world are up to this far from where the map shows them, displaced smoothly. Default 0:
        /// the map is true.
        pub map_error_m: f64 = 0.0, ["m", 0 to 1];
        /// Age of scan, odometry and fixes when the control loop gets them. Default 0. A real base takes 0.01 to 0.05 s, a
        /// lidar driver 0.05 to 0.15 s.
        pub sensing_delay_s: f64 = 0.0, ["s", 0 to 0.8];
        /// Whether their stamps are the times of measurement. Otherwise the stamps are the times of arrival.
        pub stamps_sensing_delay: bool = true;
        /// `agreeing`: the simulated robot is as this file describes it. `disagreeing`: the seed of each mission draws
        /// the true robot from `plant_ranges`; the navigator keeps the values of this file.
        pub plant: PlantKind = PlantKind::default();
        /// Ranges from which a disagreeing plant is drawn.
        pub plant_ranges: PlantRanges = PlantRanges::default();
    }
}

/// A planner that is wrong on purpose.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum WrongPlanner {
    /// The navigator's commands are executed.
    #[default]
    Off,
    /// Full speed towards people and walls.
    Obstacles,
    /// A random command, kept for a while.
    Random,
    /// The navigator's command of ten seconds ago.
    Old,
    /// A command that is not a number.
    NotFinite,
    /// Straight ahead at a speed that no base reaches.
    TooFast,
    /// [`Self::Obstacles`], [`Self::Random`] or [`Self::Old`], by the seed.
    Mixed,
}

setting_schema! {
    WrongPlanner: choices::<Self>();
}

settings! {
    /// A lidar on the robot.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct Lidar {
        /// Position ahead of the robot's origin. Default 0.
        pub mount_x_m: f64 = 0.0, ["m", -5 to 5];
        /// Position to the left of the robot's origin. Default 0.
        pub mount_y_m: f64 = 0.0, ["m", -5 to 5];
        /// Direction of the lidar's front, counter-clockwise from the robot's. Default 0.
        pub mount_yaw_rad: f64 = 0.0, ["rad", -3.2 to 3.2];
        /// Scans per second, such as 15.0; planar lidars make 5 to 40. Between two scans the robot has the last one, with its
        /// stamps. Default none: a scan in each control period.
        pub scan_rate_hz: Option<f64> = None, ["Hz", 5 to 100];
        /// Number of beams of a scan. Default 360.
        pub beams: usize = 360, ["", 1 to 65536];
        /// Angle covered by the beams, centred on the lidar's front. Default a full turn; many scanners cover three quarters of one,
        /// 4.71238898038469 rad.
        pub field_of_view_rad: f64 = TAU, ["rad", above 0 to tau];
        /// Shortest range; a nearer surface gives no measurement. Default 0.05 m, as SICK's `TiM` series.
        pub range_min_m: f64 = 0.05, ["m", at_least 0];
        /// Longest range, above `range_min_m`. Default 10 m.
        pub range_max_m: f64 = 10.0, ["m", above 0];
        /// Standard deviation of the range. Default 0.01 m: half of the 20 mm that SICK states for the `TiM` series, because
        /// mine walls are neither dark nor far.
        pub range_sigma_m: f64 = 0.01, ["m", at_least 0];
        /// Fraction of the beams that return no measurement, independently of each other: dust, wet or dark rock, grazing
        /// angles. Default 0.01: our choice.
        pub dropout: f64 = 0.01, ["", 0 to 1];
        /// Fraction of the beams that return from dust or drops in the air, at a uniformly random part of their true range.
        /// Default 0.
        pub ghosts: f64 = 0.0, ["", 0 to 1];
        /// Fraction of the beams at edges that return a range between the near and the far surface, as a spot that lies on
        /// both. Default 0.
        pub mixed_pixels: f64 = 0.0, ["", 0 to 1];
        /// Time for which a sector of the lidar sees no surface, as behind dust or mud. Default 0: never.
        pub blind_time_s: f64 = 0.0, ["s", 0 to 3600];
        /// Start of that time.
        pub blind_start_s: f64 = 0.0, ["s", 0 to 3600];
        /// Middle of the blind sector in the robot's frame, counter-clockwise from ahead.
        pub blind_direction_rad: f64 = 0.0, ["rad", -7 to 7];
        /// Width of the blind sector.
        pub blind_width_rad: f64 = 0.0, ["rad", 0 to 6.3];
        /// Duration of a revolution, in which the beams are measured one after the other while the robot moves. Default 0: all
        /// beams at once. Planar lidars commonly take 0.1 s.
        pub sweep_s: f64 = 0.0, ["s", 0 to 0.5];
    }
    rule |lidar| {
        let is_above = lidar.range_max_m > lidar.range_min_m;
        require(is_above, "range_max_m", lidar.range_max_m, "finite and above range_min_m")?;
        // A revolution begins after the one before has ended.
        let longest_s = lidar.scan_rate_hz.map_or(f64::INFINITY, f64::recip);
        let fits = lidar.sweep_s <= longest_s + 1e-6;
        require(fits, "sweep_s", lidar.sweep_s, "at most 1 / scan_rate_hz")
            .map_err(|error| error.with_bound(longest_s))
    }
}

impl Lidar {
    /// Pose of the lidar in the robot's frame.
    #[must_use]
    pub const fn mount(&self) -> Pose {
        Pose::new(self.mount_x_m, self.mount_y_m, self.mount_yaw_rad)
    }

    /// Returns a common small planar lidar: 450 beams in a revolution of 0.1 s, up to 12 m, with 2 cm of noise.
    #[must_use]
    pub fn turning() -> Self {
        Self { beams: 450, range_max_m: 12.0, range_sigma_m: 0.02, sweep_s: 0.1, ..Self::default() }
    }
}

settings! {
    /// Response of a simulated base to commands.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct DriveDynamics {
        /// Time from sending a command until the base acts on it. Default 0.03 s: a USB serial adapter delays bytes by up to
        /// 16 ms, the command's 11 bytes take 1 ms at 115,200 baud, and a base with a 100 Hz loop reads them up to 10 ms
        /// later.
        pub command_delay_s: f64 = 0.03, ["s", at_least 0];
        /// Time constant of each track's motor under closed-loop speed control. Default 0.05 s: our choice for small geared
        /// motors.
        pub motor_lag_s: f64 = 0.05, ["s", at_least 0];
        /// Speed below which a belt does not move: static friction, or a controller that rounds small commands to zero. Default
        /// 0: a base without it; small geared motors commonly have 0.02 m/s.
        pub deadband_m_s: f64 = 0.0, ["m/s", 0 to 1];
        /// Age of the last command, since the base received it, at which the base brakes by itself. Default 0.5 s, as the ROS
        /// differential drive controller.
        pub command_timeout_s: f64 = 0.5, ["s", above 0];
        /// Acceleration of the base, over that of the robot's limits. Default 1.
        pub acceleration_ratio: f64 = 1.0, ["", above 0 to 10];
        /// Deceleration of the base, over that of the robot's limits. Default 1.
        pub braking_ratio: f64 = 1.0, ["", above 0 to 10];
        /// Slope of the ground. Uphill the tracks slip more and downhill less, and across the slope the base slides down:
        /// each by half of the slope's sine, our choice for firm ground. Default 0.
        pub slope_rad: f64 = 0.0, ["rad", 0 to 0.5];
        /// Direction of the steepest ascent in the map. Default 0.
        pub uphill_rad: f64 = 0.0, ["rad", -7 to 7];
        /// Slip of the tracks.
        pub slip: Slip = Slip::default();
    }
}

impl DriveDynamics {
    /// Returns a base that follows its ramp at once and exactly: no delay, no lag, no slip.
    #[must_use]
    pub fn ideal() -> Self {
        Self { command_delay_s: 0.0, motor_lag_s: 0.0, slip: Slip::none(), ..Self::default() }
    }
}

settings! {
    /// Slip of the tracks.
    ///
    /// A tracked base turns by dragging its tracks sideways. On given ground and at moderate speed, each track turns about a point
    /// outside it that stays nearly constant. The base then moves like one with ideal wheels set farther apart (Martínez, Mandow
    /// et al., "Approximating Kinematics for Tracked Mobile Robots", International Journal of Robotics Research 24 (10), 2005;
    /// Mandow et al., "Experimental kinematics for wheeled skid-steer mobile robots", IROS 2007). ROS calls the ratio of this
    /// effective width to the geometric one the wheel separation multiplier. Sideways slip of the whole base is not simulated.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct Slip {
        /// Fraction of each belt's speed that is lost on the ground, on straights and in turns. Default 0.025: our
        /// choice for firm ground; on sand and slopes it is many times higher.
        pub mean: f64 = 0.025, ["", 0 to below 1];
        /// Effective over geometric track width: 1 for ideal wheels, more for tracks. Default 1.5: our choice between 1 and the
        /// 1.875 that the maker of the skid-steered Husky configures.
        pub width_ratio: f64 = 1.5, ["", above 0];
        /// The same ratio as the base's controller has it for converting a command to belt speeds. Default 1.455, 3 % too
        /// little: our choice. A calibration on one floor is off by more on another.
        pub calibrated_width_ratio: f64 = 1.455, ["", above 0];
        /// Standard deviation of the slow variation of both: of the slip as a fraction of the belt's speed, of the effective
        /// width as a fraction of itself. Default 0.02: our choice. With the scale errors of the odometry, dead reckoning is
        /// then off by some percent of the distance, as tracked robots are in the field; calibrated centres of rotation reach
        /// 1 % (0.42 m of 40.5 m: Pentzer, Brennan and Reichard, Journal of Field Robotics, 2014).
        pub variation: f64 = 0.02, ["", 0 to 0.2];
        /// Distance driven in which the correlation of that variation falls to 1/e. Default 2 m, a few lengths of the base: our
        /// choice for patches of different ground.
        pub variation_length_m: f64 = 2.0, ["m", above 0];
    }
}

impl Slip {
    /// Returns ground without slip.
    #[must_use]
    pub const fn none() -> Self {
        Self {
            mean: 0.0,
            width_ratio: 1.0,
            calibrated_width_ratio: 1.0,
            variation: 0.0,
            variation_length_m: 1.0,
        }
    }
}

settings! {
    /// Errors of a base's measurement of its own motion; zero disables an error.
    ///
    /// A sigma is a standard deviation. Constant errors are drawn at the start of a run.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct OdometryNoise {
        /// Travel of a belt per encoder tick. Default 0.0001 m: our choice between a 500-line encoder before a 30:1 gear
        /// (60,000 edges per turn of a drive wheel, about 0.01 mm) and a 13-line Hall sensor there (1560 edges, about 0.3 mm).
        pub encoder_tick_m: f64 = 1e-4, ["m", at_least 0];
        /// Relative error of the length of a tick, constant in a run. Default 0.005: our choice for belts that stretch and
        /// wear.
        pub travel_scale_sigma: f64 = 0.005, ["", at_least 0];
        /// Window over which the reported forward speed is averaged; zero for the last sample only. Default 0.05 s: in one
        /// sample of 10 ms a slow belt moves few ticks.
        pub speed_window_s: f64 = 0.05, ["s", at_least 0];
        /// White noise of each sample of the turn rate. Default 0.00087 rad/s: 0.05 deg/s, the total noise in the MPU-6050
        /// datasheet for its 100 Hz filter (revision 3.4, section 6.1).
        pub gyro_sigma_rad_s: f64 = 8.7e-4, ["rad/s", at_least 0];
        /// Bias of the turn rate, constant in a run. Default 0.00035 rad/s, 0.02 deg/s: our choice for the rest of the
        /// datasheet's +-20 deg/s after the mean at standstill is subtracted and the chip has warmed up.
        pub gyro_bias_sigma_rad_s: f64 = 3.5e-4, ["rad/s", at_least 0];
        /// Relative error of the gyro's scale, constant in a run. Default 0.01: the datasheet's tolerance of +-3 % as three
        /// deviations.
        pub gyro_scale_sigma: f64 = 0.01, ["", at_least 0];
        /// Resolution of the turn rate; it is rounded to the nearest step. Default 0.00026644 rad/s: 16 bits over
        /// +-500 deg/s, as WHEELTEC's drivers read the same chip.
        pub gyro_bit_rad_s: f64 = 2.6644e-4, ["rad/s", at_least 0];
    }
}

impl OdometryNoise {
    /// Returns sensors without errors. The ground may still slip, which encoders do not measure.
    #[must_use]
    pub const fn none() -> Self {
        Self {
            encoder_tick_m: 0.0,
            travel_scale_sigma: 0.0,
            speed_window_s: 0.0,
            gyro_sigma_rad_s: 0.0,
            gyro_bias_sigma_rad_s: 0.0,
            gyro_scale_sigma: 0.0,
            gyro_bit_rad_s: 0.0,
        }
    }
}

settings! {
    /// Rate and accuracy of simulated position fixes. A fix has no delay.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct Fixes {
        /// Rate of the fixes; zero for none. Default 10: planar lidars commonly turn at 10 Hz, and a scan matcher gives a fix
        /// per revolution.
        pub rate_hz: f64 = 10.0, ["Hz", 0 to 1000];
        /// Standard deviation along x and along y. Default 0.01 m: localisation with a planar lidar errs by a few millimetres
        /// at taught places (Röwekämper et al., "On the Position Accuracy of Mobile Robot Localization based on Particle
        /// Filters Combined with Scan Matching") and by less than a centimetre amid clutter (Costa et al., "Robust and Accurate
        /// Localization System for Mobile Manipulators in Cluttered Environments").
        pub sigma_m: f64 = 0.01, ["m", at_least 0];
        /// Standard deviation of the yaw. Default 0.005 rad: our choice, a third of the degree that Costa et al. stay below.
        pub sigma_rad: f64 = 0.005, ["rad", at_least 0];
        /// Fraction of the fixes that are lost. Default 0.05: our choice.
        pub dropout: f64 = 0.05, ["", 0 to 1];
    }
}

settings! {
    /// Simulated pedestrians.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct PedestrianSettings {
        /// Radius of each pedestrian.
        pub radius_m: f64 = 0.3, ["m", above 0 to 1000];
        /// Speed of the slowest pedestrian.
        pub min_speed: f64 = 0.3, ["m/s", above 0 to 1000];
        /// Speed of the fastest pedestrian, at least `min_speed`.
        pub max_speed: f64 = 0.8, ["m/s", above 0 to 1000];
        /// Whether they stop instead of walking into the robot.
        pub yields: bool = true;
        /// Diameter of each leg. The lidar then sees two walking legs within the body's disc, as at the height of shins; zero:
        /// it sees the whole disc. Default 0.
        pub leg_diameter_m: f64 = 0.0, ["m", 0 to 0.3];
    }
    rule |settings| require(
        settings.max_speed >= settings.min_speed,
        "max_speed",
        settings.max_speed,
        "at least min_speed and at most 1000",
    )
}
