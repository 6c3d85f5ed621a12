//! Rooms as the rows of a map in text.

use std::ops::Range;

/// Rows of a room with walls of one cell, highest first, and obstacles in these columns and rows. `#` is occupied, `.` is free.
pub fn rows(
    columns: usize,
    rows: usize,
    obstacles: &[(Range<usize>, Range<usize>)],
) -> Vec<String> {
    let mut room = vec![format!("#{}#", ".".repeat(columns - 2)); rows];
    for row in [0, rows - 1] {
        room[row] = "#".repeat(columns);
    }
    for (across, down) in obstacles {
        for row in &mut room[down.clone()] {
            row.replace_range(across.clone(), &"#".repeat(across.len()));
        }
    }
    room
}
