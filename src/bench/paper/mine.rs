//! A generated coal mine: mains across it, panels on both sides, rough walls, stoppings and fallen rock. It has the size of
//! the real mine of the first measurements.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::geometry::{Point, Pose};
use crate::map::{Cell, GridFrame, OccupancyGrid};

/// Size of the section, metres, and side of a cell.
const SIZE_M: [f64; 2] = [250.0, 150.0];
const RESOLUTION_M: f64 = 0.125;

/// Width of every roadway, metres; largest heights of wall bumps and their lengths, metres.
const WIDTH_M: f64 = 5.4;
const BUMPS_M: [(f64, f64); 2] = [(0.45, 5.0), (0.2, 1.2)];

/// y of the mains, metres from the lower side, and their ends along x.
const MAINS_Y: [f64; 4] = [54.0, 68.0, 82.0, 96.0];
const MAINS_X: [f64; 2] = [6.0, 244.0];
/// Distance between cross-cuts, metres.
const CROSS_CUTS: f64 = 17.0;
/// Panels: their first roadway, metres from the left. Each has four roadways, and four rows of cross-cuts to the face.
const PANELS_X: [f64; 3] = [16.0, 98.0, 176.0];
const PANEL_SPACING: f64 = 16.0;
const FACES_Y: [f64; 2] = [6.0, 144.0];

/// Share of open cross-cuts; a stopping closes the others.
const OPEN: f64 = 0.78;
/// Heaps of fallen rock, and their radii, metres.
const HEAPS: usize = 160;
const HEAP_M: [f64; 2] = [0.4, 1.3];

/// The mine of a seed: 250 by 150 m at 0.125 m a cell.
#[must_use]
pub fn made_mine(seed: u64) -> OccupancyGrid {
    let mut workings = Workings::solid(seed);
    let [left, right] = MAINS_X;
    for y in MAINS_Y {
        workings.roadway([left, y], [right, y]);
    }
    let mut x = left + 4.0;
    while x < right {
        for pair in MAINS_Y.windows(2) {
            let jitter = workings.draw([-1.5, 1.5]);
            workings.cross_cut([x + jitter, pair[0]], [x + jitter, pair[1]]);
        }
        x += CROSS_CUTS;
    }
    for first in PANELS_X {
        for (main, face) in [(MAINS_Y[0], FACES_Y[0]), (MAINS_Y[3], FACES_Y[1])] {
            workings.panel(first, main, face);
        }
    }
    workings.fallen_rock();
    workings.map
}

/// Solid rock with the roadways cut so far.
struct Workings {
    map: OccupancyGrid,
    rng: Pcg64Mcg,
    /// Middle lines: ends, metres.
    cut: Vec<[[f64; 2]; 2]>,
}

impl Workings {
    fn solid(seed: u64) -> Self {
        let side = |metres: f64| (metres / RESOLUTION_M).round() as i32;
        let frame = GridFrame {
            width: side(SIZE_M[0]),
            height: side(SIZE_M[1]),
            resolution_m: RESOLUTION_M,
            origin: Pose::default(),
        };
        Self {
            map: OccupancyGrid::filled(frame, 100),
            rng: Pcg64Mcg::seed_from_u64(seed),
            cut: Vec::new(),
        }
    }

    fn draw(&mut self, [low, high]: [f64; 2]) -> f64 {
        self.rng.random_range(low..high)
    }

    /// Four roadways from a main to a face, with cross-cuts between them; the last ones, along the face, are all open.
    fn panel(&mut self, first_x: f64, main_y: f64, face_y: f64) {
        let rooms = [0.0, 1.0, 2.0, 3.0].map(|room| first_x + room * PANEL_SPACING);
        for x in rooms {
            self.roadway([x, main_y], [x, face_y]);
        }
        for row in 1..=4 {
            let y = main_y + (face_y - main_y) * f64::from(row) / 4.0;
            for pair in rooms.windows(2) {
                if row == 4 {
                    self.roadway([pair[0], y], [pair[1], y]);
                } else {
                    let jitter = self.draw([-1.5, 1.5]);
                    self.cross_cut([pair[0], y + jitter], [pair[1], y + jitter]);
                }
            }
        }
    }

