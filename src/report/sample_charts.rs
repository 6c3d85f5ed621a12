//! Charts over the number of samples of the dynamic window: latency, regret, and missions in closed loop.

use core::fmt::{self, Display};

use maud::{Markup, html};

use super::chart::{
    Axis, Bar, Chart, LabelSide, Mark, Panel, Plot, Series, Upper, XAxis, curves, range,
    series_alt_text, series_by_name, series_class, series_legend,
};
use super::figure::{ChartFigure, Table};
use super::number::{fixed, significant};
use super::svg::LegendEntry;
use crate::bench::{DensityRow, QualityRow, RATES_HZ, SkippedCell};
use crate::experiment::Group;

const LATENCY: &str = "Sampling density against latency";
const QUALITY: &str = "Sampling density against the quality of the command";
const CLOSED_LOOP: &str = "Sampling density in closed loop";
/// The sentence of a page without timed engines.
pub(super) const NO_LATENCY: &str = "No engine was timed at any density.";

/// Least regret of the chart, percent. A logarithmic axis has no zero.
const MIN_PERCENT: f64 = 0.01;

/// The rows of the density benchmark, which share one axis of samples.
pub(super) struct SampleRows<'a> {
    density: &'a [DensityRow],
    quality: &'a [QualityRow],
    closed_loop: &'a [Group],
    counts: Vec<u64>,
}

/// The axis of samples.
pub(super) fn samples_axis(counts: impl Iterator<Item = u64>) -> XAxis {
    let counts = counts.filter(|&count| count > 0).map(|count| count as f64);
    let (fewest, most) = range(counts).unwrap_or((1.0, 1.0));
    XAxis::new(Axis::logarithmic(fewest, most), "Samples of the dynamic window (logarithmic)")
}

impl<'a> SampleRows<'a> {
    pub(super) fn new(
        density: &'a [DensityRow],
        quality: &'a [QualityRow],
        closed_loop: &'a [Group],
    ) -> Self {
        let density_counts = density.iter().map(|row| row.samples as u64);
        let quality_counts = quality.iter().map(|row| row.samples as u64);
        let counts =
            density_counts.chain(quality_counts).chain(closed_loop.iter().map(|row| row.samples));
        Self { density, quality, closed_loop, counts: counts.collect() }
    }

    fn axis(&self) -> XAxis {
        samples_axis(self.counts.iter().copied())
    }

    /// The latency of each engine.
    pub(super) fn latency(&self) -> ChartFigure {
        let rows = self.density;
        let mut caption =
            "Lines are medians; the shaded band reaches up to the 99th percentile.".to_owned();
        if let Some(row) = rows.first().filter(|_| !has_several_horizons(rows)) {
            let steps = row.steps.to_string();
            caption += &[" Each sample is simulated for ", &steps, " steps."].concat();
        }
        ChartFigure {
            chart: self.latency_chart(),
            caption,
            table: Table::of_columns(
                "density against latency",
                rows,
                &[
                    "name",
                    "samples",
                    "steps",
                    "p50_ms",
                    "p95_ms",
                    "p99_ms",
                    "max_ms",
                    "decisions",
                    "missed_20_hz",
                    "missed_50_hz",
                    "missed_100_hz",
                    "steps_per_s",
                ],
            ),
        }
    }

    fn latency_chart(&self) -> Chart {
        let series = latency_series(self.density);
        let values =
            series.iter().flat_map(|series| &series.rows).flat_map(|row| [row.p50_ms, row.p99_ms]);
        let periods_ms = RATES_HZ.map(|rate_hz| 1e3 / rate_hz);
        if series.is_empty() {
            return Chart::empty(LATENCY, NO_LATENCY);
        }
        let (fastest_ms, slowest_ms) = range(values.chain(periods_ms)).unwrap_or((1.0, 1.0));
        let levels = RATES_HZ.iter().zip(periods_ms).map(|(rate_hz, period_ms)| {
            let label = format!("{rate_hz} Hz");
            Mark::Level(period_ms, Some((LabelSide::Outside, label)))
        });
        let curves =
            curves(&series, Upper::Band, |row| Some([row.samples as f64, row.p50_ms, row.p99_ms]));
        let mut legend = series_legend(&series);
        legend.push(LegendEntry::line("limit", "period of a control loop"));
        Chart {
            title: LATENCY.to_owned(),
            plot: Plot::Panels {
                x: self.axis(),
                panels: vec![Panel {
                    title: "Latency of one decision, ms (logarithmic)".to_owned(),
                    height: 286.0,
                    y: Axis::logarithmic(fastest_ms, slowest_ms),
                    marks: levels.chain(curves).collect(),
                }],
            },
            legend,
            alt_text: series_alt_text(
                "Median latency of one decision against the number of samples",
                &series,
                |row| {
                    let ms = significant(row.p50_ms);
                    Some(format!("{ms} ms with {} samples", row.samples))
                },
            ),
        }
    }

