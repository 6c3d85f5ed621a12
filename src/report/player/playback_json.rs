//! Encodes a playback as JSON: short texts and numbers as they are, long lists as base64 of little-endian bytes.

use core::iter::repeat;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

use super::playback_recorder::{Frame, NO_MEASUREMENT, PlaybackPart, Window};
use crate::geometry::{Point, Pose};
use crate::local::WinnerSi;
use crate::map::MovingDisc;
use crate::report::map::{MAP_WIDTH, Viewport};
use crate::report::svg::simplify;
use crate::runtime::{Config, Mission};

/// What does not change during a drive. Lengths on the map are drawing units, so the script needs no map frame.
pub(super) fn drive_json(mission: &Mission, config: &Config, view: &Viewport) -> Value {
    let footprint = &config.robot.footprint;
    let discs = footprint.discs().iter();
    let discs: Vec<[f64; 3]> = discs.map(|disc| [disc.x, disc.y, disc.radius]).collect();
    json!({
        "width": MAP_WIDTH,
        "height": view.height(),
        "scale": view.scale(),
        "goal": view.at(&mission.goal.position),
        "body": footprint.body(),
        "discs": discs,
        "front_m": footprint.front_m(),
        "deadline_ms": config.local.control_period_s * 1e3,
    })
}

/// Frames, and what they refer to.
pub(super) fn part_json(part: &PlaybackPart, view: &Viewport) -> Value {
    let frames = &part.frames[..];
    let paths: Vec<_> = part.paths.iter().map(|path| path_points(path, view)).collect();
    let modes = changes(part.first, frames.iter().map(|frame| frame.row.mode.name()));
    let (beams, trajectories) = (part.shape.beams, part.shape.trajectories);
    let ranges = frames.iter().map(|frame| &frame.scan.ranges[..]);
    let windows = || frames.iter().map(|frame| frame.window.as_ref());
    let scores = windows().map(|window| window.map_or(&[][..], |window| &window.scores));
    let drawn = windows().map(|window| window.map_or(&[][..], |window| &window.paths));
    let sampled: Vec<Vec<_>> =
        drawn.map(|paths| paths.iter().map(|path| path_points(path, view)).collect()).collect();
    let predicted = windows().map(|window| window.map_or(&[][..], |window| &window.predicted));
    json!({
        "first": part.first,
        "frames": frames.len(),
        "shape": part.shape.key(),
        "events": part.event_ticks,
        "paths": paths,
        "modes": modes,
        "faults": part.events.as_ref().map(|(faults, _)| faults.list.json(part.shape.stride)),
        "protection": part.events.as_ref().map(|(_, protection)| protection.json(part.shape.stride)),
        "beams": beams,
        "trajectories": trajectories,
        "numbers": numbers(frames, view),
        "ranges": padded(ranges, beams, NO_MEASUREMENT),
        "scores": padded(scores, trajectories, NO_TRAJECTORY),
        "moving": discs(frames.iter().map(|frame| &frame.moving[..]), view),
        "predicted": discs(predicted, view),
        "sampled": sampled,
    })
}

/// The byte of a trajectory that a frame does not have. The script does not read it.
const NO_TRAJECTORY: u8 = 7;

/// Tolerance of a simplified path, drawing units. The player draws it about twenty times larger than the map does.
const PATH_TOLERANCE: f64 = 0.02;

fn path_points(path: &[Point], view: &Viewport) -> Vec<[f64; 2]> {
    let points: Vec<[f64; 2]> =
        path.iter().filter(|point| point.is_finite()).map(|point| view.at(point)).collect();
    let round = |point: [f64; 2]| point.map(|number| (number * 100.0).round() / 100.0);
    simplify(&points, PATH_TOLERANCE).into_iter().map(round).collect()
}

