//! `visualization_msgs/MarkerArray`: the dynamic window that was decided on, and the moving obstacles as predicted.

use crate::geometry::{Point, Twist};
use crate::local::{Sampling, TrajectoryFan};
use crate::map::MovingDisc;
use crate::recording::cdr::Encoder;
use crate::recording::parts::{self, MAP};

/// At most so many arcs are shown.
pub const FAN: Sampling = Sampling {
    vx_samples: 7,
    vtheta_samples: 15,
};
/// An arc is drawn as chords that turn by no more than this, radians: they are off it by less than 1 % of its radius.
const CHORD_RAD: f64 = 0.25;
/// Times at which predicted discs are shown, as shares of the horizon.
const PREDICTED: [f64; 3] = [0.33, 0.67, 1.0];
/// Height of the disc that stands for a moving obstacle, metres.
const HEIGHT_M: f64 = 0.1;

/// Numbers of `visualization_msgs/Marker`.
const CYLINDER: i32 = 3;
const LINE_STRIP: i32 = 4;
const LINE_LIST: i32 = 5;
const ADD: i32 = 0;
const DELETE_ALL: i32 = 3;

/// Red, green, blue, opacity.
type Color = [f64; 4];
const REJECTED: Color = [0.5, 0.5, 0.5, 0.3];
const WINNER: Color = [0.1, 0.4, 1.0, 1.0];
const OBSTACLE: Color = [0.9, 0.4, 0.0, 0.9];
const PREDICTION: Color = [0.9, 0.4, 0.0, 0.25];

/// One marker, about a place, of a size along its axes.
struct Marker {
    namespace: &'static str,
    id: usize,
    kind: i32,
    action: i32,
    at: Point,
    scale: [f64; 3],
    color: Color,
    points: Vec<Point>,
    colors: Vec<Color>,
}

/// A fan at a time; with none, what was shown before is taken away.
pub fn markers(time_s: f64, fan: Option<&TrajectoryFan>) -> Vec<u8> {
    let mut all = vec![Marker {
        action: DELETE_ALL,
        ..Marker::line("", LINE_LIST, 0.0, Vec::new())
    }];
    if let Some(fan) = fan {
        all.push(arcs(fan));
        all.extend(fan.winner.as_ref().map(|winner| {
            let points = arc(fan, &Twist::new(winner.vx, winner.vtheta));
            Marker {
                color: WINNER,
                ..Marker::line("chosen", LINE_STRIP, 0.04, points)
            }
        }));
        all.extend(discs(fan));
    }
    let mut message = Encoder::new();
    message.count(all.len());
    for marker in &all {
        marker.encode(&mut message, time_s);
    }
    message.finish()
}

/// All arcs in one marker: from red for the worst admissible score to green for the best, grey for what is not admissible.
fn arcs(fan: &TrajectoryFan) -> Marker {
    let color = |share: f64| -> Color { [1.0 - share, share, 0.0, 0.8] };
    let mut points = Vec::new();
    let mut colors = Vec::new();
    for (sample, share) in fan.arcs.iter().zip(fan.relative_scores()) {
        let color = share.map_or(REJECTED, color);
        let line = arc(fan, &sample.twist);
        for piece in line.windows(2) {
            points.extend_from_slice(piece);
            colors.extend([color; 2]);
        }
    }
    Marker {
        colors,
        ..Marker::line("fan", LINE_LIST, 0.01, points)
    }
}

fn arc(fan: &TrajectoryFan, twist: &Twist) -> Vec<Point> {
    let turned_rad = if twist.linear == 0.0 {
        0.0
    } else {
        twist.angular.abs() * fan.horizon_s
    };
    let chords = (turned_rad / CHORD_RAD).ceil().max(1.0);
    let time_s = |chord: u32| fan.horizon_s * f64::from(chord) / chords;
    let points = (0..=chords as u32).map(|chord| fan.from.after(twist, time_s(chord)).position());
    points.collect()
}

/// The moving obstacles, now and where they are predicted to be.
fn discs(fan: &TrajectoryFan) -> Vec<Marker> {
    let mut markers = Vec::new();
    let mut show = |namespace, color, disc: MovingDisc| {
        markers.push(Marker {
            namespace,
            id: markers.len(),
            kind: CYLINDER,
            action: ADD,
            at: disc.center(),
            scale: [2.0 * disc.radius, 2.0 * disc.radius, HEIGHT_M],
            color,
            points: Vec::new(),
            colors: Vec::new(),
        });
    };
    for disc in &fan.obstacles {
        show("moving", OBSTACLE, *disc);
        for share in PREDICTED {
            show("predicted", PREDICTION, disc.after(share * fan.horizon_s));
        }
    }
    markers
}

impl Marker {
    /// A line so many metres wide.
    fn line(namespace: &'static str, kind: i32, width_m: f64, points: Vec<Point>) -> Self {
        Self {
            namespace,
            id: 0,
            kind,
            action: ADD,
            at: Point::origin(),
            scale: [width_m, 0.0, 0.0],
            color: [0.0, 0.0, 0.0, 1.0],
            points,
            colors: Vec::new(),
        }
    }

    fn encode(&self, to: &mut Encoder, time_s: f64) {
        parts::header(to, time_s, MAP);
        to.text(self.namespace);
        to.i32(self.id as i32);
        to.i32(self.kind);
        to.i32(self.action);
        parts::point(to, &self.at);
        parts::turn(to, 0.0);
        to.all_f64(self.scale);
        color(to, &self.color);
        // Until it is taken away, and where it is.
        to.i32(0);
        to.u32(0);
        to.bool(false);
        to.count(self.points.len());
        for point in &self.points {
            parts::point(to, point);
        }
        to.count(self.colors.len());
        for one in &self.colors {
            color(to, one);
        }
        // No texture, text or mesh.
        to.text("");
        parts::header(to, 0.0, "");
        to.text("");
        to.count(0);
        to.count(0);
        to.text("");
        to.text("");
        to.text("");
        to.count(0);
        to.bool(false);
    }
}

/// `std_msgs/ColorRGBA`.
fn color(to: &mut Encoder, color: &Color) {
    color.iter().for_each(|&part| to.f32(part));
}
