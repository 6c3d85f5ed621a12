//! A world, a robot that scans it from uncertain poses, and its obstacle model.

use core::f64::consts::TAU;

use inbye::geometry::{Point, Pose};
use inbye::map::{GridFrame, MovingDisc, ObstacleGrid};
use inbye::navigator::ObstacleModel;
use inbye::sim::{Lidar, World};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Errors of the robot's pose, and the share of lost beams.
#[derive(Clone, Copy, Debug, Default)]
pub struct Errors {
    /// Standard deviation of each coordinate, metres.
    pub place_m: f64,
    /// Standard deviation of the heading, radians.
    pub yaw: f64,
    /// Share by which odometry measures distances too long.
    pub drift: f64,
    /// Drift of the heading, radians per second.
    pub drift_rad_s: f64,
    /// Share of beams without a measurement.
    pub lost: f64,
}

/// Errors of a localisation on a map.
pub const LOCALISED: Errors =
    Errors { place_m: 0.01, yaw: 0.005, drift: 0.0, drift_rad_s: 0.0, lost: 0.02 };

/// Errors of odometry: smooth, but it drifts.
pub const ODOMETRY: Errors =
    Errors { place_m: 0.001, yaw: 0.0005, drift: 0.02, drift_rad_s: 0.003, lost: 0.02 };

pub struct Stage {
    pub world: World,
    pub lidar: Lidar,
    pub model: ObstacleModel,
    pub time_s: f64,
    pub period_s: f64,
    pub errors: Errors,
    pub random: Pcg64Mcg,
    /// The true pose and that by odometry, without noise.
    pub poses: Option<(Pose, Pose)>,
}

/// A grid with cells of 0.05 m, occupied where `is_blocked` holds for a cell's centre, metres.
pub fn ground(width_m: f64, height_m: f64, is_blocked: impl Fn(f64, f64) -> bool) -> ObstacleGrid {
    let cells = |side_m: f64| (side_m / 0.05).round() as i32;
    let frame = GridFrame::new(cells(width_m), cells(height_m), 0.05, Pose::default());
    let frame = frame.expect("a sound frame");
    ObstacleGrid::from_fn(frame, |cell| {
        let center = frame.center_of(cell);
        is_blocked(center.x, center.y)
    })
}

/// A grid of the same size without obstacles.
pub fn empty(like: &ObstacleGrid) -> ObstacleGrid {
    ObstacleGrid::filled(*like.frame(), false)
}

impl Stage {
    pub fn new(truth: ObstacleGrid, known: ObstacleGrid, errors: Errors, seed: u64) -> Self {
        Self {
            world: World::new(truth),
            lidar: Lidar::default()
                // The stage drops beams itself.
                .dropout(0.0),
            model: ObstacleModel::new(known),
            time_s: 0.0,
            period_s: 0.1,
            errors,
            random: Pcg64Mcg::seed_from_u64(seed),
            poses: None,
        }
    }

    /// An empty world of 40 by 40 m.
    pub fn open(seed: u64) -> Self {
        let truth = ground(40.0, 40.0, |_, _| false);
        Self::new(truth.clone(), truth, LOCALISED, seed)
    }

    /// Looks from a pose at discs, and lets a tick pass.
    pub fn tick(&mut self, pose: &Pose, moving: &[MovingDisc]) -> Vec<MovingDisc> {
        self.world.moving = moving.to_vec();
        let mut seen = self.lidar.scan(&self.world, pose, &mut self.random);
        for range in &mut seen.scan.ranges {
            if self.random.random_bool(self.errors.lost) {
                *range = f64::NAN;
            }
        }
        let Errors { place_m, yaw, .. } = self.errors;
        let odometry = self.odometry(pose);
        let believed = Pose::new(
            odometry.x + place_m * self.normal(),
            odometry.y + place_m * self.normal(),
            odometry.yaw + yaw * self.normal(),
        );
        self.model.update(self.time_s, &believed, &seen.scan);
        self.time_s += self.period_s;
        self.model.moving().to_vec()
    }

