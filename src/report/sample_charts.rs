//! Charts over the number of samples of the dynamic window: latency, regret, and missions in closed loop.

use core::fmt::{self, Display};

use maud::{Markup, html};

use super::chart::{
    Axis, Bar, Chart, Curve, LabelSide, Mark, Panel, Upper, XAxis, marker, range, series_class,
};
use super::figure::Table;
use super::number::{fixed, significant};
use super::page::Tile;
use super::svg::LegendEntry;
use crate::bench::{DensityRow, QualityRow, RATES_HZ, SkippedCell, named_sampler};
use crate::experiment::Group;
use crate::local::Sampler;

/// The sentence of a page without timed engines.
pub(super) const NO_LATENCY: &str = "No engine was timed at any density.";

/// Least regret of the chart, percent. A logarithmic axis has no zero.
const MIN_PERCENT: f64 = 0.01;

/// Rows of one name, in ascending order of their samples.
struct Series<'a, R> {
    name: String,
    rows: Vec<&'a R>,
}

/// The series of a chart.
pub(super) struct AllSeries<'a, R> {
    all: Vec<Series<'a, R>>,
    samples: fn(&R) -> u64,
}

impl<'a, R> AllSeries<'a, R> {
    /// Groups rows by name, in the order in which the names first occur. Rows without a name are left out.
    pub(super) fn new(
        rows: &'a [R],
        samples: fn(&R) -> u64,
        name: impl Fn(&R) -> Option<String>,
    ) -> Self {
        let mut all: Vec<Series<R>> = Vec::new();
        for row in rows {
            let Some(name) = name(row) else { continue };
            match all.iter_mut().find(|series| series.name == name) {
                Some(series) => series.rows.push(row),
                None => all.push(Series { name, rows: vec![row] }),
            }
        }
        for series in &mut all {
            series.rows.sort_by_key(|row| samples(row));
        }
        Self { all, samples }
    }

    pub(super) fn rows(&self) -> impl Iterator<Item = &'a R> {
        self.all.iter().flat_map(|series| series.rows.iter().copied())
    }

    /// The axis of the samples of these series.
    pub(super) fn axis(&self) -> XAxis {
        samples_axis(self.rows().map(self.samples))
    }

    /// A curve for each series, from the median and the upper value of each row.
    pub(super) fn curves(
        &self,
        upper: Upper,
        values: impl Fn(&R) -> Option<[f64; 2]>,
    ) -> Vec<Mark> {
        let point = |row: &&R| {
            let [median, upper] = values(row)?;
            Some([(self.samples)(row) as f64, median, upper])
        };
        let curve = |(index, series): (usize, &Series<R>)| {
            let points = series.rows.iter().filter_map(point).collect();
            Mark::Curve(Curve { index, points, upper })
        };
        self.all.iter().enumerate().map(curve).collect()
    }

    /// A group of bars at each position, one bar for each series: curves would cover each other.
    fn grouped_bars(&self, height: impl Fn(&R) -> f64) -> Vec<Mark> {
        // The groups are half an octave wide, and the axis is logarithmic.
        let count = self.all.len().max(1) as f64;
        let ratio = libm::exp2(0.5 / count);
        let bars = |(index, series): (usize, &Series<R>)| {
            let bar = |row: &&R| {
                let x = (self.samples)(row) as f64;
                let left = x * libm::pow(ratio, index as f64 - count / 2.0);
                Bar { x: [left, left * ratio], y: [0.0, height(row)] }
            };
            let class = format!("{} marker", series_class(index));
            Mark::Bars(class, series.rows.iter().map(bar).collect())
        };
        self.all.iter().enumerate().map(bars).collect()
    }

    pub(super) fn legend(&self) -> Vec<LegendEntry> {
        let entry = |(index, series): (usize, &Series<R>)| {
            let mark = html! {
                g class=(series_class(index)) {
                    line class="median" x1="1" x2="27" y1="7" y2="7" {}
                    (marker(index, 14.0, 7.0))
                }
            };
            LegendEntry::new(mark, series.name.as_str())
        };
        self.all.iter().enumerate().map(entry).collect()
    }

    /// A text alternative that names the first and the last row of each series.
    pub(super) fn alt_text(&self, start: &str, text: impl Fn(&R) -> Option<String>) -> String {
        let row_text = |row: &R| {
            let samples = (self.samples)(row);
            Some(format!("{} with {samples} samples", text(row)?))
        };
        let ends = self.all.iter().filter_map(|series| {
            let (first, last) = (row_text(series.rows.first()?)?, row_text(series.rows.last()?)?);
            Some(format!(" {}: {first}, {last}.", series.name))
        });
        format!("{start}.{}", ends.collect::<String>())
    }
}

