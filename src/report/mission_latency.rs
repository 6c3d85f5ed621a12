//! The decision times of a mission: over time, and their distribution.

use super::chart::{Axis, Bar, Chart, LabelSide, Mark, Panel, Plot, XAxis};
use super::figure::{ChartFigure, Table};
use super::mission_charts::time_axis;
use super::number::{fixed, significant};
use super::svg::LegendEntry;
use super::views::MissionView;
use crate::bench::{Latencies, LatencySummary};
use crate::runtime::TraceRow;
use maud::html;

/// Least latency on a logarithmic axis, ms. It is below the resolution of any clock.
const MIN_MS: f64 = 1e-5;

/// Bars of the distribution.
const BINS: usize = 80;

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
        let mut latencies = Latencies::default();
        let ticks: Vec<[f64; 2]> = mission
            .trace
            .rows
            .iter()
            .zip(mission.latency_ms)
            .filter(|(row, ms)| row.time_s.is_finite() && latencies.record(*ms / 1e3).is_ok())
            .map(|(row, ms)| [row.time_s, ms.max(MIN_MS)])
            .collect();
        let deadline_ms = mission.control_period_s * 1e3;
        Some(Self {
            ignored: mission.latency_ms.len() - ticks.len(),
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
        let mut sentences = Vec::new();
        if let Some(deadline_ms) = self.deadline_ms {
            let late = self.ticks.iter().filter(|[_, ms]| *ms > deadline_ms);
            sentences.push(format!(
                "{} of {} decisions took longer than the control period.",
                late.count(),
                self.summary.count
            ));
        }
        if self.ignored > 0 {
            sentences.push(format!(
                "{} entries are ignored: they are no times or have no tick.",
                self.ignored
            ));
        }
        sentences.join(" ")
    }

    /// Latency over time.
    fn over_time(&self, rows: &[TraceRow]) -> ChartFigure {
        let highest_ms = self.slowest_ms().max(self.deadline_ms.unwrap_or(0.0));
        let deadline = self.deadline_ms.map(|deadline_ms| {
            let label = format!("control period, {} ms", significant(deadline_ms));
            Mark::Level(deadline_ms, Some((LabelSide::Right, label)))
        });
        let dots = Mark::Dots("latency", self.ticks.clone());
        let mark = html! { path class="latency" d="M6 8h0M14 5h0M22 9h0" {} };
        let caption = self.late_text();
        let chart = Chart {
            title: "Decision latency over time".to_owned(),
            plot: Plot::Panels {
                x: time_axis(rows),
                panels: vec![Panel {
                    title: "Latency of one decision, ms (logarithmic)".to_owned(),
                    height: 226.0,
                    // The label of the deadline stands above its line.
                    y: Axis::logarithmic(self.fastest_ms(), highest_ms * 1.5),
                    marks: [dots].into_iter().chain(deadline).collect(),
                }],
            },
            legend: vec![
                LegendEntry::new(mark, "one decision, measured end to end"),
                LegendEntry::line("limit", "deadline"),
            ],
            alt_text: format!("Decision latency over time. {} {caption}", self.text()),
        };
        ChartFigure {
            chart,
            caption,
            table: Table::of_ticks(
                "latency",
                &self.ticks,
                &[
                    ("time, s", |[time_s, _]| fixed(*time_s, 2)),
                    ("latency, ms", |[_, ms]| significant(*ms)),
                ],
            ),
        }
    }

    /// The distribution of the latencies.
    fn distribution(&self) -> ChartFigure {
        let x = Axis::logarithmic(self.fastest_ms(), self.slowest_ms());
        let mut counts = [0_u32; BINS];
        for &[_, ms] in &self.ticks {
            let bin = x.fraction(ms) * BINS as f64;
            counts[(bin.max(0.0) as usize).min(BINS - 1)] += 1;
        }
        let percent = |count: u32| 100.0 * f64::from(count) / self.ticks.len() as f64;
        let highest = counts.iter().copied().max().map_or(0.0, percent);
        let bars = counts
            .iter()
            .enumerate()
            .filter(|&(_, &count)| count > 0)
            .map(|(bin, &count)| Bar {
                x: [bin, bin + 1].map(|edge| x.value_at(edge as f64 / BINS as f64)),
                y: [0.0, percent(count)],
            })
            .collect();
        let percentiles = [
            ("p50", self.summary.p50_ms),
            ("p99", self.summary.p99_ms),
            ("slowest", self.slowest_ms()),
        ];
        let positions = percentiles.map(|(name, ms)| {
            let label = format!("{name} {} ms", significant(ms));
            Mark::Position(ms, Some(label))
        });
        let chart = Chart {
            title: "Distribution of the decision latency".to_owned(),
            plot: Plot::Panels {
                x: XAxis::new(x, "Latency of one decision, ms (logarithmic)"),
                panels: vec![Panel {
                    title: "Share of decisions, %".to_owned(),
                    height: 182.0,
                    y: Axis::rounded(0.0, highest),
                    marks: [Mark::Bars("bar".to_owned(), bars)]
                        .into_iter()
                        .chain(positions)
                        .collect(),
                }],
            },
            legend: vec![
                LegendEntry::area("bar", "share of decisions"),
                LegendEntry::line("percentile", "percentiles and the slowest"),
            ],
            alt_text: format!("Distribution of the decision latency. {}", self.text()),
        };
        let caption = self.deadline_ms.map_or_else(String::new, |deadline_ms| {
            format!(
                "The control period of {} ms is {} times the slowest decision.",
                significant(deadline_ms),
                significant(deadline_ms / self.slowest_ms())
            )
        });
        let quantiles = [0.5, 0.9, 0.95, 0.99, 0.999, 1.0].map(|share| {
            let ms = self.latencies.quantile_ms(share).unwrap_or(f64::NAN);
            [share, ms]
        });
        ChartFigure {
            chart,
            caption,
            table: Table::new(
                "percentiles",
                &quantiles,
                &[
                    ("share of decisions", |[share, _]| format!("{} %", fixed(share * 100.0, 1))),
                    ("latency at most, ms", |[_, ms]| significant(*ms)),
                ],
            ),
        }
    }
}

/// The figures of the decision times.
pub(super) fn figures(rows: &[TraceRow], latency: Option<&Latency>) -> Vec<ChartFigure> {
    match latency {
        Some(latency) => vec![latency.over_time(rows), latency.distribution()],
        None => vec![ChartFigure {
            chart: Chart::empty("Decision latency", "No decision of this run was timed."),
            caption: String::new(),
            table: Table::new("", &[(); 0], &[]),
        }],
    }
}
