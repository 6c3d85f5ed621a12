//! Sampling density against latency, for every engine.

use maud::{Markup, html};

use super::axis::Axis;
use super::curves::{Curve, Far, Plot};
use super::figure::{Figure, Table, nothing_to_show};
use super::number::{coordinate, shortened, significant};
use super::panel::{Panel, chart};
use super::samples_axis::SAMPLES;
use crate::bench::{DensityRow, RATES_HZ, SkippedCell};

const TITLE: &str = "Sampling density against latency";
const HEIGHT: f64 = 360.0;

/// One engine with its rows in order of density.
struct Series<'a> {
    name: String,
    rows: Vec<&'a DensityRow>,
}

pub(super) fn figure(rows: &[DensityRow], samples: Axis) -> Markup {
    let Some(plot) = plot(rows, samples) else {
        return nothing_to_show(TITLE, "No engine was timed at any density.");
    };
    Figure {
        title: TITLE,
        picture: chart(plot.height, &plot.alternative, &plot.content),
        legend: plot.legend(),
        caption: caption(rows),
        table: table(rows),
    }
    .markup()
}

/// What follows from the figure, and what it does not show.
pub(super) fn beside(rows: &[DensityRow], skipped: &[SkippedCell]) -> Markup {
    let series = series(rows);
    html! {
        @if !series.is_empty() {
            div class="beside" {
                h3 { "Most samples that fit" }
                p { "As measured: up to this many samples, 99 of 100 decisions end within the period of the loop." }
                (densest(&series).markup())
            }
        }
        @if !skipped.is_empty() {
            div class="beside" {
                h3 { "Not measured" }
                ul { @for cell in skipped { li { (cell.name) " with " (cell.samples) " samples: " (cell.reason) } } }
            }
        }
    }
}

/// The panel with all engines; none where no row can be shown.
pub(super) fn plot(rows: &[DensityRow], samples: Axis) -> Option<Plot> {
    let series = series(rows);
    let usable = || series.iter().flat_map(|series| &series.rows);
    usable().next()?;
    let bounds = |value: &dyn Fn(&DensityRow) -> f64| {
        usable().fold((f64::INFINITY, 0.0), |(low, high): (f64, f64), row| {
            (low.min(value(row)), high.max(value(row)))
        })
    };
    let (fastest_ms, _) = bounds(&|row| row.p50_ms);
    let (_, slowest_ms) = bounds(&|row| row.p99_ms);
    let deadlines_ms = RATES_HZ.map(|rate| 1e3 / rate);
    let mut panel = Panel::across(
        32.0,
        286.0,
        samples,
        Axis::logarithmic(
            fastest_ms.min(deadlines_ms[2]),
            slowest_ms.max(deadlines_ms[0]),
        ),
    );
    // Room for the rates to the right.
    panel.width -= 44.0;
    let curves: Vec<Curve> = series
        .iter()
        .enumerate()
        .map(|(index, series)| series.curve(index))
        .collect();
    let content = html! {
        (panel.axes(Some(SAMPLES), "Latency of one decision, ms (logarithmic)"))
        @for (rate, ms) in RATES_HZ.iter().zip(deadlines_ms) {
            @let y = coordinate(panel.y_at(ms));
            line class="limit" x1=(coordinate(panel.left)) x2=(coordinate(panel.right())) y1=(y) y2=(y) {}
            text x=(coordinate(panel.right() + 5.0)) y=(y) dy=".35em" { (rate) " Hz" }
        }
        @for curve in &curves { (curve.draw(&panel)) }
    };
    let mut keys: Vec<(Markup, String)> = curves
        .into_iter()
        .map(|curve| (curve.piece(), curve.name))
        .collect();
    let limit = html! { line class="limit" x1="1" x2="27" y1="7" y2="7" {} };
    keys.push((limit, "period of a control loop".to_owned()));
    Some(Plot {
        title: TITLE,
        style: "",
        content,
        height: HEIGHT,
        keys,
        alternative: alternative(&series),
    })
}

