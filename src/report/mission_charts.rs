//! The charts of a mission over time: motion, and the gap to the nearest obstacle.

use super::chart::{Axis, Chart, Mark, Panel, Plot, XAxis, range};
use super::figure::{ChartFigure, Table};
use super::number::fixed;
use super::svg::LegendEntry;
use super::views::MissionView;
use crate::geometry::Twist;
use crate::navigator::Mode;
use crate::runtime::TraceRow;

const MOTION: &str = "Speed and turn rate";
const GAP: &str = "Gap to the nearest obstacle";

/// Least range of a motion axis, m/s or rad/s. Rounding errors of a robot at rest stay small in the chart.
const MIN_MOTION_RANGE: f64 = 0.1;

/// Least range of the gap axis above contact, m.
const MIN_GAP_RANGE_M: f64 = 0.1;

/// The modes in the order of the legend, and their classes.
const MODES: [(Mode, &str); 10] = [
    (Mode::Driving, "mode driving"),
    (Mode::Rotating, "mode rotating"),
    (Mode::Blocked, "mode blocked"),
    (Mode::Escaping, "mode escaping"),
    (Mode::Evading, "mode evading"),
    (Mode::Parking, "mode parking"),
    (Mode::AtWaypoint, "mode at-waypoint"),
    (Mode::SensorFault, "mode sensor-fault"),
    (Mode::Arrived, "mode arrived"),
    (Mode::Failed, "mode failed"),
];

/// The time axis of a run.
pub(super) fn time_axis(rows: &[TraceRow]) -> XAxis {
    let (low, high) = range(rows.iter().map(|row| row.time_s)).unwrap_or((0.0, 0.0));
    XAxis::new(Axis::exact(low, high), "Time, s")
}

/// True and commanded motion over time, with the modes as bands.
pub(super) fn motion(mission: &MissionView) -> ChartFigure {
    let rows = &mission.trace.rows;
    ChartFigure {
        chart: motion_chart(rows, mission.control_period_s),
        caption: "The background shows the mode.".to_owned(),
        table: Table::of_ticks(
            "motion",
            rows,
            &[
                ("time, s", |row| fixed(row.time_s, 2)),
                ("speed, m/s", |row| fixed(row.twist.linear, 3)),
                ("commanded, m/s", |row| fixed(row.command.linear, 3)),
                ("turn rate, rad/s", |row| fixed(row.twist.angular, 3)),
                ("commanded, rad/s", |row| fixed(row.command.angular, 3)),
                ("mode", |row| row.mode.as_str().to_owned()),
                ("admissible samples", |row| format!("{} of {}", row.admissible, row.samples)),
            ],
        ),
    }
}

fn motion_chart(rows: &[TraceRow], period_s: f64) -> Chart {
    if rows.is_empty() {
        return Chart::empty(MOTION, "The run has no tick, so there is no motion to show.");
    }
    let panel = |title: &str, value: fn(&Twist) -> f64| {
        let values = rows.iter().flat_map(|row| [value(&row.twist), value(&row.command)]);
        let (low, high) = range(values).unwrap_or((0.0, 0.0));
        let line = |of: fn(&TraceRow) -> &Twist| {
            rows.iter().map(|row| [row.time_s, value(of(row))]).collect()
        };
        let bands = MODES.iter().skip(1).map(|(mode, class)| {
            let bands = mode_bands(rows, *mode, period_s);
            Mark::Bands(class, bands)
        });
        let mut marks: Vec<Mark> = bands.collect();
        marks.push(Mark::Line("true", line(|row| &row.twist)));
        marks.push(Mark::Line("command", line(|row| &row.command)));
        Panel {
            title: title.to_owned(),
            height: 114.0,
            y: Axis::rounded(low.min(0.0), high.max(MIN_MOTION_RANGE)),
            marks,
        }
    };
    let panels = vec![
        panel("Speed, m/s", |twist| twist.linear),
        panel("Turn rate, rad/s (left is positive)", |twist| twist.angular),
    ];
    let mut legend =
        vec![LegendEntry::line("true", "true"), LegendEntry::line("command", "command")];
    for (mode, class) in MODES {
        let count = rows.iter().filter(|row| row.mode == mode).count();
        if count > 0 {
            let percent = fixed(100.0 * count as f64 / rows.len() as f64, 1);
            legend
                .push(LegendEntry::area(class, format!("{}, {percent} % of ticks", mode.as_str())));
        }
    }
    let ends = |value: fn(&Twist) -> f64| {
        let ends = range(rows.iter().map(|row| value(&row.twist)));
        let (low, high) = ends.unwrap_or((0.0, 0.0));
        format!("{} to {}", fixed(low, 2), fixed(high, 2))
    };
    Chart {
        title: MOTION.to_owned(),
        plot: Plot::Panels { x: time_axis(rows), panels },
        legend,
        alt_text: format!(
            "True and commanded speed and turn rate over time. The true speed is {} m/s, the true turn rate {} rad/s.",
            ends(|twist| twist.linear),
            ends(|twist| twist.angular)
        ),
    }
}

