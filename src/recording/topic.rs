//! The topics of a recording.

use super::tick;
use crate::ros::msg::{
    DiagnosticArray, LaserScan, MarkerArray, Message, OccupancyGrid, Odometry, Path, TFMessage,
    TwistStamped,
};

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
    /// Latency, mode and counters of each tick.
    Diagnostics,
    /// Observation and decision of each tick to the bit.
    Tick,
}

impl Topic {
    /// All topics in the order of their numbers.
    pub const ALL: [Self; 9] = [
        Self::Map,
        Self::Plan,
        Self::Scan,
        Self::Odometry,
        Self::Command,
        Self::Transforms,
        Self::Markers,
        Self::Diagnostics,
        Self::Tick,
    ];

    /// The name of the topic in ROS.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Map => "/map",
            Self::Plan => "/plan",
            Self::Scan => "/scan",
            Self::Odometry => "/odom",
            Self::Command => "/cmd_vel",
            Self::Transforms => "/tf",
            Self::Markers => "/local_plan/markers",
            Self::Diagnostics => "/diagnostics",
            Self::Tick => "/inbye/tick",
        }
    }

    /// The name of the message type, such as `nav_msgs/msg/Path`, and its schema.
    pub fn message_type(self) -> (String, String) {
        fn of<M: Message>() -> (String, String) {
            (format!("{}/msg/{}", M::PACKAGE, M::NAME), M::schema())
        }
        match self {
            Self::Map => of::<OccupancyGrid>(),
            Self::Plan => of::<Path>(),
            Self::Scan => of::<LaserScan>(),
            Self::Odometry => of::<Odometry>(),
            Self::Command => of::<TwistStamped>(),
            Self::Transforms => of::<TFMessage>(),
            Self::Markers => of::<MarkerArray>(),
            Self::Diagnostics => of::<DiagnosticArray>(),
            Self::Tick => ("inbye_msgs/msg/Tick".to_owned(), tick::schema()),
        }
    }

    /// The quality of service in the format of `rosbag2`: map and plan also for late subscribers, scans with possible loss.
    pub fn quality_of_service(self) -> String {
        let (depth, reliability, durability) = match self {
            Self::Map | Self::Plan => (1, RELIABLE, TRANSIENT_LOCAL),
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