/// Each text that differs from the one before, with its frame; the frames begin at `first`.
fn changes(first: usize, texts: impl Iterator<Item = &'static str>) -> Vec<(usize, &'static str)> {
    let mut changes: Vec<(usize, &'static str)> = Vec::new();
    for (index, text) in (first..).zip(texts) {
        if changes.last().is_none_or(|(_, last)| *last != text) {
            changes.push((index, text));
        }
    }
    changes
}

/// A number of a frame.
type Series<'a> = &'a dyn Fn(&Frame) -> f64;

/// Lists of one number for each frame, by name; NaN where a frame has none.
fn numbers(frames: &[Frame], view: &Viewport) -> Value {
    const NO_POSE: Pose = Pose::new(f64::NAN, f64::NAN, f64::NAN);
    let at = |point: &Point, axis: usize| view.at(point)[axis];
    let start = |frame: &Frame| frame.window.as_ref().map_or(NO_POSE, |window| window.start);
    let of_window = |number: fn(&Window) -> f64| {
        move |frame: &Frame| frame.window.as_ref().map_or(f64::NAN, number)
    };
    let winner = |frame: &Frame| frame.window.as_ref()?.winner;
    let of_winner = |number: fn(&WinnerSi) -> f64| {
        move |frame: &Frame| winner(frame).as_ref().map_or(f64::NAN, number)
    };
    let lists: [(&str, Series); 37] = [
        ("time", &|frame| frame.row.time_s),
        ("x", &|frame| at(&frame.row.pose.position(), 0)),
        ("y", &|frame| at(&frame.row.pose.position(), 1)),
        ("yaw", &|frame| frame.row.pose.yaw),
        ("target_x", &|frame| at(&frame.row.local_target, 0)),
        ("target_y", &|frame| at(&frame.row.local_target, 1)),
        ("speed", &|frame| frame.row.twist.linear),
        ("turn_rate", &|frame| frame.row.twist.angular),
        ("commanded_speed", &|frame| frame.row.command.linear),
        ("commanded_turn_rate", &|frame| frame.row.command.angular),
        ("gap", &|frame| frame.row.gap_m),
        ("decision_time", &|frame| frame.decision_ms),
        ("samples", &|frame| f64::from(frame.row.samples)),
        ("admissible", &|frame| f64::from(frame.row.admissible)),
        ("plan", &|frame| frame.row.path as f64),
        ("lidar_x", &|frame| frame.scan.origin.x),
        ("lidar_y", &|frame| frame.scan.origin.y),
        ("angle_min", &|frame| frame.scan.angle_min),
        ("angle_increment", &|frame| frame.scan.angle_increment),
        ("range_max", &|frame| frame.scan.range_max),
        ("columns", &of_window(|window| window.columns as f64)),
        ("rows", &of_window(|window| (window.scores.len() / window.columns.max(1)) as f64)),
        ("horizon", &of_window(|window| window.horizon_s)),
        ("start_x", &|frame| at(&start(frame).position(), 0)),
        ("start_y", &|frame| at(&start(frame).position(), 1)),
        ("start_yaw", &|frame| start(frame).yaw),
        ("v_min", &of_window(|window| window.ends[0].linear)),
        ("v_max", &of_window(|window| window.ends[1].linear)),
        ("omega_min", &of_window(|window| window.ends[0].angular)),
        ("omega_max", &of_window(|window| window.ends[1].angular)),
        ("v", &of_winner(|winner| winner.vx)),
        ("omega", &of_winner(|winner| winner.vtheta)),
        ("heading", &of_winner(|winner| winner.terms.heading)),
        ("clearance", &of_winner(|winner| winner.terms.clearance)),
        ("velocity", &of_winner(|winner| winner.terms.velocity)),
        ("path", &of_winner(|winner| winner.terms.path)),
        ("score", &of_winner(|winner| winner.score)),
    ];
    let encoded = |(name, number): (&str, Series)| {
        let bytes = frames.iter().flat_map(|frame| (number(frame) as f32).to_le_bytes());
        (name.to_owned(), Value::from(STANDARD.encode(bytes.collect::<Vec<u8>>())))
    };
    Value::Object(lists.into_iter().map(encoded).collect())
}

/// The bytes of all frames, each padded to a number of bytes.
fn padded<'f>(frames: impl Iterator<Item = &'f [u8]>, length: usize, filler: u8) -> String {
    let padded = |bytes: &'f [u8]| bytes.iter().copied().chain(repeat(filler)).take(length);
    STANDARD.encode(frames.flat_map(padded).collect::<Vec<u8>>())
}

/// Discs by frame: the count of each frame, and x, y, radius and velocity of all discs in drawing units.
fn discs<'f>(frames: impl Iterator<Item = &'f [MovingDisc]>, view: &Viewport) -> Value {
    let (mut counts, mut numbers) = (Vec::new(), Vec::new());
    for discs in frames {
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
