//! Built-in scenes, which need no map file, and the builder of their mine maps.

use core::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

use crate::geometry::{Point, Pose, bearing, nearest_on_segment};
use crate::map::{Cell, GridFrame, OccupancyGrid};
use crate::navigator::Goal;
use crate::runtime::Mission;

/// A map with a start, a goal and a number of pedestrians.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Short name, one word.
    pub name: &'static str,
    /// Title, one line.
    pub title: &'static str,
    /// The map, 0.05 m per cell.
    pub map: OccupancyGrid,
    /// Start pose.
    pub start: Pose,
    /// Goal.
    pub goal: Point,
    /// Number of pedestrians.
    pub obstacles: usize,
    /// Seed of the pedestrians: a drive that meets some of them and seldom waits. Statistics need other seeds too.
    pub seed: u64,
}

impl Scene {
    /// The mission from the start to the goal with this time limit, seconds.
    #[must_use]
    pub fn mission(&self, time_limit_s: f64) -> Mission {
        let mission = Mission::new(Arc::new(self.map.clone()), self.start, Goal::at(self.goal));
        Mission { time_limit_s, ..mission }
    }
}

/// The names of all scenes.
pub const SCENE_NAMES: [&str; 4] = ["roadway", "crossing", "dead_end", "mine"];

/// Returns the scene with a name; `None` for a name that is not in [`SCENE_NAMES`].
#[must_use]
pub fn scene(name: &str) -> Option<Scene> {
    match name {
        "roadway" => Some(roadway()),
        "crossing" => Some(crossing()),
        "dead_end" => Some(dead_end()),
        "mine" => Some(mine()),
        _ => None,
    }
}

/// Returns the small scenes of the demo and the benchmarks, the main one first.
#[must_use]
pub fn scenes() -> Vec<Scene> {
    vec![roadway(), crossing(), dead_end()]
}

/// Two roadways joined by cross-cuts, with parked machines: 30 by 20 m.
#[must_use]
pub fn roadway() -> Scene {
    let mut mine = MineMapBuilder::solid(30.0, 20.0, 1);
    mine.roadway(3.8, &[[2.4, 3.6], [9.0, 3.0], [17.5, 4.3], [27.4, 3.5]]);
    mine.roadway(3.4, &[[2.4, 15.8], [10.0, 16.8], [20.0, 15.6], [27.4, 16.4]]);
    mine.roadway(2.9, &[[6.8, 3.2], [6.2, 9.5], [7.4, 16.4]]);
    mine.roadway(3.0, &[[15.2, 4.0], [16.4, 10.0], [15.6, 16.1]]);
    mine.roadway(2.7, &[[24.6, 3.8], [23.6, 9.8], [24.4, 16.1]]);
    mine.roadway(2.6, &[[6.2, 9.6], [11.0, 10.4], [16.3, 9.8]]);
    mine.roadway(2.5, &[[16.3, 9.9], [20.0, 9.3], [23.6, 9.9]]);
    mine.roadway(2.6, &[[24.2, 13.0], [27.6, 12.4]]);
    mine.machine([12.6, 2.3], 0.15, 2.4, 1.0);
    mine.machine([20.4, 5.3], PI - 0.1, 1.8, 0.9);
    mine.machine([12.2, 17.5], -0.1, 2.6, 1.0);
    mine.machine([27.6, 12.5], 0.0, 1.2, 1.2);
    mine.machine([16.9, 12.8], FRAC_PI_2 + 0.1, 1.2, 0.7);
    mine.heap([10.4, 11.2], 0.45);
    mine.heap([24.9, 6.9], 0.4);
    mine.heap([5.2, 12.6], 0.4);
    mine.heap([19.6, 14.3], 0.5);
    Scene {
        name: "roadway",
        title: "Two roadways joined by cross-cuts, with parked machines",
        map: mine.build(),
        start: Pose::new(2.4, 3.6, 0.0),
        goal: Point::new(27.0, 16.3),
        obstacles: 4,
        seed: 7,
    }
}

