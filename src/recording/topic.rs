//! What is recorded under which name.

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
    /// Where the robot and its odometry's frame are, at each tick.
    Transforms,
    /// The dynamic window and the moving obstacles, at each tick.
    Markers,
    /// Latency, mode and counters, at each tick.
    Diagnostics,
    /// Observation and decision to the bit, at each tick.
    Tick,
}

impl Topic {
    /// All of them, in the order of their numbers.
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

    /// Its name in ROS.
    #[must_use]
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

    /// Package and name of its messages' type.
    pub(super) const fn message(self) -> (&'static str, &'static str) {
        match self {
            Self::Map => ("nav_msgs", "OccupancyGrid"),
            Self::Plan => ("nav_msgs", "Path"),
            Self::Scan => ("sensor_msgs", "LaserScan"),
            Self::Odometry => ("nav_msgs", "Odometry"),
            Self::Command => ("geometry_msgs", "TwistStamped"),
            Self::Transforms => ("tf2_msgs", "TFMessage"),
            Self::Markers => ("visualization_msgs", "MarkerArray"),
            Self::Diagnostics => ("diagnostic_msgs", "DiagnosticArray"),
            Self::Tick => ("inbye_msgs", "Tick"),
        }
    }

    /// Quality of service as `rosbag2` keeps it: a map and a plan for who comes late, a scan that may be lost.
    pub(super) fn quality_of_service(self) -> String {
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

/// The numbers of `rmw/types.h`.
const RELIABLE: u8 = 1;
const BEST_EFFORT: u8 = 2;
const TRANSIENT_LOCAL: u8 = 1;
const VOLATILE: u8 = 2;