/// The axis of samples.
fn samples_axis(counts: impl Iterator<Item = u64>) -> XAxis {
    let counts = counts.filter(|&count| count > 0).map(|count| count as f64);
    let (fewest, most) = range(counts).unwrap_or((1.0, 1.0));
    XAxis::new(Axis::logarithmic(fewest, most), "Samples of the dynamic window (logarithmic)")
}

/// The rows of the density benchmark, which share one axis of samples.
pub(super) struct SampleRows<'a> {
    pub(super) density: &'a [DensityRow],
    pub(super) quality: &'a [QualityRow],
    pub(super) closed_loop: &'a [Group],
}

impl SampleRows<'_> {
    fn axis(&self) -> XAxis {
        let density = self.density.iter().map(|row| row.samples as u64);
        let quality = self.quality.iter().map(|row| row.samples as u64);
        samples_axis(density.chain(quality).chain(self.closed_loop.iter().map(|row| row.samples)))
    }

    /// The latency of each engine.
    pub(super) fn latency(&self) -> Chart {
        const TITLE: &str = "Sampling density against latency";
        let rows = self.density;
        let series = latency_series(rows);
        if series.all.is_empty() {
            return Chart::empty(TITLE, NO_LATENCY);
        }
        let periods_ms = RATES_HZ.map(|rate_hz| 1e3 / rate_hz);
        let values = series.rows().flat_map(|row| [row.p50_ms, row.p99_ms]);
        let (fastest_ms, slowest_ms) = range(values.chain(periods_ms)).unwrap_or((1.0, 1.0));
        let levels = RATES_HZ.iter().zip(periods_ms).map(|(rate_hz, period_ms)| {
            Mark::Level(period_ms, Some((LabelSide::Outside, format!("{rate_hz} Hz"))))
        });
        let curves = series.curves(Upper::Band, |row| Some([row.p50_ms, row.p99_ms]));
        let panel = Panel::new(
            "Latency of one decision, ms (logarithmic)",
            286.0,
            Axis::logarithmic(fastest_ms, slowest_ms),
            levels.chain(curves),
        );
        let mut legend = series.legend();
        legend.push(LegendEntry::line("limit", "period of a control loop"));
        let alt_text = series
            .alt_text("Median latency of one decision against the number of samples", |row| {
                Some(format!("{} ms", significant(row.p50_ms)))
            });
        let steps = match rows {
            [row, ..] if !has_several_horizons(rows) => {
                format!(" Each sample is simulated for {} steps.", row.steps)
            }
            _ => String::new(),
        };
        let columns = [DensityRow::SUMMARY, " steps_per_s"].concat();
        Chart {
            legend,
            caption: format!(
                "Lines are medians; the shaded band reaches up to the 99th percentile.{steps}"
            ),
            table: Some(Table::of_columns("density against latency", rows, &columns)),
            ..Chart::of_panels(TITLE, self.axis(), vec![panel], alt_text)
        }
    }

    /// The regret of each window and shape.
    pub(super) fn quality(&self) -> Chart {
        const TITLE: &str = "Sampling density against the quality of the command";
        let rows = self.quality;
        let point = |row: &QualityRow| {
            let values = [percent(row.regret_p50)?, percent(row.regret_max)?];
            (row.samples > 0 && row.window_s.is_finite()).then_some(values)
        };
        let name = |row: &QualityRow| {
            point(row)?;
            let shape = SamplingShape::new(row.vx_samples, row.vtheta_samples)?;
            Some(format!("window {} s, {}, {shape}", row.window_s, row.sampler))
        };
        let series = AllSeries::new(rows, |row| row.samples as u64, name);
        let Some(first) = rows.first().filter(|_| !series.all.is_empty()) else {
            return Chart::empty(TITLE, "No commands were compared.");
        };
        let worst = series.rows().filter_map(|row| percent(row.regret_max));
        let panel = Panel::new(
            "Regret, % of the gain of choosing (logarithmic)",
            286.0,
            Axis::logarithmic(MIN_PERCENT, worst.fold(MIN_PERCENT, f64::max)),
            series.curves(Upper::Line, point),
        );
        let mut legend = series.legend();
        legend.push(LegendEntry::line("upper", "the worst of all decisions"));
        let alt_text = series.alt_text("Median regret against the number of samples", |row| {
            Some(format!("{} %", significant(percent(row.regret_p50)?)))
        });
        let columns = [QualityRow::SUMMARY, " decisions"].concat();
        Chart {
            legend,
            caption: format!(
                "Lines are medians of {} decisions, dashed lines the worst. 0 % equals the choice among {} samples, 100 % a \
                 random sample. {MIN_PERCENT} % includes all smaller values. v : omega is the number of forward speeds to \
                 that of turn rates.",
                first.decisions, first.densest
            ),
            table: Some(Table::of_columns("density against quality", rows, &columns)),
            ..Chart::of_panels(TITLE, self.axis(), vec![panel], alt_text)
        }
    }

    /// Success and time of the missions with each sampling.
    pub(super) fn closed_loop(&self) -> Chart {
        const TITLE: &str = "Sampling density in closed loop";
        // Groups of another sampler than arcs have its name.
        const ARCS: &str = Sampler::Arcs.name();
        let has_samplers = self.closed_loop.iter().any(|row| row.config.is_some());
        let name = |row: &Group| {
            let shape = SamplingShape::new(row.vx_samples, row.vtheta_samples)?;
            let sampler = has_samplers.then(|| row.config.as_deref().unwrap_or(ARCS));
            let sampler = sampler.map_or_else(String::new, |sampler| format!("{sampler}, "));
            (row.samples > 0 && row.runs > 0).then(|| format!("{sampler}{shape}"))
        };
        let times_s = |row: &Group| {
            let times_s = [row.shared_time_p50_s?, row.shared_time_p90_s?];
            times_s.iter().all(|time_s| time_s.is_finite()).then_some(times_s)
        };
        let series = AllSeries::new(self.closed_loop, |row| row.samples, name);
        let Some(first) = series.rows().next() else {
            return Chart::empty(TITLE, "No mission was driven.");
        };
        let slowest_s = series.rows().filter_map(times_s).map(|[_, far_s]| far_s);
        let success = Panel::new(
            format!("Goal reached, % of {} missions", first.runs),
            106.0,
            Axis::exact(0.0, 100.0),
            series.grouped_bars(reached_percent),
        );
        let time = Panel::new(
            format!("Time of missions reached by all ({} of {}), s", first.shared, first.runs),
            138.0,
            Axis::rounded(0.0, slowest_s.fold(0.0, f64::max)),
            series.curves(Upper::Line, times_s),
        );
        let mut legend = series.legend();
        legend.push(LegendEntry::line("upper", "time, 90th percentile"));
        let alt_text = series.alt_text(
            "Share of missions that reached their goal, and their median time, against the number of samples",
            |row| Some(reached_text(row, 0, times_s(row).map(|[median_s, _]| median_s))),
        );
        let columns = "config samples vx_samples vtheta_samples runs reached contacts shared_time_p50_s shared_time_p90_s \
            mean_time_ratio mean_clearance_reached_m omega_sign_changes_per_m time_lost_per_person_s tick_p50_ms tick_p99_ms";
        Chart {
            legend,
            caption: "The same random missions with each sampling. Lines are median times, dashed lines the 90th percentile. \
                v : omega is the number of forward speeds to that of turn rates."
                .to_owned(),
            table: Some(Table::of_columns("density in closed loop", self.closed_loop, columns)),
            ..Chart::of_panels(TITLE, self.axis(), vec![success, time], alt_text)
        }
    }
}

