//! Charts of many missions: a soak by map and by traffic, and the variants of an ablation.

use std::collections::BTreeMap;

use maud::{Markup, html};

use super::chart::{Axis, Chart, Row, RowMark, range, spread};
use super::figure::Table;
use super::number::{fixed, optional, significant};
use super::run_charts::{MISSED, REACHED, RunEnd, missed_percent, percent, robot_contacts};
use super::svg::LegendEntry;
use crate::bench::percentiles;
use crate::experiment::{Group, RunRow, TrafficKind, by_settings};

/// Missions of a soak with a common property.
struct MissionSet<'a> {
    /// All missions, those of a map, or those with a kind of traffic.
    kind: usize,
    counts: Group,
    missions: Vec<&'a RunRow>,
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

/// The charts of a soak.
pub(super) fn soak(rows: &[RunRow]) -> Vec<Chart> {
    let sets = sets(rows);
    let measures = MEASURES.iter().map(|measure| measure.chart(&sets));
    [soak_ends(&sets)].into_iter().chain(measures).collect()
}

fn soak_ends(sets: &[MissionSet]) -> Chart {
    let caption = sets.first().map_or_else(String::new, |all| {
        format!(
            "{} missions, {} % reached their goal, {} contacts caused by the robot. The robot caused a contact if the touching \
             part of its footprint moved towards the obstacle, or if the obstacle does not move.",
            all.counts.runs,
            fixed(percent(all.counts.reached, &all.counts), 1),
            robot_contacts(&all.counts),
        )
    });
    let most = sets.iter().map(|set| missed_percent(&set.counts)).fold(1.0, f64::max);
    let rows = sets.iter().map(|set| {
        let Group { reached, runs, .. } = &set.counts;
        set.row(format!("{reached} of {runs} reached"), RunEnd::stack(&MISSED, &set.counts))
    });
    let counts: Vec<&Group> = sets.iter().map(|set| &set.counts).collect();
    Chart {
        caption,
        table: Some(ends_table(&counts)),
        ..Chart::of_rows(
            "Soak: missions that did not reach their goal",
            (Axis::rounded(0.0, most), "%"),
            rows.collect(),
            RunEnd::legend(&MISSED, &counts),
        )
    }
}

/// The ends of the missions of each set.
fn ends_table(counts: &[&Group]) -> Table {
    Table::new(
        "ends of the missions",
        counts.iter().copied(),
        &[
            ("group", |counts| counts.name.clone()),
            ("missions", |counts| counts.runs.to_string()),
            ("reached", |counts| counts.reached.to_string()),
            ("reached, %", |counts| fixed(percent(counts.reached, counts), 1)),
            (MISSED[0].text, |counts| robot_contacts(counts).to_string()),
            (MISSED[1].text, |counts| counts.contacts_avoidable.to_string()),
            (MISSED[2].text, |counts| counts.contacts_other.to_string()),
            (MISSED[3].text, |counts| counts.failed.to_string()),
            (MISSED[4].text, |counts| counts.timeouts.to_string()),
        ],
    )
}

/// The charts of wrong planners: how their missions ended with the protective layer and without it.
pub(super) fn protection(rows: &[RunRow]) -> Vec<Chart> {
    let sets = by_settings(rows);
    let counts: Vec<&Group> = sets.iter().collect();
    let chart = Chart::of_rows(
        "Wrong planners: ends of the missions",
        (Axis::exact(0.0, 100.0), "%"),
        ends_rows(&sets, |set| format!("{} contacts by the robot", robot_contacts(set))),
        RunEnd::legend(ENDS, &counts),
    );
    let caption = "The planners are wrong on purpose. Without the layer nothing prevents a contact. With the layer no contact \
        may be caused by the robot; a person who does not yield can still walk into it.";
    vec![Chart { caption: caption.to_owned(), table: Some(ends_table(&counts)), ..chart }]
}

impl Measure {
    fn chart(&self, sets: &[MissionSet]) -> Chart {
        let spreads: Vec<(&MissionSet, Option<[f64; 5]>)> =
            sets.iter().map(|set| (set, set.spread(self.value))).collect();
        let ends = spreads.iter().filter_map(|(_, spread)| *spread);
        let (least, most) = range(ends.flatten()).unwrap_or((1.0, 10.0));
        let rows = spreads.iter().map(|(set, spread)| match spread {
            Some(values) => {
                set.row(format!("median {}", significant(values[2])), RowMark::Spread(*values))
            }
            None if set.counts.reached == 0 => set.row("none reached".to_owned(), RowMark::None),
            None => set.row("no value".to_owned(), RowMark::None),
        });
        let legend = LegendEntry::new(
            spread([0.0, 6.0, 14.0, 22.0, 28.0], 7.0),
            "median, 10 to 90 %, least to greatest",
        );
        // A set without values has no spread.
        let table_rows: Vec<(&Group, [f64; 5])> = spreads
            .iter()
            .map(|(set, spread)| (&set.counts, spread.unwrap_or([f64::NAN; 5])))
            .collect();
        let table = Table::new(
            format!("{}, {}", self.title.to_lowercase(), self.axis_title),
            &table_rows,
            &[
                ("group", |(counts, _)| counts.name.clone()),
                ("reached", |(counts, _)| counts.reached.to_string()),
                ("least", |(_, spread)| significant(spread[0])),
                ("10 %", |(_, spread)| significant(spread[1])),
                ("median", |(_, spread)| significant(spread[2])),
                ("90 %", |(_, spread)| significant(spread[3])),
                ("greatest", |(_, spread)| significant(spread[4])),
            ],
        );
        let axis = (Axis::logarithmic(least, most), self.axis_title);
        Chart {
            caption: self.caption.to_owned(),
            table: Some(table),
            ..Chart::of_rows(self.title, axis, rows.collect(), vec![legend])
        }
    }
}

