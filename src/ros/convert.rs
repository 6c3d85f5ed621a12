//! Conversions to ROS messages: geometry, paths, and markers of a local decision for `RViz` and Foxglove.

use core::fmt::Display;

use super::msg::{
    ColorRGBA, Duration, Header, KeyValue, MapMetaData, Marker, MarkerArray, OccupancyGrid, Path,
    Point, Pose, PoseStamped, Quaternion, Time, Transform, Twist, TwistStamped, Vector3,
};
use crate::geometry::{self, bearing};
use crate::local::{Sampling, TrajectoryFan};
use crate::map::{self, MovingDisc};

const NANOSECONDS: u64 = 1_000_000_000;

/// Converts seconds to the nearest nanosecond. Negative times and NaN become zero.
#[must_use]
pub(crate) fn nanoseconds(time_s: f64) -> u64 {
    (time_s * NANOSECONDS as f64).round() as u64
}

/// A named value of a diagnostic status.
#[must_use]
pub(crate) fn key_value(key: &str, value: impl Display) -> KeyValue {
    KeyValue { key: key.to_owned(), value: value.to_string() }
}

impl Time {
    /// Converts seconds to the nearest nanosecond. Negative times and NaN become zero.
    #[must_use]
    pub fn from_seconds(time_s: f64) -> Self {
        let nanoseconds = nanoseconds(time_s);
        Self {
            sec: i32::try_from(nanoseconds / NANOSECONDS).unwrap_or(i32::MAX),
            nanosec: (nanoseconds % NANOSECONDS) as u32,
        }
    }
}

impl From<&geometry::Point> for Point {
    fn from(point: &geometry::Point) -> Self {
        Self { x: point.x, y: point.y, z: 0.0 }
    }
}

impl From<&geometry::Pose> for Pose {
    fn from(pose: &geometry::Pose) -> Self {
        let (sin, cos) = libm::sincos(pose.yaw / 2.0);
        Self {
            position: Point::from(&pose.position()),
            orientation: Quaternion { x: 0.0, y: 0.0, z: sin, w: cos },
        }
    }
}

impl From<&geometry::Pose> for Transform {
    fn from(pose: &geometry::Pose) -> Self {
        let Pose { position: Point { x, y, z }, orientation: rotation } = Pose::from(pose);
        Self { translation: Vector3 { x, y, z }, rotation }
    }
}

impl From<&geometry::Twist> for Twist {
    fn from(twist: &geometry::Twist) -> Self {
        Self {
            linear: Vector3 { x: twist.linear, ..Vector3::default() },
            angular: Vector3 { z: twist.angular, ..Vector3::default() },
        }
    }
}

impl TwistStamped {
    /// A velocity with time and frame.
    #[must_use]
    pub fn new(twist: &geometry::Twist, stamp: Time, frame: &str) -> Self {
        Self { header: Header { stamp, frame_id: frame.to_owned() }, twist: Twist::from(twist) }
    }
}

/// A map. Its resolution is rounded to float32.
#[must_use]
pub(crate) fn occupancy_grid(grid: &map::OccupancyGrid, header: Header) -> OccupancyGrid {
    let frame = grid.frame();
    OccupancyGrid {
        header,
        info: MapMetaData {
            map_load_time: Time::default(),
            resolution: frame.resolution_m as f32,
            width: frame.width as u32,
            height: frame.height as u32,
            origin: Pose::from(&frame.origin),
        },
        data: grid.cells().to_vec(),
    }
}

/// A path whose poses face the next point. The last pose has the direction of the one before.
#[must_use]
pub(crate) fn path(points: &[geometry::Point], header: &Header) -> Path {
    let pose = |(index, point): (usize, &geometry::Point)| {
        let from = index.min(points.len().saturating_sub(2));
        let yaw = match points.get(from..from + 2) {
            Some([here, next]) => bearing(here, next),
            _ => 0.0,
        };
        PoseStamped {
            header: header.clone(),
            pose: Pose::from(&geometry::Pose::new(point.x, point.y, yaw)),
        }
    };
    Path { header: header.clone(), poses: points.iter().enumerate().map(pose).collect() }
}

