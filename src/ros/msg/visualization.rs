//! `visualization_msgs`, and what it takes from `std_msgs` and `sensor_msgs`.

use serde::{Deserialize, Serialize};

use super::{Duration, Header, Point, Pose, Vector3};

/// Values of [`Marker::kind`].
pub mod shape {
    /// A cylinder as wide as `scale`.
    pub const CYLINDER: i32 = 3;
    /// One line through all points.
    pub const LINE_STRIP: i32 = 4;
    /// A line from each even point to the next.
    pub const LINE_LIST: i32 = 5;
}

/// Values of [`Marker::action`].
pub mod action {
    /// Show it, in place of the one with the same name and number.
    pub const ADD: i32 = 0;
    /// Remove all.
    pub const DELETE_ALL: i32 = 3;
}

/// `std_msgs/ColorRGBA`, each 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ColorRGBA {
    /// Red.
    pub r: f32,
    /// Green.
    pub g: f32,
    /// Blue.
    pub b: f32,
    /// Opacity.
    pub a: f32,
}

/// `sensor_msgs/CompressedImage`; always empty.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CompressedImage {
    /// Time and frame.
    pub header: Header,
    /// Of the data.
    pub format: String,
    /// The image.
    pub data: Vec<u8>,
}

/// `visualization_msgs/UVCoordinate`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct UVCoordinate {
    /// Across.
    pub u: f32,
    /// Up.
    pub v: f32,
}

/// `visualization_msgs/MeshFile`; always empty.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MeshFile {
    /// Its name.
    pub filename: String,
    /// Its bytes.
    pub data: Vec<u8>,
}

/// `visualization_msgs/Marker`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Marker {
    /// Time and frame.
    pub header: Header,
    /// With `id` its name.
    pub ns: String,
    /// With `ns` its name.
    pub id: i32,
    /// `type`: one of [`shape`].
    pub kind: i32,
    /// One of [`action`].
    pub action: i32,
    /// Its place.
    pub pose: Pose,
    /// Its size, metres; of lines, x is their width.
    pub scale: Vector3,
    /// Its colour.
    pub color: ColorRGBA,
    /// When it is over it goes by itself.
    pub lifetime: Duration,
    /// Whether it moves with its frame.
    pub frame_locked: bool,
    /// Its points.
    pub points: Vec<Point>,
    /// A colour for each of them, or none.
    pub colors: Vec<ColorRGBA>,
    /// Not used.
    pub texture_resource: String,
    /// Not used.
    pub texture: CompressedImage,
    /// Not used.
    pub uv_coordinates: Vec<UVCoordinate>,
    /// Not used.
    pub text: String,
    /// Not used.
    pub mesh_resource: String,
    /// Not used.
    pub mesh_file: MeshFile,
    /// Not used.
    pub mesh_use_embedded_materials: bool,
}

/// `visualization_msgs/MarkerArray`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MarkerArray {
    /// The markers.
    pub markers: Vec<Marker>,
}
