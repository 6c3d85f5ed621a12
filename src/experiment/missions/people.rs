//! Who walks where the robot drives.

use core::ops::RangeInclusive;

use rand::RngExt;
use rand_pcg::Pcg64Mcg;
use serde::{Deserialize, Serialize};

use super::Rules;
use crate::geometry::Point;
use crate::global::Path;
use crate::map::ObstacleGrid;
use crate::runtime::Config;
use crate::sim::{MovingObstacle, MovingObstacles, PedestrianSpawner, SpawnTrigger};

/// The kind of moving obstacles of a mission.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum People {
    /// None.
    Nobody,
    /// They cross or follow the path, and stop rather than walk into the robot.
    Minding,
    /// They cross or follow the path and take no notice of the robot.
    Heedless,
    /// They are not there until the robot is near, then wander about the path, and mind the robot.
    Appearing,
}

/// Of four missions with people, one has heedless ones and one appearing ones.
const KINDS: [People; 4] = [
    People::Minding,
    People::Minding,
    People::Heedless,
    People::Appearing,
];
/// How near the robot's origin comes to somebody's place before he appears, metres: from just outside the robot's margins
/// to what it sees ahead.
const APPEARS_WITHIN_M: RangeInclusive<f64> = 2.0..=5.0;
/// How far from that place he wanders, metres.
const WANDER_M: f64 = 3.0;
/// The place is at least so far along the path from either end, metres: an end that is wandered over for ever cannot be parked
/// at.
const FROM_ENDS_M: f64 = 5.0;

/// Draws moving obstacles for a path over ground. Where the drifts have no room for as many as were drawn, there are fewer.
pub(super) fn people(
    rules: &Rules,
    config: &Config,
    ground: &ObstacleGrid,
    path: &Path,
    rng: &mut Pcg64Mcg,
) -> (People, MovingObstacles) {
    // All draws are made whatever comes of them, so that one rule less does not change the others' missions.
    let count = rng.random_range(0..=rules.most_people);
    let kind = KINDS[rng.random_range(0..KINDS.len())];
    let seed: u64 = rng.random();
    let moving_obstacles = match kind {
        People::Appearing => spawned_by(count, config, ground, path, rng),
        kind => {
            let spawner = PedestrianSpawner {
                yields: kind == People::Minding,
                ..config.pedestrians.spawner(count, seed)
            };
            along(spawner, ground, path)
        }
    };
    if moving_obstacles.is_empty() {
        return (People::Nobody, moving_obstacles);
    }
    (kind, moving_obstacles)
}

fn along(spawner: PedestrianSpawner, ground: &ObstacleGrid, path: &Path) -> MovingObstacles {
    let points = path.points();
    let ends: Vec<Point> = points
        .iter()
        .take(1)
        .chain(points.last())
        .copied()
        .collect();
    let placed = (1..=spawner.count).rev().find_map(|count| {
        let spawner = PedestrianSpawner { count, ..spawner };
        spawner.spawn(ground, points, &ends).ok()
    });
    placed.unwrap_or_default()
}

fn spawned_by(
    count: usize,
    config: &Config,
    ground: &ObstacleGrid,
    path: &Path,
    rng: &mut Pcg64Mcg,
) -> MovingObstacles {
    let people = config.pedestrians;
    let stretch = FROM_ENDS_M..path.length_m() - FROM_ENDS_M;
    if stretch.is_empty() {
        return MovingObstacles::default();
    }
    let mut moving = Vec::with_capacity(count);
    for _ in 0..count {
        let place = path.point_at(rng.random_range(stretch.clone()));
        let speed = rng.random_range(people.slowest..=people.fastest);
        let appears = SpawnTrigger::WithinDistance(rng.random_range(APPEARS_WITHIN_M));
        let seed = rng.random();
        let one =
            MovingObstacle::random_waypoint(people.radius_m, speed, place, WANDER_M, ground, seed);
        // A place too narrow to wander from has nobody.
        moving.extend(one.and_then(|one| one.spawned_by(appears)).ok());
    }
    MovingObstacles::new(moving)
}
