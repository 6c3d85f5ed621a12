//! The ground of an experiment, and the ways that are looked for on it.

use super::PaperError;
use super::drawings::{DRAWINGS, Drawing};
use super::spread::spread;
use crate::geometry::Pose;
use crate::map::{Cell, FreeSpace, ObstacleGrid, OccupancyGrid};
use crate::runtime::Config;

/// Side of a drawing's character, metres.
const CHARACTER_M: f64 = 0.5;
/// Cells along that side: 5 cm each, as maps of indoor robots mostly have them.
const CELLS: usize = 10;

/// A start and a goal, both cells' centres.
#[derive(Clone, Debug, PartialEq)]
pub struct Task {
    /// What it is called in the tables.
    pub name: String,
    /// Where the path begins.
    pub start: Cell,
    /// Where it ends.
    pub goal: Cell,
}

/// A map with the ways to be found on it. Every variant searches the same free cells and proves against the same ones, at
/// the two distances from walls that [`RoutePlanner`](crate::navigator::RoutePlanner) keeps.
#[derive(Clone, Debug)]
pub struct Site {
    /// One word.
    pub name: String,
    /// One line.
    pub title: String,
    /// The ground.
    pub map: OccupancyGrid,
    /// What blocks on it.
    pub obstacles: ObstacleGrid,
    /// Where searching may go: at the comfortable distance from every obstacle.
    pub search: FreeSpace,
    /// Where a smoothed path is proved to stay: at the least distance.
    pub proof: FreeSpace,
    /// The ways, at least one.
    pub tasks: Vec<Task>,
}

impl Site {
    /// The three scenes of Table 1 and figs. 9 to 11, for the robot of a configuration.
    ///
    /// # Errors
    /// When that robot does not fit into one of them.
    pub fn roadways(config: &Config) -> Result<Vec<Self>, PaperError> {
        DRAWINGS
            .iter()
            .map(|drawing| Self::drawn(drawing, config))
            .collect()
    }

    /// A mine with so many ways on it, for Table 2 and fig. 16. Their ends are spread over all ground that can be reached:
    /// the first is drawn by the seed, each further one is the place farthest from all before; then the first is joined
    /// with the first of the second half, and so on.
    ///
    /// # Errors
    /// When the map has no room for them.
    pub fn mine(
        title: &str,
        map: OccupancyGrid,
        ways: usize,
        seed: u64,
        config: &Config,
    ) -> Result<Self, PaperError> {
        let mut site = Self::without_tasks("mine", title, map, config);
        let places = 2 * ways;
        let ends = spread(&site.search, places, seed).ok_or(PaperError::TooNarrow {
            places,
            radius_m: site.search.radius_m(),
        })?;
        let (starts, goals) = ends.split_at(ways);
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

    fn drawn(drawing: &Drawing, config: &Config) -> Result<Self, PaperError> {
        let rows: Vec<String> = drawing
            .rows
            .iter()
            .flat_map(|row| core::iter::repeat_n(enlarged(row), CELLS))
            .collect();
        let resolution_m = CHARACTER_M / CELLS as f64;
        let map =
            OccupancyGrid::from_rows(&rows, resolution_m, Pose::default()).map_err(|error| {
                PaperError::Drawing {
                    scene: drawing.name.to_owned(),
                    error,
                }
            })?;
        let mut site = Self::without_tasks(drawing.name, drawing.title, map, config);
        let end = |mark| {
            middle_of(drawing, mark).ok_or(PaperError::NoMark {
                scene: drawing.name.to_owned(),
                mark,
            })
        };
        site.tasks.push(Task {
            name: drawing.name.to_owned(),
            start: end('S')?,
            goal: end('G')?,
        });
        Ok(site)
    }
}

/// A row of a drawing with each character as wide as its cells, without the marks.
fn enlarged(row: &str) -> String {
    let ground = row.replace(['S', 'G'], ".");
    let wide = |character| core::iter::repeat_n(character, CELLS);
    ground.chars().flat_map(wide).collect()
}

/// The middle cell of a marked character.
fn middle_of(drawing: &Drawing, mark: char) -> Option<Cell> {
    let mut lowest_first = drawing.rows.iter().rev().enumerate();
    let (row, column) =
        lowest_first.find_map(|(row, text)| text.find(mark).map(|column| (row, column)))?;
    let middle = |character: usize| (character * CELLS + CELLS / 2) as i32;
    Some(Cell::new(middle(column), middle(row)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scenes_have_the_size_of_the_papers() {
        let sites = Site::roadways(&Config::default()).expect("the default robot fits");
        for site in &sites {
            let [task] = &site.tasks[..] else {
                panic!("one task each");
            };
            let frame = site.map.frame();
            let apart_m = (frame.center_of(task.goal) - frame.center_of(task.start)).norm();
            assert!(
                (19.0..26.0).contains(&apart_m),
                "{}: {apart_m} m",
                site.name
            );
            assert!(site.search.is_free(task.start) && site.search.is_free(task.goal));
        }
        assert_eq!(sites.len(), 3);
    }

    #[test]
    fn marks_are_where_they_are_drawn() {
        let drawing = Drawing {
            name: "",
            title: "",
            rows: &["..G", "S.#"],
        };
        assert_eq!(middle_of(&drawing, 'S'), Some(Cell::new(5, 5)));
        assert_eq!(middle_of(&drawing, 'G'), Some(Cell::new(25, 15)));
        assert_eq!(middle_of(&drawing, 'x'), None);
        assert_eq!(enlarged("S#"), "..........##########");
    }
}
