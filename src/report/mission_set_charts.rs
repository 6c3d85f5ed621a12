//! Charts of many missions: a soak by map and by traffic, and the variants of an ablation.

use std::collections::BTreeMap;

use maud::{Markup, html};

use super::chart::{Axis, Chart, Row, RowMark, range, spread_mark};
use super::figure::{ChartFigure, Column, Table};
use super::number::{fixed, optional, significant};
use super::run_charts::{EndCounts, RunEnd, end_legend};
use super::svg::LegendEntry;
use crate::bench::percentile;
use crate::experiment::{self, RunRow, TrafficKind};

/// Missions of a soak with a common property.
struct Group<'a> {
    /// All missions, those of a map, or those with a kind of traffic.
    kind: usize,
    label: String,
    missions: Vec<&'a RunRow>,
    counts: EndCounts,
}

/// A value of each mission, shown as its distribution in each group.
struct Measure {
    title: &'static str,
    axis_title: &'static str,
    caption: &'static str,
    value: fn(&RunRow) -> Option<f64>,
}

const MEASURES: [Measure; 2] = [
    Measure {
        title: "Soak: time per metre of path",
        axis_title: "s/m (logarithmic)",
        caption: "Simulated time of a mission divided by the length of its first path, for the missions that reached their \
            goal. It includes waiting for pedestrians.",
        value: |row| Some(row.time_s / row.path_m?),
    },
    Measure {
        title: "Soak: smallest gap of each mission",
        axis_title: "m (logarithmic)",
        caption: "Smallest true gap between the footprint and any static or moving obstacle, for the missions that reached \
            their goal.",
        value: |row| row.min_clearance_m,
    },
];

/// The figures of a soak.
pub(super) fn soak(rows: &[RunRow]) -> Vec<ChartFigure> {
    let groups = groups(rows);
    let measures = MEASURES.iter().map(|measure| measure.figure(&groups));
    [soak_ends(&groups)].into_iter().chain(measures).collect()
}

fn soak_ends(groups: &[Group]) -> ChartFigure {
    const TITLE: &str = "Soak: missions that did not reach their goal";
    let caption = groups.first().map_or_else(String::new, |all| {
        format!(
            "{} missions, {} % reached their goal, {} contacts caused by the robot. The robot caused a contact if the touching \
             part of its footprint moved towards the obstacle, or if the obstacle does not move.",
            all.missions.len(),
            fixed(all.counts.percent(all.counts.of(RunEnd::Reached)), 1),
            all.counts.of(RunEnd::RobotContact),
        )
    });
    let missed_percent = |group: &Group| group.counts.percent(group.counts.missed());
    let most = groups.iter().map(missed_percent).fold(1.0, f64::max);
    let rows = groups.iter().map(|group| {
        let (reached, missions) = (group.counts.of(RunEnd::Reached), group.missions.len());
        group.row(format!("{reached} of {missions} reached"), group.counts.stack(&RunEnd::MISSED))
    });
    let legend = end_legend(&RunEnd::MISSED, &groups.iter().map(|group| &group.counts));
    ChartFigure {
        chart: Chart::of_rows(TITLE, (Axis::rounded(0.0, most), "%"), rows.collect(), legend),
        caption,
        table: Table::new(
            "ends of the missions",
            groups,
            &[
                ("group", |group| group.label.clone()),
                ("missions", |group| group.missions.len().to_string()),
                ("reached", |group| group.counts.of(RunEnd::Reached).to_string()),
                ("reached, %", |group| {
                    fixed(group.counts.percent(group.counts.of(RunEnd::Reached)), 1)
                }),
                ("contact caused by the robot", |group| {
                    group.counts.of(RunEnd::RobotContact).to_string()
                }),
                ("contact caused by an obstacle", |group| {
                    group.counts.of(RunEnd::ObstacleContact).to_string()
                }),
                ("gave up", |group| group.counts.of(RunEnd::GaveUp).to_string()),
                ("timeout", |group| group.counts.of(RunEnd::Timeout).to_string()),
            ],
        ),
    }
}

