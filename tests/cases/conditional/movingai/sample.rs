//! A generated benchmark: maps and scenarios as files. A search that shares only the rules with this crate's measures the
//! lengths.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use pathfinding::prelude::dijkstra_all;
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::ground::{self, Rows};

/// A cell: column from the left, row from the top.
type Place = (usize, usize);

/// Costs of moves, in units of a billionth of a cell.
const STRAIGHT: u64 = 1_000_000_000;
const DIAGONAL: u64 = 1_414_213_562;

/// Formats of lengths in the benchmark's files.
#[derive(Clone, Copy)]
enum Style {
    /// Six significant digits without trailing zeros, separated by tabs.
    SixDigits,
    /// Two decimals, separated by spaces, in no order.
    TwoDecimals,
    /// Eight decimals, with empty lines at the end.
    EightDecimals,
}

/// Writes maps and scenarios below a folder; returns the number of scenarios.
pub fn write(folder: &Path) -> usize {
    let mut random = Pcg64Mcg::seed_from_u64(2012);
    let random = &mut random;
    let grounds = [
        ("open/clutter-10", ground::clutter(random, 60, 45, 0.1)),
        ("open/clutter-25", ground::clutter(random, 45, 60, 0.25)),
        ("clutter-40", ground::clutter(random, 70, 50, 0.4)),
        ("rooms", ground::rooms(random, 7, 5, 7)),
        ("maze", ground::maze(random, 19, 14)),
        ("deep/down/caves", ground::caves(random, 80, 50)),
        ("corridor", ground::clutter(random, 90, 1, 0.0)),
    ];
    let styles = [Style::SixDigits, Style::TwoDecimals, Style::EightDecimals];
    let mut scenarios = 0;
    for ((name, rows), style) in grounds.iter().zip(styles.iter().cycle()) {
        let queries = queries(random, rows);
        scenarios += queries.len();
        let map = map_text(&ground::in_many_letters(random, rows));
        let path = folder.join(format!("{name}.map"));
        fs::create_dir_all(path.parent().expect("a file is in a folder")).expect("a new folder");
        fs::write(&path, map).expect("the folder can be written to");
        // Both forms of file names that the benchmark has.
        let ending = if matches!(style, Style::TwoDecimals) { "scen" } else { "map.scen" };
        let path = folder.join(format!("{name}.{ending}"));
        fs::write(path, scen_text(name, rows, &queries, *style)).expect("as above");
    }
    scenarios
}

/// A query and the length of its shortest path, cells.
struct Query {
    start: Place,
    goal: Place,
    length: f64,
}

/// Returns queries from some starts, each to reachable goals and to itself.
fn queries(random: &mut Pcg64Mcg, rows: &Rows) -> Vec<Query> {
    let mut queries = Vec::new();
    while queries.len() < 60 {
        let start = (random.random_range(0..rows[0].len()), random.random_range(0..rows.len()));
        if !is_free(rows, start) {
            continue;
        }
        let reached = dijkstra_all(&start, |&place| moves(rows, place));
        let mut goals: Vec<(Place, u64)> =
            reached.into_iter().map(|(goal, (_, cost))| (goal, cost)).collect();
        // The order of a hash map differs from run to run.
        goals.sort_unstable();
        goals.shuffle(random);
        goals.truncate(11);
        goals.push((start, 0));
        queries.extend(goals.into_iter().map(|(goal, cost)| Query {
            start,
            goal,
            length: cost as f64 / STRAIGHT as f64,
        }));
    }
    queries
}

fn is_free(rows: &Rows, (x, y): Place) -> bool {
    rows.get(y).and_then(|row| row.get(x)) == Some(&b'.')
}

/// The eight moves; a diagonal move needs both adjacent cells free.
fn moves(rows: &Rows, (x, y): Place) -> Vec<(Place, u64)> {
    let (left, right) = (x.wrapping_sub(1), x + 1);
    let (up, down) = (y.wrapping_sub(1), y + 1);
    let straight = [(left, y), (right, y), (x, up), (x, down)];
    let diagonal = [(left, up), (right, up), (left, down), (right, down)];
    let mut moves = Vec::with_capacity(8);
    moves.extend(straight.map(|to| (to, STRAIGHT)));
    moves.extend(
        diagonal
            .into_iter()
            .filter(|&(to_x, to_y)| is_free(rows, (to_x, y)) && is_free(rows, (x, to_y)))
            .map(|to| (to, DIAGONAL)),
    );
    moves.retain(|&(to, _)| is_free(rows, to));
    moves
}

fn map_text(rows: &Rows) -> String {
    let (width, height) = (rows[0].len(), rows.len());
    let mut text = format!("type octile\nheight {height}\nwidth {width}\nmap\n");
    for row in rows {
        text.extend(row.iter().map(|&letter| char::from(letter)));
        text.push('\n');
    }
    text
}

fn scen_text(name: &str, rows: &Rows, queries: &[Query], style: Style) -> String {
    let (width, height) = (rows[0].len(), rows.len());
    let mut text = String::from(match style {
        Style::SixDigits => "version 1\n",
        Style::TwoDecimals => "",
        Style::EightDecimals => "version 1.0\n",
    });
    for Query { start, goal, length } in queries {
        let bucket = (length / 4.0) as u32;
        let line = format!(
            "{bucket} maps/{name}.map {width} {height} {} {} {} {} {}",
            start.0,
            start.1,
            goal.0,
            goal.1,
            written(*length, style)
        );
        let line = match style {
            Style::TwoDecimals => line,
            _ => line.replace(' ', "\t"),
        };
        writeln!(text, "{line}").expect("a string takes all");
    }
    if matches!(style, Style::EightDecimals) {
        text.push_str("\n\n");
    }
    text
}

fn written(length: f64, style: Style) -> String {
    match style {
        Style::TwoDecimals => format!("{length:.2}"),
        Style::EightDecimals => format!("{length:.8}"),
        Style::SixDigits => {
            let whole = format!("{length:.0}").len();
            let digits = format!("{length:.0$}", 6_usize.saturating_sub(whole));
            digits.trim_end_matches('0').trim_end_matches('.').to_owned()
        }
    }
}
