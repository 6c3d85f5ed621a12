//! Moving obstacles of a mission.

use core::ops::RangeInclusive;
use std::sync::Arc;

use rand::RngExt;
use rand_pcg::Pcg64Mcg;
use serde::{Deserialize, Serialize};

use super::Rules;
use crate::geometry::Point;
use crate::global::Path;
use crate::map::{FreeSpace, ObstacleGrid};
use crate::settings::words;
use crate::sim::{
    MovingObstacle, MovingObstacles, PedestrianSettings, PedestrianSpawner, SpawnTrigger, Surprise,
    is_in_sight,
};

words! {
    /// The kind of moving obstacles of a mission.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
    #[non_exhaustive]
    pub enum TrafficKind {
        /// No moving obstacles.
        None = "none",
        /// They cross or follow the path, and stop for the robot.
        Yielding = "yielding",
        /// They cross or follow the path and ignore the robot.
        NonYielding = "non_yielding",
        /// They appear out of the robot's sight when it is near, or are there from the start. They wander around the path and stop for
        /// the robot.
        Appearing = "appearing",
        /// They stand next to the path and walk across it when the robot is near; they stop for the robot.
        Starting = "starting",
        /// They step out of a crossing or from behind something when the robot is near; they stop for the robot.
        SteppingOut = "stepping_out",
    }
}

/// Of six missions with moving obstacles, two have yielding ones, and one has each other kind.
const KINDS: [TrafficKind; 6] = [
    TrafficKind::Yielding,
    TrafficKind::Yielding,
    TrafficKind::NonYielding,
    TrafficKind::Appearing,
    TrafficKind::Starting,
    TrafficKind::SteppingOut,
];
/// Distance of the robot's origin at which an obstacle appears, metres. Where a robot on the path sees its place from there, it
/// is present from the start, because a real person cannot appear in the view of a lidar.
const APPEARS_WITHIN_M: RangeInclusive<f64> = 2.0..=5.0;
/// Largest distance of its random waypoints from its start, metres.
const WANDER_M: f64 = 3.0;
/// Smallest distance of its start from either end along the path, metres: the robot cannot park at an end that is never
/// clear.
const FROM_ENDS_M: f64 = 5.0;

/// Generates moving obstacles along a path of a robot with this radius, metres. Where the map has no room for all of them, there are
/// fewer.
pub(super) fn traffic(
    rules: &Rules,
    pedestrians: PedestrianSettings,
    (ground, path): (&ObstacleGrid, &Path),
    robot_m: f64,
    rng: &mut Pcg64Mcg,
) -> (TrafficKind, MovingObstacles) {
    // All random numbers are drawn in any case: a change of one rule does not change the rest of the mission.
    let count = rng.random_range(0..=rules.max_people);
    let kind = KINDS[rng.random_range(0..KINDS.len())];
    let seed: u64 = rng.random();
    let sudden = |surprise| {
        let spawner = pedestrians.spawner(count, seed);
        spawner.spawn_sudden(ground, path, surprise).unwrap_or_default()
    };
    let moving_obstacles = match kind {
        TrafficKind::Appearing => appearing(count, pedestrians, ground, path, rng),
        TrafficKind::Starting => sudden(Surprise::Start),
        TrafficKind::SteppingOut => sudden(Surprise::StepOut),
        kind => {
            let pedestrians = pedestrians.yields(kind == TrafficKind::Yielding);
            along(pedestrians.spawner(count, seed), (ground, path), robot_m)
        }
    };
    if moving_obstacles.is_empty() {
        return (TrafficKind::None, moving_obstacles);
    }
    (kind, moving_obstacles)
}

fn along(
    spawner: PedestrianSpawner,
    (ground, path): (&ObstacleGrid, &Path),
    robot_m: f64,
) -> MovingObstacles {
    let points = path.points();
    let ends: Vec<Point> = points.iter().take(1).chain(points.last()).copied().collect();
    let placed = (1..=spawner.count).rev().find_map(|count| {
        let spawner = PedestrianSpawner { count, ..spawner };
        spawner.spawn(ground, points, &ends, robot_m).ok()
    });
    placed.unwrap_or_default()
}

fn appearing(
    count: usize,
    people: PedestrianSettings,
    ground: &ObstacleGrid,
    path: &Path,
    rng: &mut Pcg64Mcg,
) -> MovingObstacles {
    let stretch = FROM_ENDS_M..path.length_m() - FROM_ENDS_M;
    if stretch.is_empty() {
        return MovingObstacles::default();
    }
    let transparent = Arc::new(FreeSpace::new(ground, 0.0));
    let mut moving = Vec::with_capacity(count);
    for _ in 0..count {
        let arc_m = rng.random_range(stretch.clone());
        let place = path.point_at(arc_m);
        let speed = rng.random_range(people.min_speed..=people.max_speed);
        let within_m = rng.random_range(APPEARS_WITHIN_M);
        let seed = rng.random();
        let one =
            MovingObstacle::random_waypoint(people.radius_m, speed, place, WANDER_M, ground, seed);
        let is_hidden = !is_in_sight(&transparent, &path.point_at(arc_m - within_m), &place);
        let one = one.and_then(|one| {
            if !is_hidden {
                return Ok(one);
            }
            let one = one.spawned_by(SpawnTrigger::WithinDistance(within_m))?;
            Ok(one.out_of_sight_over(Arc::clone(&transparent)))
        });
        // A point without room for a random route gets no obstacle.
        moving.extend(one.and_then(|one| one.with_legs(people.leg_diameter_m, 0.0)).ok());
    }
    MovingObstacles::new(moving)
}