impl Measure {
    fn figure(&self, groups: &[Group]) -> ChartFigure {
        let spreads: Vec<(&Group, Option<[f64; 5]>)> =
            groups.iter().map(|group| (group, group.spread(self.value))).collect();
        let ends = spreads.iter().filter_map(|(_, spread)| *spread);
        let (least, most) = range(ends.flatten()).unwrap_or((1.0, 10.0));
        let rows = spreads.iter().map(|(group, spread)| match spread {
            Some(values) => {
                group.row(format!("median {}", significant(values[2])), RowMark::Spread(*values))
            }
            None => group.row("none reached".to_owned(), RowMark::None),
        });
        let legend = LegendEntry::new(spread_mark(), "median, 10 to 90 %, least to greatest");
        let columns: [Column<(&Group, Spread)>; 7] = [
            ("group", |(group, _)| group.label.clone()),
            ("reached", |(group, _)| group.counts.of(RunEnd::Reached).to_string()),
            ("least", |(_, spread)| spread_text(spread.as_ref(), 0)),
            ("10 %", |(_, spread)| spread_text(spread.as_ref(), 1)),
            ("median", |(_, spread)| spread_text(spread.as_ref(), 2)),
            ("90 %", |(_, spread)| spread_text(spread.as_ref(), 3)),
            ("greatest", |(_, spread)| spread_text(spread.as_ref(), 4)),
        ];
        let axis = Axis::logarithmic(least, most);
        ChartFigure {
            chart: Chart::of_rows(
                self.title,
                (axis, self.axis_title),
                rows.collect(),
                vec![legend],
            ),
            caption: self.caption.to_owned(),
            table: Table::new(
                format!("{}, {}", self.title.to_lowercase(), self.axis_title),
                &spreads,
                &columns,
            ),
        }
    }
}

/// The least, 10 %, median, 90 % and greatest of a group; none for a group without values.
type Spread = Option<[f64; 5]>;

fn spread_text(spread: Option<&[f64; 5]>, index: usize) -> String {
    significant(spread.map_or(f64::NAN, |values| values[index]))
}

/// All missions, those of each map, and those with each kind of traffic.
fn groups(rows: &[RunRow]) -> Vec<Group<'_>> {
    let mut maps: BTreeMap<String, Vec<&RunRow>> = BTreeMap::new();
    let mut traffic: BTreeMap<TrafficKind, Vec<&RunRow>> = BTreeMap::new();
    for row in rows {
        maps.entry(row.world.clone()).or_default().push(row);
        if let Some(kind) = row.traffic {
            traffic.entry(kind).or_default().push(row);
        }
    }
    let all = (!rows.is_empty()).then(|| (0, "all missions".to_owned(), rows.iter().collect()));
    let maps = maps.into_iter().map(|(map, rows)| (1, map, rows));
    let traffic = traffic.into_iter();
    let traffic = traffic.map(|(kind, rows)| (2, traffic_text(kind).to_owned(), rows));
    all.into_iter()
        .chain(maps)
        .chain(traffic)
        .map(|(kind, label, missions): (usize, String, Vec<&RunRow>)| Group {
            kind,
            label,
            counts: EndCounts::new(missions.iter().map(|row| (RunEnd::new(row), 1))),
            missions,
        })
        .collect()
}

const fn traffic_text(kind: TrafficKind) -> &'static str {
    match kind {
        TrafficKind::None => "no pedestrians",
        TrafficKind::Yielding => "pedestrians that stop for the robot",
        TrafficKind::NonYielding => "pedestrians that ignore the robot",
        TrafficKind::Appearing => "pedestrians that appear suddenly",
    }
}

impl Group<'_> {
    fn row(&self, value: String, mark: RowMark) -> Row {
        Row { group: self.kind, label: self.label.clone(), value, mark }
    }

    /// Least, 10th, 50th and 90th percentile, and greatest value of the missions that reached their goal; none if no value
    /// can be charted.
    fn spread(&self, value: fn(&RunRow) -> Option<f64>) -> Option<[f64; 5]> {
        let values: Vec<f64> = self
            .missions
            .iter()
            .filter(|row| row.reached())
            .filter_map(|row| value(row))
            .filter(|value| value.is_finite() && *value > 0.0)
            .collect();
        let at = |share| percentile(values.clone(), share);
        Some([at(f64::MIN_POSITIVE)?, at(0.1)?, at(0.5)?, at(0.9)?, at(1.0)?])
    }
}