/// The stretches of a mode: from and to, s.
fn mode_bands(rows: &[TraceRow], mode: Mode, period_s: f64) -> Vec<[f64; 2]> {
    rows.chunk_by(|a, b| a.mode == b.mode)
        .filter_map(|stretch| {
            let (first, last) = (stretch.first()?, stretch.last()?);
            (first.mode == mode).then_some([first.time_s, last.time_s + period_s])
        })
        .filter(|[from, to]| from.is_finite() && to.is_finite())
        .collect()
}

/// The gap to the nearest obstacle over time.
pub(super) fn gap(mission: &MissionView) -> ChartFigure {
    let rows = &mission.trace.rows;
    let out_of_range = rows.len() - finite_gaps(rows).count();
    let mut caption = "At or below zero the robot touches something.".to_owned();
    if out_of_range > 0 {
        let ticks = out_of_range.to_string();
        caption +=
            &[" The line breaks at ", &ticks, " ticks without an obstacle in range."].concat();
    }
    ChartFigure {
        chart: gap_chart(rows),
        caption,
        table: Table::of_ticks(
            "gap",
            rows,
            &[("time, s", |row| fixed(row.time_s, 2)), ("gap, m", |row| fixed(row.gap_m, 3))],
        ),
    }
}

fn gap_chart(rows: &[TraceRow]) -> Chart {
    let Some(closest) = closest(rows) else {
        return Chart::empty(GAP, "No obstacle was in range at any tick.");
    };
    let widest = finite_gaps(rows).map(|row| row.gap_m).fold(MIN_GAP_RANGE_M, f64::max);
    let (gap_m, time_s) = (fixed(closest.gap_m, 3), fixed(closest.time_s, 1));
    Chart {
        title: GAP.to_owned(),
        plot: Plot::Panels {
            x: time_axis(rows),
            panels: vec![Panel {
                title: "Gap, m".to_owned(),
                height: 266.0,
                y: Axis::rounded(closest.gap_m.min(0.0), widest),
                marks: vec![
                    Mark::AreaBelow("contact", 0.0),
                    Mark::Line("gap", rows.iter().map(|row| [row.time_s, row.gap_m]).collect()),
                    Mark::Level(0.0, None),
                    Mark::Circles("closest", 5.0, vec![[closest.time_s, closest.gap_m]]),
                ],
            }],
        },
        alt_text: format!(
            "Gap between the robot and the nearest obstacle over {} ticks. The smallest gap is {gap_m} m at {time_s} s.",
            rows.len()
        ),
        legend: vec![
            LegendEntry::line("gap", "gap, from the edge of the footprint"),
            LegendEntry::line("limit", "contact"),
            LegendEntry::circle("closest", 5.0, format!("smallest, {gap_m} m at {time_s} s")),
        ],
    }
}

fn finite_gaps(rows: &[TraceRow]) -> impl Iterator<Item = &TraceRow> {
    rows.iter().filter(|row| row.gap_m.is_finite() && row.time_s.is_finite())
}

/// The tick of the smallest gap, the first of several.
pub(super) fn closest(rows: &[TraceRow]) -> Option<&TraceRow> {
    finite_gaps(rows).min_by(|a, b| a.gap_m.total_cmp(&b.gap_m))
}
