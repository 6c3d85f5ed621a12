//! Obstacles grown by a distance, exactly: which cells are nearer than that to one of them.

use super::bit_grid::{BitGrid, clear_padding};

/// The cells whose square is nearer than a distance, in cells, to the square of a cell that is set; a set cell is as near
/// as can be. At a distance of zero or less there is none, and at one that is not a number all are.
///
/// Row by row: what is within reach in a row `dy` further is the row itself, spread sideways by as much as the distance
/// leaves at that `dy`. The spread grows from the furthest row to the nearest, so each row is spread once, in passing.
pub(super) fn nearer_than(cells: &BitGrid, width: i32, height: i32, distance: f64) -> BitGrid {
    if distance.is_nan() {
        let nothing = BitGrid::new(width, height);
        return nothing.neither(&nothing);
    }
    let spreads = spreads(distance, width.max(height));
    let mut near = BitGrid::new(width, height);
    let mut spread = Spread::default();
    for row in 0..height {
        if cells.row(row).iter().all(|&word| word == 0) {
            continue;
        }
        spread.begin(cells.row(row));
        for (away, &sideways) in spreads.iter().enumerate().rev() {
            spread.grow_to(sideways);
            let away = away as i32;
            for reached in [row - away, row + away] {
                if (0..height).contains(&reached) {
                    let target = near.row_mut(reached).iter_mut();
                    target.zip(&spread.words).for_each(|(to, from)| *to |= from);
                }
            }
        }
    }
    for row in 0..height {
        clear_padding(near.row_mut(row), width);
    }
    near
}

/// For each number of rows away, how many columns away a cell may be and still be nearer than the distance; at most
/// `most` of either. Between two squares there is one cell less than between their centres.
fn spreads(distance: f64, most: i32) -> Vec<usize> {
    let between = |away: i32| f64::from((away - 1).max(0));
    let squared = |dx: i32, dy: i32| between(dx).powi(2) + between(dy).powi(2);
    let mut spreads = Vec::new();
    let mut sideways = most;
    for away in 0..=most {
        while sideways >= 0 && squared(sideways, away) >= distance.abs() * distance {
            sideways -= 1;
        }
        if sideways < 0 {
            break;
        }
        spreads.push(sideways as usize);
    }
    spreads
}

/// A row of bits that spreads to both sides.
#[derive(Default)]
struct Spread {
    words: Vec<u64>,
    spare: Vec<u64>,
    reach: usize,
}

impl Spread {
    fn begin(&mut self, row: &[u64]) {
        self.words.clear();
        self.words.extend_from_slice(row);
        self.spare.resize(row.len(), 0);
        self.reach = 0;
    }

    /// Sets what is within `reach` of a bit of the row that it began with.
    fn grow_to(&mut self, reach: usize) {
        while self.reach < reach {
            // A stretch of bits moved by no more than its own length leaves no gap to where it was.
            let step = (2 * self.reach + 1).min(reach - self.reach).min(63);
            self.shift_both_ways(step as u32);
            self.reach += step;
        }
    }

    /// By 1 to 63 bits.
    fn shift_both_ways(&mut self, step: u32) {
        let back = u64::BITS - step;
        let last = self.words.len() - 1;
        for (index, to) in self.spare.iter_mut().enumerate() {
            let here = self.words[index];
            let before = if index > 0 { self.words[index - 1] } else { 0 };
            let behind = if index < last {
                self.words[index + 1]
            } else {
                0
            };
            *to = here | here << step | before >> back | here >> step | behind << back;
        }
        core::mem::swap(&mut self.words, &mut self.spare);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::Cell;

    #[test]
    fn each_cell_is_as_near_as_its_distance_says() {
        for (width, height) in [(40, 30), (129, 5), (3, 90), (64, 9)] {
            let chosen = [3, 77, width * height / 2, width * height - 1];
            let cells: Vec<bool> = (0..width * height)
                .map(|index| chosen.contains(&index))
                .collect();
            let cells = BitGrid::from_cells(width, height, &cells);
            for distance in [
                -1.0,
                0.0,
                0.3,
                1.0,
                1.5,
                2.0,
                3.7,
                5.0,
                31.0,
                1e3,
                f64::INFINITY,
            ] {
                let near = nearer_than(&cells, width, height, distance);
                for index in 0..width * height {
                    let cell = Cell::new(index % width, index / width);
                    let gap = |other: i32| {
                        let apart =
                            |one: i32, other: i32| f64::from(((one - other).abs() - 1).max(0));
                        libm::hypot(
                            apart(cell.column, other % width),
                            apart(cell.row, other / width),
                        )
                    };
                    let expected = chosen.iter().any(|&other| gap(other) < distance);
                    assert_eq!(near.get(cell), expected, "{cell:?} at {distance}");
                }
            }
        }
    }

    #[test]
    fn a_distance_that_is_no_number_reaches_everything() {
        let none = BitGrid::new(70, 3);
        assert_eq!(nearer_than(&none, 70, 3, f64::NAN).count(), 210);
        assert_eq!(nearer_than(&none, 70, 3, 1e9).count(), 0);
    }
}
