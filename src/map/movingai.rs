//! The `MovingAI` benchmark (Sturtevant 2012): grid maps, `.map` files of type octile, and path queries with known
//! lengths, `.scen` files.

use core::str::FromStr;
use std::path::Path;

use super::load::read_text;
use super::{Cell, GridFrame, MAX_GRID_SIDE, MapError, OccupancyGrid};
use crate::geometry::Pose;

/// First line of a `.map` file.
const FIRST_LINE: &str = "type octile";

/// Whether the text starts like a `.map` file.
pub(super) fn begins(text: &str) -> bool {
    text.lines().next().map(str::trim_end) == Some(FIRST_LINE)
}

/// The cell at a column and row counted from the top left, as in `.map` and `.scen` files. It is outside the grid if the
/// coordinates are.
#[must_use]
pub const fn cell_from_top_left(frame: &GridFrame, (x, y): (i32, i32)) -> Cell {
    Cell::new(x, (frame.height - 1).saturating_sub(y))
}

impl OccupancyGrid {
    /// Parses a `.map` file of type octile. `.`, `G` and `S` (swamp) are free; `@`, `O`, `T` and `W` (water) are occupied.
    /// The resolution is in metres per cell; the lower left corner is the origin.
    ///
    /// # Errors
    /// Returns an error for invalid text or a frame that [`GridFrame::new`] rejects; the message names the line.
    pub fn from_movingai(text: &str, resolution_m: f64) -> Result<Self, MapError> {
        parse(text, resolution_m)
    }
}

fn parse(text: &str, resolution_m: f64) -> Result<OccupancyGrid, MapError> {
    let mut lines = (1..).zip(text.lines().map(str::trim_end));
    let (width, height) = header(&mut lines)?;
    let frame = GridFrame::new(width, height, resolution_m, Pose::default())?;
    let mut cells = Vec::new();
    let mut rows = 0;
    for (line, row) in lines {
        if rows < height {
            append_row(&mut cells, line, row, width)?;
            rows += 1;
        } else if !row.is_empty() {
            let expected = format!("the end after {height} rows, the stated `height`");
            return Err(bad_line(line, "another row".into(), expected));
        }
    }
    if rows < height {
        let found = format!("the file ends after {rows} rows");
        let expected = format!("{height}, the stated `height`");
        return Err(bad_line(text.lines().count(), found, expected));
    }
    Ok(OccupancyGrid::from_top_down(frame, &cells))
}

/// Reads width and height from the lines up to `map`.
fn header<'a>(lines: &mut impl Iterator<Item = (usize, &'a str)>) -> Result<(i32, i32), MapError> {
    let (mut width, mut height) = (None, None);
    let mut last = 1;
    for (line, text) in lines {
        last = line;
        match text.split_once(' ') {
            _ if line == 1 && text == FIRST_LINE => {}
            Some(("height", value)) if line > 1 => height = Some(side(line, "height", value)?),
            Some(("width", value)) if line > 1 => width = Some(side(line, "width", value)?),
            None if text == "map" => {
                return width.zip(height).ok_or_else(|| {
                    let expected = "`height` and `width` before it".into();
                    bad_line(line, "`map`".into(), expected)
                });
            }
            _ => {
                let expected = match line {
                    1 => format!("`{FIRST_LINE}`"),
                    _ => "`height N`, `width N` or `map`".into(),
                };
                return Err(bad_line(line, quoted(text), expected));
            }
        }
    }
    let expected = format!("`{FIRST_LINE}`, `height N`, `width N`, `map` and the rows");
    Err(bad_line(last, "the file ends".into(), expected))
}

fn side(line: usize, key: &str, value: &str) -> Result<i32, MapError> {
    let cells = value.trim().parse().ok();
    cells.filter(|cells| (1..=MAX_GRID_SIDE).contains(cells)).ok_or_else(|| {
        let expected = format!("a whole number from 1 to {MAX_GRID_SIDE}");
        bad_line(line, format!("`{key}` is {}", quoted(value)), expected)
    })
}

fn append_row(cells: &mut Vec<i8>, line: usize, row: &str, width: i32) -> Result<(), MapError> {
    let before = cells.len();
    for (column, character) in (1..).zip(row.chars()) {
        cells.push(match character {
            '.' | 'G' | 'S' => 0,
            '@' | 'O' | 'T' | 'W' => 100,
            _ => {
                let found = format!("column {column}: {character:?}");
                let expected = "`.`, `G` or `S` (free), or `@`, `O`, `T` or `W` (blocked)".into();
                return Err(bad_line(line, found, expected));
            }
        });
    }
    let found = cells.len() - before;
    if found == width as usize {
        return Ok(());
    }
    let expected = format!("{width}, the stated `width`");
    Err(bad_line(line, format!("a row of {found} cells"), expected))
}

