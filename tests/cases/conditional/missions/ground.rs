//! Small mines: halls cut out of rock.

use std::sync::Arc;

use inbye::geometry::Pose;
use inbye::map::{ObstacleGrid, OccupancyGrid, UnknownPolicy};

/// Side of a cell, metres.
const RESOLUTION_M: f64 = 0.1;

/// A world under construction. Rectangles are `[x0, y0, x1, y1]`, metres.
#[derive(Clone)]
pub struct Ground {
    /// From the largest y downwards, as in a map file.
    rows: Vec<Vec<char>>,
}

impl Ground {
    /// Solid rock of this size, metres.
    pub fn rock(width_m: f64, height_m: f64) -> Self {
        let cells = |metres: f64| (metres / RESOLUTION_M).round() as usize;
        Self { rows: vec![vec!['#'; cells(width_m)]; cells(height_m)] }
    }

    /// Cuts a hall.
    pub fn room(self, place: [f64; 4]) -> Self {
        self.fill(place, '.')
    }

    /// Adds a wall.
    pub fn wall(self, place: [f64; 4]) -> Self {
        self.fill(place, '#')
    }

    fn fill(mut self, place: [f64; 4], with: char) -> Self {
        let [left, bottom, right, top] =
            place.map(|metres| (metres / RESOLUTION_M).round() as usize);
        let height = self.rows.len();
        for row in &mut self.rows[height - top..height - bottom] {
            row[left..right].fill(with);
        }
        self
    }

    pub fn map(&self) -> Arc<OccupancyGrid> {
        let rows: Vec<String> = self.rows.iter().map(|row| row.iter().collect()).collect();
        let map = OccupancyGrid::from_rows(&rows, RESOLUTION_M, Pose::default());
        Arc::new(map.expect("rows of equal length"))
    }

    pub fn obstacles(&self) -> ObstacleGrid {
        self.map().obstacles(UnknownPolicy::Blocked)
    }
}

/// A hall of this size inside rock half a metre thick; its lower left corner is at (0.5, 0.5).
pub fn hall(width_m: f64, height_m: f64) -> Ground {
    Ground::rock(width_m + 1.0, height_m + 1.0).room([0.5, 0.5, width_m + 0.5, height_m + 0.5])
}