/// Room-and-pillar workings: nine pillars with crossings between them, 24 by 24 m.
#[must_use]
pub fn crossing() -> Scene {
    let mut mine = MineMapBuilder::solid(24.0, 24.0, 2);
    for place in [2.2, 8.7, 15.3, 21.8] {
        mine.roadway(2.9, &[[2.2, place], [21.8, place]]);
        mine.roadway(2.9, &[[place, 2.2], [place, 21.8]]);
    }
    mine.machine([12.0, 9.6], 0.05, 2.2, 0.9);
    mine.machine([14.4, 18.6], FRAC_PI_2, 2.0, 0.8);
    mine.heap([5.6, 7.6], 0.45);
    mine.heap([16.4, 12.0], 0.4);
    mine.heap([18.6, 22.8], 0.5);
    mine.props([7.6, 12.6], [7.6, 14.4], 0.9);
    Scene {
        name: "crossing",
        title: "Rooms and pillars: nine pillars in a chequer of crossings",
        map: mine.build(),
        start: Pose::new(2.2, 2.2, FRAC_PI_2 / 2.0),
        goal: Point::new(21.6, 21.6),
        obstacles: 6,
        seed: 2,
    }
}

/// A blind heading on the straight line to the goal, and two detours: 24 by 14 m.
#[must_use]
pub fn dead_end() -> Scene {
    let mut mine = MineMapBuilder::solid(24.0, 14.0, 3);
    mine.roadway(3.2, &[[2.4, 7.4], [14.2, 7.4]]);
    mine.roadway(2.6, &[[13.4, 6.6], [13.4, 7.9]]);
    mine.roadway(3.0, &[[4.6, 7.2], [5.4, 2.6], [17.0, 2.4], [18.8, 7.4]]);
    mine.roadway(2.6, &[[6.0, 8.0], [6.6, 11.6], [17.6, 11.4], [18.8, 7.6]]);
    mine.roadway(3.2, &[[18.4, 7.4], [21.6, 7.4]]);
    mine.machine([13.6, 12.2], 0.0, 1.8, 0.9);
    mine.machine([11.4, 1.6], 0.05, 2.0, 0.9);
    mine.heap([8.6, 8.6], 0.4);
    mine.heap([14.6, 3.5], 0.35);
    Scene {
        name: "dead_end",
        title: "A blind heading on the straight line to the goal, and the ways round it",
        map: mine.build(),
        start: Pose::new(2.6, 7.4, 0.0),
        goal: Point::new(21.4, 7.4),
        obstacles: 4,
        seed: 7,
    }
}

