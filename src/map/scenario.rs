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
    /// Line of the file that it stands in, from one.
    pub line: usize,
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
    /// The most that `optimal` can be off because it is written with few digits, cells: half a unit of the last one.
    pub rounding: f64,
}

/// Significant digits of a length in files that part with trailing zeros: what C++ streams write unless told otherwise.
const FEWEST_DIGITS: i32 = 6;

/// Longest file read, bytes.
const MAX_BYTES: u64 = 64 << 20;

/// Reads the queries of a `.scen` file, in file order. The line `version N` at the top may be missing; fields are
/// parted by one tab or by spaces; empty lines are passed over.
///
/// # Errors
/// When the file cannot be read, or a line does not hold the nine fields; the message names the file, line and field.
pub fn read_scen(path: &Path) -> Result<Vec<Scenario>, MapError> {
    read_text(path, MAX_BYTES)
        .and_then(|text| parse_scen(&text))
        .map_err(|problem| problem.in_file(path))
}

/// The queries in the text of a `.scen` file; see [`read_scen`].
///
/// # Errors
/// When a line does not hold the nine fields; the message names the line and field.
pub fn parse_scen(text: &str) -> Result<Vec<Scenario>, MapError> {
    let mut scenarios = Vec::new();
    let mut digits = Digits::default();
    for (line, text) in (1..).zip(text.lines().map(str::trim)) {
        if text.is_empty() || line == 1 && text.starts_with("version") {
            continue;
        }
        let (scenario, optimal) = scenario(line, text)?;
        scenarios.push(scenario);
        digits.add(optimal);
    }
    for scenario in &mut scenarios {
        scenario.rounding = digits.rounding(scenario.optimal);
    }
    Ok(scenarios)
}

/// How the lengths of a file are written.
#[derive(Default)]
struct Digits {
    /// Decimals of the first length.
    decimals: Option<i32>,
    /// Whether a length has other decimals than the first: the file parts with trailing zeros.
    varying: bool,
    /// Significant digits of the longest.
    significant: i32,
}

impl Digits {
    fn add(&mut self, length: &str) {
        let decimals = length.split_once('.').map_or(0, |(_, after)| after.len()) as i32;
        self.varying |= *self.decimals.get_or_insert(decimals) != decimals;
        let significant = length.trim_start_matches(['0', '.']).replace('.', "").len() as i32;
        self.significant = self.significant.max(significant);
    }

    /// The most that a length of this file can be off. Where all have the same decimals, that is half a unit of the
    /// last; else each has as many significant digits as the longest, those that are zeros unwritten.
    fn rounding(&self, length: f64) -> f64 {
        let decimals = match self.decimals {
            Some(decimals) if decimals > 0 && !self.varying => decimals,
            _ if length > 0.0 => {
                let whole_digits = libm::floor(libm::log10(length)) as i32 + 1;
                self.significant.max(FEWEST_DIGITS) - whole_digits
            }
            _ => return 0.0,
        };
        0.5 / libm::pow(10.0, f64::from(decimals))
    }
}

/// A query, and its optimal length as it is written.
fn scenario(line: usize, text: &str) -> Result<(Scenario, &str), MapError> {
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
        line,
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
        // Told by all lines together.
        rounding: 0.0,
    };
    for (name, (x, y)) in [("start", scenario.start), ("goal", scenario.goal)] {
        if !((0..scenario.width).contains(&x) && (0..scenario.height).contains(&y)) {
            let found = format!("{name} is ({x}, {y})");
            let expected = format!("a cell of the {width} x {height} map");
            return Err(bad_line(line, found, expected));
        }
    }
    Ok((scenario, optimal))
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Rounding of each length of a file that lists these.
    fn roundings(lengths: &[&str]) -> Vec<f64> {
        let lines: Vec<String> = lengths
            .iter()
            .map(|length| format!("0 m.map 9 9 1 1 2 2 {length}"))
            .collect();
        let scenarios = parse_scen(&lines.join("\n")).expect("lines of nine fields");
        scenarios.iter().map(|query| query.rounding).collect()
    }

    fn assert_near(found: &[f64], expected: &[f64]) {
        let near = |(found, expected): (&f64, &f64)| (found - expected).abs() <= 1e-9 * expected;
        assert!(
            found.len() == expected.len() && found.iter().zip(expected).all(near),
            "{found:?}"
        );
    }

    #[test]
    fn lengths_are_off_by_half_a_unit_of_their_last_digit() {
        // Two decimals throughout, as bg512 has; eight, as the cities have.
        assert_near(&roundings(&["3.41", "449.00"]), &[5e-3, 5e-3]);
        assert_near(&roundings(&["2.00000000", "371.62950897"]), &[5e-9, 5e-9]);
        // Six significant digits without trailing zeros, as most have.
        assert_near(
            &roundings(&["2.41421", "2", "0", "193.5", "2835.85"]),
            &[5e-6, 5e-6, 0.0, 5e-4, 5e-3],
        );
        // Whole numbers alone tell nothing of themselves.
        assert_near(&roundings(&["2", "34"]), &[5e-6, 5e-5]);
        // All that an f64 has.
        assert_near(&roundings(&["4.828427124746190", "2"]), &[5e-16, 5e-16]);
    }
}
