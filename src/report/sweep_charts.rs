//! The charts of a sweep: success and time over the number of samples, and the latencies of its cells.

use std::collections::BTreeMap;

use super::chart::{Axis, Chart, Panel, Upper, range};
use super::figure::Table;
use super::number::significant;
use super::sample_charts::{AllSeries, SamplingShape, reached_percent, reached_text};
use crate::experiment::{Group, RunRow, WorldKind};

/// File name without extension, and title, of the groups of a kind of worlds.
pub(super) const fn names(kind: WorldKind) -> (&'static str, &'static str) {
    match kind {
        WorldKind::Scenes => ("groups-scenes", "Built-in scenes"),
        WorldKind::Map => ("groups-map", "Routes on maps"),
        WorldKind::Missions => ("groups-missions", "Random missions"),
        WorldKind::Barn => ("groups-barn", "BARN"),
        WorldKind::DynaBarn => ("groups-dynabarn", "DynaBARN"),
        WorldKind::Localization => ("groups-localization", "Localization"),
        WorldKind::Paper => ("groups-paper", "Drives of the paper"),
        WorldKind::Mrpb => ("groups-mrpb", "MRPB 1.0"),
    }
}

/// Success and time of the groups of a sweep in one kind of worlds.
pub(super) fn groups(title: &'static str, groups: &[Group]) -> Chart {
    let has_engines = groups.iter().any(|group| group.engine != groups[0].engine);
    // Samplings with one number of samples and several shapes are not one series.
    let has_shapes = groups.iter().any(|one| {
        let is_other =
            |other: &Group| other.samples == one.samples && other.vx_samples != one.vx_samples;
        groups.iter().any(is_other)
    });
    // A series has its settings, weights and, if there are several, its engine and its shape.
    let name = |group: &Group| {
        let engine = has_engines.then(|| group.engine.clone());
        let shape = SamplingShape::new(group.vx_samples, group.vtheta_samples);
        let shape = shape.filter(|_| has_shapes).map(|shape| shape.to_string());
        let parts = [group.config.clone(), group.weights.clone(), engine, shape];
        let parts: Vec<String> = parts.into_iter().flatten().collect();
        let name =
            if parts.is_empty() { "settings of the worlds".to_owned() } else { parts.join(", ") };
        (group.samples > 0 && group.runs > 0).then_some(name)
    };
    // The mean time that compares between groups.
    let time_s = |group: &Group| group.mean_shared_time_s.filter(|time_s| time_s.is_finite());
    let series = AllSeries::new(groups, |group| group.samples, name);
    let Some(first) = series.rows().next() else {
        return Chart::empty(title, "No cell has a result.");
    };
    let (least, _) = range(series.rows().map(reached_percent)).unwrap_or((0.0, 100.0));
    let (fastest_s, slowest_s) = range(series.rows().filter_map(time_s)).unwrap_or((0.0, 1.0));
    let success = Panel::new(
        format!("Goal reached, % of {} runs", first.runs),
        130.0,
        Axis::rounded(least.min(90.0), 100.0),
        series.curves(Upper::None, |group| Some([reached_percent(group); 2])),
    );
    let time = Panel::new(
        format!("Mean time of the {} runs that all reached, s", first.shared),
        134.0,
        Axis::rounded(fastest_s, slowest_s),
        series.curves(Upper::None, |group| Some([time_s(group)?; 2])),
    );
    let start = format!(
        "{title}: share of runs that reached their goal, and their mean time, against the number of samples"
    );
    let alt_text = series.alt_text(&start, |group| Some(reached_text(group, 1, time_s(group))));
    // The kind of the worlds is that of the chart.
    let columns = Group::SUMMARY.trim_start_matches("kind ").to_owned()
        + " timeouts failed mean_score mean_clearance_m";
    Chart {
        legend: series.legend(),
        caption: "Times are means over the worlds and seeds in which all groups reached the goal, \
            without the groups that reached none."
            .to_owned(),
        table: Some(Table::of_columns(title, groups, &columns)),
        ..Chart::of_panels(title, series.axis(), vec![success, time], alt_text)
    }
}

/// The latency cells of one engine with the same number of samples.
#[derive(Default)]
struct LatencyPoint {
    engine: String,
    samples: u64,
    cells: usize,
    sum_p50_ms: f64,
    worst_p99_ms: f64,
    slowest_ms: f64,
}

impl LatencyPoint {
    fn p50_ms(&self) -> f64 {
        self.sum_p50_ms / self.cells as f64
    }
}

/// The latencies that a sweep measured.
pub(super) fn latency(rows: &[RunRow]) -> Chart {
    const TITLE: &str = "Latency of a tick";
    const CAPTION: &str = "From the scan to the command; no other cell ran at the same time. Lines are means of the medians of \
        the cells, the bands end at the worst 99th percentile of a cell.";
    let points = latency_points(rows);
    if points.is_empty() {
        return Chart::empty(TITLE, "No cell has a measured tick.");
    }
    let series = AllSeries::new(&points, |point| point.samples, |point| Some(point.engine.clone()));
    let values = |point: &LatencyPoint| [point.p50_ms(), point.worst_p99_ms];
    let (least_ms, worst_ms) = range(points.iter().flat_map(values)).unwrap_or((1.0, 1.0));
    let panel = Panel::new(
        "Latency of one tick, ms (logarithmic)",
        222.0,
        Axis::logarithmic(least_ms.max(1e-6), worst_ms.max(1e-6)),
        series.curves(Upper::Band, |point| Some(values(point))),
    );
    let table = Table::new(
        TITLE,
        &points,
        &[
            ("engine", |point| point.engine.clone()),
            ("samples", |point| point.samples.to_string()),
            ("cells", |point| point.cells.to_string()),
            ("mean of medians, ms", |point| significant(point.p50_ms())),
            ("worst p99, ms", |point| significant(point.worst_p99_ms)),
            ("slowest, ms", |point| significant(point.slowest_ms)),
        ],
    );
    let alt_text = format!("{TITLE} against the number of samples. {CAPTION}");
    Chart {
        legend: series.legend(),
        caption: CAPTION.to_owned(),
        table: Some(table),
        ..Chart::of_panels(TITLE, series.axis(), vec![panel], alt_text)
    }
}

/// The points by samples, then by engine. A run that ended before its first tick has no latency.
fn latency_points(rows: &[RunRow]) -> Vec<LatencyPoint> {
    let mut all: BTreeMap<(u64, &str), LatencyPoint> = BTreeMap::new();
    for row in rows {
        let (Some(p50_ms), Some(p99_ms), Some(slowest_ms)) =
            (row.tick_p50_ms, row.tick_p99_ms, row.tick_max_ms)
        else {
            continue;
        };
        let engine = row.ran_on.as_deref().unwrap_or_default();
        let samples = u64::from(row.vx_samples) * u64::from(row.vtheta_samples);
        let point = all.entry((samples, engine)).or_default();
        engine.clone_into(&mut point.engine);
        point.samples = samples;
        point.cells += 1;
        point.sum_p50_ms += p50_ms;
        point.worst_p99_ms = point.worst_p99_ms.max(p99_ms);
        point.slowest_ms = point.slowest_ms.max(slowest_ms);
    }
    all.into_values().collect()
}
