//! What a controller in a shared library gets, as C sees it.

use core::ffi::{c_char, c_void};

use serde::Deserialize;

/// Limits of the robot, m/s, rad/s, m/s^2 and rad/s^2. Decelerations are below zero.
#[derive(Clone, Copy, Debug, Deserialize)]
#[repr(C)]
pub struct InbyeLimits {
    pub min_vel_x: f64,
    pub max_vel_x: f64,
    pub max_vel_theta: f64,
    pub acc_lim_x: f64,
    pub decel_lim_x: f64,
    pub acc_lim_theta: f64,
    pub decel_lim_theta: f64,
}

/// The robot that a controller is made for.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct InbyeRobot {
    /// Control period, seconds.
    pub period_s: f64,
    /// Radius around the robot's origin that contains its body, metres.
    pub radius_m: f64,
    pub limits: InbyeLimits,
}

/// What a controller decides from at a tick. Poses are x, y and yaw in the map frame; velocities m/s and rad/s. The arrays are
/// valid during the call.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct InbyeControllerInput {
    pub time_s: f64,
    pub pose: [f64; 3],
    pub velocity: [f64; 2],
    /// Pose and velocity when a command of this tick takes effect.
    pub predicted_pose: [f64; 3],
    pub predicted_velocity: [f64; 2],
    pub last_command: [f64; 2],
    /// Limits as far as the drive has shown them.
    pub limits: InbyeLimits,
    pub goal: [f64; 2],
    pub has_goal_yaw: bool,
    pub goal_yaw: f64,
    /// The key node that inbye would drive to.
    pub local_target: [f64; 2],
    /// The global path: x and y of each point, and their number.
    pub path: *const f64,
    pub path_count: usize,
    /// Length of the path behind the robot, metres.
    pub path_progress_m: f64,
    /// Whether another goal begins with this tick.
    pub is_reset: bool,
    /// Ranges of the newest scan, metres: NaN for no measurement, the longest range for nothing within it.
    pub ranges: *const f64,
    pub range_count: usize,
    pub angle_min: f64,
    pub angle_increment: f64,
    pub range_max: f64,
    pub scan_s: f64,
    /// Tracked moving obstacles: x, y, radius, vx and vy of each, and their number.
    pub moving_obstacles: *const f64,
    pub moving_obstacle_count: usize,
    /// Place of the lidar in the robot's frame, metres: the ranges are from there.
    pub lidar: [f64; 2],
}

pub type AbiVersion = unsafe extern "C" fn() -> u32;
pub type Create = unsafe extern "C" fn(*const InbyeRobot) -> *mut c_void;
pub type Compute =
    unsafe extern "C" fn(*mut c_void, *const InbyeControllerInput, *mut f64, *mut f64) -> bool;
pub type Destroy = unsafe extern "C" fn(*mut c_void);
pub type Reason = unsafe extern "C" fn() -> *const c_char;
