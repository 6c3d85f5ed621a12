//! Maps of the kinds that the benchmark has, as rows of text from the top: `.` is free, `@` is an obstacle.

use rand::RngExt;
use rand::seq::SliceRandom;
use rand_pcg::Pcg64Mcg;

/// A map: rows from the top, characters from the left.
pub type Rows = Vec<Vec<u8>>;

/// Blocks each cell independently with this probability.
pub fn clutter(random: &mut Pcg64Mcg, width: usize, height: usize, share: f64) -> Rows {
    let mut row = || -> Vec<u8> {
        let mut cell = || {
            if random.random_bool(share) { b'@' } else { b'.' }
        };
        (0..width).map(|_| cell()).collect()
    };
    (0..height).map(|_| row()).collect()
}

/// Square rooms behind walls of one cell, each wall with one or two doors.
pub fn rooms(random: &mut Pcg64Mcg, across: usize, down: usize, side: usize) -> Rows {
    let pitch = side + 1;
    let mut rows = vec![vec![b'.'; across * pitch + 1]; down * pitch + 1];
    for (y, row) in rows.iter_mut().enumerate() {
        for (x, cell) in row.iter_mut().enumerate() {
            if x % pitch == 0 || y % pitch == 0 {
                *cell = b'@';
            }
        }
    }
    for y in 0..down {
        for x in 0..across {
            for _ in 0..random.random_range(1..=2) {
                let (east, south) = (random.random_range(1..=side), random.random_range(1..=side));
                if x + 1 < across {
                    rows[y * pitch + east][(x + 1) * pitch] = b'.';
                }
                if y + 1 < down {
                    rows[(y + 1) * pitch][x * pitch + south] = b'.';
                }
            }
        }
    }
    rows
}

/// A maze without loops, its corridors two cells wide.
pub fn maze(random: &mut Pcg64Mcg, across: usize, down: usize) -> Rows {
    let mut rows = vec![vec![b'@'; across * 3 + 1]; down * 3 + 1];
    let mut open = |x: usize, y: usize| {
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            rows[y + dy][x + dx] = b'.';
        }
    };
    let mut seen = vec![false; across * down];
    let mut trail = vec![(0_usize, 0_usize)];
    seen[0] = true;
    open(1, 1);
    while let Some(&(x, y)) = trail.last() {
        let mut ways = [(1, 0), (-1, 0), (0, 1), (0, -1_isize)];
        ways.shuffle(random);
        let next = ways.into_iter().find_map(|(dx, dy)| {
            let (to_x, to_y) = (x.checked_add_signed(dx)?, y.checked_add_signed(dy)?);
            let is_new = to_x < across && to_y < down && !seen[to_y * across + to_x];
            is_new.then_some((to_x, to_y))
        });
        let Some((to_x, to_y)) = next else {
            trail.pop();
            continue;
        };
        seen[to_y * across + to_x] = true;
        // The room, and the wall between the two rooms.
        open(to_x * 3 + 1, to_y * 3 + 1);
        open((x + to_x) * 3 / 2 + 1, (y + to_y) * 3 / 2 + 1);
        trail.push((to_x, to_y));
    }
    rows
}

/// Returns caves: random clutter, smoothed.
pub fn caves(random: &mut Pcg64Mcg, width: usize, height: usize) -> Rows {
    let mut rows = clutter(random, width, height, 0.42);
    for _ in 0..4 {
        let rock_about = |x: usize, y: usize| {
            let mut rock = 0;
            for near_y in y.wrapping_sub(1)..y + 2 {
                for near_x in x.wrapping_sub(1)..x + 2 {
                    let cell = rows.get(near_y).and_then(|row| row.get(near_x));
                    rock += u32::from(cell != Some(&b'.'));
                }
            }
            rock
        };
        let worn = |y: usize| {
            let cell = |x: usize| if rock_about(x, y) >= 5 { b'@' } else { b'.' };
            (0..width).map(cell).collect()
        };
        rows = (0..height).map(worn).collect();
    }
    rows
}

/// Returns the same map with all letters that the format allows.
pub fn in_many_letters(random: &mut Pcg64Mcg, rows: &Rows) -> Rows {
    let mut letter = |&cell: &u8| match cell {
        b'.' => b"...GS"[random.random_range(0..5)],
        _ => b"@@OTW"[random.random_range(0..5)],
    };
    let mut lettered = Rows::new();
    for row in rows {
        lettered.push(row.iter().map(&mut letter).collect());
    }
    lettered
}
