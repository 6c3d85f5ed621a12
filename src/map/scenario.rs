//! Path-finding queries with known answers: `.scen` files of the `MovingAI` benchmark (Sturtevant 2012).

use core::str::FromStr;
use std::path::Path;

use super::MapError;
use super::load::read_text;
use super::movingai::{bad_line, quoted};

/// One query. Coordinates are (x, y) in cells from the top left of the map; see
/// [`cell_from_top_left`](super::cell_from_top_left).
#[derive(Clone, Debug, PartialEq)]
pub struct Scenario {
    /// Group of queries of about equal length.
    pub bucket: u32,
    /// Name of the map, as written.
    pub map: String,
    /// Columns of the map that the coordinates are for.
    pub width: i32,
    /// Rows of that map.
    pub height: i32,
    /// Where the path begins.
    pub start: (i32, i32),
    /// Where it ends.
    pub goal: (i32, i32),
    /// Length of the shortest path, cells: eight neighbours, no corner cut. Files round it, some to two decimals.
    pub optimal: f64,
}

/// Longest file read, bytes.
const MAX_BYTES: u64 = 64 << 20;

/// Reads the queries of a `.scen` file, in file order. The line `version N` at the top may be missing; fields are
/// parted by one tab or by spaces; empty lines are passed over.
///
/// # Errors
/// When the file cannot be read, or a line does not hold the nine fields; the message names the file, line and field.
pub fn read_scen(path: &Path) -> Result<Vec<Scenario>, MapError> {
    read_text(path, MAX_BYTES)
        .and_then(|text| parse(&text))
        .map_err(|problem| problem.in_file(path))
}

fn parse(text: &str) -> Result<Vec<Scenario>, MapError> {
    (1..)
        .zip(text.lines().map(str::trim))
        .filter(|(line, text)| !(text.is_empty() || *line == 1 && text.starts_with("version")))
        .map(|(line, text)| scenario(line, text))
        .collect()
}

fn scenario(line: usize, text: &str) -> Result<Scenario, MapError> {
    let fields: Vec<&str> = if text.contains('\t') {
        text.split('\t').map(str::trim).collect()
    } else {
        text.split(' ').filter(|field| !field.is_empty()).collect()
    };
    let &[
        bucket,
        map,
        width,
        height,
        start_x,
        start_y,
        goal_x,
        goal_y,
        optimal,
    ] = fields.as_slice()
    else {
        let found = format!("{} fields", fields.len());
        let expected = "9: bucket, map, width, height, start x, start y, goal x, goal y, optimal";
        return Err(bad_line(line, found, expected.into()));
    };
    let whole = "a whole number";
    let size = "a whole number above zero";
    let scenario = Scenario {
        bucket: field(line, "bucket", bucket, whole, |_| true)?,
        map: map.to_owned(),
        width: field(line, "width", width, size, |&cells| cells > 0)?,
        height: field(line, "height", height, size, |&cells| cells > 0)?,
        start: (
            field(line, "start x", start_x, whole, |_| true)?,
            field(line, "start y", start_y, whole, |_| true)?,
        ),
        goal: (
            field(line, "goal x", goal_x, whole, |_| true)?,
            field(line, "goal y", goal_y, whole, |_| true)?,
        ),
        optimal: field(
            line,
            "optimal",
            optimal,
            "a length of at least zero",
            |length: &f64| length.is_finite() && *length >= 0.0,
        )?,
    };
    for (name, (x, y)) in [("start", scenario.start), ("goal", scenario.goal)] {
        if !((0..scenario.width).contains(&x) && (0..scenario.height).contains(&y)) {
            let found = format!("{name} is ({x}, {y})");
            let expected = format!("a cell of the {width} x {height} map");
            return Err(bad_line(line, found, expected));
        }
    }
    Ok(scenario)
}

fn field<T: FromStr>(
    line: usize,
    name: &str,
    text: &str,
    expected: &str,
    accept: impl Fn(&T) -> bool,
) -> Result<T, MapError> {
    text.parse().ok().filter(accept).ok_or_else(|| {
        bad_line(
            line,
            format!("{name} is {}", quoted(text)),
            expected.to_owned(),
        )
    })
}
