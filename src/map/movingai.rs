//! Grid maps of the `MovingAI` benchmark (Sturtevant 2012): `.map` files of type octile.

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
pub(super) fn quoted(text: &str) -> String {
    format!("{:?}", text.chars().take(40).collect::<String>())
}

pub(super) fn bad_line(line: usize, found: String, expected: String) -> MapError {
    MapError::BadLine { line, found, expected }
}
