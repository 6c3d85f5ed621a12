//! Speed and turn rate over time: what was commanded, what the base did, and in which mode.

use maud::{Markup, html};

use super::MissionView;
use super::axis::Axis;
use super::figure::{Figure, Table, area_key, line_key, nothing_to_show};
use super::number::{coordinate, fixed};
use super::panel::{Panel, chart};
use crate::geometry::Twist;
use crate::navigator::Mode;
use crate::runtime::TraceRow;

const TITLE: &str = "Speed and turn rate";
const HEIGHT: f64 = 340.0;

pub(super) fn figure(mission: &MissionView) -> Markup {
    let rows = &mission.trace.rows;
    if rows.is_empty() {
        return nothing_to_show(TITLE, "The run has no tick, so there is no motion to show.");
    }
    let time = time_axis(rows);
    let speed = Panel::across(32.0, 114.0, time, value_axis(rows, |twist| twist.linear));
    let turn = Panel::across(184.0, 114.0, time, value_axis(rows, |twist| twist.angular));
    let bands = mode_bands(rows, mission.control_period_s);
    let picture = html! {
        (draw_bands(&bands, &speed))
        (draw_bands(&bands, &turn))
        (speed.axes(None, "Speed, m/s"))
        (turn.axes(Some("Time, s"), "Turn rate, rad/s (left is positive)"))
        (lines(&speed, rows, |twist| twist.linear))
        (lines(&turn, rows, |twist| twist.angular))
    };
    let mut legend = vec![line_key("true", "true"), line_key("command", "command")];
    for mode in MODES {
        if rows.iter().any(|row| row.mode == mode) {
            legend.push(area_key(class(mode), &share_in_words(rows, mode)));
        }
    }
    Figure {
        title: TITLE,
        picture: chart(HEIGHT, &alternative(rows), &picture),
        legend,
        caption: "The background shows the mode.".to_owned(),
        table: table(rows),
    }
    .markup()
}

/// The range of time of a run, exactly.
pub(super) fn time_axis(rows: &[TraceRow]) -> Axis {
    let times = || rows.iter().map(|row| row.time_s).filter(|t| t.is_finite());
    let low = times().fold(f64::INFINITY, f64::min);
    let high = times().fold(f64::NEG_INFINITY, f64::max);
    if low <= high {
        Axis::exact(low, high)
    } else {
        Axis::exact(0.0, 0.0)
    }
}

/// Least range of a motion axis, m/s or rad/s: rounding errors of a robot at rest must not fill the picture.
const LEAST_RANGE: f64 = 0.1;

/// A range that holds zero and every finite value of the true and commanded motion.
fn value_axis(rows: &[TraceRow], value: impl Fn(&Twist) -> f64) -> Axis {
    let (low, high) = range(rows, |row| {
        let (motion, command) = (value(&row.twist), value(&row.command));
        [motion, command]
    });
    Axis::rounded(low.min(0.0), high.max(LEAST_RANGE))
}

/// The least and greatest finite values; zeros where there is none.
fn range(rows: &[TraceRow], values: impl Fn(&TraceRow) -> [f64; 2]) -> (f64, f64) {
    rows.iter()
        .flat_map(values)
        .filter(|value| value.is_finite())
        .fold(None, |range: Option<(f64, f64)>, value| {
            let (low, high) = range.unwrap_or((value, value));
            Some((low.min(value), high.max(value)))
        })
        .unwrap_or((0.0, 0.0))
}

fn lines(panel: &Panel, rows: &[TraceRow], value: impl Fn(&Twist) -> f64) -> Markup {
    html! {
        (panel.line("true", rows.iter().map(|row| (row.time_s, value(&row.twist)))))
        (panel.line("command", rows.iter().map(|row| (row.time_s, value(&row.command)))))
    }
}

/// All modes, in the order of the legend.
const MODES: [Mode; 10] = [
    Mode::Driving,
    Mode::Rotating,
    Mode::Blocked,
    Mode::Escaping,
    Mode::Evading,
    Mode::Parking,
    Mode::AtWaypoint,
    Mode::SensorFault,
    Mode::Arrived,
    Mode::Failed,
];

/// A mode in words.
pub(super) fn mode_words(mode: Mode) -> &'static str {
    match mode {
        Mode::Driving => "driving",
        Mode::Rotating => "rotating in place",
        Mode::Blocked => "blocked",
        Mode::Escaping => "escaping",
        Mode::Evading => "evading",
        Mode::SensorFault => "sensor fault",
        Mode::Parking => "parking",
        Mode::AtWaypoint => "at a waypoint",
        Mode::Arrived => "arrived",
        Mode::Failed => "failed",
    }
}

fn class(mode: Mode) -> &'static str {
    match mode {
        Mode::Driving => "mode driving",
        Mode::Rotating => "mode turning",
        Mode::Blocked | Mode::SensorFault => "mode blocked",
        Mode::Escaping => "mode backing",
        Mode::Evading => "mode evading",
        Mode::Parking => "mode parking",
        Mode::AtWaypoint => "mode stopped",
        Mode::Arrived => "mode arrived",
        Mode::Failed => "mode failed",
    }
}

fn share_in_words(rows: &[TraceRow], mode: Mode) -> String {
    let count = rows.iter().filter(|row| row.mode == mode).count();
    let percent = 100.0 * count as f64 / rows.len() as f64;
    format!("{}, {} % of ticks", mode_words(mode), fixed(percent, 1))
}

/// Stretches of one mode, other than driving: the mode, from when, until when.
fn mode_bands(rows: &[TraceRow], period_s: f64) -> Vec<(Mode, f64, f64)> {
    rows.chunk_by(|a, b| a.mode == b.mode)
        .filter_map(|stretch| {
            let (first, last) = (stretch.first()?, stretch.last()?);
            (first.mode != Mode::Driving).then_some((
                first.mode,
                first.time_s,
                last.time_s + period_s,
            ))
        })
        .filter(|(_, from, until)| from.is_finite() && until.is_finite())
        .collect()
}

fn draw_bands(bands: &[(Mode, f64, f64)], panel: &Panel) -> Markup {
    html! {
        @for &(mode, from, until) in bands {
            @let left = panel.x_at(from);
            @let right = panel.x_at(until).min(panel.right());
            // A single tick of a long run must still be seen.
            rect class=(class(mode)) x=(coordinate(left)) y=(coordinate(panel.top))
                width=(coordinate((right - left).max(1.0))) height=(coordinate(panel.height)) {}
        }
    }
}

fn alternative(rows: &[TraceRow]) -> String {
    let (slowest, fastest) = range(rows, |row| [row.twist.linear; 2]);
    let (right, left) = range(rows, |row| [row.twist.angular; 2]);
    format!(
        "Speed and turn rate over time, true against command. The true speed runs from {} to {} metres per second, \
         the true turn rate from {} to {} radians per second.",
        fixed(slowest, 2),
        fixed(fastest, 2),
        fixed(right, 2),
        fixed(left, 2)
    )
}

fn table(rows: &[TraceRow]) -> Table<'static> {
    let heads = &[
        "time, s",
        "speed, m/s",
        "commanded, m/s",
        "turn rate, rad/s",
        "commanded, rad/s",
        "mode",
        "admissible samples",
    ];
    Table::of_ticks("motion", heads, rows, |_, row| {
        vec![
            fixed(row.time_s, 2),
            fixed(row.twist.linear, 3),
            fixed(row.command.linear, 3),
            fixed(row.twist.angular, 3),
            fixed(row.command.angular, 3),
            mode_words(row.mode).to_owned(),
            format!("{} of {}", row.admissible, row.samples),
        ]
    })
}