    /// Adds the motion since the last tick to the odometry, with its errors.
    fn odometry(&mut self, pose: &Pose) -> Pose {
        let now = self.poses.map_or(*pose, |(before, odometry)| {
            let step = before.inverse_transform(&pose.position());
            let scale = 1.0 + self.errors.drift;
            let place = odometry.transform(&Point::new(step.x * scale, step.y * scale));
            let turned = inbye::geometry::wrap_angle(pose.yaw - before.yaw);
            let yaw = odometry.yaw + turned + self.errors.drift_rad_s * self.period_s;
            Pose::new(place.x, place.y, yaw)
        });
        self.poses = Some((*pose, now));
        now
    }

    /// A true disc in the frame of the odometry.
    pub fn as_estimated(&self, disc: &MovingDisc) -> MovingDisc {
        let Some((pose, odometry)) = self.poses else {
            return *disc;
        };
        let center = odometry.transform(&pose.inverse_transform(&disc.center()));
        let (sin, cos) = libm::sincos(odometry.yaw - pose.yaw);
        MovingDisc {
            x: center.x,
            y: center.y,
            radius: disc.radius,
            vx: cos * disc.vx - sin * disc.vy,
            vy: sin * disc.vx + cos * disc.vy,
        }
    }

    fn normal(&mut self) -> f64 {
        let radius = (-2.0 * libm::log(1.0 - self.random.random::<f64>())).sqrt();
        radius * libm::cos(TAU * self.random.random::<f64>())
    }

    /// Whether a mark stands within a distance, metres, of a place.
    pub fn is_marked(&self, x: f64, y: f64, within_m: f64) -> bool {
        let mut marks = self.model.marks();
        marks.any(|mark| libm::hypot(mark.x - x, mark.y - y) < within_m)
    }
}

/// A disc.
pub fn disc(x: f64, y: f64, radius: f64, vx: f64, vy: f64) -> MovingDisc {
    MovingDisc { x, y, radius, vx, vy }
}

/// A true disc at a tick and the disc found for it.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    pub time_s: f64,
    pub truth: MovingDisc,
    pub found: Option<MovingDisc>,
}

/// The found disc that is nearest to a true one, within 0.6 m.
pub fn nearest(truth: &MovingDisc, found: &[MovingDisc]) -> Option<MovingDisc> {
    let apart = |disc: &MovingDisc| (disc.center() - truth.center()).norm();
    found
        .iter()
        .copied()
        .filter(|disc| apart(disc) < 0.6)
        .min_by(|one, other| apart(one).total_cmp(&apart(other)))
}

impl Sample {
    pub fn new(time_s: f64, truth: MovingDisc, found: &[MovingDisc]) -> Self {
        let found = nearest(&truth, found);
        Self { time_s, truth, found }
    }

    /// Error of the velocity, m/s; infinite where nothing was found.
    pub fn velocity_error(&self) -> f64 {
        self.found.map_or(f64::INFINITY, |found| {
            libm::hypot(found.vx - self.truth.vx, found.vy - self.truth.vy)
        })
    }

    /// Angle between the true direction and the one found, degrees.
    pub fn direction_error_deg(&self) -> f64 {
        self.found.map_or(f64::INFINITY, |found| {
            let turn = libm::atan2(found.vy, found.vx) - libm::atan2(self.truth.vy, self.truth.vx);
            inbye::geometry::wrap_angle(turn).abs().to_degrees()
        })
    }

    pub fn center_error_m(&self) -> f64 {
        self.found.map_or(f64::INFINITY, |found| (found.center() - self.truth.center()).norm())
    }

    pub fn radius_error_m(&self) -> f64 {
        self.found.map_or(f64::INFINITY, |found| (found.radius - self.truth.radius).abs())
    }
}

/// Reverses the velocities of the found discs: the fault that the checks must find.
pub fn reversed(samples: &[Sample]) -> Vec<Sample> {
    let reverse = |sample: &Sample| Sample {
        found: sample.found.map(|found| MovingDisc { vx: -found.vx, vy: -found.vy, ..found }),
        ..*sample
    };
    samples.iter().map(reverse).collect()
}

/// The value below which a share of them lies.
pub fn quantile(mut values: Vec<f64>, share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let place = (values.len() as f64 * share) as usize;
    values.get(place).copied().unwrap_or(f64::NAN)
}
