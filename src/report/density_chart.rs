//! Sampling density against latency, for every engine.

use maud::{Markup, html};

use super::axis::Axis;
use super::figure::{Figure, Table, key, line_key, nothing_to_show};
use super::number::{coordinate, shortened, significant};
use super::panel::{Panel, chart};
use crate::bench::DensityRow;

const TITLE: &str = "Sampling density against latency";
const HEIGHT: f64 = 360.0;

/// Rates of common control loops, Hz: a decision must fit into their period.
const RATES_HZ: [f64; 3] = [20.0, 50.0, 100.0];

/// Engines that a drawing can tell apart; further ones repeat the colours.
const COLOURS: usize = 6;

/// One engine with its rows in order of density.
struct Series<'a> {
    name: String,
    class: String,
    index: usize,
    rows: Vec<&'a DensityRow>,
}

pub(super) fn figure(rows: &[DensityRow]) -> Markup {
    let series = series(rows);
    let usable = || series.iter().flat_map(|series| &series.rows);
    if usable().next().is_none() {
        return nothing_to_show(TITLE, "No engine was timed at any density.");
    }
    let bounds = |value: &dyn Fn(&DensityRow) -> f64| {
        usable().fold((f64::INFINITY, 0.0), |(low, high): (f64, f64), row| {
            (low.min(value(row)), high.max(value(row)))
        })
    };
    let (fewest, most) = bounds(&|row| row.samples as f64);
    let (fastest_ms, _) = bounds(&|row| row.p50_ms);
    let (_, slowest_ms) = bounds(&|row| row.p99_ms);
    let deadlines_ms = RATES_HZ.map(|rate| 1e3 / rate);
    let mut panel = Panel::across(
        32.0,
        286.0,
        Axis::logarithmic(fewest, most),
        Axis::logarithmic(
            fastest_ms.min(deadlines_ms[2]),
            slowest_ms.max(deadlines_ms[0]),
        ),
    );
    // Room for the rates to the right.
    panel.width -= 44.0;
    let picture = html! {
        (panel.axes(Some("Samples of the dynamic window (logarithmic)"), "Latency of one decision, ms (logarithmic)"))
        @for (rate, ms) in RATES_HZ.iter().zip(deadlines_ms) {
            @let y = coordinate(panel.y_at(ms));
            line class="limit" x1=(coordinate(panel.left)) x2=(coordinate(panel.right())) y1=(y) y2=(y) {}
            text x=(coordinate(panel.right() + 5.0)) y=(y) dy=".35em" { (rate) " Hz" }
        }
        @for series in &series { (series.draw(&panel)) }
    };
    let mut legend: Vec<Markup> = series.iter().map(Series::key).collect();
    legend.push(line_key("limit", "period of a control loop at that rate"));
    let figure = Figure {
        title: TITLE,
        picture: chart(HEIGHT, &alternative(&series), &picture),
        legend,
        caption: caption(rows),
        table: table(rows),
    };
    html! {
        (figure.markup())
        div class="beside" {
            h3 { "Most samples that fit" }
            p { "As measured: up to this many samples, 99 of 100 decisions end within the period of the loop." }
            (densest(&series).markup())
        }
    }
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
            format!("{}, {} steps", engine_name(row), row.steps)
        } else {
            engine_name(row)
        };
        if let Some(series) = all.iter_mut().find(|series| series.name == name) {
            series.rows.push(row);
        } else {
            let index = all.len();
            all.push(Series {
                name,
                class: format!("engine-{}", index % COLOURS),
                index,
                rows: vec![row],
            });
        }
    }
    for series in &mut all {
        series.rows.sort_by_key(|row| row.samples);
    }
    all
}

fn engine_name(row: &DensityRow) -> String {
    match (&row.adapter, row.threads) {
        (Some(adapter), _) => format!("{}, {adapter}", row.engine),
        (None, 0) => row.engine.clone(),
        (None, 1) => format!("{}, 1 thread", row.engine),
        (None, threads) => format!("{}, {threads} threads", row.engine),
    }
}

impl Series<'_> {
    fn draw(&self, panel: &Panel) -> Markup {
        let samples = |row: &DensityRow| row.samples as f64;
        let band: Vec<(f64, f64, f64)> = self
            .rows
            .iter()
            .map(|row| (samples(row), row.p50_ms, row.p99_ms))
            .collect();
        html! {
            g class=(self.class) {
                (panel.band("tail", &band))
                (panel.line("median", self.rows.iter().map(|row| (samples(row), row.p50_ms))))
                @for row in &self.rows {
                    (marker(self.index, panel.x_at(samples(row)), panel.y_at(row.p50_ms)))
                }
            }
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

    fn key(&self) -> Markup {
        let mark = html! {
            g class=(self.class) {
                line class="median" x1="1" x2="27" y1="7" y2="7" {}
                (marker(self.index, 14.0, 7.0))
            }
        };
        key(&mark, &self.name)
    }
}

/// A mark whose shape tells engines apart without their colours.
fn marker(index: usize, x: f64, y: f64) -> Markup {
    const SHAPES: [&str; 5] = [
        "m-4 0a4 4 0 1 0 8 0a4 4 0 1 0 -8 0z",
        "m-3.5 -3.5h7v7h-7z",
        "m0 -4.8l4.4 8h-8.8z",
        "m0 -5l5 5l-5 5l-5 -5z",
        "m0 4.8l4.4 -8h-8.8z",
    ];
    let shape = SHAPES[index % SHAPES.len()];
    html! { path class="marker" d=(format!("M{} {}{shape}", coordinate(x), coordinate(y))) {} }
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
            "trajectory-steps per second",
        ],
        rows: rows
            .iter()
            .map(|row| {
                vec![
                    engine_name(row),
                    row.samples.to_string(),
                    row.steps.to_string(),
                    significant(row.p50_ms),
                    significant(row.p95_ms),
                    significant(row.p99_ms),
                    significant(row.max_ms),
                    row.decisions.to_string(),
                    shortened(row.steps_per_s),
                ]
            })
            .collect(),
    }
}
