//! Errors of messages and of the node.

use thiserror::Error;

use crate::map::MapError;

/// Why a message is rejected. A rejected message changes nothing.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum MessageError {
    /// The bytes are no message of the topic's type.
    #[error("it cannot be decoded ({reason}): the topic's type must be {expected}")]
    Undecodable {
        /// Message of the decoder.
        reason: String,
        /// Type of the topic.
        expected: &'static str,
    },
    /// A number is infinite or NaN.
    #[error("{field} is not finite")]
    NotFinite {
        /// The field.
        field: &'static str,
    },
    /// A quaternion has the wrong length.
    #[error(
        "the quaternion of {field} has length {length}: it must be 1; (0, 0, 0, 1) is no rotation"
    )]
    BadQuaternion {
        /// The field.
        field: &'static str,
        /// Length of the quaternion.
        length: f64,
    },
    /// A pose is not on the ground plane.
    #[error("{field} is tilted: its z axis must point up, because the robot drives in a plane")]
    Tilted {
        /// The field.
        field: &'static str,
    },
    /// A goal is in another frame than the map.
    #[error("it is in the frame `{found}`, the map in `{expected}`: send it in the map's frame")]
    WrongFrame {
        /// Frame of the message.
        found: String,
        /// Frame of the map.
        expected: String,
    },
    /// A frame has no name.
    #[error("its {field} is empty: name the frame")]
    NoFrame {
        /// The field.
        field: &'static str,
    },
    /// The number of cells does not match the size of the map.
    #[error("it has {found} cells, but {width} columns and {height} rows")]
    WrongCellCount {
        /// Number of cells.
        found: usize,
        /// Number of columns.
        width: u32,
        /// Number of rows.
        height: u32,
    },
    /// A cell has an invalid value.
    #[error("cell {index} is {value}: it must be 0 to 100, or -1 for unknown")]
    BadCell {
        /// Index of the cell.
        index: usize,
        /// Value of the cell.
        value: i8,
    },
    /// The size or the resolution of a map is invalid.
    #[error(transparent)]
    Map(#[from] MapError),
    /// The number of ranges does not match the angles of the scan.
    #[error(
        "it has {found} ranges, but {expected} beams from angle_min to angle_max by angle_increment"
    )]
    WrongBeamCount {
        /// Number of ranges.
        found: usize,
        /// Number of beams.
        expected: f64,
    },
    /// A number of a scan is out of range.
    #[error("{field} is {value}: it must be {expected}")]
    OutOfRange {
        /// The field.
        field: &'static str,
        /// The number.
        value: f64,
        /// The valid range.
        expected: &'static str,
    },
    /// A scan is a repetition or older than the last.
    #[error(
        "its stamp is not after the stamp of the last scan: check the clock of the lidar's driver"
    )]
    NotNewer,
}

/// The input that the node waits for. Meanwhile the robot brakes to zero.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum MissingInput {
    /// There is no map.
    #[error("no map was received")]
    Map,
    /// There is no odometry.
    #[error("no odometry was received")]
    Odometry,
    /// The last odometry is too old.
    #[error("odometry is no longer received")]
    RecentOdometry,
    /// The transform from the odometry frame to the map frame is unknown.
    #[error(
        "odometry is in the frame `{odometry}` and tf does not connect it to `{map}`: start a localization node, or set \
         odom_is_map"
    )]
    Transform {
        /// Frame of the odometry.
        odometry: String,
        /// Frame of the map.
        map: String,
    },
    /// There is no scan.
    #[error("no scan was received")]
    Scan,
}

/// Why a node cannot start.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum NodeError {
    /// The namespace is invalid in ROS.
    #[error(
        "the namespace `{namespace}` is invalid ({reason}): begin with a slash, then letters, digits and single \
         underscores, such as /robot1"
    )]
    BadNamespace {
        /// The namespace.
        namespace: String,
        /// Message of `ros2-client`.
        reason: String,
    },
    /// DDS cannot start.
    #[error(
        "DDS cannot start ({reason}): check that a network interface is up and the domain's ports are free"
    )]
    Dds {
        /// Message of `ros2-client`.
        reason: String,
    },
}
