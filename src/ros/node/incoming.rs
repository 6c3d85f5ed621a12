//! Incoming messages, validated and converted to the types of this crate.

use super::notices::MessageError;
use crate::geometry::{Point, Pose, Twist};
use crate::map::{GridFrame, OccupancyGrid, UNKNOWN};
use crate::navigator::Goal;
use crate::ros::msg::{self, Message};

/// Tolerance of the length of a quaternion: some drivers round to few digits.
const QUATERNION_TOLERANCE: f64 = 0.01;
/// Least vertical component of the z axis of a pose: 0.5 is a slope of 60 degrees.
const MIN_UPRIGHT: f64 = 0.5;

/// A subscribed topic.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Topic {
    /// `nav_msgs/OccupancyGrid`.
    Map,
    /// `sensor_msgs/LaserScan`.
    Scan,
    /// `nav_msgs/Odometry`.
    Odometry,
    /// `geometry_msgs/PoseStamped`.
    Goal,
    /// `tf2_msgs/TFMessage` of moving frames.
    Transforms,
    /// `tf2_msgs/TFMessage` of static frames.
    StaticTransforms,
}

impl Topic {
    /// The name of the topic, relative to the namespace.
    #[must_use]
    pub const fn name(self) -> &'static str {
        self.name_and_type().0
    }

    /// The name of the topic, and of its message type without the package.
    pub(super) const fn name_and_type(self) -> (&'static str, &'static str) {
        match self {
            Self::Map => ("map", msg::OccupancyGrid::NAME),
            Self::Scan => ("scan", msg::LaserScan::NAME),
            Self::Odometry => ("odom", msg::Odometry::NAME),
            Self::Goal => ("goal_pose", msg::PoseStamped::NAME),
            Self::Transforms => ("tf", msg::TFMessage::NAME),
            Self::StaticTransforms => ("tf_static", msg::TFMessage::NAME),
        }
    }
}

/// A received message.
#[derive(Clone, Debug, PartialEq)]
pub enum IncomingMessage {
    /// On [`Topic::Map`].
    Map(msg::OccupancyGrid),
    /// On [`Topic::Scan`].
    Scan(msg::LaserScan),
    /// On [`Topic::Odometry`].
    Odometry(Box<msg::Odometry>),
    /// On [`Topic::Goal`].
    Goal(msg::PoseStamped),
    /// On [`Topic::Transforms`].
    Transforms(msg::TFMessage),
    /// On [`Topic::StaticTransforms`].
    StaticTransforms(msg::TFMessage),
    /// Bytes that the decoder rejected, with its message.
    Undecodable(Topic, String),
}

impl IncomingMessage {
    /// The topic of the message.
    #[must_use]
    pub const fn topic(&self) -> Topic {
        match self {
            Self::Map(_) => Topic::Map,
            Self::Scan(_) => Topic::Scan,
            Self::Odometry(_) => Topic::Odometry,
            Self::Goal(_) => Topic::Goal,
            Self::Transforms(_) => Topic::Transforms,
            Self::StaticTransforms(_) => Topic::StaticTransforms,
            Self::Undecodable(topic, _) => *topic,
        }
    }
}

/// A map and its frame, in which the navigator works.
#[derive(Debug, PartialEq)]
pub struct MapInput {
    pub frame: String,
    pub grid: OccupancyGrid,
}

impl TryFrom<&msg::OccupancyGrid> for MapInput {
    type Error = MessageError;

