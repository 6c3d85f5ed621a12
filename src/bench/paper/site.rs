//! The maps of the paper's experiments and their tasks.

use super::PaperError;
use super::ascii_maps::{ASCII_MAPS, AsciiMap};
use super::farthest_point_sampling::farthest_points;
use crate::geometry::Pose;
use crate::map::{Cell, FreeSpace, ObstacleGrid, OccupancyGrid};
use crate::runtime::Config;

/// Side of a character, metres.
const CHARACTER_M: f64 = 0.5;
/// Cells along that side: 5 cm each, as usual for indoor maps.
const CELLS: usize = 10;

/// A start and a goal, both cells' centres.
#[derive(Clone, Debug, PartialEq)]
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
    /// # Errors
    /// Fails when that robot does not fit into one of them.
    pub fn roadways(config: &Config) -> Result<Vec<Self>, PaperError> {
        ASCII_MAPS.iter().map(|map| Self::from_ascii(map, config)).collect()
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

    fn from_ascii(drawing: &AsciiMap, config: &Config) -> Result<Self, PaperError> {
        let rows: Vec<String> = drawing
            .rows
            .iter()
            .flat_map(|row| core::iter::repeat_n(enlarged(row), CELLS))
            .collect();
        let resolution_m = CHARACTER_M / CELLS as f64;
        let map = OccupancyGrid::from_rows(&rows, resolution_m, Pose::default())
            .map_err(|error| PaperError::AsciiMap { scene: drawing.name.to_owned(), error })?;
        let mut site = Self::without_tasks(drawing.name, drawing.title, map, config);
        let end = |mark| {
            middle_of(drawing, mark)
                .ok_or(PaperError::NoMark { scene: drawing.name.to_owned(), mark })
        };
        site.tasks.push(Task { name: drawing.name.to_owned(), start: end('S')?, goal: end('G')? });
        Ok(site)
    }
}

/// Returns a row with each character as wide as its cells, without the marks.
fn enlarged(row: &str) -> String {
    let ground = row.replace(['S', 'G'], ".");
    let wide = |character| core::iter::repeat_n(character, CELLS);
    ground.chars().flat_map(wide).collect()
}

/// The middle cell of a marked character.
fn middle_of(drawing: &AsciiMap, mark: char) -> Option<Cell> {
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
    fn roadways_have_the_size_of_the_papers_scenes() {
        let sites = Site::roadways(&Config::default()).expect("the default robot fits");
        for site in &sites {
            let [task] = &site.tasks[..] else {
                panic!("one task each");
            };
            let frame = site.map.frame();
            let apart_m = (frame.center_of(task.goal) - frame.center_of(task.start)).norm();
            assert!((19.0..26.0).contains(&apart_m), "{}: {apart_m} m", site.name);
            assert!(site.search.is_free(task.start) && site.search.is_free(task.goal));
        }
        assert_eq!(sites.len(), 3);
    }

    #[test]
    fn marks_are_found_in_the_text_map() {
        let drawing = AsciiMap { name: "", title: "", rows: &["..G", "S.#"] };
        assert_eq!(middle_of(&drawing, 'S'), Some(Cell::new(5, 5)));
        assert_eq!(middle_of(&drawing, 'G'), Some(Cell::new(25, 15)));
        assert_eq!(middle_of(&drawing, 'x'), None);
        assert_eq!(enlarged("S#"), "..........##########");
    }
}