/// Number of arcs along each axis of the dynamic window. Nav2 warns of more (`nav2_mppi_controller/README.md`).
pub(crate) const SAMPLING: Sampling = Sampling { vx_samples: 5, vtheta_samples: 13 };
/// Line segments of an arc.
const SEGMENTS: u32 = 10;
const ARC_WIDTH_M: f64 = 0.01;
const CHOSEN_WIDTH_M: f64 = 0.04;
const OBSTACLE_HEIGHT_M: f64 = 1.0;
/// Times of the predicted obstacles, as fractions of the horizon.
const PREDICTED: [f64; 3] = [0.33, 0.67, 1.0];

const REJECTED: ColorRGBA = rgba(1.0, 0.2, 0.2, 0.2);
const CHOSEN: ColorRGBA = rgba(1.0, 0.8, 0.0, 1.0);
const OBSTACLE: ColorRGBA = rgba(0.8, 0.2, 0.8, 0.6);
const PREDICTION: ColorRGBA = rgba(0.8, 0.2, 0.8, 0.2);

/// The markers of a decision, which replace all earlier ones. Without sampling there are only the obstacles.
#[must_use]
pub(crate) fn markers(
    fan: Option<&TrajectoryFan>,
    moving: &[MovingDisc],
    header: &Header,
    lifetime: Duration,
) -> MarkerArray {
    let new = |ns: &str, shape| Marker {
        header: header.clone(),
        ns: ns.to_owned(),
        r#type: shape,
        action: Marker::ADD,
        lifetime,
        ..Marker::default()
    };
    let mut markers = vec![Marker { action: Marker::DELETEALL, ..new("", Marker::ARROW) }];
    if let Some(fan) = fan {
        let (points, colors) = arcs(fan);
        markers.push(Marker {
            scale: width(ARC_WIDTH_M),
            points,
            colors,
            ..new("arcs", Marker::LINE_LIST)
        });
        markers.extend(fan.winner.as_ref().map(|_| Marker {
            scale: width(CHOSEN_WIDTH_M),
            color: CHOSEN,
            points: fan.winner_points(SEGMENTS).iter().map(Point::from).collect(),
            ..new("chosen", Marker::LINE_STRIP)
        }));
    }
    let horizon_s = fan.map(|fan| fan.horizon_s);
    for disc in moving {
        let now = ("moving", OBSTACLE, *disc);
        let predicted = horizon_s.into_iter().flat_map(|horizon_s| {
            PREDICTED.map(|share| ("predicted", PREDICTION, disc.after(share * horizon_s)))
        });
        for (ns, color, disc) in [now].into_iter().chain(predicted) {
            markers.push(Marker {
                id: markers.len() as i32,
                pose: Pose {
                    position: Point { z: OBSTACLE_HEIGHT_M / 2.0, ..Point::from(&disc.center()) },
                    ..Pose::default()
                },
                scale: Vector3 { x: 2.0 * disc.radius, y: 2.0 * disc.radius, z: OBSTACLE_HEIGHT_M },
                color,
                ..new(ns, Marker::CYLINDER)
            });
        }
    }
    MarkerArray { markers }
}

/// The segments of all arcs, coloured from blue for the worst score to green for the best.
fn arcs(fan: &TrajectoryFan) -> (Vec<Point>, Vec<ColorRGBA>) {
    let (mut points, mut colors) = (Vec::new(), Vec::new());
    for (sample, share) in fan.arcs.iter().zip(fan.relative_scores()) {
        let color =
            share.map_or(REJECTED, |share| rgba(0.0, share as f32, 1.0 - share as f32, 0.8));
        let along: Vec<Point> = fan.points(sample, SEGMENTS).iter().map(Point::from).collect();
        for segment in along.windows(2) {
            points.extend(segment);
            colors.extend([color; 2]);
        }
    }
    (points, colors)
}

fn width(metres: f64) -> Vector3 {
    Vector3 { x: metres, ..Vector3::default() }
}

const fn rgba(r: f32, g: f32, b: f32, a: f32) -> ColorRGBA {
    ColorRGBA { r, g, b, a }
}
