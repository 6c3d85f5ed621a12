//! What sampling density is worth in a closed loop: missions that reach their goal, and the time that they take.

use maud::{Markup, html};

use super::axis::Axis;
use super::curves::{Curve, Far, Plot, class, far_mark};
use super::figure::{Figure, Table, nothing_to_show};
use super::number::{coordinate, fixed, significant};
use super::panel::{Panel, chart};
use super::samples_axis::SAMPLES;
use super::sampling_shape::SamplingShape;
use crate::experiment::Group as ClosedLoopRow;

const TITLE: &str = "Sampling density in closed loop";
const HEIGHT: f64 = 360.0;
/// Width of a bar.
const BAR: f64 = 9.0;

/// Samplings of one shape, in order of density.
struct Series<'a> {
    shape: SamplingShape,
    rows: Vec<&'a ClosedLoopRow>,
}

pub(super) fn figure(rows: &[ClosedLoopRow], samples: Axis) -> Markup {
    let Some(plot) = plot(rows, samples) else {
        return nothing_to_show(TITLE, "No mission was driven.");
    };
    Figure {
        title: TITLE,
        picture: chart(plot.height, &plot.alternative, &plot.content),
        legend: plot.legend(),
        caption: "The same random missions with each sampling. Lines are median times, dashed ones the 90th percentile; \
            v : omega is forward speeds to turn rates."
            .to_owned(),
        table: table(rows),
    }
    .markup()
}

/// The panels of success and of time, one below the other; none where no row can be shown.
pub(super) fn plot(rows: &[ClosedLoopRow], samples: Axis) -> Option<Plot> {
    let series = series(rows);
    let usable = || series.iter().flat_map(|series| &series.rows);
    let first = usable().next()?;
    let slowest_s = usable()
        .filter_map(|row| time_s(row))
        .fold(0.0, |slowest_s: f64, (_, far_s)| slowest_s.max(far_s));
    let success = Panel::across(32.0, 106.0, samples, Axis::exact(0.0, 100.0));
    let time = Panel::across(180.0, 138.0, samples, Axis::rounded(0.0, slowest_s));
    let times: Vec<Curve> = series
        .iter()
        .enumerate()
        .map(|(index, series)| series.times(index))
        .collect();
    let (missions, shared) = (first.runs, first.shared);
    let reached_title = format!("Goal reached, % of {missions} missions");
    let time_title = format!("Time of missions reached by all ({shared} of {missions}), s");
    let content = html! {
        (success.axes(None, &reached_title))
        @for (index, series) in series.iter().enumerate() {
            (series.bars(&success, BAR * (index as f64 - times.len() as f64 / 2.0), index))
        }
        (time.axes(Some(SAMPLES), &time_title))
        @for curve in &times { (curve.draw(&time)) }
    };
    let mut keys: Vec<(Markup, String)> = times
        .into_iter()
        .map(|curve| (curve.piece(), curve.name))
        .collect();
    keys.push((far_mark(), "time, 90th percentile".to_owned()));
    Some(Plot {
        title: TITLE,
        style: "",
        content,
        height: HEIGHT,
        keys,
        alternative: alternative(&series),
    })
}

/// Shapes in the order in which they first occur. Rows without a sample or a mission are left out.
fn series(rows: &[ClosedLoopRow]) -> Vec<Series<'_>> {
    let mut all: Vec<Series> = Vec::new();
    for row in rows {
        let Some(shape) = SamplingShape::of(row.vx_samples, row.vtheta_samples) else {
            continue;
        };
        if row.samples == 0 || row.runs == 0 {
            continue;
        }
        if let Some(series) = all.iter_mut().find(|series| series.shape == shape) {
            series.rows.push(row);
        } else {
            let rows = vec![row];
            all.push(Series { shape, rows });
        }
    }
    for series in &mut all {
        series.rows.sort_by_key(|row| row.samples);
    }
    all
}

/// Percent of the missions that reached their goal.
fn reached_percent(row: &ClosedLoopRow) -> f64 {
    100.0 * row.reached as f64 / row.runs as f64
}

/// Median and 90th percentile of the time, seconds, where both can be shown.
fn time_s(row: &ClosedLoopRow) -> Option<(f64, f64)> {
    let pair = row.shared_time_p50_s.zip(row.shared_time_p90_s);
    pair.filter(|(median_s, far_s)| median_s.is_finite() && far_s.is_finite())
}

impl Series<'_> {
    /// A bar at each density, beside those of the other shapes: as a rule all reach the same share, and curves would hide
    /// one another.
    fn bars(&self, panel: &Panel, aside: f64, index: usize) -> Markup {
        html! {
            g class=(class(index)) {
                @for row in &self.rows {
                    @let top = panel.y_at(reached_percent(row));
                    rect class="marker" x=(coordinate(panel.x_at(row.samples as f64) + aside)) y=(coordinate(top))
                        width=(coordinate(BAR)) height=(coordinate(panel.bottom() - top)) {}
                }
            }
        }
    }

    fn times(&self, index: usize) -> Curve {
        let point = |row: &&ClosedLoopRow| {
            let (median_s, far_s) = time_s(row)?;
            Some((row.samples as f64, median_s, far_s))
        };
        Curve {
            name: self.shape.to_string(),
            index,
            points: self.rows.iter().filter_map(point).collect(),
            far: Far::Line,
        }
    }
}

fn alternative(series: &[Series]) -> String {
    let said = |row: &ClosedLoopRow| {
        let time = time_s(row).map_or_else(
            || "no time".to_owned(),
            |(median_s, _)| format!("{} s", significant(median_s)),
        );
        let reached = fixed(reached_percent(row), 0);
        format!("{reached} % and {time} with {} samples", row.samples)
    };
    let words: Vec<String> = series
        .iter()
        .filter_map(|series| {
            let (first, last) = (series.rows.first()?, series.rows.last()?);
            Some(format!(
                " {}: {}, {}.",
                series.shape,
                said(first),
                said(last)
            ))
        })
        .collect();
    format!(
        "Share of missions that reached their goal, and their median time, against the number of samples.{}",
        words.concat()
    )
}

fn table(rows: &[ClosedLoopRow]) -> Table<'static> {
    let number = |value: Option<f64>, decimals| fixed(value.unwrap_or(f64::NAN), decimals);
    Table {
        title: "density in closed loop".to_owned(),
        heads: &[
            "samples",
            "forward speeds",
            "turn rates",
            "missions",
            "reached",
            "contacts",
            "time, median, s",
            "time, 90th percentile, s",
            "time by that of the densest",
            "mean smallest gap, m",
            "tick, median, ms",
            "tick, p99, ms",
        ],
        rows: rows
            .iter()
            .map(|row| {
                vec![
                    row.samples.to_string(),
                    row.vx_samples.to_string(),
                    row.vtheta_samples.to_string(),
                    row.runs.to_string(),
                    row.reached.to_string(),
                    row.contacts.to_string(),
                    number(row.shared_time_p50_s, 1),
                    number(row.shared_time_p90_s, 1),
                    number(row.mean_time_ratio, 3),
                    number(row.mean_clearance_reached_m, 3),
                    number(row.tick_p50_ms, 3),
                    number(row.tick_p99_ms, 3),
                ]
            })
            .collect(),
    }
}
