//! `visualization_msgs`, and the types that it takes from `std_msgs` and `sensor_msgs`.

use super::common::{Duration, Header};
use super::declaration::messages;
use super::geometry::{Point, Pose, Vector3};

messages! {
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
