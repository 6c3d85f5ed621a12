//! What each part of the navigator buys: how the missions of each variant ended, and their mean times.

use maud::Markup;

use super::axis::Axis;
use super::curves::Plot;
use super::figure::{Figure, Table, area_mark};
use super::number::fixed;
use super::panel::chart;
use super::row_chart::{self, Place, Row, RowChart};
use crate::experiment::Group as AblationRow;

/// Ends of missions, from the axis on: class and meaning.
const ENDS: [(&str, &str); 4] = [
    ("end-reached", "reached"),
    ("end-stopped", "gave up, or time up"),
    ("end-other", "contact, not by the robot's motion"),
    ("end-robot", "contact by the robot"),
];
/// Whose time a bar is: class and meaning.
const TIMES: [(&str, &str); 2] = [
    ("own-time", "its own successes"),
    ("shared-time", "missions that all reached"),
];

/// The figures of a page: ends and times.
pub(super) fn figures(rows: &[AblationRow]) -> Vec<Markup> {
    let missions = rows.first().map_or(0, |row| row.runs);
    let shared = rows.first().map_or(0, |row| row.shared);
    let captions = [
        format!(
            "The same {missions} missions by each; each navigator has one part more than the one above it."
        ),
        format!(
            "{shared} missions were reached by every variant that reached any; the lighter bar is the mean time over these."
        ),
    ];
    let figures = plots(rows).into_iter().zip(captions);
    figures
        .map(|(plot, caption)| {
            Figure {
                title: plot.title,
                picture: chart(plot.height, &plot.alternative, &plot.content),
                legend: plot.legend(),
                caption,
                table: table(rows),
            }
            .markup()
        })
        .collect()
}

/// The same as plots of their own.
pub(super) fn plots(rows: &[AblationRow]) -> Vec<Plot> {
    vec![endings(rows), times(rows)]
}

fn row(row: &AblationRow, value: String) -> Row {
    Row {
        part: 0,
        label: row.name.clone(),
        value,
    }
}

/// A bar of the full length for each variant.
fn endings(rows: &[AblationRow]) -> Plot {
    let percent = |row: &AblationRow| format!("{} % reached", fixed(100.0 * row.reached_share, 1));
    let named: Vec<Row> = rows.iter().map(|one| row(one, percent(one))).collect();
    let mark = |place: &Place<'_>, index: usize| {
        let tally = &rows[index];
        let counts = [
            tally.reached,
            tally.failed + tally.timeouts,
            tally.contacts_other,
            tally.contacts_robot,
        ];
        let share = |count: usize| 100.0 * count as f64 / tally.runs.max(1) as f64;
        place.stack(
            ENDS.iter()
                .zip(counts)
                .map(|((class, _), count)| (*class, share(count))),
        )
    };
    plot(
        "How the missions ended",
        "%",
        Axis::exact(0.0, 100.0),
        &named,
        &ENDS,
        mark,
    )
}

/// Of a variant's own successes, and of the missions that all share.
fn times(rows: &[AblationRow]) -> Plot {
    let pair = |row: &AblationRow| [row.mean_time_s, row.mean_shared_time_s];
    let longest = rows.iter().flat_map(pair).flatten().fold(1.0, f64::max);
    let seconds = |row: &AblationRow| {
        let [own, shared] = pair(row).map(|time_s| fixed(time_s.unwrap_or(f64::NAN), 1));
        match row.mean_time_s {
            Some(_) => format!("{own} s, of the shared {shared} s"),
            None => "none reached".to_owned(),
        }
    };
    let named: Vec<Row> = rows.iter().map(|one| row(one, seconds(one))).collect();
    let mark = |place: &Place<'_>, index: usize| {
        place.halves(
            TIMES.map(|(class, _)| class),
            pair(&rows[index]).map(Option::unwrap_or_default),
        )
    };
    plot(
        "Mean time of the missions reached",
        "s",
        Axis::rounded(0.0, longest),
        &named,
        &TIMES,
        mark,
    )
}

fn plot(
    title: &'static str,
    axis_title: &str,
    axis: Axis,
    rows: &[Row],
    keys: &[(&str, &str)],
    mark: impl Fn(&Place<'_>, usize) -> Markup,
) -> Plot {
    let of = RowChart {
        axis_title,
        axis,
        rows,
    };
    Plot {
        title,
        style: row_chart::STYLE,
        content: of.draw(mark),
        height: of.height(),
        keys: keys
            .iter()
            .map(|(class, meaning)| (area_mark(class), (*meaning).to_owned()))
            .collect(),
        alternative: of.said(title),
    }
}

fn table(rows: &[AblationRow]) -> Table<'static> {
    let number = |value: Option<f64>, decimals| fixed(value.unwrap_or(f64::NAN), decimals);
    Table {
        title: "what each part buys".to_owned(),
        heads: &[
            "navigator",
            "missions",
            "reached",
            "reached, %",
            "contacts by the robot",
            "other contacts",
            "gave up",
            "time up",
            "mean time, s",
            "mean time over shared missions, s",
            "mean smallest gap, m",
        ],
        rows: rows
            .iter()
            .map(|row| {
                let tally = row;
                vec![
                    row.name.clone(),
                    tally.runs.to_string(),
                    tally.reached.to_string(),
                    fixed(tally.reached_share * 100.0, 1),
                    tally.contacts_robot.to_string(),
                    tally.contacts_other.to_string(),
                    tally.failed.to_string(),
                    tally.timeouts.to_string(),
                    number(tally.mean_time_s, 1),
                    number(row.mean_shared_time_s, 1),
                    number(tally.mean_clearance_reached_m, 3),
                ]
            })
            .collect(),
    }
}
