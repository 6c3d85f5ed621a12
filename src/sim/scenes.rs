//! Built-in scenes, which need no map file.

use core::f64::consts::{FRAC_PI_2, PI};

use super::mine_map::MineMapBuilder;
use crate::geometry::{Point, Pose};
use crate::map::OccupancyGrid;

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
    /// Seed of the pedestrians.
    pub seed: u64,
}

/// Returns all scenes, the main one first.
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
        obstacles: 6,
        seed: 1,
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
        obstacles: 3,
        seed: 3,
    }
}
