//! Latencies that a sweep measured, by the number of samples.

use maud::{Markup, html};

use super::axis::Axis;
use super::curves::{Curve, Far, Plot};
use super::figure::{Figure, Table};
use super::number::significant;
use super::panel::{Panel, chart};
use super::samples_axis::SAMPLES;
use crate::experiment::RunRow as LatencyRow;

const TITLE: &str = "Latency of a tick";
const HEIGHT: f64 = 300.0;
/// What the curves are, for those who do not see them and those who do.
const CAPTION: &str = "From the scan to the command; each cell had the machine to itself. Lines are the means of the cells' \
    medians, the bands end at the worst 99th percentile of a cell.";

/// The cells of one engine with the same number of samples.
struct Point {
    ran_on: String,
    samples: u64,
    cells: usize,
    sum_p50_ms: f64,
    worst_p99_ms: f64,
    slowest_ms: f64,
}

impl Point {
    fn p50_ms(&self) -> f64 {
        self.sum_p50_ms / self.cells as f64
    }
}

pub(super) fn figure(rows: &[LatencyRow]) -> Markup {
    let plot = plot(rows);
    Figure {
        title: TITLE,
        picture: plot.as_ref().map_or_else(
            || html! {},
            |plot| chart(plot.height, &plot.alternative, &plot.content),
        ),
        legend: plot.map_or_else(Vec::new, |plot| plot.legend()),
        caption: CAPTION.to_owned(),
        table: table(rows),
    }
    .markup()
}

/// The curves; none where there is no row.
pub(super) fn plot(rows: &[LatencyRow]) -> Option<Plot> {
    let points = points(rows);
    let fewest = points.first()?.samples;
    let most = points.last()?.samples;
    let least_ms = points
        .iter()
        .map(Point::p50_ms)
        .fold(f64::INFINITY, f64::min);
    let worst_ms = points
        .iter()
        .map(|point| point.worst_p99_ms)
        .fold(0.0, f64::max);
    let panel = Panel::across(
        32.0,
        222.0,
        Axis::logarithmic(fewest as f64, most as f64),
        Axis::logarithmic(least_ms.max(1e-6), worst_ms.max(1e-6)),
    );
    let mut engines: Vec<&str> = Vec::new();
    for row in rows {
        let engine = row.ran_on.as_deref().unwrap_or_default();
        if !engines.contains(&engine) {
            engines.push(engine);
        }
    }
    let curve = |(index, engine): (usize, &&str)| {
        let own = points.iter().filter(|point| point.ran_on == **engine);
        Curve {
            name: (*engine).to_owned(),
            index,
            points: own
                .map(|point| (point.samples as f64, point.p50_ms(), point.worst_p99_ms))
                .collect(),
            far: Far::Band,
        }
    };
    let curves: Vec<Curve> = engines.iter().enumerate().map(curve).collect();
    let content = html! {
        (panel.axes(Some(SAMPLES), "Latency of one tick, ms (logarithmic)"))
        @for curve in &curves { (curve.draw(&panel)) }
    };
    Some(Plot {
        style: "",
        title: TITLE,
        content,
        height: HEIGHT,
        keys: curves
            .into_iter()
            .map(|curve| (curve.piece(), curve.name))
            .collect(),
        alternative: format!("{TITLE} against the number of samples. {CAPTION}"),
    })
}

/// From the fewest samples to the most.
fn points(rows: &[LatencyRow]) -> Vec<Point> {
    let mut all: Vec<Point> = Vec::new();
    for row in rows {
        let ran_on = row.ran_on.as_deref().unwrap_or_default();
        let samples = u64::from(row.vx_samples) * u64::from(row.vtheta_samples);
        let is_it = |point: &Point| point.ran_on == ran_on && point.samples == samples;
        let place = all.iter().position(is_it).unwrap_or_else(|| {
            all.push(Point {
                ran_on: ran_on.to_owned(),
                samples,
                cells: 0,
                sum_p50_ms: 0.0,
                worst_p99_ms: 0.0,
                slowest_ms: 0.0,
            });
            all.len() - 1
        });
        let point = &mut all[place];
        point.cells += 1;
        point.sum_p50_ms += row.tick_p50_ms.unwrap_or_default();
        point.worst_p99_ms = point.worst_p99_ms.max(row.tick_p99_ms.unwrap_or_default());
        point.slowest_ms = point.slowest_ms.max(row.tick_max_ms.unwrap_or_default());
    }
    all.sort_by_key(|point| point.samples);
    all
}

fn table(rows: &[LatencyRow]) -> Table<'static> {
    let row = |point: &Point| {
        vec![
            point.ran_on.clone(),
            point.samples.to_string(),
            point.cells.to_string(),
            significant(point.p50_ms()),
            significant(point.worst_p99_ms),
            significant(point.slowest_ms),
        ]
    };
    Table {
        title: TITLE.to_owned(),
        heads: &[
            "engine",
            "samples",
            "cells",
            "mean of medians, ms",
            "worst p99, ms",
            "slowest, ms",
        ],
        rows: points(rows).iter().map(row).collect(),
    }
}
