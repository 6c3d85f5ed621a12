//! What goes out.

use super::plane;
use crate::geometry::{self, Point, Pose, bearing};
use crate::ros::msg;
use crate::ros::msg::{Header, Path, PoseStamped, Time, Twist, TwistStamped, Vector3};

/// What to publish at a tick.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Published {
    /// For `cmd_vel`; none where this node has nothing to say: another may drive.
    pub command: Option<geometry::Twist>,
    /// For `plan`: one that is new.
    pub path: Option<Path>,
    /// For `local_markers`.
    pub markers: Option<msg::MarkerArray>,
    /// For people: what has changed since the tick before, a line each.
    pub notes: Vec<String>,
}

/// A velocity as `geometry_msgs/Twist`.
#[must_use]
pub fn twist(command: &geometry::Twist) -> Twist {
    Twist {
        linear: Vector3 {
            x: command.linear,
            ..Vector3::default()
        },
        angular: Vector3 {
            z: command.angular,
            ..Vector3::default()
        },
    }
}

/// The same with a time and the robot's own frame.
#[must_use]
pub fn twist_stamped(command: &geometry::Twist, stamp: Time, base_frame: &str) -> TwistStamped {
    TwistStamped {
        header: Header {
            stamp,
            frame_id: base_frame.to_owned(),
        },
        twist: twist(command),
    }
}

/// A way as `nav_msgs/Path`: at each point facing the next.
pub(super) fn path(points: &[Point], header: &Header) -> Path {
    let pose = |index: usize| {
        let at = points[index];
        let next = points.get(index + 1);
        let before = index.checked_sub(1).map(|before| &points[before]);
        let yaw = match (next, before) {
            (Some(next), _) => bearing(&at, next),
            (None, Some(before)) => bearing(before, &at),
            (None, None) => 0.0,
        };
        PoseStamped {
            header: header.clone(),
            pose: plane::in_space(&Pose::new(at.x, at.y, yaw)),
        }
    };
    Path {
        header: header.clone(),
        poses: (0..points.len()).map(pose).collect(),
    }
}
