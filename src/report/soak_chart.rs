//! A soak: how its missions ended, how fast and how near to things they were driven, by map and by who was about.

use maud::{Markup, html};

use super::axis::Axis;
use super::curves::Plot;
use super::figure::{Figure, Table, area_mark};
use super::number::{fixed, significant};
use super::panel::chart;
use super::row_chart::{self, Place, Row, RowChart, spread_key};
use super::soak_groups::{Group, groups};
use crate::experiment::{Group as Tally, RunRow};

/// Ends of missions that did not arrive, from the axis on: class, meaning and count.
type Missed = (&'static str, &'static str, fn(&Tally) -> usize);
const MISSED: [Missed; 4] = [
    ("end-robot", "contact by the robot", |tally| {
        tally.contacts_robot
    }),
    ("end-other", "contact by somebody else's motion", |tally| {
        tally.contacts_other
    }),
    ("end-stopped", "gave up", |tally| tally.failed),
    ("end-late", "time up", |tally| tally.timeouts),
];

/// A figure of a mission that has a spread.
struct Measured {
    title: &'static str,
    axis_title: &'static str,
    caption: &'static str,
    heads: &'static [&'static str],
    figure: fn(&RunRow) -> Option<f64>,
}

const MEASURED: [Measured; 2] = [
    Measured {
        title: "Soak: time for each metre of the way",
        axis_title: "s/m (logarithmic)",
        caption: "Simulated time of a mission over the length of its first path; the missions that arrived. Waiting for people \
            is in it.",
        heads: &[
            "missions",
            "arrived",
            "least, s/m",
            "10 %, s/m",
            "median, s/m",
            "90 %, s/m",
            "greatest, s/m",
        ],
        figure: |row| Some(row.time_s / row.path_m?),
    },
    Measured {
        title: "Soak: smallest gap of a mission",
        axis_title: "m (logarithmic)",
        caption: "Smallest true gap between the footprint and anything solid, people too; the missions that arrived.",
        heads: &[
            "missions",
            "arrived",
            "least, m",
            "10 %, m",
            "median, m",
            "90 %, m",
            "greatest, m",
        ],
        figure: |row| row.min_clearance_m,
    },
];

/// The figures of a page.
pub(super) fn figures(rows: &[RunRow]) -> Vec<Markup> {
    let groups = groups(rows);
    let captions = MEASURED
        .iter()
        .map(|one| (one.caption.to_owned(), spreads(one, &groups)));
    let texts = [(endings_caption(&groups), endings(&groups))]
        .into_iter()
        .chain(captions);
    let figures = plots(rows).into_iter().zip(texts);
    figures
        .map(|(plot, (caption, table))| {
            Figure {
                title: plot.title,
                picture: chart(plot.height, &plot.alternative, &plot.content),
                legend: plot.legend(),
                caption,
                table,
            }
            .markup()
        })
        .collect()
}

/// The same as plots of their own: how missions ended, times, gaps.
pub(super) fn plots(rows: &[RunRow]) -> Vec<Plot> {
    let groups = groups(rows);
    let spreads = MEASURED.iter().map(|one| spread_plot(one, &groups));
    [endings_plot(&groups)].into_iter().chain(spreads).collect()
}

fn endings_plot(groups: &[Group]) -> Plot {
    let percent = |group: &Group, count: usize| 100.0 * count as f64 / group.missions.len() as f64;
    let missed = |group: &Group| group.tally.runs - group.tally.reached;
    let most = groups
        .iter()
        .map(|group| percent(group, missed(group)))
        .fold(1.0, f64::max);
    let rows: Vec<Row> = groups
        .iter()
        .map(|group| {
            group.row(format!(
                "{} of {} arrived",
                group.tally.reached, group.tally.runs
            ))
        })
        .collect();
    let mark = |place: &Place<'_>, index: usize| {
        let group = &groups[index];
        place.stack(
            MISSED
                .map(|(class, _, count)| (class, percent(group, count(&group.tally))))
                .into_iter(),
        )
    };
    let of = RowChart {
        axis_title: "%",
        axis: Axis::rounded(0.0, most),
        rows: &rows,
    };
    let occurs = |(_, _, count): &Missed| groups.iter().any(|group| count(&group.tally) > 0);
    let keys = MISSED.into_iter().filter(occurs);
    Plot {
        title: "Soak: missions that did not arrive",
        style: row_chart::STYLE,
        content: of.draw(mark),
        height: of.height(),
        keys: keys
            .map(|(class, meaning, _)| (area_mark(class), meaning.to_owned()))
            .collect(),
        alternative: of.said("How the missions ended"),
    }
}

