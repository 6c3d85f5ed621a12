//! A reel as the page holds it: an object of small texts and numbers, and long lists as bytes in base64.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Map, Value, json};

use super::reel::{Frame, Reel, Window};
use crate::geometry::{Point, Pose};
use crate::map::MovingDisc;
use crate::report::MissionView;
use crate::report::motion_chart::mode_words;
use crate::report::simplify::simplify;
use crate::report::viewport::{MAP_WIDTH, Viewport};

/// The film of a mission. Lengths on the map are in the drawing's units, so that the player needs no map frame.
pub(super) fn film(mission: &MissionView<'_>, reel: &Reel, view: &Viewport) -> Value {
    let frames = &reel.frames;
    let lidar = frames.first().map(|frame| &frame.beams);
    let fan = frames.iter().find_map(|frame| frame.window.as_ref());
    json!({
        "frames": frames.len(),
        "width": MAP_WIDTH,
        "height": view.height(),
        "scale": view.scale(),
        "goal": view.at(&mission.goal),
        "footprint": mission.footprint.discs().iter().map(|disc| [disc.x, disc.y, disc.radius]).collect::<Vec<_>>(),
        "paths": mission.trace.paths.iter().map(|path| drawn(path, view)).collect::<Vec<_>>(),
        "modes": frames.iter().map(|frame| mode_words(frame.row.mode)).collect::<Runs>().0,
        "faults": reel.faults.film(reel.stride),
        "deadline_ms": mission.control_period_s * 1e3,
        "lidar": {
            "beams": lidar.map_or(0, |lidar| lidar.ranges.len()),
            "angle_min": lidar.map_or(0.0, |lidar| lidar.angle_min),
            "angle_increment": lidar.map_or(0.0, |lidar| lidar.angle_increment),
            "range_max": lidar.map_or(0.0, |lidar| lidar.range_max),
        },
        "fan": {
            "columns": fan.map_or(0, |fan| fan.columns),
            "arcs": fan.map_or(0, |fan| fan.scores.len()),
            "horizon_s": fan.map_or(0.0, |fan| fan.horizon_s),
        },
        "numbers": numbers(frames, view),
        "ranges": ranges(frames),
        "scores": scores(frames),
        "moving": discs(frames.iter().map(|frame| &frame.moving[..]), view),
        "predicted": discs(frames.iter().map(predicted), view),
    })
}

fn predicted(frame: &Frame) -> &[MovingDisc] {
    frame
        .window
        .as_ref()
        .map_or(&[], |window| &window.predicted)
}

/// How far a path may lie from the data, drawing units: the player shows it some twenty times as large as the map does.
const FINE: f64 = 0.02;

/// A line of the map in drawing units.
fn drawn(path: &[Point], view: &Viewport) -> Vec<[f64; 2]> {
    let points: Vec<[f64; 2]> = path
        .iter()
        .filter(|point| point.x.is_finite() && point.y.is_finite())
        .map(|point| view.at(point))
        .collect();
    let rounded = |point: [f64; 2]| point.map(|number| (number * 100.0).round() / 100.0);
    simplify(&points, FINE).into_iter().map(rounded).collect()
}