/// The missions of a soak that did not reach their goal, with the reasons; nothing if all did.
pub(super) fn missed_missions(rows: &[RunRow]) -> Markup {
    let missed = || rows.iter().filter(|row| !row.reached());
    let table = Table::new(
        "missions that did not reach their goal",
        missed(),
        &[
            ("map", |row| row.world.clone()),
            ("seed", |row| row.seed.to_string()),
            ("traffic", |row| match row.obstacles {
                0 => "none".to_owned(),
                count => format!("{count}, {}", row.traffic.map_or("unknown", TrafficKind::name)),
            }),
            ("end", |row| row.outcome.text().to_owned()),
            ("time, s", |row| fixed(row.time_s, 1)),
            ("path, m", |row| optional(row.path_m, 1)),
            ("reason", |row| row.reason.clone().unwrap_or_default()),
        ],
    );
    html! {
        @if missed().next().is_some() {
            div class="full-row words" {
                h3 { "Missions that did not reach their goal" }
                p class="machine" {
                    "To play one of them back, run the command of the soak with " code { "--replay SEED --report DIR" } "."
                }
                (table.markup())
            }
        }
    }
}

/// The figures of an ablation: ends and times of each variant.
pub(super) fn ablation(rows: &[experiment::Group]) -> Vec<ChartFigure> {
    let missions = rows.first().map_or(0, |row| row.runs);
    let shared = rows.first().map_or(0, |row| row.shared);
    let captions = [
        format!(
            "Every variant drives the same {missions} missions. Each variant has one part more than the one above it."
        ),
        format!(
            "Every variant with any success reached the goal of {shared} missions; the lighter bar is the mean time over these."
        ),
    ];
    let charts = [ablation_ends(rows), ablation_times(rows)];
    charts
        .into_iter()
        .zip(captions)
        .map(|(chart, caption)| ChartFigure { chart, caption, table: ablation_table(rows) })
        .collect()
}

fn ablation_ends(rows: &[experiment::Group]) -> Chart {
    const ENDS: [RunEnd; 6] = [
        RunEnd::Reached,
        RunEnd::GaveUp,
        RunEnd::Timeout,
        RunEnd::AvoidableContact,
        RunEnd::ObstacleContact,
        RunEnd::RobotContact,
    ];
    let counts: Vec<EndCounts> = rows.iter().map(group_counts).collect();
    let chart_rows = rows.iter().zip(&counts).map(|(row, counts)| Row {
        group: 0,
        label: row.name.clone(),
        value: format!("{} % reached", fixed(100.0 * row.reached_share, 1)),
        mark: counts.stack(&ENDS),
    });
    Chart::of_rows(
        "Ends of the missions",
        (Axis::exact(0.0, 100.0), "%"),
        chart_rows.collect(),
        end_legend(&ENDS, &counts.iter()),
    )
}

fn group_counts(group: &experiment::Group) -> EndCounts {
    EndCounts::new([
        (RunEnd::Reached, group.reached),
        (RunEnd::GaveUp, group.failed),
        (RunEnd::Timeout, group.timeouts),
        (RunEnd::AvoidableContact, group.contacts_avoidable),
        (RunEnd::ObstacleContact, group.contacts_other),
        (RunEnd::RobotContact, group.contacts_robot),
    ])
}

/// Mean times over the successes of each variant, and over the missions that all variants share.
fn ablation_times(rows: &[experiment::Group]) -> Chart {
    let times = |row: &experiment::Group| [row.mean_time_s, row.mean_shared_time_s];
    let longest = rows.iter().flat_map(times).flatten().fold(1.0, f64::max);
    let chart_rows = rows.iter().map(|row| {
        let [own, shared] = times(row);
        Row {
            group: 0,
            label: row.name.clone(),
            value: match own {
                Some(_) => format!("{} s, shared {} s", optional(own, 1), optional(shared, 1)),
                None => "none reached".to_owned(),
            },
            mark: RowMark::Pair([
                ("own-time", own.unwrap_or_default()),
                ("shared-time", shared.unwrap_or_default()),
            ]),
        }
    });
    Chart::of_rows(
        "Mean time of the missions reached",
        (Axis::rounded(0.0, longest), "s"),
        chart_rows.collect(),
        vec![
            LegendEntry::area("own-time", "own successes"),
            LegendEntry::area("shared-time", "missions that all reached"),
        ],
    )
}

fn ablation_table(rows: &[experiment::Group]) -> Table {
    Table::of_columns(
        "effect of each part",
        rows,
        &[
            "name",
            "runs",
            "reached",
            "reached_share",
            "contacts_robot",
            "contacts_avoidable",
            "contacts_other",
            "failed",
            "timeouts",
            "mean_time_s",
            "mean_shared_time_s",
            "mean_clearance_reached_m",
        ],
    )
}