fn spread_plot(of: &Measured, groups: &[Group]) -> Plot {
    let spreads: Vec<Option<[f64; 5]>> =
        groups.iter().map(|group| group.spread(of.figure)).collect();
    let value = |spread: &Option<[f64; 5]>| match spread {
        Some([_, _, middle, ..]) => format!("median {}", significant(*middle)),
        None => "none arrived".to_owned(),
    };
    let rows: Vec<Row> = groups
        .iter()
        .zip(&spreads)
        .map(|(group, spread)| group.row(value(spread)))
        .collect();
    let ends = spreads
        .iter()
        .flatten()
        .map(|[least, .., most]| (*least, *most));
    let (least, most) = ends
        .reduce(|(a, b), (c, d)| (a.min(c), b.max(d)))
        .unwrap_or((1.0, 10.0));
    let chart = RowChart {
        axis_title: of.axis_title,
        axis: Axis::logarithmic(least, most),
        rows: &rows,
    };
    let mark = |place: &Place<'_>, index: usize| {
        html! {
            @if let Some(values) = &spreads[index] { (place.spread(values)) }
        }
    };
    Plot {
        title: of.title,
        style: row_chart::STYLE,
        content: chart.draw(mark),
        height: chart.height(),
        keys: vec![spread_key()],
        alternative: chart.said(of.title),
    }
}

fn endings_caption(groups: &[Group]) -> String {
    let Some(all) = groups.first() else {
        return "No mission was driven.".to_owned();
    };
    let tally = &all.tally;
    format!(
        "{} missions, {} % reached their goal; {} contacts by the robot. A contact is the robot's when the part of its footprint \
         that touched moved towards what it touched, or that stands still.",
        tally.runs,
        fixed(100.0 * tally.reached_share, 1),
        tally.contacts_robot,
    )
}

fn endings(groups: &[Group]) -> Table<'static> {
    let row = |group: &Group| {
        let tally = &group.tally;
        let mut row = vec![
            group.label.clone(),
            tally.runs.to_string(),
            tally.reached.to_string(),
            fixed(100.0 * tally.reached_share, 1),
        ];
        row.extend(MISSED.map(|(_, _, count)| count(tally).to_string()));
        row
    };
    Table {
        title: "how missions ended".to_owned(),
        heads: &[
            "missions",
            "in all",
            "reached",
            "reached, %",
            "contact by the robot",
            "contact by somebody else's motion",
            "gave up",
            "time up",
        ],
        rows: groups.iter().map(row).collect(),
    }
}

fn spreads(of: &Measured, groups: &[Group]) -> Table<'static> {
    let row = |group: &Group| {
        let mut row = vec![group.label.clone(), group.tally.reached.to_string()];
        row.extend(
            group
                .spread(of.figure)
                .unwrap_or([f64::NAN; 5])
                .map(significant),
        );
        row
    };
    Table {
        title: of.title.to_lowercase(),
        heads: of.heads,
        rows: groups.iter().map(row).collect(),
    }
}

/// Every mission that did not arrive, and why; nothing where all did.
pub(super) fn missed(rows: &[RunRow]) -> Markup {
    let missed = || rows.iter().filter(|row| !row.reached());
    let people = |row: &RunRow| match row.obstacles {
        0 => "nobody".to_owned(),
        moving => format!("{moving}, {}", spelled(row.traffic)),
    };
    let table = Table {
        title: "missions that did not arrive".to_owned(),
        heads: &[
            "map", "seed", "people", "ended", "time, s", "path, m", "why",
        ],
        rows: missed()
            .map(|row| {
                vec![
                    row.world.clone(),
                    row.seed.to_string(),
                    people(row),
                    spelled(row.outcome),
                    fixed(row.time_s, 1),
                    fixed(row.path_m.unwrap_or(f64::NAN), 1),
                    row.reason.clone().unwrap_or_default(),
                ]
            })
            .collect(),
    };
    html! {
        @if missed().next().is_some() {
            div class="whole-row words" {
                h3 { "Missions that did not arrive" }
                p class="machine" { "The soak's own command with " code { "--replay SEED --report DIR" } " in place of the report drives one of them again, to be played back." }
                (table.markup())
            }
        }
    }
}

/// As a record spells it.
fn spelled(word: impl serde::Serialize) -> String {
    let word = serde_json::to_value(word).unwrap_or_default();
    word.as_str().unwrap_or_default().to_owned()
}
