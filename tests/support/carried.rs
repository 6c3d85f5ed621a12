//! Robots that stand somewhere on a map and do not know where, or believe to be elsewhere.

use std::f64::consts::{PI, TAU};

use inbye::geometry::{Pose, wrap_angle};
use inbye::localization::{LocalizationSettings, LocalizationStatus, Localizer, LostReason};
use inbye::map::{Cell, DistanceField, ObstacleGrid, TimedScan};
use inbye::sim::{Lidar, World};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Clearance of the places, metres.
const CLEARANCE_M: f64 = 0.5;
/// Revolutions before a pose that stays counts as found, and until which there must be an answer.
const SETTLED: u32 = 60;
const MOST: u32 = 400;
/// A found pose is right within these, metres and radians.
const RIGHT_M: f64 = 0.3;
const RIGHT_RAD: f64 = 0.1;

/// How many robots got which answer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Answers {
    pub right: u32,
    pub refused: u32,
    /// Found at a wrong place.
    pub wrong: u32,
    /// No answer in time.
    pub open: u32,
}

/// Whether the robots believe to be somewhere else.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Belief {
    None,
    Elsewhere,
}

/// A lidar all around, with whole revolutions at one time.
pub fn lidar() -> Lidar {
    Lidar::default()
        .beams(360)
        .field_of_view_rad(TAU)
        .range_min_m(0.05)
        .range_max_m(12.0)
        .range_sigma_m(0.01)
        .dropout(0.01)
        .sweep_s(0.0)
}

/// Sets robots down at random places of a map, with this lidar.
pub fn carry(
    obstacles: &ObstacleGrid,
    robots: u32,
    belief: Belief,
    seed: u64,
) -> Result<Answers, String> {
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    let (field, world) = (DistanceField::new(obstacles), World::new(obstacles.clone()));
    let lidar = lidar();
    let frame = *obstacles.frame();
    let place = |rng: &mut Pcg64Mcg| {
        for _ in 0..100_000 {
            let (columns, rows) = (0..frame.width, 0..frame.height);
            let cell = Cell::new(rng.random_range(columns), rng.random_range(rows));
            if field.distance_m(cell) > CLEARANCE_M {
                let center = frame.center_of(cell);
                return Ok(Pose::new(center.x, center.y, rng.random_range(-PI..PI)));
            }
        }
        Err("the map has no room for a robot")
    };
    let mut answers = Answers::default();
    for _ in 0..robots {
        let truth = place(&mut rng)?;
        let settings = LocalizationSettings::default();
        let localizer = match belief {
            Belief::None => Localizer::without_pose(obstacles, settings),
            Belief::Elsewhere => Localizer::new(obstacles, settings, &place(&mut rng)?),
        };
        let mut localizer = localizer.map_err(|error| error.to_string())?;
        let mut status = LocalizationStatus::Uncertain;
        for tick in 0..MOST {
            let time_s = 0.1 * f64::from(tick);
            localizer.predict(time_s, &Pose::default());
            let seen = lidar.scan(&world, &truth, &mut rng);
            status = localizer.update(&TimedScan::from_scan(&seen.scan, time_s, 0.0)).status;
            let is_refused = status == LocalizationStatus::Lost(LostReason::Ambiguous);
            if is_refused || tick >= SETTLED && status == LocalizationStatus::Tracking {
                break;
            }
        }
        let found = localizer.pose();
        let is_right = (found.position() - truth.position()).norm() < RIGHT_M
            && wrap_angle(found.yaw - truth.yaw).abs() < RIGHT_RAD;
        let count = match status {
            LocalizationStatus::Tracking if is_right => &mut answers.right,
            LocalizationStatus::Tracking => &mut answers.wrong,
            LocalizationStatus::Lost(LostReason::Ambiguous) => &mut answers.refused,
            _ => &mut answers.open,
        };
        *count += 1;
    }
    Ok(answers)
}
