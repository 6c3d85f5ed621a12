//! The charts of a sweep: success and time over the number of samples, and the latencies of its cells.

use std::collections::BTreeMap;

use super::chart::{
    Axis, Chart, Panel, Plot, Series, Upper, curves, range, series_alt_text, series_by_name,
    series_legend,
};
use super::figure::{ChartFigure, Table};
use super::number::{fixed, significant};
use super::sample_charts::samples_axis;
use crate::experiment::{Group, RunRow, WorldKind};

/// The groups of each kind of worlds, in the order in which the kinds first occur.
pub(super) fn by_kind(groups: &[Group]) -> Vec<Vec<Group>> {
    let mut all: Vec<Vec<Group>> = Vec::new();
    for group in groups {
        match all.iter_mut().find(|of| of[0].kind == group.kind) {
            Some(of) => of.push(group.clone()),
            None => all.push(vec![group.clone()]),
        }
    }
    all
}

/// File name without extension, and title, of the groups of a kind of worlds.
pub(super) const fn names(kind: WorldKind) -> (&'static str, &'static str) {
    match kind {
        WorldKind::Scenes => ("groups-scenes", "Built-in scenes"),
        WorldKind::Map => ("groups-map", "Routes on maps"),
        WorldKind::Missions => ("groups-missions", "Random missions"),
        WorldKind::Barn => ("groups-barn", "BARN"),
        WorldKind::DynaBarn => ("groups-dynabarn", "DynaBARN"),
    }
}

/// The figure of groups of one kind of worlds.
pub(super) fn groups(title: &str, groups: &[Group]) -> ChartFigure {
    ChartFigure {
        chart: groups_chart(title, groups),
        caption: "Times are means over the worlds and seeds in which all groups reached the goal."
            .to_owned(),
        table: Table::of_columns(
            title,
            groups,
            &[
                "config",
                "weights",
                "engine",
                "vx_samples",
                "vtheta_samples",
                "runs",
                "reached",
                "contacts",
                "timeouts",
                "failed",
                "mean_time_s",
                "shared",
                "mean_shared_time_s",
                "mean_score",
                "mean_clearance_m",
            ],
        ),
    }
}

fn groups_chart(title: &str, groups: &[Group]) -> Chart {
    let series = group_series(groups);
    let usable = || series.iter().flat_map(|series| &series.rows).copied();
    let Some(first) = usable().next() else {
        return Chart::empty(title, "No cell has a result.");
    };
    let (least, _) = range(usable().map(reached_percent)).unwrap_or((0.0, 100.0));
    let (fastest_s, slowest_s) = range(usable().filter_map(shared_time_s)).unwrap_or((0.0, 1.0));
    let success = Panel {
        title: format!("Goal reached, % of {} runs", first.runs),
        height: 130.0,
        y: Axis::rounded(least.min(90.0), 100.0),
        marks: curves(&series, Upper::None, |group| {
            let percent = reached_percent(group);
            Some([group.samples as f64, percent, percent])
        }),
    };
    let time = Panel {
        title: format!("Mean time of the {} runs that all reached, s", first.shared),
        height: 134.0,
        y: Axis::rounded(fastest_s, slowest_s),
        marks: curves(&series, Upper::None, |group| {
            let time_s = shared_time_s(group)?;
            Some([group.samples as f64, time_s, time_s])
        }),
    };
    let start = format!(
        "{title}: share of runs that reached their goal, and their mean time, against the number of samples"
    );
    Chart {
        title: title.to_owned(),
        plot: Plot::Panels {
            x: samples_axis(usable().map(|group| group.samples)),
            panels: vec![success, time],
        },
        legend: series_legend(&series),
        alt_text: series_alt_text(&start, &series, |group| {
            let time = shared_time_s(group).map(|time_s| format!("{} s", significant(time_s)));
            let time = time.unwrap_or_else(|| "no time".to_owned());
            let reached = fixed(reached_percent(group), 1);
            Some(format!("{reached} % and {time} with {} samples", group.samples))
        }),
    }
}

/// Groups by settings, weights and, if there are several, engines.
fn group_series(groups: &[Group]) -> Vec<Series<'_, Group>> {
    let has_engines = groups.iter().any(|group| group.engine != groups[0].engine);
    let name = |group: &Group| {
        let engine = has_engines.then(|| group.engine.clone());
        let parts = [group.config.clone(), group.weights.clone(), engine];
        let parts: Vec<String> = parts.into_iter().flatten().collect();
        let name =
            if parts.is_empty() { "settings of the worlds".to_owned() } else { parts.join(", ") };
        (group.samples > 0 && group.runs > 0).then_some(name)
    };
    series_by_name(groups, name, |group| group.samples)
}

fn reached_percent(group: &Group) -> f64 {
    100.0 * group.reached as f64 / group.runs as f64
}

/// The mean time that compares between groups, s.
fn shared_time_s(group: &Group) -> Option<f64> {
    group.mean_shared_time_s.filter(|time_s| time_s.is_finite())
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

/// The figure of the latencies that a sweep measured.
pub(super) fn latency(rows: &[RunRow]) -> ChartFigure {
    const TITLE: &str = "Latency of a tick";
    const CAPTION: &str = "From the scan to the command; no other cell ran at the same time. Lines are means of the medians of \
        the cells, the bands end at the worst 99th percentile of a cell.";
    let points = latency_points(rows);
    let series = series_by_name(&points, |point| Some(point.engine.clone()), |point| point.samples);
    let values = points.iter().flat_map(|point| [point.p50_ms(), point.worst_p99_ms]);
    let (least_ms, worst_ms) = range(values).unwrap_or((1.0, 1.0));
    let chart = Chart {
        title: TITLE.to_owned(),
        plot: Plot::Panels {
            x: samples_axis(points.iter().map(|point| point.samples)),
            panels: vec![Panel {
                title: "Latency of one tick, ms (logarithmic)".to_owned(),
                height: 222.0,
                y: Axis::logarithmic(least_ms.max(1e-6), worst_ms.max(1e-6)),
                marks: curves(&series, Upper::Band, |point| {
                    Some([point.samples as f64, point.p50_ms(), point.worst_p99_ms])
                }),
            }],
        },
        legend: series_legend(&series),
        alt_text: format!("{TITLE} against the number of samples. {CAPTION}"),
    };
    ChartFigure {
        chart,
        caption: CAPTION.to_owned(),
        table: Table::new(
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
        ),
    }
}

/// The points by samples, then by engine.
fn latency_points(rows: &[RunRow]) -> Vec<LatencyPoint> {
    let mut all: BTreeMap<(u64, &str), LatencyPoint> = BTreeMap::new();
    for row in rows {
        let engine = row.ran_on.as_deref().unwrap_or_default();
        let samples = u64::from(row.vx_samples) * u64::from(row.vtheta_samples);
        let point = all.entry((samples, engine)).or_default();
        engine.clone_into(&mut point.engine);
        point.samples = samples;
        point.cells += 1;
        point.sum_p50_ms += row.tick_p50_ms.unwrap_or_default();
        point.worst_p99_ms = point.worst_p99_ms.max(row.tick_p99_ms.unwrap_or_default());
        point.slowest_ms = point.slowest_ms.max(row.tick_max_ms.unwrap_or_default());
    }
    all.into_values().collect()
}