/// A finite share as a percentage of at least [`MIN_PERCENT`].
fn percent(share: Option<f64>) -> Option<f64> {
    share.filter(|share| share.is_finite()).map(|share| (share * 100.0).max(MIN_PERCENT))
}

pub(super) fn reached_percent(group: &Group) -> f64 {
    100.0 * group.reached as f64 / group.runs as f64
}

/// Share and time of a group in words.
pub(super) fn reached_text(group: &Group, decimals: usize, time_s: Option<f64>) -> String {
    let time = time_s.map(|time_s| format!("{} s", significant(time_s)));
    let time = time.unwrap_or_else(|| "no time".to_owned());
    format!("{} % and {time}", fixed(reached_percent(group), decimals))
}

/// Engines with the rows that a logarithmic scale can show.
fn latency_series(rows: &[DensityRow]) -> AllSeries<'_, DensityRow> {
    let several_horizons = has_several_horizons(rows);
    let is_shown = |ms: f64| ms.is_finite() && ms > 0.0;
    let name = |row: &DensityRow| {
        let steps = several_horizons.then(|| format!(", {} steps", row.steps));
        let name = || named_sampler(&row.name, &row.sampler) + &steps.unwrap_or_default();
        (row.samples > 0 && is_shown(row.p50_ms) && is_shown(row.p99_ms)).then(name)
    };
    AllSeries::new(rows, |row| row.samples as u64, name)
}

