//! The topics of a recording and the ROS messages of a tick.

use super::tick;
use crate::base::ProtectiveAction;
use crate::geometry::{Point, Pose};
use crate::map::{OccupancyGrid, Scan};
use crate::navigator::Mode;
use crate::ros::convert::{self, key_value};
use crate::ros::msg::{
    self, DiagnosticArray, DiagnosticStatus, Header, LaserScan, Message, TFMessage, Time,
    TransformStamped,
};
use crate::runtime::{OdometryReading, TickEvent};

/// A topic of a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Topic {
    /// The map, once.
    Map,
    /// Each new global path.
    Plan,
    /// The scan of each tick.
    Scan,
    /// The odometry of each tick.
    Odometry,
    /// The command of each tick.
    Command,
    /// The transforms of each tick.
    Transforms,
    /// The dynamic window and the moving obstacles of each tick.
    Markers,
    /// Latency, mode, counters and the action of the protective layer of each tick.
    Diagnostics,
    /// Observation and decision of each tick to the bit.
    Tick,
    /// The zones, once, if there are any.
    Zones,
    /// The map with what the scans contradicted, before the tick from which on the navigator uses it.
    UpdatedMap,
}

impl Topic {
    /// All topics in the order of their numbers.
    pub const ALL: [Self; 11] = [
        Self::Map,
        Self::Plan,
        Self::Scan,
        Self::Odometry,
        Self::Command,
        Self::Transforms,
        Self::Markers,
        Self::Diagnostics,
        Self::Tick,
        Self::Zones,
        Self::UpdatedMap,
    ];

    /// The name of the topic in ROS.
    pub fn name(self) -> &'static str {
        self.description().0
    }

    /// The name of the topic in ROS, and the name of its message type, such as `nav_msgs/msg/Path`, with its schema.
    pub fn description(self) -> (&'static str, String, String) {
        fn of<M: Message>(topic: &'static str) -> (&'static str, String, String) {
            (topic, format!("{}/msg/{}", M::PACKAGE, M::NAME), M::schema())
        }
        match self {
            Self::Map => of::<msg::OccupancyGrid>("/map"),
            Self::Plan => of::<msg::Path>("/plan"),
            Self::Scan => of::<LaserScan>("/scan"),
            Self::Odometry => of::<msg::Odometry>("/odom"),
            Self::Command => of::<msg::TwistStamped>("/cmd_vel"),
            Self::Transforms => of::<TFMessage>("/tf"),
            Self::Markers => of::<msg::MarkerArray>("/local_plan/markers"),
            Self::Diagnostics => of::<DiagnosticArray>("/diagnostics"),
            Self::Zones => of::<msg::OccupancyGrid>("/zones"),
            Self::UpdatedMap => of::<msg::OccupancyGrid>("/updated_map"),
            Self::Tick => ("/inbye/tick", "inbye_msgs/msg/Tick".to_owned(), tick::schema()),
        }
    }

    /// The quality of service in the format of `rosbag2`: maps, zones and plan also for late subscribers, scans with possible loss.
    pub fn quality_of_service(self) -> String {
        let (depth, reliability, durability) = match self {
            Self::Map | Self::Zones | Self::UpdatedMap | Self::Plan => {
                (1, RELIABLE, TRANSIENT_LOCAL)
            }
            Self::Scan => (5, BEST_EFFORT, VOLATILE),
            Self::Transforms => (100, RELIABLE, VOLATILE),
            _ => (10, RELIABLE, VOLATILE),
        };
        format!(
            "- history: 1\n  depth: {depth}\n  reliability: {reliability}\n  durability: {durability}\n  \
             deadline:\n    sec: 0\n    nsec: 0\n  lifespan:\n    sec: 0\n    nsec: 0\n  liveliness: 1\n  \
             liveliness_lease_duration:\n    sec: 0\n    nsec: 0\n  avoid_ros_namespace_conventions: false"
        )
    }
}

// Constants of `rmw/types.h`.
const RELIABLE: u8 = 1;
const BEST_EFFORT: u8 = 2;
const TRANSIENT_LOCAL: u8 = 1;
const VOLATILE: u8 = 2;

/// The fixed frame (REP-105).
pub const MAP_FRAME: &str = "map";
/// The frame of the odometry, in which the pose never jumps (REP-105).
const ODOM_FRAME: &str = "odom";
/// The robot's frame (REP-105).
pub const BASE_FRAME: &str = "base_link";
/// The frame of the scans of a lidar off the robot's origin: its place, with the axes of the robot's frame.
const LIDAR_FRAME: &str = "lidar";

/// A header with a time in seconds and a frame.
pub fn header(time_s: f64, frame: &str) -> Header {
    Header { stamp: Time::from_seconds(time_s), frame_id: frame.to_owned() }
}

/// A map. Its resolution is rounded to float32.
pub fn map(time_s: f64, grid: &OccupancyGrid) -> msg::OccupancyGrid {
    convert::occupancy_grid(grid, header(time_s, MAP_FRAME))
}

/// A scan of a lidar with a shortest range. All numbers are rounded to float32.
pub fn laser_scan(time_s: f64, scan: &Scan, range_min_m: f64) -> LaserScan {
    let frame = if is_at_robot(&scan.origin) { BASE_FRAME } else { LIDAR_FRAME };
    LaserScan {
        header: header(time_s, frame),
        angle_min: scan.angle_min as f32,
        angle_max: scan.angle(scan.ranges.len().saturating_sub(1)) as f32,
        angle_increment: scan.angle_increment as f32,
        // All beams have one time: those of a real lidar are compensated for the robot's motion.
        time_increment: 0.0,
        scan_time: 0.0,
        range_min: range_min_m as f32,
        range_max: scan.range_max as f32,
        ranges: scan.ranges.iter().map(|&range| range as f32).collect(),
        intensities: Vec::new(),
    }
}

