//! Simulated planar lidars, by exact ray casting in the world.

use core::f64::consts::TAU;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::{Lidar, SimError, World};
use crate::base::ld19::{self, POINTS, POINTS_PER_S, Packet, RANGE_MAX_M};
use crate::base::standard_normal;
use crate::geometry::{Point, Pose, Vector};
use crate::localization::PoseHistory;
use crate::map::{MovingDisc, Scan, TimedScan};

/// Difference of the ranges on both sides of an edge, metres.
const EDGE_M: f64 = 0.2;

/// A scan, and the moving obstacles that it shows.
#[derive(Clone, Debug, PartialEq, Default)]
#[non_exhaustive]
pub struct LidarReturn {
    /// The measured ranges.
    pub scan: Scan,
    /// Indices in [`World::moving`] of the obstacles that at least one beam hits first, ascending.
    pub visible: Vec<usize>,
}

impl Lidar {
    /// Returns a scan of a lidar at a finite pose, in the lidar's own frame. A beam ends at the first obstacle; its range is
    /// zero if the lidar is inside one. A beam without a hit within range reads infinite. A dropped beam, and one with a hit
    /// nearer than the shortest range, reads NaN and makes no obstacle visible. (For a hit that is too near, REP-117 has minus
    /// infinity; real scanners give zero, NaN or an error code.)
    ///
    /// Noise is normal, independent for each beam and clamped to the shortest and longest range; visibility does not
    /// depend on it, nor on ghosts and mixed pixels. Without any of these and dropouts the scan uses no random numbers.
    #[must_use]
    pub fn scan(&self, world: &World, pose: &Pose, rng: &mut Pcg64Mcg) -> LidarReturn {
        self.scan_from(world, |_| *pose, rng)
    }

    /// Returns a revolution that ends at a time, seconds. Each beam is that of [`Lidar::scan`] from the lidar's pose at its
    /// own time, seconds; moving obstacles have their positions at the end.
    #[must_use]
    pub fn sweep(
        &self,
        world: &World,
        pose_at: impl Fn(f64) -> Pose,
        end_s: f64,
        rng: &mut Pcg64Mcg,
    ) -> TimedScan {
        let gaps = (self.beams.max(2) - 1) as f64;
        let time_of = |beam: usize| end_s - self.sweep_s * (1.0 - beam as f64 / gaps);
        let found = self.scan_from(world, |beam| pose_at(time_of(beam)), rng);
        TimedScan::from_scan(&found.scan, end_s, self.sweep_s)
    }

    /// The ranges of a scan in the robot's frame, one for each beam, in directions that stay the same from scan to scan: those of
    /// the beams of a robot that does not turn. The nearest of several ranges counts, and a direction without a beam has NaN.
    #[must_use]
    pub fn ranges_in_fixed_directions(&self, scan: &Scan) -> Vec<f64> {
        let first = self.mount_yaw_rad - self.field_of_view_rad / 2.0;
        let increment = self.angle_increment();
        let mut ranges = vec![f64::NAN; self.beams];
        for (beam, range) in scan.ranges.iter().enumerate() {
            let turned = (scan.angle(beam) - first + increment / 2.0).rem_euclid(TAU);
            if let Some(nearest) = ranges.get_mut((turned / increment) as usize) {
                // `f64::min` ignores NaN.
                *nearest = nearest.min(*range);
            }
        }
        ranges
    }

    /// Returns a scan with a pose for each beam.
    fn scan_from(
        &self,
        world: &World,
        pose_of: impl Fn(usize) -> Pose,
        rng: &mut Pcg64Mcg,
    ) -> LidarReturn {
        let mut scan = Scan {
            angle_min: -self.field_of_view_rad / 2.0,
            angle_increment: self.angle_increment(),
            range_max: self.range_max_m,
            ranges: Vec::with_capacity(self.beams),
            ..Scan::default()
        };
        let mut is_visible = vec![false; world.moving.len()];
        let poses: Vec<Pose> = (0..self.beams).map(pose_of).collect();
        let may_hit = self.may_hit_moving(world, &poses);
        let ray = |(beam, pose): (usize, &Pose)| (pose.position(), pose.yaw + scan.angle(beam));
        let rays: Vec<(Point, f64)> = poses.iter().enumerate().map(ray).collect();
        let to_static = world.ranges_to_static_m(&rays, self.range_max_m);
        for (beam, (pose, to_static_m)) in poses.iter().zip(to_static).enumerate() {
            let angle = scan.angle(beam);
            let hit = if may_hit[beam] {
                self.first_hit(world, &pose.position(), pose.yaw + angle, to_static_m)
            } else {
                (to_static_m, None)
            };
            let (range, disc) = self.beam(world, pose, angle, hit, rng);
            if let Some(disc) = disc {
                is_visible[disc] = true;
            }
            scan.ranges.push(range);
        }
        LidarReturn {
            scan,
            visible: (0..is_visible.len()).filter(|&disc| is_visible[disc]).collect(),
        }
    }