    fn try_from(message: &msg::OccupancyGrid) -> Result<Self, MessageError> {
        let info = &message.info;
        let origin = planar_pose("info.origin", &info.origin)?;
        let cells = &message.data;
        let (width, height) = (info.width, info.height);
        let side = |cells: u32| i32::try_from(cells).unwrap_or(i32::MAX);
        let resolution_m = shortest_decimal(info.resolution);
        let frame = GridFrame::new(side(width), side(height), resolution_m, origin)?;
        if cells.len() != frame.len() {
            return Err(MessageError::WrongCellCount { found: cells.len(), width, height });
        }
        let is_bad = |value: &i8| *value != UNKNOWN && !(0..=100).contains(value);
        if let Some(index) = cells.iter().position(is_bad) {
            return Err(MessageError::BadCell { index, value: cells[index] });
        }
        Ok(Self {
            frame: frame_name("header.frame_id", &message.header.frame_id)?,
            grid: OccupancyGrid::new(frame, cells.clone()),
        })
    }
}

/// The shortest decimal of a float32: 0.05 instead of 0.05000000074505806.
fn shortest_decimal(single: f32) -> f64 {
    single.to_string().parse().unwrap_or_else(|_| f64::from(single))
}

/// Odometry: a pose in its frame and a velocity in the base frame.
#[derive(Clone, Debug, PartialEq)]
pub struct OdometryInput {
    pub frame: String,
    pub base_frame: String,
    pub pose: Pose,
    pub twist: Twist,
}

impl TryFrom<&msg::Odometry> for OdometryInput {
    type Error = MessageError;

    fn try_from(message: &msg::Odometry) -> Result<Self, MessageError> {
        let twist = &message.twist.twist;
        let twist = Twist::new(twist.linear.x, twist.angular.z);
        if !twist.is_finite() {
            return Err(MessageError::NotFinite("twist.twist"));
        }
        Ok(Self {
            frame: frame_name("header.frame_id", &message.header.frame_id)?,
            base_frame: frame_name("child_frame_id", &message.child_frame_id)?,
            pose: planar_pose("pose.pose", &message.pose.pose)?,
            twist,
        })
    }
}

/// A goal and its frame. An orientation of four zeros leaves the yaw free.
///
/// # Errors
/// When the pose or the frame is invalid.
pub fn goal(message: &msg::PoseStamped) -> Result<(String, Goal), MessageError> {
    let frame = frame_name("header.frame_id", &message.header.frame_id)?;
    let mut pose = message.pose;
    let msg::Quaternion { x, y, z, w } = pose.orientation;
    let is_yaw_free = [x, y, z, w] == [0.0; 4];
    if is_yaw_free {
        pose.orientation = msg::Quaternion::default();
    }
    let pose = planar_pose("pose", &pose)?;
    let goal =
        Goal { position: Point::new(pose.x, pose.y), yaw: (!is_yaw_free).then_some(pose.yaw) };
    Ok((frame, goal))
}

/// Projects a pose on the ground plane.
///
/// # Errors
/// When a number is not finite, the quaternion is invalid, or the pose is tilted by more than 60 degrees.
pub fn planar_pose(field: &'static str, pose: &msg::Pose) -> Result<Pose, MessageError> {
    let position = &pose.position;
    let msg::Quaternion { x, y, z, w } = pose.orientation;
    let numbers = [position.x, position.y, position.z, x, y, z, w];
    if numbers.iter().any(|number| !number.is_finite()) {
        return Err(MessageError::NotFinite(field));
    }
    let length = libm::sqrt(x * x + y * y + z * z + w * w);
    if (length - 1.0).abs() > QUATERNION_TOLERANCE {
        return Err(MessageError::BadQuaternion { field, length });
    }
    if 1.0 - 2.0 * (x * x + y * y) < MIN_UPRIGHT {
        return Err(MessageError::Tilted(field));
    }
    let yaw = libm::atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z));
    Ok(Pose::new(position.x, position.y, yaw))
}

/// The name of a frame without the leading slash of ROS 1.
///
/// # Errors
/// When the name is empty.
pub fn frame_name(field: &'static str, name: &str) -> Result<String, MessageError> {
    match name.strip_prefix('/').unwrap_or(name) {
        "" => Err(MessageError::NoFrame(field)),
        name => Ok(name.to_owned()),
    }
}
