//! `inbye node`.

use std::path::PathBuf;

use clap::Args;

use super::arguments::{EngineArguments, duration, whole};

/// `inbye node`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  inbye node --config robot.toml --namespace /rover --arm --for 60\n\n\
    Subscriptions, with the names and types of ROS 2: map (OccupancyGrid, latched), scan (LaserScan), odom (Odometry), goal_pose \
    (PoseStamped, in a frame that is connected to the map's), initialpose (PoseWithCovarianceStamped), \
    keepout_filter_mask and speed_filter_mask (OccupancyGrid, latched), costmap_filter_info (CostmapFilterInfo), speed_limit (SpeedLimit), tf and \
    tf_static, inbye/arm and inbye/stop (Bool). Publications: cmd_vel (Twist, or \
    TwistStamped with --stamped), plan (Path, latched), local_markers (MarkerArray), diagnostics (DiagnosticArray), tf and inbye/updated_map (with \
    pose_source = \"scans\"). All names are \
    within the namespace, tf too; --remap renames them.\n\
    Action: navigate_to_pose (NavigateToPose), with feedback, cancel and result. By default its services work with \
    clients on rmw_fastrtps_cpp; with RMW_IMPLEMENTATION=rmw_cyclonedds_cpp they work with clients on Cyclone DDS.\n\
    With --managed the node starts unconfigured, has the services inbye/change_state, inbye/get_state and inbye/get_available_transitions, and \
    pursues goals once it is activated.\n\
    The robot moves only while it is armed: by --arm, the typed word `arm`, POST /arm on --operator-port, or true on inbye/arm. A \
    goal never arms it. Enter, POST /stop, or true on inbye/stop stops it until it is armed again. Every velocity passes the \
    protective layer ([collision_monitor] in the settings), which limits it by the raw scan.\n\
    The robot's pose is the odometry's pose, transformed to the map's frame by tf. With --odom-is-map, or if both frames have the \
    same name, it needs no tf. With pose_source = \"scans\" the node localises the robot on the map itself, near initialpose or on the whole \
    map, and publishes the transform of the odometry's frame. The lidar's pose on the robot comes from tf at the scan's stamp; a scan from a frame that tf does not \
    know is rejected. The stamps of scan and odometry compensate the motion during a scan.\n\
    Without a goal the node publishes no velocity. With a goal it publishes a velocity at each control_period_s. The robot brakes to \
    zero while map, scan or odometry are missing, or while a scan (scan_timeout_s), the odometry (odometry_timeout_s) or a transform \
    on tf (transform_timeout_s) is too old. It continues afterwards. Ages are those of the stamps: synchronise the clocks of all \
    machines (chrony, NTP). Messages whose stamps are more than max_clock_ahead_s in the future are rejected. Simulated time (use_sim_time) is not supported. The node \
    aborts the goal if scans are missing for longer than sensor_fault_patience_s. When a new goal comes or the \
    map changes, the robot continues to drive and the node plans in the background. A goal within a tenth of the goal tolerances of the present one is not a new one. An orientation of four zeros leaves the goal's yaw free. After a \
    goal the node publishes zero for a second, and at its own end for 0.25 s. At its end it aborts its goal.\n\
    ROS_DOMAIN_ID selects the domain. ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST, or ROS_LOCALHOST_ONLY=1, restricts discovery to \
    this machine. SUBNET and SYSTEM_DEFAULT are the default; OFF is an error. DDS runs in a separate process with a memory limit (network_memory_mib). If that process ends or hangs, the robot \
    brakes to zero and the process is started again. If the node itself ends or hangs, that process publishes zeros. For the time \
    in between, the base must have its own timeout on cmd_vel. The program must be built with `--features ros2`; it needs no ROS installation."
)]
pub struct NodeArguments {
    /// Settings, TOML: those of `inbye drive`.
    #[arg(long, value_name = "FILE.toml")]
    pub config: Option<PathBuf>,
    #[command(flatten)]
    pub names: NameArguments,
    #[command(flatten)]
    pub engine: EngineArguments,
    /// Publish `cmd_vel` as `TwistStamped`, which newer releases of Nav2 and `ros2_control` expect.
    #[arg(long, conflicts_with = "unstamped")]
    pub stamped: bool,
    /// Publish `cmd_vel` as `Twist`: the default.
    #[arg(long)]
    pub unstamped: bool,
    /// Treat the odometry frame as the map frame.
    #[arg(long)]
    pub odom_is_map: bool,
    #[command(flatten)]
    pub lifecycle: LifecycleArguments,
    #[command(flatten)]
    pub operator: OperatorArguments,
    /// Duration of the run, seconds [default: until Ctrl-C].
    #[arg(long = "for", value_name = "S", allow_negative_numbers = true, value_parser = duration)]
    pub for_s: Option<f64>,
    /// Run as the network process of a node, within this memory, MiB.
    #[arg(long, hide = true, value_name = "MIB")]
    pub network_memory_mib: Option<u64>,
}

/// The names of a node in ROS.
#[derive(Debug, Args)]
pub struct NameArguments {
    /// Namespace of node and topics, such as /rover [default: none].
    #[arg(long, value_name = "NS", default_value = "", hide_default_value = true)]
    pub namespace: String,
    /// Rename a topic, a service or the action, such as scan:=/front/scan or ~/arm:=arm; __ns:=/robot1 sets the namespace, and
    /// __node:=NAME the name of the node. Repeatable.
    #[arg(long, short, value_name = "FROM:=TO")]
    pub remap: Vec<String>,
    /// Accept the arguments of ROS 2 launch files: --ros-args -r FROM:=TO.
    #[arg(long)]
    pub ros_args: bool,
}

/// How a node starts.
#[derive(Debug, Args)]
pub struct LifecycleArguments {
    /// Start unconfigured, and wait until a lifecycle manager configures and activates the node.
    #[arg(long)]
    pub managed: bool,
}

/// The operator of a node.
#[derive(Debug, Args)]
pub struct OperatorArguments {
    /// Arm the robot at once. Without it, the robot moves after the word `arm` in the terminal, a request to --operator-port, or a
    /// message on `inbye/arm`.
    #[arg(long)]
    pub arm: bool,
    /// Serve the operator on this port of localhost: POST /arm, POST /stop, GET /status.
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = whole::<u16>(1, 65_535))]
    pub operator_port: Option<u16>,
}

#[cfg(not(feature = "ros2"))]
pub fn run(_arguments: &NodeArguments) -> anyhow::Result<bool> {
    anyhow::bail!(
        "inbye node: this program was built without ROS 2: build it with `cargo build --release --features ros2`"
    )
}

#[cfg(feature = "ros2")]
mod control;
#[cfg(feature = "ros2")]
mod network_process;

#[cfg(feature = "ros2")]
pub fn run(arguments: &NodeArguments) -> anyhow::Result<bool> {
    match arguments.network_memory_mib {
        Some(memory_mib) => network_process::run(arguments, memory_mib),
        None => control::run(arguments),
    }
}
