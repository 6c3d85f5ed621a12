//! ROS 2 message types: each is declared once, for CDR and for its definition.
//!
//! CDR has no field names: the order of the fields is the format. The types are those of the repositories
//! `ros2/common_interfaces`, `ros2/geometry2` (`tf2_msgs`) and `ros2/rcl_interfaces` (`builtin_interfaces`). A covariance is
//! 6 rows of 6 numbers here and `float64[36]` there: the bytes are the same.

mod common;
pub(crate) mod declaration;
mod geometry;
mod nav;
mod visualization;

pub use common::{Byte, DiagnosticArray, DiagnosticStatus, Duration, Header, KeyValue, Time};
pub use declaration::{FieldType, Message};
pub use geometry::{
    Point, Pose, PoseStamped, PoseWithCovariance, Quaternion, TFMessage, Transform,
    TransformStamped, Twist, TwistStamped, TwistWithCovariance, Vector3,
};
pub use nav::{LaserScan, MapMetaData, OccupancyGrid, Odometry, Path};
pub use visualization::{ColorRGBA, CompressedImage, Marker, MarkerArray, MeshFile, UVCoordinate};