/// The start of a text for a message: quoted and shortened.
fn quoted(text: &str) -> String {
    format!("{:?}", text.chars().take(40).collect::<String>())
}

fn bad_line(line: usize, found: String, expected: String) -> MapError {
    MapError::BadLine { line, found, expected }
}

/// One path query. Coordinates are (x, y) in cells from the top left of the map; see
/// [`cell_from_top_left`](super::cell_from_top_left).
#[derive(Clone, Debug, PartialEq)]
pub struct Scenario {
    /// Its line in the file, from one.
    pub line: usize,
    /// Index of the group of queries of similar length.
    pub bucket: u32,
    /// Name of the map, as in the file.
    pub map: String,
    /// Width of the map that the coordinates refer to, cells.
    pub width: i32,
    /// Height of that map, cells.
    pub height: i32,
    /// Start of the path.
    pub start: (i32, i32),
    /// End of the path.
    pub goal: (i32, i32),
    /// Length of the shortest path, cells: eight neighbours, no corner cutting. Files round it, some to two decimals.
    pub optimal: f64,
    /// Largest rounding error of `optimal`, cells: half a unit of its last digit.
    pub rounding: f64,
}

/// Significant digits of a length in files without trailing zeros: the default of C++ streams.
const DEFAULT_DIGITS: i32 = 6;

/// Largest file accepted, bytes.
const MAX_SCEN_BYTES: u64 = 64 << 20;

/// Reads the queries of a `.scen` file in file order. The first line `version N` is optional; fields are separated by one
/// tab or by spaces; empty lines are skipped.
///
/// # Errors
/// Returns an error if the file cannot be read or a line does not hold nine valid fields; the message names file, line
/// and field.
pub fn read_scen(path: &Path) -> Result<Vec<Scenario>, MapError> {
    read_text(path, MAX_SCEN_BYTES)
        .and_then(|text| parse_scen(&text))
        .map_err(|problem| problem.in_file(path))
}

/// Parses the text of a `.scen` file; see [`read_scen`].
///
/// # Errors
/// Returns an error if a line does not hold nine valid fields; the message names line and field.
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

/// How many digits the lengths of a file have.
#[derive(Default)]
struct Digits {
    /// Decimals of the first length.
    decimals: Option<i32>,
    /// Whether another length has another number of decimals: the file omits trailing zeros.
    varying: bool,
    /// Largest number of significant digits.
    significant: i32,
}

impl Digits {
    fn add(&mut self, length: &str) {
        let decimals = length.split_once('.').map_or(0, |(_, after)| after.len()) as i32;
        self.varying |= *self.decimals.get_or_insert(decimals) != decimals;
        let significant = length.trim_start_matches(['0', '.']).replace('.', "").len() as i32;
        self.significant = self.significant.max(significant);
    }

    /// The largest rounding error of a length in this file. If all lengths have the same number of decimals, it is half a
    /// unit of the last decimal. Otherwise each has as many significant digits as the longest, without trailing zeros.
    fn rounding(&self, length: f64) -> f64 {
        let decimals = match self.decimals {
            Some(decimals) if decimals > 0 && !self.varying => decimals,
            _ if length > 0.0 => {
                let whole_digits = libm::floor(libm::log10(length)) as i32 + 1;
                self.significant.max(DEFAULT_DIGITS) - whole_digits
            }
            _ => return 0.0,
        };
        0.5 / libm::pow(10.0, f64::from(decimals))
    }
}

/// Parses a line into a query and the text of its optimal length.
fn scenario(line: usize, text: &str) -> Result<(Scenario, &str), MapError> {
    let fields: Vec<&str> = if text.contains('\t') {
        text.split('\t').map(str::trim).collect()
    } else {
        text.split(' ').filter(|field| !field.is_empty()).collect()
    };
    let &[bucket, map, width, height, start_x, start_y, goal_x, goal_y, optimal] =
        fields.as_slice()
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
        optimal: field(line, "optimal", optimal, "a length of at least zero", |length: &f64| {
            length.is_finite() && *length >= 0.0
        })?,
        // Computed after all lines are read.
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
    text.parse()
        .ok()
        .filter(accept)
        .ok_or_else(|| bad_line(line, format!("{name} is {}", quoted(text)), expected.to_owned()))
}