    /// Whether each beam may hit a moving obstacle: the others need no test. All may where the poses of the beams differ.
    fn may_hit_moving(&self, world: &World, poses: &[Pose]) -> Vec<bool> {
        let Some(pose) = poses.first() else {
            return Vec::new();
        };
        if poses.iter().any(|other| other != pose) {
            return vec![true; poses.len()];
        }
        let mut may_hit = vec![false; poses.len()];
        let increment = self.angle_increment();
        for (_, disc) in moving_parts(world) {
            let to_center = disc.center() - pose.position();
            let away_m = to_center.norm();
            if away_m <= disc.radius {
                return vec![true; poses.len()];
            }
            let middle = libm::atan2(to_center.y, to_center.x) - pose.yaw;
            let half = libm::asin(disc.radius / away_m);
            // The beams begin at half the field of view to the right, and go round once at most. One more on each side of the disc
            // covers rounding.
            let begin = (middle - half + self.field_of_view_rad / 2.0).rem_euclid(TAU);
            for turn in [0.0, TAU] {
                let first = ((begin - turn) / increment).floor() - 1.0;
                let last = ((begin - turn + 2.0 * half) / increment).ceil() + 1.0;
                let end = (last + 1.0).max(0.0) as usize;
                let beams = (first.max(0.0) as usize).min(may_hit.len())..end.min(may_hit.len());
                if let Some(beams) = may_hit.get_mut(beams) {
                    beams.fill(true);
                }
            }
        }
        may_hit
    }

    /// The measured range of a beam in a direction of the lidar's frame, radians, and the moving obstacle that it hits, if any. `hit`
    /// are its true range and that obstacle.
    fn beam(
        &self,
        world: &World,
        pose: &Pose,
        angle: f64,
        hit: (f64, Option<usize>),
        rng: &mut Pcg64Mcg,
    ) -> (f64, Option<usize>) {
        if self.dropout > 0.0 && rng.random::<f64>() < self.dropout {
            return (f64::NAN, None);
        }
        let (mut range, disc) = hit;
        if range < self.range_min_m {
            return (f64::NAN, None);
        }
        if self.mixed_pixels > 0.0 && rng.random::<f64>() < self.mixed_pixels {
            range = self.mixed_with_neighbour(world, pose, angle, range, rng);
        }
        if self.ghosts > 0.0 && rng.random::<f64>() < self.ghosts {
            let farthest_m = range.min(self.range_max_m);
            range = self.range_min_m + (farthest_m - self.range_min_m) * rng.random::<f64>();
        }
        if self.range_sigma_m > 0.0 && range.is_finite() {
            range += self.range_sigma_m * standard_normal(rng);
            range = range.clamp(self.range_min_m, self.range_max_m);
        }
        (range, disc)
    }

    /// The range of a beam whose spot lies on two surfaces: one between them, where the range half a step further differs by
    /// more than noise does.
    fn mixed_with_neighbour(
        &self,
        world: &World,
        pose: &Pose,
        angle: f64,
        range: f64,
        rng: &mut Pcg64Mcg,
    ) -> f64 {
        let half_step_further = pose.yaw + angle + self.angle_increment() / 2.0;
        let start = pose.position();
        let to_static_m = world.range_to_static_m(&start, half_step_further, self.range_max_m);
        let (other, _) = self.first_hit(world, &start, half_step_further, to_static_m);
        let is_edge = range.is_finite() && (other - range).abs() > EDGE_M && other.is_finite();
        if is_edge { range + (other - range) * rng.random::<f64>() } else { range }
    }

    /// A full turn has one beam at its seam; a smaller field of view has a beam at both edges.
    fn angle_increment(&self) -> f64 {
        let gaps = if self.field_of_view_rad < TAU { (self.beams - 1).max(1) } else { self.beams };
        self.field_of_view_rad / gaps as f64
    }

    /// True range, infinite beyond the longest, and the moving obstacle that the beam hits, if any, from its range to a static one.
    fn first_hit(
        &self,
        world: &World,
        start: &Point,
        direction: f64,
        to_static_m: f64,
    ) -> (f64, Option<usize>) {
        let (mut range, mut first) = (to_static_m, None);
        if world.moving.is_empty() {
            return (range, first);
        }
        let (sin, cos) = libm::sincos(direction);
        for (index, disc) in moving_parts(world) {
            let to_disc = range_to_disc(start, &Vector::new(cos, sin), disc);
            if to_disc < range && to_disc <= self.range_max_m {
                range = to_disc;
                first = Some(index);
            }
        }
        (range, first)
    }
}

