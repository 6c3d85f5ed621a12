//! ROS 2 message types: each is declared once, for CDR and for its definition.
//!
//! CDR has no field names: the order of the fields is the format. The types are those of the repositories
//! `ros2/common_interfaces`, `ros2/geometry2` (`tf2_msgs`), `ros2/rcl_interfaces` (`builtin_interfaces`) and
//! `ros-navigation/navigation2` (`nav2_msgs`). A covariance is
//! 6 rows of 6 numbers here and `float64[36]` there: the bytes are the same.

pub(crate) mod declaration;
mod lifecycle;
mod nav2;

pub use declaration::Message;
pub use lifecycle::{
    ChangeStateRequest, ChangeStateResponse, EmptyRequest, GetAvailableTransitionsResponse,
    GetStateResponse, LifecycleAnswer, LifecycleRequest, State, Transition, TransitionDescription,
    TransitionEvent,
};
pub use nav2::{
    ActionAnswer, ActionCancel, ActionCancelAnswer, ActionEnd, ActionFeedback, ActionGoal,
    ActionResultRequest, CostmapFilterInfo, NavigateToPoseFeedback, NavigateToPoseGoal,
    NavigateToPoseResult, SpeedLimit,
};

use declaration::{Decoder, Encoder, FieldType, messages};

messages! {
    /// A time since 1970, or zero if it is unknown.
    #[derive(Copy, Default, Eq, PartialOrd, Ord)]
    builtin_interfaces / Time {
        /// Whole seconds.
        sec: i32,
        /// Nanoseconds, 0 to 999,999,999.
        nanosec: u32,
    }

    /// A duration.
    #[derive(Copy, Default, Eq)]
    builtin_interfaces / Duration {
        /// Whole seconds.
        sec: i32,
        /// Nanoseconds, 0 to 999,999,999.
        nanosec: u32,
    }

    /// Time and frame of data.
    #[derive(Default, Eq)]
    std_msgs / Header {
        /// Time of the measurement.
        stamp: Time,
        /// Frame of the data.
        frame_id: String,
    }

    /// A named value.
    #[derive(Default, Eq)]
    diagnostic_msgs / KeyValue {
        /// The name.
        key: String,
        /// The value as text.
        value: String,
    }

    /// The status of a component.
    #[derive(Default, Eq)]
    diagnostic_msgs / DiagnosticStatus {
        [OK: Byte = Byte(0), WARN: Byte = Byte(1), ERROR: Byte = Byte(2), STALE: Byte = Byte(3)]
        /// OK, WARN, ERROR or STALE.
        level: Byte,
        /// Name of the component.
        name: String,
        /// Description of the status.
        message: String,
        /// Name of the hardware.
        hardware_id: String,
        /// Values of the status.
        values: Vec<KeyValue>,
    }

    /// The status of several components.
    #[derive(Default, Eq)]
    diagnostic_msgs / DiagnosticArray {
        /// Time and frame.
        header: Header,
        /// The statuses.
        status: Vec<DiagnosticStatus>,
    }
}

/// The field type `byte`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "ros2", derive(serde::Serialize, serde::Deserialize))]
pub struct Byte(pub u8);

impl core::fmt::Display for Byte {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        self.0.fmt(f)
    }
}

impl FieldType for Byte {
    fn type_name() -> String {
        "byte".to_owned()
    }

    fn encode(&self, encoder: &mut Encoder) {
        self.0.encode(encoder);
    }

    fn decode(decoder: &mut Decoder<'_>) -> Option<Self> {
        u8::decode(decoder).map(Self)
    }
}

impl Time {
    /// Whether the time is unknown.
    #[must_use]
    pub const fn is_zero(&self) -> bool {
        self.sec == 0 && self.nanosec == 0
    }

