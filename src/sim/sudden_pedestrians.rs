//! Pedestrians that start to walk when the robot is near: some stand in sight, others step out from a hidden place.

use core::f64::consts::FRAC_PI_2;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::moving_obstacle::Patrol;
use super::route_sampler::{is_in_sight, straight_route, winding_route};
use super::{MovingObstacle, MovingObstacles, PedestrianSpawner, SimError};
use crate::geometry::{Point, bearing};
use crate::global::Path;
use crate::map::{FreeSpace, ObstacleGrid};

/// Smallest distance of the meeting place from either end along the path, metres: the robot cannot park at an end that is
/// never clear.
const FROM_ENDS_M: f64 = 5.0;
/// Length of the walk from its start to the path, metres, of a standing pedestrian, and of one that steps out.
const STANDING_M: core::ops::RangeInclusive<f64> = 0.8..=2.5;
const HIDDEN_M: core::ops::RangeInclusive<f64> = 2.0..=6.0;
/// Length of the walk beyond the path, metres.
const BEYOND_M: f64 = 2.5;
/// A pedestrian that steps out is hidden at this distance from the path, metres, from the robot at that distance before the
/// meeting place.
const UNSEEN_M: f64 = 1.2;
const UNSEEN_FROM_M: f64 = 2.0;
/// The pedestrian starts so that a robot at this speed, m/s, meets it, but for a random factor.
const ROBOT_M_S: f64 = 0.8;
const EARLY: core::ops::RangeInclusive<f64> = 0.7..=1.3;
/// Attempts to find a walk for each pedestrian.
const ATTEMPTS: usize = 64;

/// How pedestrians surprise the robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Surprise {
    /// They stand in sight next to the path, and walk across it.
    Start,
    /// They walk onto the path from where the robot cannot see them.
    StepOut,
}

impl PedestrianSpawner {
    /// Spawns pedestrians that stand until the robot comes near, and walk across its path so that they meet. Where no walk is
    /// found for all of them, there are fewer.
    ///
    /// # Errors
    /// [`SimError::Setting`] for a setting out of range.
    pub fn spawn_sudden(
        &self,
        obstacles: &ObstacleGrid,
        path: &Path,
        surprise: Surprise,
    ) -> Result<MovingObstacles, SimError> {
        self.validate()?;
        let settings = &self.settings;
        let walkable = FreeSpace::new(obstacles, settings.radius_m);
        let transparent = FreeSpace::new(obstacles, 0.0);
        let stretch = FROM_ENDS_M..path.length_m() - FROM_ENDS_M;
        let mut rng = Pcg64Mcg::seed_from_u64(self.seed);
        let mut all = Vec::with_capacity(self.count);
        let attempts = if stretch.is_empty() { 0 } else { self.count };
        for _ in 0..attempts {
            let speed_m_s = self.draw_speed_m_s(&mut rng);
            let found = (0..ATTEMPTS).find_map(|_| {
                let arc_m = rng.random_range(stretch.clone());
                let place = path.point_at(arc_m);
                let points = match surprise {
                    Surprise::Start => standing_walk(&walkable, path, arc_m, &mut rng),
                    Surprise::StepOut => {
                        let points = hidden_walk(&walkable, &place, &mut rng)?;
                        let robot = path.point_at(arc_m - UNSEEN_FROM_M);
                        is_unseen(&transparent, &points, &place, &robot).then_some(points)
                    }
                };
                points.map(|points| (place, points))
            });
            let Some((place, points)) = found else { continue };
            let to_place_m = (points[0] - place).norm();
            let early = rng.random_range(EARLY);
            let meets_within_m =
                (ROBOT_M_S * to_place_m / speed_m_s * early).max(settings.radius_m);
            let walk = Patrol::new(Path::new(points), speed_m_s);
            let one = MovingObstacle::mid_patrol(settings.radius_m, settings.yields, walk)?;
            let one = one.with_legs(settings.leg_diameter_m, rng.random_range(0.0..1.0))?;
            all.push(one.starting_within(meets_within_m, place)?);
        }
        Ok(MovingObstacles::new(all))
    }
}

/// A straight walk across the path from one side.
fn standing_walk(
    free: &FreeSpace,
    path: &Path,
    arc_m: f64,
    rng: &mut Pcg64Mcg,
) -> Option<Vec<Point>> {
    let (place, along) = (path.point_at(arc_m), path.direction_at(arc_m));
    let side = if rng.random_bool(0.5) { FRAC_PI_2 } else { -FRAC_PI_2 };
    let across = libm::atan2(along.y, along.x) + side;
    let walk = straight_route(free, &place, across, *STANDING_M.end());
    let before_m = (place - walk[0]).norm();
    (STANDING_M.contains(&before_m)).then(|| walk.to_vec())
}

/// A walk to a place on the path over free space, and straight on beyond it.
fn hidden_walk(free: &FreeSpace, place: &Point, rng: &mut Pcg64Mcg) -> Option<Vec<Point>> {
    let mut points = winding_route(free, place, &HIDDEN_M, rng)?;
    points.reverse();
    if let [.., before, last] = points[..] {
        let onward = straight_route(free, &last, bearing(&before, &last), BEYOND_M);
        points.push(onward[1]);
    }
    Some(points)
}

/// Whether neither the start of a walk nor its part shortly before a place is in sight from another place.
fn is_unseen(transparent: &FreeSpace, walk: &[Point], place: &Point, from: &Point) -> bool {
    let path = Path::new(walk.to_vec());
    let shortly_before = path.samples(0.1).find(|point| (point - place).norm() <= UNSEEN_M);
    let hidden = [Some(walk[0]), shortly_before];
    hidden.iter().flatten().all(|point| !is_in_sight(transparent, from, point))
}
