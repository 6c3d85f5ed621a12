//! A simulated LD19 lidar that writes its packets.

use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

use super::{Lidar, SimError, World};
use crate::base::ld19::{POINTS, POINTS_PER_S, Packet, Point, RANGE_MAX_M};
use crate::geometry::Pose;
use crate::localization::PoseHistory;

/// Speed of rotation, degrees per second: 10 Hz.
const SPEED_DEG_S: f64 = 3600.0;

/// Angle between points, degrees.
const STEP_DEG: f64 = SPEED_DEG_S / POINTS_PER_S;

/// A full turn in units of 0.01 degrees, and the period of the lidar's clock, ms.
const TURN: f64 = 36_000.0;
const CLOCK_MS: f64 = 30_000.0;

/// Intensity of every return.
const INTENSITY: u8 = 200;

/// An LD19 at the origin of a robot that moves in a world.
pub struct RotatingLidar {
    lidar: Lidar,
    /// The world; the caller moves its obstacles.
    pub world: World,
    track: PoseHistory,
    rng: Pcg64Mcg,
    /// Number of points so far.
    points: u64,
    packet: Packet,
}

impl RotatingLidar {
    /// Creates a lidar that starts at time zero. Noise and dropouts are those of the settings; beams, field of view,
    /// range and revolution time are the LD19's.
    ///
    /// # Errors
    /// [`SimError::Setting`] names the first setting out of range.
    pub fn new(lidar: Lidar, world: World, seed: u64) -> Result<Self, SimError> {
        let lidar = Lidar { range_max_m: RANGE_MAX_M, ..lidar };
        lidar.validate()?;
        Ok(Self {
            lidar,
            world,
            track: PoseHistory::new(),
            rng: Pcg64Mcg::seed_from_u64(seed),
            points: 0,
            packet: Packet::default(),
        })
    }

    /// Advances to a time, seconds, with the robot at a pose; appends the bytes that the lidar writes.
    pub fn step(&mut self, now_s: f64, pose: &Pose, line: &mut Vec<u8>) {
        self.track.record(now_s, pose);
        loop {
            let time_s = self.points as f64 / POINTS_PER_S;
            if time_s > now_s {
                return;
            }
            let place = self.track.at(time_s).unwrap_or(*pose);
            self.measure(time_s, &place, line);
        }
    }

    fn measure(&mut self, time_s: f64, place: &Pose, line: &mut Vec<u8>) {
        let clockwise = (self.points as f64 * STEP_DEG * 100.0) % TURN;
        let range = self.lidar.measure(
            &self.world,
            place,
            -(clockwise / 100.0).to_radians(),
            &mut self.rng,
        );
        let index = (self.points % POINTS as u64) as usize;
        self.points += 1;
        let angle = (clockwise.round() % TURN) as u16;
        if index == 0 {
            self.packet.first = angle;
        }
        // A distance of zero means no return.
        let distance_mm = if range.is_finite() { (range * 1e3).round() as u16 } else { 0 };
        self.packet.points[index] =
            Point { distance_mm, intensity: if distance_mm > 0 { INTENSITY } else { 0 } };
        if index == POINTS - 1 {
            self.packet.last = angle;
            self.packet.speed_deg_s = SPEED_DEG_S as u16;
            self.packet.time_ms = ((time_s * 1e3) % CLOCK_MS) as u16;
            line.extend(self.packet.encode());
        }
    }
}
