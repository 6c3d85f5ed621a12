//! Incoming messages, validated and converted to the types of this crate.

use super::notices::MessageError;
use super::zones::{KEEPOUT_MASK, SPEED_MASK};
use crate::geometry::{Point, Pose, Twist};
use crate::localization::PoseHint;
use crate::map::{GridFrame, OccupancyGrid, UNKNOWN};
use crate::navigator::Goal;
use crate::robot::{MAX_RATE, is_plausible};
use crate::ros::msg::{self, Message, Time};

/// Largest coordinate of a position, metres: beyond it the numbers of a map lose centimetres.
const MAX_POSITION_M: f64 = 1e6;
/// Tolerance of the length of a quaternion: some drivers round to few digits.
const QUATERNION_TOLERANCE: f64 = 0.01;
/// Least vertical component of the z axis of a pose: 0.5 is a slope of 60 degrees.
const MIN_UPRIGHT: f64 = 0.5;
/// Standard deviations of a rough pose from `RViz`, metres and radians: half a metre and 15 degrees.
const HINT_SIGMAS: (f64, f64) = (0.5, 0.262);
/// Longest name of a frame, bytes.
const MAX_FRAME_NAME: usize = 256;

/// The service that changes the state of the node.
pub const CHANGE_STATE: &str = "inbye/change_state";
/// The topic of velocities.
pub const COMMAND: &str = "cmd_vel";
/// The name of the action.
pub const NAVIGATE: &str = "navigate_to_pose";

/// A received message.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum IncomingMessage {
    /// On `map`.
    Map(msg::OccupancyGrid),
    /// On `scan`.
    Scan(msg::LaserScan),
    /// On `odom`.
    Odometry(Box<msg::Odometry>),
    /// On `keepout_filter_mask`: closed zones.
    KeepoutMask(msg::OccupancyGrid),
    /// On `speed_filter_mask`: zones with a speed limit.
    SpeedMask(msg::OccupancyGrid),
    /// On `costmap_filter_info`: what the speed mask means.
    FilterInfo(msg::CostmapFilterInfo),
    /// On `speed_limit`: a limit for everywhere.
    SpeedLimit(msg::SpeedLimit),
    /// On `goal_pose`.
    Goal(msg::PoseStamped),
    /// A request to change the state of the node.
    ChangeState(msg::LifecycleRequest),
    /// A goal of the action `navigate_to_pose`.
    Navigate(Box<msg::ActionGoal>),
    /// A request to cancel goals of that action.
    Cancel(msg::ActionCancel),
    /// A request for the result of a goal that has not ended.
    ResultRequest(msg::ActionResultRequest),
    /// On `initialpose`: about where the robot is.
    InitialPose(Box<msg::PoseWithCovarianceStamped>),
    /// On `inbye/arm`: true arms the robot, false disarms it.
    Arm(msg::Bool),
    /// On `inbye/stop`: true stops the robot until it is armed again; false changes nothing.
    Stop(msg::Bool),
    /// On `tf`.
    Transforms(msg::TFMessage),
    /// On `tf_static`.
    StaticTransforms(msg::TFMessage),
    /// Bytes that the decoder rejected.
    Undecodable {
        /// The topic.
        topic: &'static str,
        /// Type of the topic, without its package.
        expected: &'static str,
        /// Message of the decoder.
        reason: String,
    },
    /// A publisher whose messages do not arrive, because the qualities of service do not match.
    Unmatched {
        /// The topic.
        topic: &'static str,
        /// The quality of service that a publisher needs.
        expected: String,
    },
    /// Another node publishes on `cmd_vel` or serves the action, or no longer does.
    OtherPublisher {
        /// The topic, or the name of the action.
        topic: &'static str,
        /// Whether there is one.
        is_present: bool,
    },
}

impl IncomingMessage {
    /// The static names of a topic and of its type.
    pub(super) fn topic_and_type(topic: &str) -> Option<(&'static str, &'static str)> {
        let known = [
            ("map", msg::OccupancyGrid::NAME),
            ("scan", msg::LaserScan::NAME),
            ("odom", msg::Odometry::NAME),
            (KEEPOUT_MASK, msg::OccupancyGrid::NAME),
            (SPEED_MASK, msg::OccupancyGrid::NAME),
            ("costmap_filter_info", msg::CostmapFilterInfo::NAME),
            ("speed_limit", msg::SpeedLimit::NAME),
            ("goal_pose", msg::PoseStamped::NAME),
            (CHANGE_STATE, msg::ChangeStateRequest::NAME),
            (NAVIGATE, msg::NavigateToPoseGoal::NAME),
            ("initialpose", msg::PoseWithCovarianceStamped::NAME),
            ("inbye/arm", msg::Bool::NAME),
            ("inbye/stop", msg::Bool::NAME),
            ("tf", msg::TFMessage::NAME),
            ("tf_static", msg::TFMessage::NAME),
            (COMMAND, msg::Twist::NAME),
        ];
        known.into_iter().find(|(name, _)| *name == topic)
    }

