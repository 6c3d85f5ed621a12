//! `inbye node`, as typed.

use std::path::PathBuf;

use clap::Args;
use inbye::local::EngineChoice;

use super::arguments::{duration, whole};
use super::known_words;

/// `inbye node`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  inbye node --config robot.toml --namespace /rover --for 60\n\n\
    Subscribed, with ROS 2's names and types: map (OccupancyGrid, latched), scan (LaserScan), odom (Odometry), goal_pose \
    (PoseStamped, in the map's frame), tf and tf_static. Published: cmd_vel (Twist, or TwistStamped with --stamped), plan (Path, \
    latched), local_markers (MarkerArray).\n\
    The pose is that of odom, moved by what tf says of its frame in the map's; with --odom-is-map, or where both frames have \
    the same name, as it stands. The lidar is where tf says on the robot, else at its origin; what the robot drove while it turned is taken out by the stamps of scan and odometry. All names are within the namespace, \
    tf too.\n\
    Without a goal nothing is published. With one, a velocity at each control_period_s: the robot brakes to zero while map, \
    scan, odometry or transform are missing or older than scan_timeout_s, and goes on when they come; it gives up when scans \
    stay away for sensor_fault_patience_s. Another goal or another map on the way stops it first; then it plans. An orientation of \
    all zeros leaves the goal's yaw free. At the goal, and when a goal is given up, zeros for a second; at the end, too.\n\
    ROS_DOMAIN_ID names the domain; ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST, or ROS_LOCALHOST_ONLY=1, keeps discovery off \
    other machines. Needs a program built with `--features ros2`, and no ROS."
)]
pub struct NodeArguments {
    /// Settings, TOML: those of `inbye drive`.
    #[arg(long, value_name = "FILE.toml")]
    pub config: Option<PathBuf>,
    /// Before the names of node and topics, such as /rover [default: none].
    #[arg(long, value_name = "NS", default_value = "", hide_default_value = true)]
    pub namespace: String,
    /// Engine, or gpu:NAME for an adapter whose name contains NAME.
    #[arg(long, default_value = "auto", value_parser = known_words::engine())]
    pub engine: EngineChoice,
    /// CPU threads [default: all cores].
    #[arg(long, allow_negative_numbers = true, value_parser = whole::<usize>(1, 1024))]
    pub threads: Option<usize>,
    /// Publish `cmd_vel` as `TwistStamped`, as newer releases of Nav2 and `ros2_control` expect it.
    #[arg(long, conflicts_with = "unstamped")]
    pub stamped: bool,
    /// Publish `cmd_vel` as `Twist`: the default.
    #[arg(long)]
    pub unstamped: bool,
    /// Take odometry to be in the map's frame, whatever it says.
    #[arg(long)]
    pub odom_is_map: bool,
    /// End after so long, seconds [default: at Ctrl-C].
    #[arg(long = "for", value_name = "S", allow_negative_numbers = true, value_parser = duration)]
    pub for_s: Option<f64>,
}