/// Words that stay the same for many frames: each with the frame where it begins.
struct Runs(Vec<(usize, &'static str)>);

impl FromIterator<&'static str> for Runs {
    fn from_iter<I: IntoIterator<Item = &'static str>>(words: I) -> Self {
        let mut runs: Vec<(usize, &'static str)> = Vec::new();
        for (index, word) in words.into_iter().enumerate() {
            if runs.last().is_none_or(|(_, last)| *last != word) {
                runs.push((index, word));
            }
        }
        Self(runs)
    }
}

/// A number for each frame, by name; NaN where it has none.
fn numbers(frames: &[Frame], view: &Viewport) -> Value {
    const NO_POSE: Pose = Pose::new(f64::NAN, f64::NAN, f64::NAN);
    type Number<'a> = (&'static str, &'a dyn Fn(&Frame) -> f64);
    let at = |point: &Point, axis: usize| view.at(point)[axis];
    let of_window = |frame: &Frame, number: &dyn Fn(&Window) -> f64| {
        frame.window.as_ref().map_or(f64::NAN, number)
    };
    let of_winner = |frame: &Frame, number: &dyn Fn(&crate::local::WinnerSi) -> f64| {
        let winner = frame
            .window
            .as_ref()
            .and_then(|window| window.winner.as_ref());
        winner.map_or(f64::NAN, number)
    };
    let from = |frame: &Frame| frame.window.as_ref().map_or(NO_POSE, |window| window.from);
    let all: [Number<'_>; 31] = [
        ("time", &|frame| frame.row.time_s),
        ("x", &|frame| at(&frame.row.pose.position(), 0)),
        ("y", &|frame| at(&frame.row.pose.position(), 1)),
        ("yaw", &|frame| frame.row.pose.yaw),
        ("target_x", &|frame| at(&frame.row.local_target, 0)),
        ("target_y", &|frame| at(&frame.row.local_target, 1)),
        ("speed", &|frame| frame.row.twist.linear),
        ("turn", &|frame| frame.row.twist.angular),
        ("told_speed", &|frame| frame.row.command.linear),
        ("told_turn", &|frame| frame.row.command.angular),
        ("gap", &|frame| frame.row.gap_m),
        ("took", &|frame| frame.took_ms),
        ("samples", &|frame| f64::from(frame.row.samples)),
        ("admissible", &|frame| f64::from(frame.row.admissible)),
        ("path", &|frame| frame.row.path as f64),
        ("from_x", &|frame| at(&from(frame).position(), 0)),
        ("from_y", &|frame| at(&from(frame).position(), 1)),
        ("from_yaw", &|frame| from(frame).yaw),
        ("v_low", &|frame| {
            of_window(frame, &|window| window.ends[0].linear)
        }),
        ("v_high", &|frame| {
            of_window(frame, &|window| window.ends[1].linear)
        }),
        ("w_low", &|frame| {
            of_window(frame, &|window| window.ends[0].angular)
        }),
        ("w_high", &|frame| {
            of_window(frame, &|window| window.ends[1].angular)
        }),
        ("v", &|frame| of_winner(frame, &|winner| winner.vx)),
        ("omega", &|frame| of_winner(frame, &|winner| winner.vtheta)),
        ("heading", &|frame| {
            of_winner(frame, &|winner| winner.terms.heading)
        }),
        ("dist", &|frame| {
            of_winner(frame, &|winner| winner.terms.clearance)
        }),
        ("vel", &|frame| {
            of_winner(frame, &|winner| winner.terms.velocity)
        }),
        ("combine", &|frame| {
            of_winner(frame, &|winner| winner.terms.path)
        }),
        ("score", &|frame| of_winner(frame, &|winner| winner.score)),
        ("belief_x", &|frame| at(&frame.row.belief.position(), 0)),
        ("belief_y", &|frame| at(&frame.row.belief.position(), 1)),
    ];
    let list = |number: &dyn Fn(&Frame) -> f64| {
        let bytes = frames
            .iter()
            .flat_map(|frame| (number(frame) as f32).to_le_bytes());
        Value::from(STANDARD.encode(bytes.collect::<Vec<u8>>()))
    };
    let object: Map<String, Value> = all
        .into_iter()
        .map(|(name, number)| (name.to_owned(), list(number)))
        .collect();
    object.into()
}

/// The beams of all frames, as many for each.
fn ranges(frames: &[Frame]) -> String {
    let beams = frames.first().map_or(0, |frame| frame.beams.ranges.len());
    let of_frame = |frame: &Frame| {
        let mut ranges = frame.beams.ranges.clone();
        ranges.resize(beams, u8::MAX);
        ranges
    };
    STANDARD.encode(frames.iter().flat_map(of_frame).collect::<Vec<u8>>())
}

/// The arcs of all frames, as many for each; those of a frame without a fan are the last reason, which draws nothing.
fn scores(frames: &[Frame]) -> String {
    const NO_ARC: u8 = 7;
    let windows = || frames.iter().map(|frame| frame.window.as_ref());
    let arcs = windows()
        .flatten()
        .next()
        .map_or(0, |window| window.scores.len());
    let of_frame = |window: Option<&Window>| {
        let mut scores = window.map_or_else(Vec::new, |window| window.scores.clone());
        scores.resize(arcs, NO_ARC);
        scores
    };
    STANDARD.encode(windows().flat_map(of_frame).collect::<Vec<u8>>())
}

/// Lists of discs: how many each frame has, and x, y, radius, and way in a second of all of them in drawing units.
fn discs<'a>(of_frames: impl Iterator<Item = &'a [MovingDisc]>, view: &Viewport) -> Value {
    let (mut counts, mut numbers) = (Vec::new(), Vec::new());
    for discs in of_frames {
        counts.extend((discs.len() as u16).to_le_bytes());
        for disc in discs {
            let [x, y] = view.at(&disc.center());
            let scale = view.scale();
            let disc = [x, y, disc.radius * scale, disc.vx * scale, -disc.vy * scale];
            numbers.extend(disc.map(|number| (number as f32).to_le_bytes()).concat());
        }
    }
    json!({ "counts": STANDARD.encode(counts), "numbers": STANDARD.encode(numbers) })
}
