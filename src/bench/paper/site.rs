//! The maps of the paper's experiments and their tasks.

use core::iter::repeat_n;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use thiserror::Error;

use crate::geometry::Pose;
use crate::map::{Cell, FreeSpace, ObstacleGrid, OccupancyGrid};
use crate::runtime::Config;

/// Side of a character, metres.
const CHARACTER_M: f64 = 0.5;
/// Cells along that side: 5 cm each, as usual for indoor maps.
const CELLS: usize = 10;

/// A map that cannot be used.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum PaperError {
    /// Too little room for paths.
    #[error(
        "the map has no {places} connected places {radius_m:.3} m from every obstacle: use a map whose roadways are wider \
         than twice that"
    )]
    TooNarrow {
        /// Number of places.
        places: usize,
        /// Distance kept from obstacles, metres.
        radius_m: f64,
    },
    /// A start and a goal without a path.
    #[error("{task}: no path from the start to the goal {radius_m:.3} m from every obstacle")]
    NoPath {
        /// The task.
        task: String,
        /// Distance kept from obstacles, metres.
        radius_m: f64,
    },
}

/// The scenes of Table 1 in the paper's order: name, title, and map as text, highest row first, one character for each half
/// metre: `#` rock or machine, `.` free, `S` start, `G` goal. The paper does not publish its maps: these have its size, with
/// start and goal about 20 m apart.
const SCENES: [[&str; 3]; 3] = [
    ["drift", "A straight drift with parked machines", include_str!("maps/drift.txt")],
    ["junction", "A bend and a junction with cross-cuts", include_str!("maps/junction.txt")],
    ["rooms", "Rooms and pillars with clutter", include_str!("maps/rooms.txt")],
];

/// A start and a goal, both cells' centres.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Task {
    /// Name in the tables.
    pub name: String,
    /// Start cell.
    pub start: Cell,
    /// Goal cell.
    pub goal: Cell,
}

/// A map with its tasks. All variants search the same free cells and validate paths against the same ones. The two
/// distances from walls are those of [`RoutePlanner`](crate::navigator::RoutePlanner).
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Site {
    /// Name.
    pub name: String,
    /// Title.
    pub title: String,
    /// The map.
    pub map: OccupancyGrid,
    /// Its obstacles.
    pub obstacles: ObstacleGrid,
    /// Free cells for searches: at the comfortable distance to every obstacle.
    pub search: FreeSpace,
    /// Free cells for smoothed paths: at the least distance.
    pub proof: FreeSpace,
    /// The tasks, at least one.
    pub tasks: Vec<Task>,
}

impl Site {
    /// The three scenes of Table 1 and figs. 9 to 11, for the robot of a configuration.
    ///
    /// # Panics
    /// Never: the text of each scene is a map with a start and a goal.
    #[must_use]
    pub fn roadways(config: &Config) -> Vec<Self> {
        let scene = |[name, title, text]: [&str; 3]| {
            let rows: Vec<String> =
                text.lines().flat_map(|row| repeat_n(enlarged(row), CELLS)).collect();
            let resolution_m = CHARACTER_M / CELLS as f64;
            let map = OccupancyGrid::from_rows(&rows, resolution_m, Pose::default());
            let map = map.expect("rows of equal length");
            let end = |mark| marked(text, mark).expect("one start and one goal");
            let task = Task { name: name.to_owned(), start: end('S'), goal: end('G') };
            Self { tasks: vec![task], ..Self::without_tasks(name, title, map, config) }
        };
        SCENES.map(scene).into()
    }

    /// A mine with this number of tasks, for Table 2 and fig. 16. Their ends are spread over all reachable cells. The seed
    /// determines the first end; each further one is the cell farthest from all previous ones. The first end is paired with
    /// the first of the second half, and so on.
    ///
    /// # Errors
    /// Fails when the map has no room for them.
    pub fn mine(
        title: &str,
        map: OccupancyGrid,
        tasks: usize,
        seed: u64,
        config: &Config,
    ) -> Result<Self, PaperError> {
        let mut site = Self::without_tasks("mine", title, map, config);
        let places = 2 * tasks;
        let ends = farthest_points(&site.search, places, seed)
            .ok_or(PaperError::TooNarrow { places, radius_m: site.search.radius_m() })?;
        let (starts, goals) = ends.split_at(tasks);
        site.tasks = starts
            .iter()
            .zip(goals)
            .enumerate()
            .map(|(index, (&start, &goal))| Task {
                name: format!("Path {}", index + 1),
                start,
                goal,
            })
            .collect();
        Ok(site)
    }

