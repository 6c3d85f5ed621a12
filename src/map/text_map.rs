//! Maps as rows of text.

use super::{GridFrame, MapError, OccupancyGrid, UNKNOWN};
use crate::geometry::Pose;

impl OccupancyGrid {
    /// Parses rows of text, from the largest y down, one character per cell: `#` is occupied, `.` or a space is free, `?`
    /// is unknown. The resolution is in metres per cell; the origin is the lower left corner.
    ///
    /// # Errors
    /// Returns an error if there is no cell, a row differs in length from the first, a character is unknown, or
    /// [`GridFrame::new`] rejects the frame. Rows and columns are counted from one at the top left.
    pub fn from_rows(
        rows: &[impl AsRef<str>],
        resolution_m: f64,
        origin: Pose,
    ) -> Result<Self, MapError> {
        let width = rows.first().map_or(0, |row| row.as_ref().chars().count());
        if width == 0 {
            return Err(MapError::Empty);
        }
        let side = |cells: usize| i32::try_from(cells).unwrap_or(i32::MAX);
        let frame = GridFrame::new(side(width), side(rows.len()), resolution_m, origin)?;
        let mut cells = Vec::with_capacity(frame.len());
        for (row, text) in rows.iter().enumerate() {
            for (column, character) in text.as_ref().chars().enumerate() {
                let value = occupancy(character).ok_or(MapError::UnknownCharacter {
                    row: row + 1,
                    column: column + 1,
                    character,
                })?;
                cells.push(value);
            }
            let found = cells.len() - row * width;
            if found != width {
                return Err(MapError::RaggedRow { row: row + 1, found, expected: width });
            }
        }
        Ok(Self::from_top_down(frame, &cells))
    }

    /// Parses the lines of a text with [`Self::from_rows`], with the lower left corner at the origin. Empty lines at the
    /// end are ignored.
    ///
    /// # Errors
    /// See [`Self::from_rows`].
    pub fn from_text(text: &str, resolution_m: f64) -> Result<Self, MapError> {
        let mut rows: Vec<&str> = text.lines().collect();
        while rows.last().is_some_and(|row| row.is_empty()) {
            rows.pop();
        }
        Self::from_rows(&rows, resolution_m, Pose::default())
    }
}

fn occupancy(character: char) -> Option<i8> {
    match character {
        '#' => Some(100),
        '.' | ' ' => Some(0),
        '?' => Some(UNKNOWN),
        _ => None,
    }
}