    /// The regret of each window and shape.
    pub(super) fn quality(&self) -> ChartFigure {
        let rows = self.quality;
        let (decisions, densest) = rows.first().map_or((0, 0), |row| (row.decisions, row.densest));
        ChartFigure {
            chart: self.quality_chart(),
            caption: format!(
                "Lines are medians of {decisions} decisions, dashed lines the worst. 0 % equals the choice among \
                 {densest} samples, 100 % a random sample. {MIN_PERCENT} % includes all smaller values. v : omega is \
                 the number of forward speeds to that of turn rates."
            ),
            table: Table::of_columns(
                "density against quality",
                rows,
                &[
                    "window_s",
                    "samples",
                    "vx_samples",
                    "vtheta_samples",
                    "decisions",
                    "without_command",
                    "regret_p50",
                    "regret_max",
                    "v_off_p50_m_s",
                    "v_off_max_m_s",
                    "omega_off_p50_rad_s",
                    "omega_off_max_rad_s",
                ],
            ),
        }
    }

    fn quality_chart(&self) -> Chart {
        let point = |row: &QualityRow| {
            let (median, worst) = (percent(row.regret_p50)?, percent(row.regret_max)?);
            (row.samples > 0 && row.window_s.is_finite()).then_some([
                row.samples as f64,
                median,
                worst,
            ])
        };
        let name = |row: &QualityRow| {
            point(row)?;
            let shape = SamplingShape::new(row.vx_samples, row.vtheta_samples)?;
            Some(format!("window {} s, {shape}", row.window_s))
        };
        let series = series_by_name(self.quality, name, |row| row.samples as u64);
        if series.is_empty() {
            return Chart::empty(QUALITY, "No commands were compared.");
        }
        let rows = series.iter().flat_map(|series| &series.rows);
        let worst = rows.filter_map(|row| percent(row.regret_max)).fold(MIN_PERCENT, f64::max);
        let mut legend = series_legend(&series);
        legend.push(LegendEntry::line("upper", "the worst of all decisions"));
        Chart {
            title: QUALITY.to_owned(),
            plot: Plot::Panels {
                x: self.axis(),
                panels: vec![Panel {
                    title: "Regret, % of the gain of choosing (logarithmic)".to_owned(),
                    height: 286.0,
                    y: Axis::logarithmic(MIN_PERCENT, worst),
                    marks: curves(&series, Upper::Line, point),
                }],
            },
            legend,
            alt_text: series_alt_text(
                "Median regret against the number of samples",
                &series,
                |row| {
                    let median = significant(percent(row.regret_p50)?);
                    Some(format!("{median} % with {} samples", row.samples))
                },
            ),
        }
    }

    /// Success and time of the missions with each sampling.
    pub(super) fn closed_loop(&self) -> ChartFigure {
        ChartFigure {
            chart: self.closed_loop_chart(),
            caption: "The same random missions with each sampling. Lines are median times, dashed lines the 90th \
                percentile. v : omega is the number of forward speeds to that of turn rates."
                .to_owned(),
            table: Table::of_columns(
                "density in closed loop",
                self.closed_loop,
                &[
                    "samples",
                    "vx_samples",
                    "vtheta_samples",
                    "runs",
                    "reached",
                    "contacts",
                    "shared_time_p50_s",
                    "shared_time_p90_s",
                    "mean_time_ratio",
                    "mean_clearance_reached_m",
                    "tick_p50_ms",
                    "tick_p99_ms",
                ],
            ),
        }
    }

    fn closed_loop_chart(&self) -> Chart {
        let name = |row: &Group| {
            let shape = SamplingShape::new(row.vx_samples, row.vtheta_samples)?;
            (row.samples > 0 && row.runs > 0).then(|| shape.to_string())
        };
        let series = series_by_name(self.closed_loop, name, |row| row.samples);
        let Some(first) = series.first().and_then(|series| series.rows.first()) else {
            return Chart::empty(CLOSED_LOOP, "No mission was driven.");
        };
        let reached_percent = |row: &Group| 100.0 * row.reached as f64 / row.runs as f64;
        let rows = series.iter().flat_map(|series| &series.rows);
        let slowest_s = rows
            .filter_map(|row| time_s(row))
            .fold(0.0, |slowest_s: f64, (_, far_s)| slowest_s.max(far_s));
        let success = Panel {
            title: format!("Goal reached, % of {} missions", first.runs),
            height: 106.0,
            y: Axis::exact(0.0, 100.0),
            marks: grouped_bars(&series, |row| (row.samples as f64, reached_percent(row))),
        };
        let time = Panel {
            title: format!(
                "Time of missions reached by all ({} of {}), s",
                first.shared, first.runs
            ),
            height: 138.0,
            y: Axis::rounded(0.0, slowest_s),
            marks: curves(&series, Upper::Line, |row| {
                let (median_s, far_s) = time_s(row)?;
                Some([row.samples as f64, median_s, far_s])
            }),
        };
        let mut legend = series_legend(&series);
        legend.push(LegendEntry::line("upper", "time, 90th percentile"));
        Chart {
            title: CLOSED_LOOP.to_owned(),
            plot: Plot::Panels { x: self.axis(), panels: vec![success, time] },
            legend,
            alt_text: series_alt_text(
                "Share of missions that reached their goal, and their median time, against the number of samples",
                &series,
                |row| {
                    let time =
                        time_s(row).map(|(median_s, _)| format!("{} s", significant(median_s)));
                    let time = time.unwrap_or_else(|| "no time".to_owned());
                    let reached = fixed(reached_percent(row), 0);
                    Some(format!("{reached} % and {time} with {} samples", row.samples))
                },
            ),
        }
    }
}