/// The odometry of the base. Its covariances are unknown, which is zero.
pub fn odometry(time_s: f64, reading: &OdometryReading) -> msg::Odometry {
    let mut message = msg::Odometry {
        header: header(time_s, ODOM_FRAME),
        child_frame_id: BASE_FRAME.to_owned(),
        ..msg::Odometry::default()
    };
    message.pose.pose = msg::Pose::from(&reading.pose);
    message.twist.twist = msg::Twist::from(&reading.twist);
    message
}

/// Whether a lidar at this place needs no frame of its own.
fn is_at_robot(lidar: &Point) -> bool {
    *lidar == Point::default()
}

/// The transforms `map` to `odom` to `base_link` of a robot with an estimated pose in the map, if it has one, and a pose in its
/// odometry; and to `lidar`, for a lidar off the robot's origin.
pub fn transforms(
    time_s: f64,
    estimate: Option<&Pose>,
    odometry: &Pose,
    lidar: &Point,
) -> TFMessage {
    let transform = |parent, child: &str, pose: &Pose| TransformStamped {
        header: header(time_s, parent),
        child_frame_id: child.to_owned(),
        transform: msg::Transform::from(pose),
    };
    let in_map =
        estimate.map(|pose| transform(MAP_FRAME, ODOM_FRAME, &pose.frame_origin(odometry)));
    let in_odometry = transform(ODOM_FRAME, BASE_FRAME, odometry);
    let on_robot = || transform(BASE_FRAME, LIDAR_FRAME, &Pose::new(lidar.x, lidar.y, 0.0));
    let on_robot = (!is_at_robot(lidar)).then(on_robot);
    TFMessage { transforms: in_map.into_iter().chain([in_odometry]).chain(on_robot).collect() }
}

/// The state of the navigator and of the protective layer at a tick.
pub fn diagnostics(event: &TickEvent<'_>, engine: &str) -> DiagnosticArray {
    DiagnosticArray {
        header: header(event.observation.time_s, ""),
        status: vec![decision_status(event, engine), protection_status(event.protective_action)],
    }
}

/// What the protective layer of the sender does to the command: its action, and the reason as the message.
fn protection_status(action: &ProtectiveAction) -> DiagnosticStatus {
    let level = if action.passes() { DiagnosticStatus::OK } else { DiagnosticStatus::WARN };
    DiagnosticStatus {
        level,
        name: "inbye: protection".to_owned(),
        message: action.to_string(),
        hardware_id: String::new(),
        values: vec![key_value("action", action.name())],
    }
}

/// Latency, mode and counters of a decision and its navigator.
fn decision_status(event: &TickEvent<'_>, engine: &str) -> DiagnosticStatus {
    let TickEvent { decision, took_s, navigator, .. } = *event;
    let mode = decision.mode;
    let (level, message) = match (navigator.fault(), mode) {
        (Some(fault), _) => (DiagnosticStatus::ERROR, fault.to_string()),
        (None, Mode::Failed) => (DiagnosticStatus::ERROR, mode.name().to_owned()),
        (None, Mode::Blocked | Mode::SensorFault) => {
            (DiagnosticStatus::WARN, mode.name().to_owned())
        }
        (None, _) => (DiagnosticStatus::OK, mode.name().to_owned()),
    };
    let counts = decision.counts.unwrap_or_default();
    let observation_faults: u64 = navigator.observation_faults().values().sum();
    let mut values = vec![
        key_value("mode", mode.name()),
        key_value("latency_ms", took_s * 1e3),
        key_value("admissible", counts.admissible),
        key_value("collision", counts.collision),
        key_value("cannot_stop", counts.cannot_stop),
        key_value("outside", counts.outside),
        key_value("plans", navigator.plans().len()),
        key_value("observation_faults", observation_faults),
    ];
    let motion = navigator.motion();
    values.push(key_value("delay_s", motion.safe_delay_s));
    values.push(key_value("delay_identified", motion.delay_s.is_some()));
    values.push(key_value("acceleration_m_s2", motion.acceleration_m_s2));
    values.push(key_value("braking_m_s2", motion.braking_m_s2));
    if let Some(delay_s) = motion.delay_s {
        values.push(key_value("delay_low_s", delay_s.low));
        values.push(key_value("delay_high_s", delay_s.high));
    }
    if let Some(ratio) = motion.turn_ratio {
        values.push(key_value("turn_ratio", ratio.value));
        values.push(key_value("turn_ratio_low", ratio.low));
        values.push(key_value("turn_ratio_high", ratio.high));
    }
    if let Some(stats) = navigator.deadline_stats() {
        values.push(key_value("deadline_ms", stats.deadline_s * 1e3));
        values.push(key_value("deadline_misses", stats.misses));
    }
    if let Some(incidents) = navigator.planner().incidents() {
        values.push(key_value("gpu_failures", incidents.failures.values().sum::<u64>()));
        values.push(key_value("cpu_ticks", incidents.on_cpu));
    }
    DiagnosticStatus {
        level,
        name: "inbye: decision".to_owned(),
        message,
        hardware_id: engine.to_owned(),
        values,
    }
}