    /// A roadway that may be closed.
    fn cross_cut(&mut self, from: [f64; 2], to: [f64; 2]) {
        if self.rng.random_bool(OPEN) {
            self.roadway(from, to);
        }
    }

    /// Cuts a roadway along an axis. It ends half its width beyond the points, which opens the corners.
    fn roadway(&mut self, from: [f64; 2], to: [f64; 2]) {
        let along = usize::from(from[0] == to[0]);
        let (start, end) = (from[along].min(to[along]), from[along].max(to[along]));
        let (start, end) = (start - WIDTH_M / 2.0, end + WIDTH_M / 2.0);
        let middle = from[1 - along];
        let walls = [self.wall(start, end), self.wall(start, end)];
        let widest = WIDTH_M / 2.0 + BUMPS_M.iter().map(|(height, _)| height).sum::<f64>();
        let cells = |low: f64, high: f64| {
            (low / RESOLUTION_M).floor() as i32..(high / RESOLUTION_M).ceil() as i32
        };
        for step in cells(start, end) {
            let at = (f64::from(step) + 0.5) * RESOLUTION_M;
            for offset in cells(middle - widest, middle + widest) {
                let aside = (f64::from(offset) + 0.5) * RESOLUTION_M - middle;
                let wall = &walls[usize::from(aside > 0.0)];
                if aside.abs() < WIDTH_M / 2.0 + wall.height_at(at) {
                    let [column, row] = if along == 0 { [step, offset] } else { [offset, step] };
                    self.map.set(Cell::new(column, row), 0);
                }
            }
        }
        self.cut.push([from, to]);
    }

    /// Random bumps of one wall.
    fn wall(&mut self, start: f64, end: f64) -> Wall {
        let bumps = BUMPS_M.map(|(height, length)| {
            let count = ((end - start) / length).ceil() as usize + 2;
            (0..count).map(|_| self.draw([-height, height])).collect()
        });
        Wall { start, bumps }
    }

    /// Adds fallen rock along the walls.
    fn fallen_rock(&mut self) {
        for _ in 0..HEAPS {
            let [from, to] = self.cut[self.rng.random_range(0..self.cut.len())];
            let share = self.draw([0.1, 0.9]);
            let aside = self.draw([0.3, 0.55]) * WIDTH_M;
            let aside = if self.rng.random_bool(0.5) { aside } else { -aside };
            let along_x = from[1] == to[1];
            let center = Point::new(
                from[0] + (to[0] - from[0]) * share + if along_x { 0.0 } else { aside },
                from[1] + (to[1] - from[1]) * share + if along_x { aside } else { 0.0 },
            );
            let radius_m = self.draw(HEAP_M);
            let reach = (radius_m / RESOLUTION_M).ceil() as i32;
            let Some(middle) = self.map.frame().cell_of(&center) else {
                continue;
            };
            for row in middle.row - reach..=middle.row + reach {
                for column in middle.column - reach..=middle.column + reach {
                    let cell = Cell::new(column, row);
                    if (self.map.frame().center_of(cell) - center).norm() < radius_m {
                        self.map.set(cell, 100);
                    }
                }
            }
        }
    }
}

/// Offsets of a wall from its straight line.
struct Wall {
    start: f64,
    /// Heights at equal distances, for each length of bump.
    bumps: [Vec<f64>; 2],
}

impl Wall {
    fn height_at(&self, at: f64) -> f64 {
        let blended = |(bumps, (_, length)): (&Vec<f64>, (f64, f64))| {
            let place = (at - self.start).max(0.0) / length;
            let (index, share) = (place as usize, place.fract());
            let height = |index: usize| bumps[index.min(bumps.len() - 1)];
            height(index) + (height(index + 1) - height(index)) * share
        };
        self.bumps.iter().zip(BUMPS_M).map(blended).sum()
    }
}