/// A group of bars at each position, one bar for each series: curves would cover each other.
fn grouped_bars<R>(series: &[Series<R>], point: impl Fn(&R) -> (f64, f64)) -> Vec<Mark> {
    // The groups are half an octave wide, and the axis is logarithmic.
    let count = series.len().max(1) as f64;
    let ratio = libm::exp2(0.5 / count);
    let bars = |(index, series): (usize, &Series<R>)| {
        let bar = |row: &&R| {
            let (x, height) = point(row);
            let left = x * libm::pow(ratio, index as f64 - count / 2.0);
            Bar { x: [left, left * ratio], y: [0.0, height] }
        };
        let class = format!("{} marker", series_class(index));
        Mark::Bars(class, series.rows.iter().map(bar).collect())
    };
    series.iter().enumerate().map(bars).collect()
}

/// Median and 90th percentile of the time, s, if both are finite.
fn time_s(row: &Group) -> Option<(f64, f64)> {
    let pair = row.shared_time_p50_s.zip(row.shared_time_p90_s);
    pair.filter(|(median_s, far_s)| median_s.is_finite() && far_s.is_finite())
}

/// A finite share as a percentage of at least [`MIN_PERCENT`].
fn percent(share: Option<f64>) -> Option<f64> {
    share.filter(|share| share.is_finite()).map(|share| (share * 100.0).max(MIN_PERCENT))
}

/// Engines with the rows that a logarithmic scale can show.
fn latency_series(rows: &[DensityRow]) -> Vec<Series<'_, DensityRow>> {
    let several_horizons = has_several_horizons(rows);
    let is_shown = |ms: f64| ms.is_finite() && ms > 0.0;
    let name = |row: &DensityRow| {
        let name = if several_horizons {
            format!("{}, {} steps", row.name, row.steps)
        } else {
            row.name.clone()
        };
        (row.samples > 0 && is_shown(row.p50_ms) && is_shown(row.p99_ms)).then_some(name)
    };
    series_by_name(rows, name, |row| row.samples as u64)
}

fn has_several_horizons(rows: &[DensityRow]) -> bool {
    rows.iter().any(|row| row.steps != rows[0].steps)
}

/// The most samples of each engine that keep a rate, and the cells that were not measured.
pub(super) fn density_notes(rows: &[DensityRow], skipped: &[SkippedCell]) -> Markup {
    let series = latency_series(rows);
    let table = Table::new(
        "most samples whose 99th percentile is within the period",
        &series,
        &[
            ("engine", |series| series.name.clone()),
            ("20 Hz", |series| most_samples_at(series, RATES_HZ[0])),
            ("50 Hz", |series| most_samples_at(series, RATES_HZ[1])),
            ("100 Hz", |series| most_samples_at(series, RATES_HZ[2])),
        ],
    );
    html! {
        @if !series.is_empty() {
            div class="chart-note" {
                h3 { "Most samples at each rate" }
                p { "Up to this many samples, 99 of 100 measured decisions end within the period of the control loop." }
                (table.markup())
            }
        }
        @if !skipped.is_empty() {
            div class="chart-note" {
                h3 { "Not measured" }
                ul { @for cell in skipped { li { (cell.name) " with " (cell.samples) " samples: " (cell.reason) } } }
            }
        }
    }
}

/// The most samples up to which every measured density keeps a rate.
fn most_samples_at(series: &Series<DensityRow>, rate_hz: f64) -> String {
    let is_late = |row: &&DensityRow| row.p99_ms > 1e3 / rate_hz;
    let first_late = series.rows.iter().position(is_late);
    match first_late {
        Some(0) => format!("fewer than {}", series.rows[0].samples),
        Some(index) => series.rows[index - 1].samples.to_string(),
        None => {
            let most = series.rows.last().map_or(0, |row| row.samples);
            format!("{most} or more")
        }
    }
}

/// Turn rates for each forward speed of a sampling, to the nearest power of two: whole counts keep the ratio only
/// approximately.
struct SamplingShape(f64);

impl SamplingShape {
    /// The shape of a sampling; none without a forward speed.
    fn new(vx_samples: u32, vtheta_samples: u32) -> Option<Self> {
        let ratio = f64::from(vtheta_samples.max(1)) / f64::from(vx_samples);
        (vx_samples > 0).then(|| Self(libm::exp2(libm::round(libm::log2(ratio)))))
    }
}

impl Display for SamplingShape {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0 < 1.0 {
            write!(out, "v : omega = {}:1", 1.0 / self.0)
        } else {
            write!(out, "v : omega = 1:{}", self.0)
        }
    }
}