fn has_several_horizons(rows: &[DensityRow]) -> bool {
    rows.iter().any(|row| row.steps != rows[0].steps)
}

/// The fastest median decisions: of about a thousand samples, and of the most samples.
pub(super) fn density_tiles(rows: &[DensityRow]) -> Vec<Tile> {
    let fastest = |samples: usize| {
        let of = rows.iter().filter(move |row| row.samples == samples);
        of.min_by(|one, other| one.p50_ms.total_cmp(&other.p50_ms))
    };
    let tile = |row: &DensityRow| {
        (
            format!("{} samples, fastest", grouped(row.samples)),
            significant(row.p50_ms),
            "ms, median",
        )
    };
    let about = rows.iter().map(|row| row.samples).min_by_key(|samples| samples.abs_diff(1024));
    let most = rows.iter().map(|row| row.samples).max();
    let both = [about, most.filter(|most| about != Some(*most))];
    both.into_iter().flatten().filter_map(fastest).map(tile).collect()
}

/// A count with commas between its thousands.
fn grouped(count: usize) -> String {
    let digits = count.to_string();
    let first = digits.len() % 3;
    let mut text = digits[..first].to_owned();
    for (place, digit) in digits[first..].chars().enumerate() {
        if place % 3 == 0 && !text.is_empty() {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// The most samples of each engine that keep a rate, and the cells that were not measured.
pub(super) fn density_notes(rows: &[DensityRow], skipped: &[SkippedCell]) -> Markup {
    let series = latency_series(rows).all;
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
                ul { @for cell in skipped { li { (named_sampler(&cell.name, &cell.sampler)) " with " (cell.samples) " samples: " (cell.reason) } } }
            }
        }
    }
}

/// The most samples up to which every measured density keeps a rate.
fn most_samples_at(series: &Series<DensityRow>, rate_hz: f64) -> String {
    let is_late = |row: &&DensityRow| row.p99_ms > 1e3 / rate_hz;
    match series.rows.iter().position(is_late) {
        Some(0) => format!("fewer than {}", series.rows[0].samples),
        Some(index) => series.rows[index - 1].samples.to_string(),
        None => format!("{} or more", series.rows.last().map_or(0, |row| row.samples)),
    }
}

/// Turn rates for each forward speed of a sampling, to the nearest power of two: whole counts keep the ratio only
/// approximately.
pub(super) struct SamplingShape(f64);

impl SamplingShape {
    /// The shape of a sampling; none without a forward speed.
    pub(super) fn new(vx_samples: u32, vtheta_samples: u32) -> Option<Self> {
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