/// Three long roadways with cross-cuts, some of them blocked: 90 by 46 m.
#[must_use]
pub fn mine() -> Scene {
    let mut mine = MineMapBuilder::solid(90.0, 46.0, 4);
    mine.roadway(4.0, &[[4.0, 5.0], [24.0, 4.4], [47.0, 6.2], [70.0, 5.0], [86.0, 5.8]]);
    mine.roadway(3.6, &[[4.0, 22.0], [22.0, 23.2], [45.0, 21.6], [66.0, 23.4], [86.0, 22.4]]);
    mine.roadway(3.8, &[[4.0, 40.0], [28.0, 41.0], [52.0, 39.2], [86.0, 40.4]]);
    mine.roadway(3.0, &[[10.0, 5.0], [11.0, 14.0], [9.6, 22.0]]);
    mine.roadway(2.8, &[[27.0, 5.0], [26.0, 13.0], [28.0, 22.6]]);
    mine.roadway(3.0, &[[44.0, 6.0], [45.2, 14.0], [44.0, 22.0]]);
    mine.roadway(2.7, &[[62.0, 5.4], [61.0, 14.0], [63.0, 23.0]]);
    mine.roadway(3.0, &[[78.0, 5.4], [79.0, 14.0], [77.6, 22.4]]);
    mine.roadway(3.0, &[[20.0, 23.0], [20.6, 31.0], [19.0, 40.6]]);
    mine.roadway(2.8, &[[36.0, 22.4], [35.0, 31.0], [36.4, 40.4]]);
    mine.roadway(2.8, &[[53.0, 22.2], [54.2, 31.0], [53.0, 39.4]]);
    mine.roadway(3.0, &[[70.0, 23.0], [69.0, 31.0], [70.4, 39.8]]);
    mine.roadway(2.7, &[[10.6, 14.0], [18.0, 13.4], [26.2, 13.4]]);
    mine.roadway(2.7, &[[54.0, 31.0], [61.0, 31.8], [69.0, 31.0]]);
    mine.machine([18.0, 3.4], 0.05, 2.6, 1.0);
    mine.machine([37.0, 6.8], PI + 0.1, 2.4, 1.0);
    mine.machine([54.0, 4.6], -0.05, 2.2, 0.9);
    mine.machine([33.0, 23.4], 0.0, 2.2, 0.9);
    mine.machine([59.0, 21.8], 0.1, 2.4, 0.9);
    mine.machine([27.2, 39.6], 0.05, 2.6, 1.0);
    mine.machine([62.0, 40.8], 0.0, 2.4, 0.9);
    mine.machine([45.4, 13.0], FRAC_PI_2, 2.0, 2.6);
    mine.machine([35.2, 31.4], FRAC_PI_2, 2.2, 2.6);
    mine.heap([26.4, 10.0], 0.45);
    mine.heap([61.4, 12.0], 0.4);
    mine.heap([79.6, 16.0], 0.5);
    mine.heap([19.6, 33.0], 0.45);
    mine.heap([70.2, 34.6], 0.45);
    mine.heap([76.0, 39.0], 0.5);
    mine.props([8.0, 23.4], [14.0, 23.6], 1.5);
    mine.props([80.0, 4.6], [84.0, 4.8], 1.0);
    Scene {
        name: "mine",
        title: "Three long roadways with cross-cuts, some of them blocked",
        map: mine.build(),
        start: Pose::new(10.0, 5.0, 0.0),
        goal: Point::new(80.0, 40.0),
        obstacles: 5,
        seed: 3,
    }
}

/// Side of a cell, metres.
const RESOLUTION_M: f64 = 0.05;

/// Coarse and fine roughness of the walls: size and height of the bumps, metres.
const ROUGHNESS_M: [(f64, f64); 2] = [(1.1, 0.16), (0.3, 0.07)];

const FREE: i8 = 0;
const OCCUPIED: i8 = 100;

/// Builds a map by cutting workings out of solid rock. Coordinates are in metres from the lower-left corner.
struct MineMapBuilder {
    frame: GridFrame,
    cells: Vec<i8>,
    seed: u64,
}

impl MineMapBuilder {
    /// Starts with solid rock. The seed determines the roughness of the walls.
    fn solid(width_m: f64, height_m: f64, seed: u64) -> Self {
        let frame = GridFrame {
            width: (width_m / RESOLUTION_M).round() as i32,
            height: (height_m / RESOLUTION_M).round() as i32,
            resolution_m: RESOLUTION_M,
            origin: Pose::default(),
        };
        Self { frame, cells: vec![OCCUPIED; frame.len()], seed }
    }

    /// Cuts a roadway along a polyline, with round ends and walls that are rough by at most 0.23 m.
    fn roadway(&mut self, width_m: f64, line: &[[f64; 2]]) {
        let most_rough_m: f64 = ROUGHNESS_M.iter().map(|(_, height)| height).sum();
        for leg in line.windows(2) {
            let (from, to) = (Point::from(leg[0]), Point::from(leg[1]));
            let near_m = width_m / 2.0 + most_rough_m;
            for index in self.cells_around(&from, &to, near_m) {
                let center = self.frame.center_of(self.frame.cell_at(index));
                let reach = width_m / 2.0 + self.roughness(&center);
                if (center - nearest_on_segment(&from, &to, &center)).norm() < reach {
                    self.cells[index] = FREE;
                }
            }
        }
    }

