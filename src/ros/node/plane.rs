//! Poses of the ground out of poses in space.

use super::MessageError;
use crate::geometry::Pose;
use crate::ros::msg;

/// A quaternion's length may be off by so much: some drivers send few digits.
const LENGTH_OFF: f64 = 0.01;
/// The z axis of what stands or drives rises at least so much: 0.5 is a slope of 60 degrees.
const LEAST_UP: f64 = 0.5;

/// The pose on the ground below a pose in space.
///
/// # Errors
/// When a number is not finite, the quaternion none, or the pose on its side.
pub fn pose(
    field: &'static str,
    place: &msg::Vector3,
    turned: &msg::Quaternion,
) -> Result<Pose, MessageError> {
    let msg::Quaternion { x, y, z, w } = *turned;
    let numbers = [place.x, place.y, place.z, x, y, z, w];
    if numbers.iter().any(|number| !number.is_finite()) {
        return Err(MessageError::NotFinite { field });
    }
    let length = libm::sqrt(x * x + y * y + z * z + w * w);
    if (length - 1.0).abs() > LENGTH_OFF {
        return Err(MessageError::BadQuaternion { field, length });
    }
    if 1.0 - 2.0 * (x * x + y * y) < LEAST_UP {
        return Err(MessageError::TurnedOver { field });
    }
    let yaw = libm::atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z));
    Ok(Pose::new(place.x, place.y, yaw))
}

/// A pose on the ground as one in space.
pub fn in_space(pose: &Pose) -> msg::Pose {
    let (sin, cos) = libm::sincos(pose.yaw / 2.0);
    msg::Pose {
        position: msg::Point {
            x: pose.x,
            y: pose.y,
            z: 0.0,
        },
        orientation: msg::Quaternion {
            x: 0.0,
            y: 0.0,
            z: sin,
            w: cos,
        },
    }
}