/// What a lidar hits of the moving obstacles, each part with the index of its obstacle.
fn moving_parts(world: &World) -> impl Iterator<Item = (usize, &MovingDisc)> {
    let seen = world.seen.iter().flatten().map(|(index, disc)| (*index, disc));
    let whole = if world.seen.is_some() { &[][..] } else { &world.moving };
    whole.iter().enumerate().chain(seen)
}

/// Distance along a ray of unit direction to a disc: zero inside it, infinite if the ray misses.
fn range_to_disc(start: &Point, direction: &Vector, disc: &MovingDisc) -> f64 {
    let to_center = disc.center() - start;
    let outside = to_center.norm_squared() - disc.radius * disc.radius;
    if outside <= 0.0 {
        return 0.0;
    }
    let along = to_center.dot(direction);
    let depth = along * along - outside;
    if along <= 0.0 || depth < 0.0 {
        return f64::INFINITY;
    }
    along - depth.sqrt()
}

/// Speed of rotation, degrees per second: 10 Hz.
const SPEED_DEG_S: f64 = 3600.0;

/// Angle between points, degrees.
const STEP_DEG: f64 = SPEED_DEG_S / POINTS_PER_S;

/// A full turn in units of 0.01 degrees, and the period of the lidar's clock, ms.
const TURN: f64 = 36_000.0;
const CLOCK_MS: f64 = 30_000.0;

/// Intensity of every return.
const INTENSITY: u8 = 200;

/// An LD19 on a robot that moves in a world.
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
    /// Creates a lidar that starts at time zero. Its place, noise and dropouts are those of the settings; beams, field of view,
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
            let robot = self.track.at(time_s).unwrap_or(*pose);
            let place = robot.transform_pose(&self.lidar.mount());
            self.measure(time_s, &place, line);
        }
    }

    fn measure(&mut self, time_s: f64, place: &Pose, line: &mut Vec<u8>) {
        let clockwise = (self.points as f64 * STEP_DEG * 100.0) % TURN;
        let direction = -(clockwise / 100.0).to_radians();
        let (start, along) = (place.position(), place.yaw + direction);
        let to_static_m = self.world.range_to_static_m(&start, along, self.lidar.range_max_m);
        let hit = self.lidar.first_hit(&self.world, &start, along, to_static_m);
        let (range, _) = self.lidar.beam(&self.world, place, direction, hit, &mut self.rng);
        let index = (self.points % POINTS as u64) as usize;
        self.points += 1;
        let angle = (clockwise.round() % TURN) as u16;
        if index == 0 {
            self.packet.first = angle;
        }
        // A distance of zero means no return.
        let distance_mm = if range.is_finite() { (range * 1e3).round() as u16 } else { 0 };
        self.packet.points[index] =
            ld19::Point { distance_mm, intensity: if distance_mm > 0 { INTENSITY } else { 0 } };
        if index == POINTS - 1 {
            self.packet.last = angle;
            self.packet.speed_deg_s = SPEED_DEG_S as u16;
            self.packet.time_ms = ((time_s * 1e3) % CLOCK_MS) as u16;
            line.extend(self.packet.encode());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::{GridFrame, ObstacleGrid};

    #[test]
    fn beam_that_is_not_tested_hits_no_moving_obstacle() {
        let frame = GridFrame::new(10, 10, 1.0, Pose::default()).expect("a valid size");
        let mut world = World::new(ObstacleGrid::filled(frame, false));
        let mut random = Pcg64Mcg::seed_from_u64(3);
        let mut untested = 0;
        for case in 0..500 {
            let mut within = |low: f64, high: f64| low + (high - low) * random.random::<f64>();
            let disc = MovingDisc {
                x: within(1.0, 9.0),
                y: within(1.0, 9.0),
                radius: within(0.01, 0.5),
                vx: 0.0,
                vy: 0.0,
            };
            world.moving = vec![disc];
            let lidar = Lidar {
                beams: 1 + case % 97,
                field_of_view_rad: if case % 2 == 0 { TAU } else { within(0.1, TAU) },
                ..Lidar::default()
            };
            let pose = Pose::new(within(1.0, 9.0), within(1.0, 9.0), within(-9.0, 9.0));
            let may_hit = lidar.may_hit_moving(&world, &vec![pose; lidar.beams]);
            assert_eq!(may_hit.len(), lidar.beams);
            for (beam, may_hit) in may_hit.into_iter().enumerate().filter(|(_, may_hit)| !may_hit) {
                let angle = beam as f64 * lidar.angle_increment() - lidar.field_of_view_rad / 2.0;
                let start = pose.position();
                let (_, hit) = lidar.first_hit(&world, &start, pose.yaw + angle, f64::INFINITY);
                assert_eq!(hit, None, "{case}: beam {beam}, {disc:?}, {pose:?}");
                untested += usize::from(!may_hit);
            }
        }
        assert!(untested > 10_000, "{untested}");
    }
}
