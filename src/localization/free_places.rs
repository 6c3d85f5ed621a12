//! Where a robot can stand, by blocks of places.

/// The places of a grid where a robot can stand.
#[derive(Clone, Debug)]
pub(super) struct FreePlaces(Vec<Quarters>);

/// Which quarters of blocks have a free place.
#[derive(Clone, Debug)]
struct Quarters {
    /// Blocks from left to right.
    columns: usize,
    /// A bit for each quarter: the lower left one, the one above it, and those on their right.
    masks: Vec<u8>,
}

impl FreePlaces {
    /// Creates the blocks from the free places in rows, the lowest row first. On the last level a quarter of a block has
    /// 2^(levels - 1) places on each side.
    pub fn new(columns: usize, free: &[bool], levels: usize) -> Self {
        let rows = free.len() / columns;
        let mut quarters = vec![Quarters::of(columns, rows, |place| free[place])];
        for level in 1..levels {
            let below = &quarters[level - 1];
            let rows = below.masks.len() / below.columns;
            quarters.push(Quarters::of(below.columns, rows, |block| below.masks[block] != 0));
        }
        Self(quarters)
    }

    /// Whether each of four blocks of a level has a free place: the one that begins at `right` and `up`, multiples of 2^(level + 1)
    /// within the grid, the one above it, and those on their right.
    pub fn of_four(&self, level: usize, right: i32, up: i32) -> [bool; 4] {
        let Quarters { columns, masks } = &self.0[level];
        let (column, row) = (right as usize >> (level + 1), up as usize >> (level + 1));
        let mask = masks[row * columns + column];
        [1, 2, 4, 8].map(|quarter| mask & quarter != 0)
    }
}

impl Quarters {
    /// Creates the blocks of a level from the free quarters in rows.
    fn of(columns: usize, rows: usize, is_free: impl Fn(usize) -> bool) -> Self {
        let half = columns.div_ceil(2);
        let mut masks = vec![0; half * rows.div_ceil(2)];
        for row in 0..rows {
            for column in 0..columns {
                let bit = u8::from(is_free(row * columns + column));
                masks[row / 2 * half + column / 2] |= bit << (2 * (column % 2) + row % 2);
            }
        }
        Self { columns: half, masks }
    }
}
