//! The charts of a mission: motion, the gap to the nearest obstacle, and the decision times.

use maud::html;

use super::chart::{Axis, Bar, Chart, LabelSide, Mark, Panel, XAxis, range};
use super::figure::Table;
use super::mission_page::MissionView;
use super::number::{fixed, significant};
use super::svg::LegendEntry;
use crate::bench::{Latencies, LatencySummary};
use crate::geometry::Twist;
use crate::navigator::Mode;
use crate::runtime::TraceRow;

/// Least range of a motion axis, m/s or rad/s. Rounding errors of a robot at rest stay small in the chart.
const MIN_MOTION_RANGE: f64 = 0.1;

/// Least range of the gap axis above contact, m.
const MIN_GAP_RANGE_M: f64 = 0.1;

/// Least latency on a logarithmic axis, ms. It is below the resolution of any clock.
const MIN_MS: f64 = 1e-5;

/// Bars of the distribution of latencies.
const BINS: usize = 80;

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
fn time_axis(rows: &[TraceRow]) -> XAxis {
    let (low, high) = range(rows.iter().map(|row| row.time_s)).unwrap_or((0.0, 0.0));
    XAxis::new(Axis::exact(low, high), "Time, s")
}

/// Driven and commanded motion over time, with the modes as bands.
pub(super) fn motion(mission: &MissionView) -> Chart {
    const TITLE: &str = "Speed and turn rate";
    let rows = &mission.result.trace.rows;
    if rows.is_empty() {
        return Chart::empty(TITLE, "The run has no tick, so there is no motion to show.");
    }
    let true_range = |value: fn(&Twist) -> f64| {
        let (low, high) = range(rows.iter().map(|row| value(&row.twist))).unwrap_or((0.0, 0.0));
        format!("{} to {}", fixed(low, 2), fixed(high, 2))
    };
    let panel = |title: &str, value: fn(&Twist) -> f64| {
        let values = rows.iter().flat_map(|row| [value(&row.twist), value(&row.command)]);
        let (low, high) = range(values).unwrap_or((0.0, 0.0));
        let bands = MODES.iter().skip(1).map(|(mode, class)| {
            Mark::Bands(class, mode_bands(rows, *mode, mission.control_period_s()))
        });
        let line = |class, of: fn(&TraceRow) -> &Twist| {
            Mark::Line(class, rows.iter().map(|row| [row.time_s, value(of(row))]).collect())
        };
        let lines = [line("true", |row| &row.twist), line("command", |row| &row.command)];
        let y = Axis::rounded(low.min(0.0), high.max(MIN_MOTION_RANGE));
        Panel::new(title, 114.0, y, bands.chain(lines))
    };
    let panels = vec![
        panel("Speed, m/s", |twist| twist.linear),
        panel("Turn rate, rad/s (left is positive)", |twist| twist.angular),
    ];
    let modes = MODES.iter().filter_map(|&(mode, class)| {
        let count = rows.iter().filter(|row| row.mode == mode).count();
        let percent = fixed(100.0 * count as f64 / rows.len() as f64, 1);
        let text = format!("{}, {percent} % of ticks", mode.name());
        (count > 0).then(|| LegendEntry::area(class, text))
    });
    let lines = [LegendEntry::line("true", "driven"), LegendEntry::line("command", "command")];
    let alt_text = format!(
        "Driven and commanded speed and turn rate over time: true in a simulation, measured by a real base. The driven speed is {} m/s, the \
         driven turn rate {} rad/s.",
        true_range(|twist| twist.linear),
        true_range(|twist| twist.angular)
    );
    let table = Table::of_ticks(
        "motion",
        rows,
        &[
            ("time, s", |row| fixed(row.time_s, 2)),
            ("speed, m/s", |row| fixed(row.twist.linear, 3)),
            ("commanded, m/s", |row| fixed(row.command.linear, 3)),
            ("turn rate, rad/s", |row| fixed(row.twist.angular, 3)),
            ("commanded, rad/s", |row| fixed(row.command.angular, 3)),
            ("mode", |row| row.mode.name().to_owned()),
            ("admissible samples", |row| format!("{} of {}", row.admissible, row.samples)),
        ],
    );
    Chart {
        legend: lines.into_iter().chain(modes).collect(),
        caption: "The background shows the mode.".to_owned(),
        table: Some(table),
        ..Chart::of_panels(TITLE, time_axis(rows), panels, alt_text)
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
pub(super) fn gap(mission: &MissionView) -> Chart {
    const TITLE: &str = "Gap to the nearest obstacle";
    let rows = &mission.result.trace.rows;
    let Some(closest) = closest(rows) else {
        return Chart::empty(TITLE, "No obstacle was in range at any tick.");
    };
    let widest = finite_gaps(rows).map(|row| row.gap_m).fold(MIN_GAP_RANGE_M, f64::max);
    let (gap_m, time_s) = (fixed(closest.gap_m, 3), fixed(closest.time_s, 1));
    let panel = Panel::new(
        "Gap, m",
        266.0,
        Axis::rounded(closest.gap_m.min(0.0), widest),
        [
            Mark::AreaBelow("contact", 0.0),
            Mark::Line("gap", rows.iter().map(|row| [row.time_s, row.gap_m]).collect()),
            Mark::Level(0.0, None),
            Mark::Circles("closest", 5.0, vec![[closest.time_s, closest.gap_m]]),
        ],
    );
    let alt_text = format!(
        "Gap between the robot and the nearest obstacle over {} ticks. The smallest gap is {gap_m} m at {time_s} s.",
        rows.len()
    );
    let breaks = match rows.len() - finite_gaps(rows).count() {
        0 => String::new(),
        ticks => format!(" The line breaks at {ticks} ticks without an obstacle in range."),
    };
    let table = Table::of_ticks(
        "gap",
        rows,
        &[("time, s", |row| fixed(row.time_s, 2)), ("gap, m", |row| fixed(row.gap_m, 3))],
    );
    Chart {
        legend: vec![
            LegendEntry::line("gap", "gap, from the edge of the footprint"),
            LegendEntry::line("limit", "contact"),
            LegendEntry::circle("closest", 5.0, format!("smallest, {gap_m} m at {time_s} s")),
        ],
        caption: format!("At or below zero the robot touches something.{breaks}"),
        table: Some(table),
        ..Chart::of_panels(TITLE, time_axis(rows), vec![panel], alt_text)
    }
}

fn finite_gaps(rows: &[TraceRow]) -> impl Iterator<Item = &TraceRow> {
    rows.iter().filter(|row| row.gap_m.is_finite() && row.time_s.is_finite())
}

/// The tick of the smallest gap, the first of several.
pub(super) fn closest(rows: &[TraceRow]) -> Option<&TraceRow> {
    finite_gaps(rows).min_by(|a, b| a.gap_m.total_cmp(&b.gap_m))
}

/// The timed decisions of a mission, at least one.
pub(super) struct Latency {
    pub(super) summary: LatencySummary,
    /// Time of each decision, s, and its latency, ms, above zero.
    ticks: Vec<[f64; 2]>,
    /// Number of entries that are no time or have no tick.
    ignored: usize,
    /// Deadline of a decision, ms; none without a control period.
    deadline_ms: Option<f64>,
    latencies: Latencies,
}

impl Latency {
    /// The decisions of a mission; none if none was timed.
    pub(super) fn new(mission: &MissionView) -> Option<Self> {
        let (rows, decision_s) = (&mission.result.trace.rows, &mission.result.decision_s);
        let mut latencies = Latencies::default();
        let ticks: Vec<[f64; 2]> = rows
            .iter()
            .zip(decision_s)
            .filter(|(row, took_s)| row.time_s.is_finite() && latencies.record(**took_s).is_ok())
            .map(|(row, took_s)| [row.time_s, (took_s * 1e3).max(MIN_MS)])
            .collect();
        let deadline_ms = mission.control_period_s() * 1e3;
        Some(Self {
            ignored: decision_s.len() - ticks.len(),
            deadline_ms: (deadline_ms.is_finite() && deadline_ms > 0.0).then_some(deadline_ms),
            summary: latencies.summary()?,
            ticks,
            latencies,
        })
    }

    fn fastest_ms(&self) -> f64 {
        let times = self.ticks.iter().map(|[_, ms]| *ms);
        times.fold(self.slowest_ms(), f64::min)
    }

    fn slowest_ms(&self) -> f64 {
        self.summary.max_ms.max(MIN_MS)
    }

    fn text(&self) -> String {
        format!(
            "Half of {} decisions took at most {} ms, 99 % at most {} ms, the slowest {} ms.",
            self.summary.count,
            significant(self.summary.p50_ms),
            significant(self.summary.p99_ms),
            significant(self.summary.max_ms)
        )
    }

    /// Sentences on late decisions and ignored entries.
    fn late_text(&self) -> String {
        let late = self.deadline_ms.map(|deadline_ms| {
            let late = self.ticks.iter().filter(|[_, ms]| *ms > deadline_ms).count();
            format!(
                "{late} of {} decisions took longer than the control period.",
                self.summary.count
            )
        });
        let ignored = (self.ignored > 0).then(|| {
            format!("{} entries are ignored: they are no times or have no tick.", self.ignored)
        });
        late.into_iter().chain(ignored).collect::<Vec<_>>().join(" ")
    }

    /// Latency over time.
    fn over_time(&self, rows: &[TraceRow]) -> Chart {
        let highest_ms = self.slowest_ms().max(self.deadline_ms.unwrap_or(0.0));
        let deadline = self.deadline_ms.map(|deadline_ms| {
            let label = format!("control period, {} ms", significant(deadline_ms));
            Mark::Level(deadline_ms, Some((LabelSide::Right, label)))
        });
        let panel = Panel::new(
            "Latency of one decision, ms (logarithmic)",
            226.0,
            // The label of the deadline stands above its line.
            Axis::logarithmic(self.fastest_ms(), highest_ms * 1.5),
            [Mark::Dots("latency", self.ticks.clone())].into_iter().chain(deadline),
        );
        let mark = html! { path class="latency" d="M6 8h0M14 5h0M22 9h0" {} };
        let caption = self.late_text();
        let alt_text = format!("Decision latency over time. {} {caption}", self.text());
        let table = Table::of_ticks(
            "latency",
            &self.ticks,
            &[
                ("time, s", |[time_s, _]| fixed(*time_s, 2)),
                ("latency, ms", |[_, ms]| significant(*ms)),
            ],
        );
        Chart {
            legend: vec![
                LegendEntry::new(mark, "one decision, measured end to end"),
                LegendEntry::line("limit", "deadline"),
            ],
            caption,
            table: Some(table),
            ..Chart::of_panels("Decision latency over time", time_axis(rows), vec![panel], alt_text)
        }
    }

    /// The distribution of the latencies.
    fn distribution(&self) -> Chart {
        let x = Axis::logarithmic(self.fastest_ms(), self.slowest_ms());
        let mut counts = [0_u32; BINS];
        for &[_, ms] in &self.ticks {
            let bin = x.fraction(ms) * BINS as f64;
            counts[(bin.max(0.0) as usize).min(BINS - 1)] += 1;
        }
        let percent = |count: u32| 100.0 * f64::from(count) / self.ticks.len() as f64;
        let highest = counts.iter().copied().max().map_or(0.0, percent);
        let counted = counts.iter().enumerate().filter(|&(_, &count)| count > 0);
        let bars = counted.map(|(bin, &count)| Bar {
            x: [bin, bin + 1].map(|edge| x.value_at(edge as f64 / BINS as f64)),
            y: [0.0, percent(count)],
        });
        let percentiles = [
            ("p50", self.summary.p50_ms),
            ("p99", self.summary.p99_ms),
            ("slowest", self.slowest_ms()),
        ];
        let positions = percentiles
            .map(|(name, ms)| Mark::Position(ms, Some(format!("{name} {} ms", significant(ms)))));
        let panel = Panel::new(
            "Share of decisions, %",
            182.0,
            Axis::rounded(0.0, highest),
            [Mark::Bars("bar".to_owned(), bars.collect())].into_iter().chain(positions),
        );
        let quantiles = [0.5, 0.9, 0.95, 0.99, 0.999, 1.0]
            .map(|share| [share, self.latencies.quantile_ms(share).unwrap_or(f64::NAN)]);
        let table = Table::new(
            "percentiles",
            &quantiles,
            &[
                ("share of decisions", |[share, _]| format!("{} %", fixed(share * 100.0, 1))),
                ("latency at most, ms", |[_, ms]| significant(*ms)),
            ],
        );
        let caption = self.deadline_ms.map(|deadline_ms| {
            format!(
                "The control period of {} ms is {} times the slowest decision.",
                significant(deadline_ms),
                significant(deadline_ms / self.slowest_ms())
            )
        });
        let alt_text = format!("Distribution of the decision latency. {}", self.text());
        let x = XAxis::new(x, "Latency of one decision, ms (logarithmic)");
        Chart {
            legend: vec![
                LegendEntry::area("bar", "share of decisions"),
                LegendEntry::line("percentile", "percentiles and the slowest"),
            ],
            caption: caption.unwrap_or_default(),
            table: Some(table),
            ..Chart::of_panels("Distribution of the decision latency", x, vec![panel], alt_text)
        }
    }
}

/// The charts of the decision times.
pub(super) fn latency(rows: &[TraceRow], latency: Option<&Latency>) -> Vec<Chart> {
    match latency {
        Some(latency) => vec![latency.over_time(rows), latency.distribution()],
        None => vec![Chart::empty("Decision latency", "No decision of this run was timed.")],
    }
}
