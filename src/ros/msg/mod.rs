//! The messages that a node exchanges, field by field as ROS 2 declares them.
//!
//! CDR knows no names: the order of the fields is the format. Definitions: the repositories
//! `ros2/common_interfaces`, `ros2/geometry2` (`tf2_msgs`) and `ros2/rcl_interfaces` (`builtin_interfaces`). A covariance, 36 numbers row by row there, is 6 rows of 6 here: the bytes are the same.

mod geometry;
mod header;
mod nav;
mod scan;
mod tf;
mod visualization;

pub use geometry::{
    Point, Pose, PoseStamped, PoseWithCovariance, Quaternion, Transform, TransformStamped, Twist,
    TwistStamped, TwistWithCovariance, Vector3,
};
pub use header::{Duration, Header, Time};
pub use nav::{MapMetaData, OccupancyGrid, Odometry, Path};
pub use scan::LaserScan;
pub use tf::TFMessage;
pub use visualization::{
    ColorRGBA, CompressedImage, Marker, MarkerArray, MeshFile, UVCoordinate, action, shape,
};
