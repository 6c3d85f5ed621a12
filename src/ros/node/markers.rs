//! The local planner at work, for `RViz` and Foxglove: some of its arcs by score, the one it chose, and what moves.

use crate::geometry::{Pose, Twist};
use crate::local::{Sampling, TrajectoryFan};
use crate::map::MovingDisc;
use crate::ros::msg::{
    ColorRGBA, Duration, Header, Marker, MarkerArray, Point, Vector3, action, shape,
};

/// Arcs shown along each axis of the window: Nav2 warns of more (`nav2_mppi_controller/README.md`).
pub const SHOWN: Sampling = Sampling {
    vx_samples: 5,
    vtheta_samples: 13,
};
/// Straight pieces of an arc.
const PIECES: u32 = 10;
/// Markers that are not renewed go after this long: half a second.
const LIFETIME: Duration = Duration {
    sec: 0,
    nanosec: 500_000_000,
};
const ARC_WIDTH_M: f64 = 0.01;
const CHOSEN_WIDTH_M: f64 = 0.04;
const BODY_HEIGHT_M: f64 = 1.0;

/// Markers of a decision; of what moves alone where it needed no sampling.
pub fn markers(fan: Option<&TrajectoryFan>, moving: &[MovingDisc], header: &Header) -> MarkerArray {
    let mut markers = vec![Marker {
        action: action::DELETE_ALL,
        ..marker(header, "", 0, 0)
    }];
    if let Some(fan) = fan {
        markers.push(arcs(fan, header));
        markers.extend(chosen(fan, header));
    }
    let bodies = moving.iter().enumerate();
    markers.extend(bodies.map(|(number, disc)| body(disc, number as i32, header)));
    MarkerArray { markers }
}

/// From the worst of those shown, blue, to the best, green; what is not admissible is faint red.
fn arcs(fan: &TrajectoryFan, header: &Header) -> Marker {
    let (worst, best) = fan.score_range();
    let mut all = Marker {
        scale: width(ARC_WIDTH_M),
        ..marker(header, "arcs", 0, shape::LINE_LIST)
    };
    for arc in &fan.arcs {
        let color = match arc.score {
            Some(score) => {
                let share = (score - worst) / (best - worst).max(f64::MIN_POSITIVE);
                rgba(0.0, share, 1.0 - share, 0.8)
            }
            None => rgba(1.0, 0.2, 0.2, 0.2),
        };
        let points = points(&fan.from, &arc.twist, fan.horizon_s);
        for piece in points.windows(2) {
            all.points.extend(piece);
            all.colors.extend([color; 2]);
        }
    }
    all
}

fn chosen(fan: &TrajectoryFan, header: &Header) -> Option<Marker> {
    let winner = fan.winner.as_ref()?;
    let twist = Twist::new(winner.vx, winner.vtheta);
    Some(Marker {
        scale: width(CHOSEN_WIDTH_M),
        color: rgba(1.0, 0.8, 0.0, 1.0),
        points: points(&fan.from, &twist, fan.horizon_s),
        ..marker(header, "chosen", 0, shape::LINE_STRIP)
    })
}

fn body(disc: &MovingDisc, number: i32, header: &Header) -> Marker {
    let mut body = Marker {
        scale: Vector3 {
            x: 2.0 * disc.radius,
            y: 2.0 * disc.radius,
            z: BODY_HEIGHT_M,
        },
        color: rgba(0.8, 0.2, 0.8, 0.6),
        ..marker(header, "moving", number, shape::CYLINDER)
    };
    body.pose.position = Point {
        x: disc.x,
        y: disc.y,
        z: BODY_HEIGHT_M / 2.0,
    };
    body
}

fn points(from: &Pose, twist: &Twist, horizon_s: f64) -> Vec<Point> {
    let at = |piece: u32| {
        let pose = from.after(twist, horizon_s * f64::from(piece) / f64::from(PIECES));
        Point {
            x: pose.x,
            y: pose.y,
            z: 0.0,
        }
    };
    (0..=PIECES).map(at).collect()
}

fn marker(header: &Header, ns: &str, id: i32, kind: i32) -> Marker {
    Marker {
        header: header.clone(),
        ns: ns.to_owned(),
        id,
        kind,
        action: action::ADD,
        lifetime: LIFETIME,
        ..Marker::default()
    }
}

fn width(metres: f64) -> Vector3 {
    Vector3 {
        x: metres,
        ..Vector3::default()
    }
}

fn rgba(r: f64, g: f64, b: f64, a: f64) -> ColorRGBA {
    let [r, g, b, a] = [r, g, b, a].map(|share| share as f32);
    ColorRGBA { r, g, b, a }
}
