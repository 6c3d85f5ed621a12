//! Why a message is not used.

use thiserror::Error;

use crate::map::MapError;

/// What is wrong with a message. It is refused as a whole, and what was known before stays.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum MessageError {
    /// The bytes are not the message that the topic is for.
    #[error("it cannot be decoded ({reason}): the topic's type must be {expected}")]
    Undecodable {
        /// As the decoder says it.
        reason: String,
        /// The type.
        expected: &'static str,
    },
    /// A number that is infinite or NaN.
    #[error("{field} is not finite")]
    NotFinite {
        /// Where.
        field: &'static str,
    },
    /// A rotation that is none.
    #[error(
        "the quaternion of {field} has length {length}: it must be 1; (0, 0, 0, 1) is no rotation"
    )]
    BadQuaternion {
        /// Where.
        field: &'static str,
        /// As given.
        length: f64,
    },
    /// A pose that is not on the ground.
    #[error("{field} is turned over: its z axis must point up, for the robot drives in the plane")]
    TurnedOver {
        /// Where.
        field: &'static str,
    },
    /// A goal in a frame of its own.
    #[error("it is in the frame `{found}`, the map in `{expected}`: give it in the map's frame")]
    WrongFrame {
        /// Of the message.
        found: String,
        /// Of the map.
        expected: String,
    },
    /// A frame without a name.
    #[error("its {field} is empty: name the frame")]
    NoFrame {
        /// Which.
        field: &'static str,
    },
    /// A map whose cells are not as many as its size says.
    #[error("it has {found} cells, but {width} columns and {height} rows")]
    WrongCellCount {
        /// As they came.
        found: usize,
        /// As stated.
        width: u32,
        /// As stated.
        height: u32,
    },
    /// A value that no cell can have.
    #[error("cell {index} is {value}: it must be 0 to 100, or -1 for unknown")]
    BadCell {
        /// Position in the data.
        index: usize,
        /// As given.
        value: i8,
    },
    /// A map with an impossible size or resolution.
    #[error(transparent)]
    Map(#[from] MapError),
    /// A scan whose angles and ranges do not fit together.
    #[error(
        "it has {found} ranges, but {expected} beams from angle_min to angle_max by angle_increment"
    )]
    WrongBeamCount {
        /// As they came.
        found: usize,
        /// By the angles.
        expected: f64,
    },
    /// A scan with an impossible number.
    #[error("{field} is {value}: it must be {expected}")]
    OutOfRange {
        /// Which.
        field: &'static str,
        /// As given.
        value: f64,
        /// What would be accepted.
        expected: &'static str,
    },
    /// A scan that came before, or one from before the last.
    #[error("its stamp is not after that of the scan before: it says nothing new")]
    NotNewer,
}

/// Why a node cannot join the others.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum NodeError {
    /// A namespace that ROS does not allow.
    #[error(
        "the namespace `{namespace}` cannot be used ({reason}): begin with a slash, then letters, digits and single \
         underscores, such as /robot1"
    )]
    BadNamespace {
        /// As given.
        namespace: String,
        /// In the library's words.
        reason: String,
    },
    /// DDS could not be started.
    #[error(
        "DDS cannot start ({reason}): check that a network interface is up and the domain's ports are free"
    )]
    NoWire {
        /// In the library's words.
        reason: String,
    },
}
