//! The obstacles of a simulated world, and the gaps to them.

use crate::geometry::{Point, Pose, Twist};
use crate::map::{MovingDisc, ObstacleGrid, RayCaster, RayEnd};
use crate::robot::Footprint;
use crate::runtime::{Contact, ObstacleGap, TouchedBody};

/// Everything that the robot can touch. All gaps are in metres, exact to rounding; at or below zero there is contact.
#[derive(Clone, Debug)]
pub struct World {
    obstacles: ObstacleGap,
    rays: RayCaster,
    /// Moving obstacles at their present positions.
    pub moving: Vec<MovingDisc>,
    /// What a lidar hits of them, each part with the index of its obstacle: legs, or an earlier position. None: the discs of
    /// `moving`.
    pub seen: Option<Vec<(usize, MovingDisc)>>,
}

impl World {
    /// Creates a world without moving obstacles.
    #[must_use]
    pub fn new(obstacles: ObstacleGrid) -> Self {
        let obstacles = ObstacleGap::new(obstacles);
        let rays = RayCaster::of_field(obstacles.field());
        Self { obstacles, rays, moving: Vec::new(), seen: None }
    }

    /// The static obstacles.
    #[must_use]
    pub const fn obstacles(&self) -> &ObstacleGrid {
        self.obstacles.obstacles()
    }

    /// The smallest gap between the body and anything solid.
    #[must_use]
    pub fn gap_m(&self, footprint: &Footprint, pose: &Pose) -> f64 {
        self.gap_to_static_m(footprint, pose).min(self.gap_to_moving_m(footprint, pose))
    }

    /// Whether the gap by the discs of the footprint, at most that of the body, may be less than this. It costs far less than a
    /// measurement where nothing is near.
    #[must_use]
    pub(super) fn may_be_nearer(&self, footprint: &Footprint, pose: &Pose, gap_m: f64) -> bool {
        let is_near_static = || {
            !self.obstacles.is_surely_farther(footprint, pose, gap_m)
                && self.obstacles.disc_gap_m(footprint, pose) < gap_m
        };
        is_near_static() || self.gap_to_moving_m(footprint, pose) < gap_m
    }

    /// Range along a ray to the first static obstacle, metres; infinite beyond the longest range.
    #[must_use]
    pub(super) fn range_to_static_m(&self, start: &Point, direction: f64, longest_m: f64) -> f64 {
        range_m(self.rays.cast(start, direction, longest_m))
    }

    /// As [`Self::range_to_static_m`] for each of these starts and directions.
    #[must_use]
    pub(super) fn ranges_to_static_m(&self, rays: &[(Point, f64)], longest_m: f64) -> Vec<f64> {
        self.rays.cast_all(rays, longest_m).into_iter().map(range_m).collect()
    }

    /// The smallest gap between the body and the static obstacles: see [`ObstacleGap::gap_m`].
    #[must_use]
    pub fn gap_to_static_m(&self, footprint: &Footprint, pose: &Pose) -> f64 {
        self.obstacles.gap_m(footprint, pose)
    }

    /// The contact at a time, seconds, of a robot at a pose, by the nearest body. The robot closes the gap at the highest speed
    /// of these motions. A moving body has its index in `moving`.
    #[must_use]
    pub fn contact(
        &self,
        footprint: &Footprint,
        time_s: f64,
        pose: &Pose,
        twists: &[Twist],
    ) -> Contact {
        let gap_m = |disc: &MovingDisc| footprint.gap_to_disc_m(pose, &disc.center(), disc.radius);
        let by_gap = self.moving.iter().enumerate().map(|(index, disc)| (gap_m(disc), index, disc));
        let nearest = by_gap.min_by(|one, other| one.0.total_cmp(&other.0));
        let to_static_m = self.gap_to_static_m(footprint, pose);
        let touched = |(_, index, disc): (f64, usize, &MovingDisc)| {
            let closing = |twist| footprint.closing_speed_m_s(pose, twist, &disc.center());
            TouchedBody::Moving {
                index,
                speed_m_s: libm::hypot(disc.vx, disc.vy),
                closing_m_s: twists.iter().map(closing).fold(f64::NEG_INFINITY, f64::max),
            }
        };
        let nearest = nearest.filter(|nearest| nearest.0 < to_static_m);
        let body = nearest.map_or(TouchedBody::Static, touched);
        Contact { time_s, pose: *pose, body }
    }

    /// The smallest gap between the body and the moving obstacles; infinite without any.
    #[must_use]
    pub fn gap_to_moving_m(&self, footprint: &Footprint, pose: &Pose) -> f64 {
        self.moving
            .iter()
            .map(|disc| footprint.gap_to_disc_m(pose, &disc.center(), disc.radius))
            .fold(f64::INFINITY, f64::min)
    }
}

/// The range of a ray; infinite where it ends at its longest range.
const fn range_m(end: RayEnd) -> f64 {
    match end {
        RayEnd::Blocked(range_m) | RayEnd::Outside(range_m) => range_m,
        RayEnd::Free => f64::INFINITY,
    }
}