/// All missions, those of each map, and those with each kind of traffic.
fn sets(rows: &[RunRow]) -> Vec<MissionSet<'_>> {
    let mut all: BTreeMap<(usize, &str, Option<TrafficKind>), Vec<&RunRow>> = BTreeMap::new();
    for row in rows {
        all.entry((0, "all missions", None)).or_default().push(row);
        all.entry((1, &row.world, None)).or_default().push(row);
        if let Some(traffic) = row.traffic {
            all.entry((2, "", Some(traffic))).or_default().push(row);
        }
    }
    let set = |((kind, name, traffic), missions): ((_, &str, Option<TrafficKind>), Vec<_>)| {
        let name = if let Some(traffic) = traffic { traffic_text(traffic) } else { name };
        let counts = Group::of(name, missions.iter().copied());
        MissionSet { kind, counts, missions }
    };
    all.into_iter().map(set).collect()
}

const fn traffic_text(kind: TrafficKind) -> &'static str {
    match kind {
        TrafficKind::None => "no pedestrians",
        TrafficKind::Yielding => "pedestrians that stop for the robot",
        TrafficKind::NonYielding => "pedestrians that ignore the robot",
        TrafficKind::Appearing => "pedestrians that appear suddenly",
        TrafficKind::Starting => "standing pedestrians that start to walk",
        TrafficKind::SteppingOut => "pedestrians that step out of a crossing",
    }
}

impl MissionSet<'_> {
    fn row(&self, value: String, mark: RowMark) -> Row {
        Row { group: self.kind, label: self.counts.name.clone(), value, mark }
    }

    /// Least, 10th, 50th and 90th percentile, and greatest value of the missions that reached their goal; none if no value
    /// can be charted.
    fn spread(&self, value: fn(&RunRow) -> Option<f64>) -> Option<[f64; 5]> {
        let reached = self.missions.iter().filter(|row| row.reached());
        let values: Vec<f64> = reached
            .filter_map(|row| value(row))
            .filter(|value| value.is_finite() && *value > 0.0)
            .collect();
        let [least, low, middle, high, most] = percentiles(values, [0.0, 0.1, 0.5, 0.9, 1.0]);
        Some([least?, low?, middle?, high?, most?])
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

/// The charts of an ablation: ends and times of each variant.
pub(super) fn ablation(rows: &[Group]) -> Vec<Chart> {
    let (missions, shared) = rows.first().map_or((0, 0), |row| (row.runs, row.shared));
    let captions = [
        format!(
            "Every variant drives the same {missions} missions. Each variant has one part more than the one above it."
        ),
        format!(
            "Every variant with any success reached the goal of {shared} missions; the lighter bar is the mean time over these."
        ),
    ];
    let columns = [Group::ENDS, " reached mean_shared_time_s"].concat();
    let charts = [ablation_ends(rows), ablation_times(rows)].into_iter().zip(captions);
    charts
        .map(|(chart, caption)| {
            let table = Some(Table::of_columns("effect of each part", rows, &columns));
            Chart { caption, table, ..chart }
        })
        .collect()
}

/// All ends, from the goal to contacts that the robot caused.
const ENDS: [&RunEnd; 6] = {
    let [robot, avoidable, other, gave_up, timeout] = &MISSED;
    [&REACHED, gave_up, timeout, avoidable, other, robot]
};

/// A bar with all ends for each group.
fn ends_rows(groups: &[Group], value: impl Fn(&Group) -> String) -> Vec<Row> {
    let row = |group: &Group| Row {
        group: 0,
        label: group.name.clone(),
        value: value(group),
        mark: RunEnd::stack(ENDS, group),
    };
    groups.iter().map(row).collect()
}

fn ablation_ends(rows: &[Group]) -> Chart {
    let reached = |row: &Group| format!("{} % reached", fixed(100.0 * row.reached_share, 1));
    Chart::of_rows(
        "Ends of the missions",
        (Axis::exact(0.0, 100.0), "%"),
        ends_rows(rows, reached),
        RunEnd::legend(ENDS, &rows.iter().collect::<Vec<_>>()),
    )
}

/// Mean times over the successes of each variant, and over the missions that all variants share.
fn ablation_times(rows: &[Group]) -> Chart {
    let times = |row: &Group| [row.mean_time_s, row.mean_shared_time_s];
    let longest = rows.iter().flat_map(times).flatten().fold(1.0, f64::max);
    let chart_rows = rows.iter().map(|row| {
        let [own, shared] = times(row);
        let value = format!("{} s, shared {} s", optional(own, 1), optional(shared, 1));
        Row {
            group: 0,
            label: row.name.clone(),
            value: if own.is_some() { value } else { "none reached".to_owned() },
            mark: RowMark::Pair([
                ("own-time", own.unwrap_or_default()),
                ("shared-time", shared.unwrap_or_default()),
            ]),
        }
    });
    let legend = vec![
        LegendEntry::area("own-time", "own successes"),
        LegendEntry::area("shared-time", "missions that all reached"),
    ];
    let axis = (Axis::rounded(0.0, longest), "s");
    Chart::of_rows("Mean time of the missions reached", axis, chart_rows.collect(), legend)
}