/// Engines in the order in which they first occur. Rows that a logarithmic scale cannot show are left out.
fn series(rows: &[DensityRow]) -> Vec<Series<'_>> {
    let several_horizons = several_horizons(rows);
    let mut all: Vec<Series> = Vec::new();
    let shown = |ms: f64| ms.is_finite() && ms > 0.0;
    for row in rows
        .iter()
        .filter(|row| row.samples > 0 && shown(row.p50_ms) && shown(row.p99_ms))
    {
        let name = if several_horizons {
            format!("{}, {} steps", row.name, row.steps)
        } else {
            row.name.clone()
        };
        if let Some(series) = all.iter_mut().find(|series| series.name == name) {
            series.rows.push(row);
        } else {
            let rows = vec![row];
            all.push(Series { name, rows });
        }
    }
    for series in &mut all {
        series.rows.sort_by_key(|row| row.samples);
    }
    all
}

impl Series<'_> {
    fn curve(&self, index: usize) -> Curve {
        let point = |row: &&DensityRow| (row.samples as f64, row.p50_ms, row.p99_ms);
        Curve {
            name: self.name.clone(),
            index,
            points: self.rows.iter().map(point).collect(),
            far: Far::Band,
        }
    }

    /// The most samples up to which every density measured keeps a rate, in words.
    fn densest_at(&self, rate_hz: f64) -> String {
        let late = |row: &&&DensityRow| row.p99_ms > 1e3 / rate_hz;
        let kept = self.rows.iter().take_while(|row| !late(row)).last();
        match kept {
            None => format!("fewer than {}", self.rows[0].samples),
            Some(row) if self.rows.iter().any(|row| late(&row)) => row.samples.to_string(),
            Some(row) => format!("{} or more", row.samples),
        }
    }
}

fn caption(rows: &[DensityRow]) -> String {
    let what = "Lines are medians; the shaded band reaches up to the 99th percentile.";
    if several_horizons(rows) {
        what.to_owned()
    } else {
        format!(
            "{what} Each sample is followed over {} steps.",
            rows[0].steps
        )
    }
}

/// Whether the rows differ in the number of steps, which their names must then tell.
fn several_horizons(rows: &[DensityRow]) -> bool {
    rows.iter().any(|row| row.steps != rows[0].steps)
}

fn alternative(series: &[Series]) -> String {
    let words: Vec<String> = series
        .iter()
        .filter_map(|series| {
            let (first, last) = (series.rows.first()?, series.rows.last()?);
            Some(format!(
                " {}: {} ms at {} samples, {} ms at {}.",
                series.name,
                significant(first.p50_ms),
                first.samples,
                significant(last.p50_ms),
                last.samples
            ))
        })
        .collect();
    format!(
        "Median latency of one decision against the number of samples.{}",
        words.concat()
    )
}

/// The densest window of each engine that keeps a control loop's rate 99 times in 100.
fn densest(series: &[Series]) -> Table<'static> {
    Table {
        title: "most samples whose 99th percentile fits into the period".to_owned(),
        heads: &["engine", "20 Hz", "50 Hz", "100 Hz"],
        rows: series
            .iter()
            .map(|series| {
                let fits = RATES_HZ.map(|rate| series.densest_at(rate));
                [vec![series.name.clone()], fits.to_vec()].concat()
            })
            .collect(),
    }
}

fn table(rows: &[DensityRow]) -> Table<'static> {
    Table {
        title: "density against latency".to_owned(),
        heads: &[
            "engine",
            "samples",
            "steps",
            "p50, ms",
            "p95, ms",
            "p99, ms",
            "slowest, ms",
            "decisions",
            "late at 20 Hz",
            "late at 50 Hz",
            "late at 100 Hz",
            "trajectory-steps per second",
        ],
        rows: rows
            .iter()
            .map(|row| {
                vec![
                    row.name.clone(),
                    row.samples.to_string(),
                    row.steps.to_string(),
                    significant(row.p50_ms),
                    significant(row.p95_ms),
                    significant(row.p99_ms),
                    significant(row.max_ms),
                    row.decisions.to_string(),
                    row.missed_20_hz.to_string(),
                    row.missed_50_hz.to_string(),
                    row.missed_100_hz.to_string(),
                    shortened(row.steps_per_s),
                ]
            })
            .collect(),
    }
}