    /// The time in seconds.
    #[must_use]
    pub fn seconds(&self) -> f64 {
        f64::from(self.sec) + f64::from(self.nanosec) * 1e-9
    }
}

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

    /// A pose with its uncertainty, time and frame.
    #[derive(Default)]
    geometry_msgs / PoseWithCovarianceStamped {
        /// Time and frame.
        header: Header,
        /// The pose.
        pose: PoseWithCovariance,
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

messages! {
    /// Size and position of a map.
    #[derive(Copy, Default)]
    nav_msgs / MapMetaData {
        /// Time at which the map was loaded.
        map_load_time: Time,
        /// Side of a cell, metres.
        resolution: f32,
        /// Number of columns.
        width: u32,
        /// Number of rows.
        height: u32,
        /// Pose of the lower left corner of cell (0, 0).
        origin: Pose,
    }

    /// An occupancy grid map.
    #[derive(Default)]
    nav_msgs / OccupancyGrid {
        /// Time and frame.
        header: Header,
        /// Size and position.
        info: MapMetaData,
        /// Occupancy in percent, 0 to 100, or -1 for unknown; row by row, the lowest first.
        data: Vec<i8>,
    }

    /// Pose and velocity of a robot.
    #[derive(Default)]
    nav_msgs / Odometry {
        /// Time, and frame of the pose.
        header: Header,
        /// Frame of the velocity: the robot's base frame.
        child_frame_id: String,
        /// Pose of the robot.
        pose: PoseWithCovariance,
        /// Velocity of the robot.
        twist: TwistWithCovariance,
    }

    /// A path.
    #[derive(Default)]
    nav_msgs / Path {
        /// Time and frame.
        header: Header,
        /// Poses from the start to the goal.
        poses: Vec<PoseStamped>,
    }

    /// A scan of a planar lidar.
    #[derive(Default)]
    sensor_msgs / LaserScan {
        /// Time of the first beam, and frame of the lidar.
        header: Header,
        /// Angle of the first beam, radians.
        angle_min: f32,
        /// Angle of the last beam, radians.
        angle_max: f32,
        /// Angle between two beams, radians.
        angle_increment: f32,
        /// Time between two beams, seconds.
        time_increment: f32,
        /// Time between two scans, seconds.
        scan_time: f32,
        /// Shortest measurable range, metres.
        range_min: f32,
        /// Longest measurable range, metres.
        range_max: f32,
        /// Range of each beam, metres; infinite for no return, NaN for no measurement (REP-117).
        ranges: Vec<f32>,
        /// Strength of each return.
        intensities: Vec<f32>,
    }
}

messages! {
    /// A truth value.
    #[derive(Copy, Default, Eq)]
    std_msgs / Bool {
        /// The value.
        data: bool,
    }

    /// A colour with opacity, each 0 to 1.
    #[derive(Copy, Default)]
    std_msgs / ColorRGBA {
        /// Red.
        r: f32,
        /// Green.
        g: f32,
        /// Blue.
        b: f32,
        /// Opacity.
        a: f32,
    }

    /// A compressed image.
    #[derive(Default)]
    sensor_msgs / CompressedImage {
        /// Time and frame.
        header: Header,
        /// Format of the data.
        format: String,
        /// The image.
        data: Vec<u8>,
    }

    /// A texture coordinate.
    #[derive(Copy, Default)]
    visualization_msgs / UVCoordinate {
        /// Horizontal coordinate.
        u: f32,
        /// Vertical coordinate.
        v: f32,
    }

    /// A mesh.
    #[derive(Default)]
    visualization_msgs / MeshFile {
        /// Name of the file.
        filename: String,
        /// Contents of the file.
        data: Vec<u8>,
    }

    /// A shape to display.
    #[derive(Default)]
    visualization_msgs / Marker {
        [
            ARROW: i32 = 0, CUBE: i32 = 1, SPHERE: i32 = 2, CYLINDER: i32 = 3, LINE_STRIP: i32 = 4,
            LINE_LIST: i32 = 5, ADD: i32 = 0, DELETE: i32 = 2, DELETEALL: i32 = 3,
        ]
        /// Time and frame.
        header: Header,
        /// Namespace: a marker is identified by namespace and number.
        ns: String,
        /// Number in the namespace.
        id: i32,
        /// Shape: `CYLINDER`, `LINE_STRIP`, `LINE_LIST`, ...
        r#type: i32,
        /// ADD, DELETE or DELETEALL.
        action: i32,
        /// Pose of the shape.
        pose: Pose,
        /// Size of the shape, metres; x is the width of a line.
        scale: Vector3,
        /// Colour of the shape.
        color: ColorRGBA,
        /// Time until the marker disappears; zero for never.
        lifetime: Duration,
        /// Whether the marker moves with its frame.
        frame_locked: bool,
        /// Points of a line.
        points: Vec<Point>,
        /// Colour of each point, or none.
        colors: Vec<ColorRGBA>,
        /// Source of the texture.
        texture_resource: String,
        /// Texture.
        texture: CompressedImage,
        /// Texture coordinates of the points.
        uv_coordinates: Vec<UVCoordinate>,
        /// Text of a text marker.
        text: String,
        /// Source of a mesh.
        mesh_resource: String,
        /// Mesh.
        mesh_file: MeshFile,
        /// Whether the mesh has its own materials.
        mesh_use_embedded_materials: bool,
    }

    /// Several markers.
    #[derive(Default)]
    visualization_msgs / MarkerArray {
        /// The markers.
        markers: Vec<Marker>,
    }
}
