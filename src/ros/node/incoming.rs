//! Incoming messages, validated and converted to the types of this crate.

use super::notices::MessageError;
use super::zones::{FILTER_INFO, KEEPOUT_MASK, SPEED_MASK};
use crate::geometry::{Pose, Twist, wrap_angle};
use crate::localization::PoseHint;
use crate::map::{GridFrame, OccupancyGrid};
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
/// The topic of the map.
pub const MAP: &str = "map";
/// The name of the action.
pub const NAVIGATE: &str = "navigate_to_pose";

/// Declares the messages of other nodes: the kind of the frame that passes them to the control process, the message in it, and
/// the topic or service with the name of its type.
macro_rules! incoming_messages {
    ($($(#[$doc:meta])* $kind:literal $name:ident($payload:ty: $message:ident) $topic:expr, $type:literal;)*) => {
        /// A received message.
        #[derive(Clone, Debug, PartialEq)]
        #[non_exhaustive]
        pub enum IncomingMessage {
            $($(#[$doc])* $name($payload),)*
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
            /// Another node reads `cmd_vel` or publishes another topic with another type, or no longer does.
            OtherType {
                /// The topic.
                topic: &'static str,
                /// The type of this node, with its package.
                expected: String,
                /// The type of the other node, if there is one.
                found: Option<String>,
            },
        }

        impl IncomingMessage {
            /// The static names of a topic and of its type.
            pub(super) fn topic_and_type(topic: &str) -> Option<(&'static str, &'static str)> {
                let known = [$(($topic, $type),)* (COMMAND, "Twist")];
                known.into_iter().find(|(name, _)| *name == topic)
            }

            #[cfg(test)]
            pub(super) fn topics() -> impl Iterator<Item = &'static str> {
                [$($topic,)* COMMAND].into_iter()
            }

            /// The topic of the message, relative to the namespace, without rules that remap it.
            #[must_use]
            pub const fn topic(&self) -> &'static str {
                match self {
                    $(Self::$name(_) => $topic,)*
                    Self::Undecodable { topic, .. }
                    | Self::Unmatched { topic, .. }
                    | Self::OtherPublisher { topic, .. }
                    | Self::OtherType { topic, .. } => topic,
                }
            }

            /// Kind and payload of the frame.
            pub(super) fn to_parts(&self) -> (u8, Vec<u8>) {
                let report = |kind, topic: &str, value: String| {
                    (kind, msg::KeyValue { key: topic.to_owned(), value }.to_cdr())
                };
                match self {
                    $(Self::$name(message) => ($kind, message.to_cdr()),)*
                    Self::Undecodable { topic, reason, .. } => report(8, topic, reason.clone()),
                    Self::Unmatched { topic, expected } => report(19, topic, expected.clone()),
                    Self::OtherPublisher { topic, is_present } => {
                        report(20, topic, is_present.to_string())
                    }
                    Self::OtherType { topic, expected, found } => {
                        let found = found.as_deref().unwrap_or_default();
                        report(22, topic, format!("{expected} {found}"))
                    }
                }
            }

            /// The message with a kind and a payload, or nothing if they are invalid.
            pub(super) fn from_parts(kind: u8, payload: &[u8]) -> Option<Self> {
                match kind {
                    $($kind => Some(Self::$name(msg::$message::from_cdr(payload)?.into())),)*
                    8 | 19 | 20 | 22 => {
                        let msg::KeyValue { key, value } = Message::from_cdr(payload)?;
                        let (topic, expected) = Self::topic_and_type(&key)?;
                        Some(match kind {
                            8 => Self::Undecodable { topic, expected, reason: value },
                            19 => Self::Unmatched { topic, expected: value },
                            20 => Self::OtherPublisher { topic, is_present: value.parse().ok()? },
                            _ => {
                                let (expected, found) = value.split_once(' ')?;
                                let found = (!found.is_empty()).then(|| found.to_owned());
                                Self::OtherType { topic, expected: expected.to_owned(), found }
                            }
                        })
                    }
                    _ => None,
                }
            }
        }
    };
}

incoming_messages! {
    /// On `map`.
    2 Map(msg::OccupancyGrid: OccupancyGrid) MAP, "OccupancyGrid";
    /// On `scan`.
    3 Scan(msg::LaserScan: LaserScan) "scan", "LaserScan";
    /// On `odom`.
    4 Odometry(Box<msg::Odometry>: Odometry) "odom", "Odometry";
    /// On `goal_pose`.
    5 Goal(msg::PoseStamped: PoseStamped) "goal_pose", "PoseStamped";
    /// On `tf`.
    6 Transforms(msg::TFMessage: TFMessage) "tf", "TFMessage";
    /// On `tf_static`.
    7 StaticTransforms(msg::TFMessage: TFMessage) "tf_static", "TFMessage";
    /// On `inbye/arm`: true arms the robot, false disarms it.
    9 Arm(msg::Bool: Bool) "inbye/arm", "Bool";
    /// On `inbye/stop`: true stops the robot until it is armed again; false changes nothing.
    10 Stop(msg::Bool: Bool) "inbye/stop", "Bool";
    /// On `initialpose`: about where the robot is.
    11 InitialPose(Box<msg::PoseWithCovarianceStamped>: PoseWithCovarianceStamped) "initialpose", "PoseWithCovarianceStamped";
    /// On `keepout_filter_mask`: closed zones.
    12 KeepoutMask(msg::OccupancyGrid: OccupancyGrid) KEEPOUT_MASK, "OccupancyGrid";
    /// On `speed_filter_mask`: zones with a speed limit.
    13 SpeedMask(msg::OccupancyGrid: OccupancyGrid) SPEED_MASK, "OccupancyGrid";
    /// On `costmap_filter_info`: what the speed mask means.
    14 FilterInfo(msg::CostmapFilterInfo: CostmapFilterInfo) FILTER_INFO, "CostmapFilterInfo";
    /// On `speed_limit`: a limit for everywhere.
    15 SpeedLimit(msg::SpeedLimit: SpeedLimit) "speed_limit", "SpeedLimit";
    /// A goal of the action `navigate_to_pose`.
    16 Navigate(Box<msg::ActionGoal>: ActionGoal) NAVIGATE, "NavigateToPose";
    /// A request to cancel goals of that action.
    17 Cancel(msg::ActionCancel: ActionCancel) NAVIGATE, "NavigateToPose";
    /// A request to change the state of the node.
    18 ChangeState(msg::LifecycleRequest: LifecycleRequest) CHANGE_STATE, "ChangeState";
    /// A request for the result of a goal of the action that has not ended.
    21 ResultRequest(msg::ActionResultRequest: ActionResultRequest) NAVIGATE, "NavigateToPose";
}

impl IncomingMessage {
    /// Whether a node published the message, on a topic or to a service. The others are reports of the transport.
    pub(super) const fn is_published(&self) -> bool {
        !matches!(
            self,
            Self::Unmatched { .. } | Self::OtherPublisher { .. } | Self::OtherType { .. }
        )
    }

    /// Whether the message is a goal.
    pub(super) const fn is_goal(&self) -> bool {
        matches!(self, Self::Goal(_) | Self::Navigate(_))
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
        let side = |cells: u32| i32::try_from(cells).unwrap_or(i32::MAX);
        let resolution_m = shortest_decimal(info.resolution);
        let frame = GridFrame::new(side(info.width), side(info.height), resolution_m, origin)?;
        Ok(Self {
            frame: frame_name("header.frame_id", &message.header.frame_id)?,
            grid: OccupancyGrid::from_cells(frame, message.data.clone())?,
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

/// A goal in a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct GoalInput {
    pub frame: String,
    /// Zero for the time of its arrival.
    pub stamp: Time,
    pub goal: Goal,
}

impl GoalInput {
    /// Converts a message. An orientation of four zeros leaves the yaw free.
    ///
    /// # Errors
    /// When the pose or the frame is invalid.
    pub fn new(message: &msg::PoseStamped) -> Result<Self, MessageError> {
        let frame = frame_name("header.frame_id", &message.header.frame_id)?;
        let mut pose = message.pose;
        let msg::Quaternion { x, y, z, w } = pose.orientation;
        let is_yaw_free = [x, y, z, w] == [0.0; 4];
        if is_yaw_free {
            pose.orientation = msg::Quaternion::default();
        }
        let pose = planar_pose("pose", &pose)?;
        let yaw = (!is_yaw_free).then_some(pose.yaw);
        let goal = Goal { position: pose.position(), yaw };
        Ok(Self { frame, stamp: message.header.stamp, goal })
    }

    /// The goal in another frame, in which its own has this pose.
    pub fn transformed(&self, frame: &str, pose: &Pose) -> Self {
        let Goal { position, yaw } = self.goal;
        let goal = Goal {
            position: pose.transform(&position),
            yaw: yaw.map(|yaw| wrap_angle(pose.yaw + yaw)),
        };
        Self { frame: frame.to_owned(), stamp: self.stamp, goal }
    }
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
/// As [`check_pose`], and when the pose is tilted by more than 60 degrees.
pub fn planar_pose(field: &'static str, pose: &msg::Pose) -> Result<Pose, MessageError> {
    check_pose(field, pose)?;
    let yaw = upright_yaw(&pose.orientation).ok_or(MessageError::Tilted(field))?;
    Ok(Pose::new(pose.position.x, pose.position.y, yaw))
}

/// Checks the numbers of a pose.
///
/// # Errors
/// When a number is not finite, the position is too far away, or the quaternion is invalid.
pub fn check_pose(field: &'static str, pose: &msg::Pose) -> Result<(), MessageError> {
    let position = &pose.position;
    let msg::Quaternion { x, y, z, w } = pose.orientation;
    let numbers = [position.x, position.y, position.z, x, y, z, w];
    if numbers.iter().any(|number| !number.is_finite()) {
        return Err(MessageError::NotFinite(field));
    }
    if position.x.abs().max(position.y.abs()).max(position.z.abs()) > MAX_POSITION_M {
        return Err(MessageError::TooFar { field, max_m: MAX_POSITION_M });
    }
    let length = libm::sqrt(x * x + y * y + z * z + w * w);
    if (length - 1.0).abs() > QUATERNION_TOLERANCE {
        return Err(MessageError::BadQuaternion { field, length });
    }
    Ok(())
}

/// The yaw of a rotation; none if it tilts the z axis by more than 60 degrees.
pub fn upright_yaw(rotation: &msg::Quaternion) -> Option<f64> {
    let msg::Quaternion { x, y, z, w } = *rotation;
    let is_upright = 1.0 - 2.0 * (x * x + y * y) >= MIN_UPRIGHT;
    is_upright.then(|| libm::atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)))
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