    /// Whether a node published the message, on a topic or to a service. The others are reports of the transport.
    pub(super) const fn is_published(&self) -> bool {
        !matches!(self, Self::Unmatched { .. } | Self::OtherPublisher { .. })
    }

    /// The topic of the message, relative to the namespace.
    #[must_use]
    pub const fn topic(&self) -> &'static str {
        match self {
            Self::Map(_) => "map",
            Self::Scan(_) => "scan",
            Self::Odometry(_) => "odom",
            Self::KeepoutMask(_) => KEEPOUT_MASK,
            Self::SpeedMask(_) => SPEED_MASK,
            Self::FilterInfo(_) => "costmap_filter_info",
            Self::SpeedLimit(_) => "speed_limit",
            Self::Goal(_) => "goal_pose",
            Self::ChangeState(_) => CHANGE_STATE,
            Self::Navigate(_) | Self::Cancel(_) | Self::ResultRequest(_) => NAVIGATE,
            Self::InitialPose(_) => "initialpose",
            Self::Arm(_) => "inbye/arm",
            Self::Stop(_) => "inbye/stop",
            Self::Transforms(_) => "tf",
            Self::StaticTransforms(_) => "tf_static",
            Self::Undecodable { topic, .. }
            | Self::Unmatched { topic, .. }
            | Self::OtherPublisher { topic, .. } => topic,
        }
    }
}

/// A map and its frame, in which the navigator works.
#[derive(Debug, PartialEq)]
pub struct MapInput {
    pub frame: String,
    pub grid: OccupancyGrid,
}

impl MapInput {
    /// Converts a message.
    ///
    /// # Errors
    /// When a frame, a pose or a number is invalid.
    pub fn new(message: &msg::OccupancyGrid) -> Result<Self, MessageError> {
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
    /// Time of the measurement by the sender's clock.
    pub stamp: Time,
    pub frame: String,
    pub base_frame: String,
    pub pose: Pose,
    pub twist: Twist,
}

impl OdometryInput {
    /// Converts a message.
    ///
    /// # Errors
    /// When a frame, a pose or a number is invalid.
    pub fn new(message: &msg::Odometry) -> Result<Self, MessageError> {
        let twist = &message.twist.twist;
        let twist = Twist::new(twist.linear.x, twist.angular.z);
        if !twist.is_finite() {
            return Err(MessageError::NotFinite("twist.twist"));
        }
        if !is_plausible(&twist) {
            return Err(MessageError::TooFast { field: "twist.twist", max: MAX_RATE });
        }
        Ok(Self {
            stamp: message.header.stamp,
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

/// A rough pose and its frame. Its standard deviations are those of the position along its worse axis and of the yaw. A covariance
/// of zeros, as `nav2_simple_commander` sends, stands for that of `RViz`.
///
/// # Errors
/// When the pose, the covariance or the frame is invalid.
pub fn pose_hint(
    message: &msg::PoseWithCovarianceStamped,
) -> Result<(String, PoseHint), MessageError> {
    let frame = frame_name("header.frame_id", &message.header.frame_id)?;
    let msg::PoseWithCovariance { pose, covariance } = &message.pose;
    let pose = planar_pose("pose.pose", pose)?;
    let [[xx, xy, ..], [_, yy, ..], .., [.., yaw]] = *covariance;
    let (mean, half) = (f64::midpoint(xx, yy), (xx - yy) / 2.0);
    let (sigma_m, sigma_rad) = if [xx, xy, yy, yaw] == [0.0; 4] {
        HINT_SIGMAS
    } else {
        ((mean + libm::hypot(half, xy)).sqrt(), yaw.sqrt())
    };
    if !(sigma_m > 0.0 && sigma_rad > 0.0) {
        return Err(MessageError::NoCovariance);
    }
    Ok((frame, PoseHint { pose, sigma_m, sigma_rad }))
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
    if position.x.abs().max(position.y.abs()) > MAX_POSITION_M {
        return Err(MessageError::TooFar { field, max_m: MAX_POSITION_M });
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
/// When the name is empty, too long, or has control characters, which would reach the user's terminal.
pub fn frame_name(field: &'static str, name: &str) -> Result<String, MessageError> {
    match name.strip_prefix('/').unwrap_or(name) {
        "" => Err(MessageError::NoFrame(field)),
        name if name.len() > MAX_FRAME_NAME || name.chars().any(char::is_control) => {
            Err(MessageError::BadFrameName { field, max: MAX_FRAME_NAME })
        }
        name => Ok(name.to_owned()),
    }
}
