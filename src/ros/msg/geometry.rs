//! `geometry_msgs` and `tf2_msgs`.

use super::common::Header;
use super::declaration::messages;

messages! {
    /// A vector.
    #[derive(Copy, Default)]
    geometry_msgs / Vector3 {
        /// Component along or about x.
        x: f64,
        /// Component along or about y.
        y: f64,
        /// Component along or about z.
        z: f64,
    }

    /// A position, metres.
    #[derive(Copy, Default)]
    geometry_msgs / Point {
        /// Position along x.
        x: f64,
        /// Position along y.
        y: f64,
        /// Position along z.
        z: f64,
    }

    /// A rotation as a unit quaternion.
    #[derive(Copy)]
    geometry_msgs / Quaternion {
        /// First imaginary component.
        x: f64 = 0,
        /// Second imaginary component.
        y: f64 = 0,
        /// Third imaginary component.
        z: f64 = 0,
        /// Real component.
        w: f64 = 1,
    }

    /// A pose.
    #[derive(Copy, Default)]
    geometry_msgs / Pose {
        /// Position, metres.
        position: Point,
        /// Rotation.
        orientation: Quaternion,
    }

    /// A pose with time and frame.
    #[derive(Default)]
    geometry_msgs / PoseStamped {
        /// Time and frame.
        header: Header,
        /// The pose.
        pose: Pose,
    }

    /// A pose with its uncertainty.
    #[derive(Copy, Default)]
    geometry_msgs / PoseWithCovariance {
        /// The pose.
        pose: Pose,
        /// Covariance of x, y, z and the rotations about them, row by row.
        covariance: [[f64; 6]; 6],
    }

    /// A velocity.
    #[derive(Copy, Default)]
    geometry_msgs / Twist {
        /// Linear velocity, m/s.
        linear: Vector3,
        /// Angular velocity, rad/s.
        angular: Vector3,
    }

    /// A velocity with time and frame.
    #[derive(Default)]
    geometry_msgs / TwistStamped {
        /// Time and frame.
        header: Header,
        /// The velocity.
        twist: Twist,
    }

    /// A velocity with its uncertainty.
    #[derive(Copy, Default)]
    geometry_msgs / TwistWithCovariance {
        /// The velocity.
        twist: Twist,
        /// Covariance of x, y, z and the rotations about them, row by row.
        covariance: [[f64; 6]; 6],
    }

    /// A transform between two frames.
    #[derive(Copy, Default)]
    geometry_msgs / Transform {
        /// Origin of the child frame in the parent frame, metres.
        translation: Vector3,
        /// Rotation of the child frame in the parent frame.
        rotation: Quaternion,
    }

    /// A transform with its frames.
    #[derive(Default)]
    geometry_msgs / TransformStamped {
        /// Time and parent frame.
        header: Header,
        /// Child frame.
        child_frame_id: String,
        /// Pose of the child frame in the parent frame.
        transform: Transform,
    }

    /// A list of transforms.
    #[derive(Default)]
    tf2_msgs / TFMessage {
        /// The transforms.
        transforms: Vec<TransformStamped>,
    }
}

impl Default for Quaternion {
    /// The identity.
    fn default() -> Self {
        Self { x: 0.0, y: 0.0, z: 0.0, w: 1.0 }
    }
}