    fn without_tasks(name: &str, title: &str, map: OccupancyGrid, config: &Config) -> Self {
        let obstacles = map.obstacles(config.unknown);
        let planner = config.route_planner(map.frame().resolution_m);
        let least_m = planner.least_radius_m();
        let radii_m = [least_m, least_m + config.navigator.comfort_margin_m];
        let [proof, search] = FreeSpace::for_radii(&obstacles, radii_m);
        Self {
            name: name.to_owned(),
            title: title.to_owned(),
            map,
            obstacles,
            search,
            proof,
            tasks: Vec::new(),
        }
    }
}

/// Returns a row with each character as wide as its cells, without the marks.
fn enlarged(row: &str) -> String {
    let ground = row.replace(['S', 'G'], ".");
    ground.chars().flat_map(|character| repeat_n(character, CELLS)).collect()
}

/// The middle cell of a marked character.
fn marked(text: &str, mark: char) -> Option<Cell> {
    let mut lowest_first = text.lines().rev().enumerate();
    let (row, column) = lowest_first.find_map(|(row, line)| Some((row, line.find(mark)?)))?;
    let middle = |character: usize| (character * CELLS + CELLS / 2) as i32;
    Some(Cell::new(middle(column), middle(row)))
}

/// Returns cells of the largest connected part of a space, each as far as possible from those before it; the seed determines
/// the first. None if there are too few.
fn farthest_points(space: &FreeSpace, count: usize, seed: u64) -> Option<Vec<Cell>> {
    let part = largest_part(space);
    if part.is_empty() || part.len() < count {
        return None;
    }
    let squared = |one: Cell, other: Cell| {
        let (columns, rows) = (one.column - other.column, one.row - other.row);
        i64::from(columns).pow(2) + i64::from(rows).pow(2)
    };
    let first = Pcg64Mcg::seed_from_u64(seed).random_range(0..part.len());
    let mut chosen = vec![part[first]];
    let mut nearest = vec![i64::MAX; part.len()];
    while let (Some(&last), true) = (chosen.last(), chosen.len() < count) {
        let mut farthest = (0, 0);
        for (index, (&cell, nearest)) in part.iter().zip(&mut nearest).enumerate() {
            *nearest = (*nearest).min(squared(cell, last));
            if *nearest > farthest.0 {
                farthest = (*nearest, index);
            }
        }
        chosen.push(part[farthest.1]);
    }
    Some(chosen)
}

/// The largest connected set of free cells.
fn largest_part(space: &FreeSpace) -> Vec<Cell> {
    let frame = space.frame();
    let mut seen = vec![false; frame.len()];
    let mut largest = Vec::new();
    for first in frame.cells() {
        if !seen[frame.index(first)] && space.is_free(first) {
            let part: Vec<Cell> = space.flood(first, &mut seen).map(|(cell, _)| cell).collect();
            if part.len() > largest.len() {
                largest = part;
            }
        }
    }
    largest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::UnknownPolicy;

    fn space(rows: &[&str]) -> FreeSpace {
        let map = OccupancyGrid::from_rows(rows, 1.0, Pose::default()).expect("a sound drawing");
        FreeSpace::new(&map.obstacles(UnknownPolicy::Blocked), 0.0)
    }

    #[test]
    fn farthest_points_are_in_the_largest_connected_part() {
        // Two parts that touch only at a corner, which no path may cut.
        let parts = space(&["..#...", "..#...", "##...."]);
        assert_eq!(largest_part(&parts).len(), 10);
        let places = farthest_points(&parts, 4, 1).expect("room for four");
        assert!(places.iter().all(|cell| cell.column > 1));
        assert_eq!(farthest_points(&parts, 4, 1), Some(places));
        assert_eq!(farthest_points(&parts, 99, 1), None);
        assert_eq!(farthest_points(&space(&["##"]), 1, 1), None);
    }

    #[test]
    fn farthest_points_are_far_from_each_other() {
        let places =
            farthest_points(&space(&["...................."]), 4, 7).expect("room for four");
        // For any first cell, both ends are among the next ones, and the fourth halves the longest gap.
        let columns: Vec<i32> = places.iter().map(|cell| cell.column).collect();
        assert!(columns[1..].contains(&0) && columns[1..].contains(&19), "{columns:?}");
    }

    #[test]
    fn marks_are_found_in_the_text_map() {
        let text = "..G\nS.#\n";
        assert_eq!(marked(text, 'S'), Some(Cell::new(5, 5)));
        assert_eq!(marked(text, 'G'), Some(Cell::new(25, 15)));
        assert_eq!(marked(text, 'x'), None);
        assert_eq!(enlarged("S#"), "..........##########");
    }
}