    /// The cells of the box around a line with a margin, metres.
    fn cells_around(&self, from: &Point, to: &Point, margin_m: f64) -> Vec<usize> {
        let cells = |one: f64, other: f64, count: i32| {
            let cell = |metres: f64| (metres / RESOLUTION_M).floor() as i32;
            let (low, high) = (cell(one.min(other) - margin_m), cell(one.max(other) + margin_m));
            low.max(0)..=high.min(count - 1)
        };
        let columns = cells(from.x, to.x, self.frame.width);
        let rows = cells(from.y, to.y, self.frame.height);
        let row = |y: i32| columns.clone().map(move |x| self.frame.index(Cell::new(x, y)));
        rows.flat_map(row).collect()
    }

    /// Adds a machine: a box with a heading, radians.
    fn machine(&mut self, center: [f64; 2], heading_rad: f64, length_m: f64, width_m: f64) {
        let place = Pose::new(center[0], center[1], heading_rad);
        self.fill(&place.position(), libm::hypot(length_m, width_m), |point| {
            let own = place.inverse_transform(point);
            own.x.abs() <= length_m / 2.0 && own.y.abs() <= width_m / 2.0
        });
    }

    /// Adds a heap of broken rock.
    fn heap(&mut self, center: [f64; 2], radius_m: f64) {
        let center = Point::from(center);
        let seed = self.seed;
        self.fill(&center, 1.2 * radius_m, |point| {
            (point - center).norm() < radius_m + 0.2 * radius_m * noise(point, 0.25, seed ^ 1)
        });
    }

    /// Adds square props with sides of 0.2 m along a line, at equal distances of about `spacing_m`.
    fn props(&mut self, from: [f64; 2], to: [f64; 2], spacing_m: f64) {
        let (from, to) = (Point::from(from), Point::from(to));
        let count = ((to - from).norm() / spacing_m).round().max(1.0);
        for prop in 0..=count as usize {
            let center = from + (to - from) * (prop as f64 / count);
            self.machine([center.x, center.y], bearing(&from, &to), 0.2, 0.2);
        }
    }

    /// Returns the map.
    fn build(self) -> OccupancyGrid {
        OccupancyGrid::new(self.frame, self.cells)
    }

    /// Fills the cells whose centres are inside a shape, which lies within a distance of a point, metres.
    fn fill(&mut self, center: &Point, within_m: f64, inside: impl Fn(&Point) -> bool) {
        for index in self.cells_around(center, center, within_m) {
            if inside(&self.frame.center_of(self.frame.cell_at(index))) {
                self.cells[index] = OCCUPIED;
            }
        }
    }

    /// Offset of the wall from its nominal line, metres, outwards positive.
    fn roughness(&self, point: &Point) -> f64 {
        ROUGHNESS_M
            .iter()
            .zip(self.seed..)
            .map(|(&(size, height), seed)| height * noise(point, size, seed))
            .sum()
    }
}

/// Value noise from -1 to 1 on a lattice with a pitch in metres.
fn noise(point: &Point, size_m: f64, seed: u64) -> f64 {
    let (x, y) = (point.x / size_m, point.y / size_m);
    let (column, row) = (x.floor(), y.floor());
    let blend = |at: f64| at * at * (3.0 - 2.0 * at);
    let (right, up) = (blend(x - column), blend(y - row));
    let value = |dx: i64, dy: i64| lattice(column as i64 + dx, row as i64 + dy, seed);
    let low = value(0, 0) + (value(1, 0) - value(0, 0)) * right;
    let high = value(0, 1) + (value(1, 1) - value(0, 1)) * right;
    low + (high - low) * up
}

/// Pseudo-random value from -1 to 1 of a lattice point: coordinates and seed through the finalizer of Steele, Lea and
/// Flood's `SplitMix64` (2014).
fn lattice(column: i64, row: i64, seed: u64) -> f64 {
    let mut bits = seed;
    for part in [column, row] {
        bits = (bits ^ part as u64).wrapping_add(0x9E37_79B9_7F4A_7C15);
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        bits ^= bits >> 31;
    }
    // A double has 53 significant bits.
    (bits >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}
