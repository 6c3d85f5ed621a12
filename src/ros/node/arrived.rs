//! What comes in, checked and in the crate's own terms.

use std::fmt::{self, Display, Formatter};

use super::frames::frame_name;
use super::{MessageError, plane};
use crate::geometry::{Point, Pose, Twist};
use crate::map::{GridFrame, OccupancyGrid, UNKNOWN};
use crate::navigator::Goal;
use crate::ros::msg;

/// A topic that is listened to.
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
    /// `tf2_msgs/TFMessage`, of frames that move.
    Transforms,
    /// The same, of frames that do not.
    StaticTransforms,
}

impl Topic {
    /// Its name, relative to the namespace.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Map => "map",
            Self::Scan => "scan",
            Self::Odometry => "odom",
            Self::Goal => "goal_pose",
            Self::Transforms => "tf",
            Self::StaticTransforms => "tf_static",
        }
    }

    /// Package and name of its type.
    #[must_use]
    pub const fn type_name(self) -> (&'static str, &'static str) {
        match self {
            Self::Map => ("nav_msgs", "OccupancyGrid"),
            Self::Scan => ("sensor_msgs", "LaserScan"),
            Self::Odometry => ("nav_msgs", "Odometry"),
            Self::Goal => ("geometry_msgs", "PoseStamped"),
            Self::Transforms | Self::StaticTransforms => ("tf2_msgs", "TFMessage"),
        }
    }
}

/// A message that came.
#[derive(Clone, Debug, PartialEq)]
pub enum Arrived {
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
    /// Bytes that are no message of the topic, and the decoder's words.
    Undecodable(Topic, String),
}

impl Arrived {
    /// The topic it came on.
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

/// A map, and the frame that it is given in: the one all poses are in.
#[derive(Debug, PartialEq)]
pub(super) struct Chart {
    pub frame: String,
    pub grid: OccupancyGrid,
}

impl Display for Chart {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let GridFrame {
            width,
            height,
            resolution_m,
            ..
        } = self.grid.frame();
        let frame = &self.frame;
        write!(
            f,
            "{width} by {height} cells of {resolution_m} m in the frame `{frame}`"
        )
    }
}

impl Chart {
    pub fn of(message: &msg::OccupancyGrid) -> Result<Self, MessageError> {
        let info = &message.info;
        let origin = plane::pose(
            "info.origin",
            &info.origin.position,
            &info.origin.orientation,
        )?;
        let cells = &message.data;
        let (width, height) = (info.width, info.height);
        let side = |cells: u32| i32::try_from(cells).unwrap_or(i32::MAX);
        let frame = GridFrame::new(side(width), side(height), decimal(info.resolution), origin)?;
        if cells.len() != frame.len() {
            return Err(MessageError::WrongCellCount {
                found: cells.len(),
                width,
                height,
            });
        }
        let is_bad = |value: &i8| *value != UNKNOWN && !(0..=100).contains(value);
        if let Some(index) = cells.iter().position(is_bad) {
            let value = cells[index];
            return Err(MessageError::BadCell { index, value });
        }
        Ok(Self {
            frame: frame_name("header.frame_id", &message.header.frame_id)?,
            grid: OccupancyGrid::new(frame, cells.clone()),
        })
    }
}

/// The number that a single-precision one was meant to be: 0.05, and not 0.05000000074505806.
fn decimal(single: f32) -> f64 {
    single
        .to_string()
        .parse()
        .unwrap_or_else(|_| f64::from(single))
}

/// Odometry: a pose in its frame, and a motion in the robot's own.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Motion {
    pub frame: String,
    pub base_frame: String,
    pub pose: Pose,
    pub twist: Twist,
}

impl Motion {
    pub fn of(message: &msg::Odometry) -> Result<Self, MessageError> {
        let pose = &message.pose.pose;
        let twist = &message.twist.twist;
        let twist = Twist::new(twist.linear.x, twist.angular.z);
        if !twist.is_finite() {
            let field = "twist.twist";
            return Err(MessageError::NotFinite { field });
        }
        Ok(Self {
            frame: frame_name("header.frame_id", &message.header.frame_id)?,
            base_frame: frame_name("child_frame_id", &message.child_frame_id)?,
            pose: plane::pose("pose.pose", &pose.position, &pose.orientation)?,
            twist,
        })
    }
}

/// A goal in a frame that must be the map's. All zeros for its orientation leave the yaw free.
pub(super) fn goal(message: &msg::PoseStamped) -> Result<(String, Goal), MessageError> {
    let frame = frame_name("header.frame_id", &message.header.frame_id)?;
    let msg::Pose {
        position,
        orientation: turned,
    } = &message.pose;
    let is_free = [turned.x, turned.y, turned.z, turned.w] == [0.0; 4];
    let turned = if is_free { &<_>::default() } else { turned };
    let pose = plane::pose("pose", position, turned)?;
    let goal = Goal {
        position: Point::new(pose.x, pose.y),
        yaw: (!is_free).then_some(pose.yaw),
    };
    Ok((frame, goal))
}
