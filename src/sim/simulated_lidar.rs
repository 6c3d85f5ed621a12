//! The lidar of a simulated robot: its place on the robot, the times of its scans, and its faults.

use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

use super::faulty_lidar::{FaultyLidar, degraded_range};
use super::{FaultInjection, Lidar, World};
use crate::geometry::Pose;
use crate::localization::PoseHistory;
use crate::runtime::LidarData;

/// Rounding of a number of scans: a scan that ends at a tick is not left to the next one.
const ROUNDING: f64 = 1e-9;

/// A lidar on a robot.
pub(super) struct SimulatedLidar {
    settings: Lidar,
    /// The pose of the lidar in the robot's frame; none for one at the robot's origin that looks ahead.
    mount: Option<Pose>,
    rng: Pcg64Mcg,
    faulty: FaultyLidar,
    /// The last scan and the time of its measurement, seconds, for a lidar with a scan rate.
    last: Option<(f64, LidarData)>,
}

impl SimulatedLidar {
    /// Creates a lidar whose noise and random faults the seed determines.
    pub fn new(settings: Lidar, seed: u64) -> Self {
        Self {
            settings,
            mount: Some(settings.mount()).filter(|mount| *mount != Pose::default()),
            rng: Pcg64Mcg::seed_from_u64(seed),
            faulty: FaultyLidar::new(seed),
            last: None,
        }
    }

    /// Time at which the newest scan ended that the robot can have at a time, seconds.
    pub fn newest_scan_s(&self, time_s: f64) -> f64 {
        let rate_hz = self.settings.scan_rate_hz;
        rate_hz.map_or(time_s, |rate_hz| (time_s * rate_hz + ROUNDING).floor() / rate_hz)
    }

    /// Returns the scan that ended at a time, in the robot's frame, with its stamp; both in seconds. Its faults are those of the
    /// time of the tick in which the robot gets it.
    pub fn scan(
        &mut self,
        (world, true_poses): (&World, &PoseHistory),
        faults: &[FaultInjection],
        tick_s: f64,
        (scan_s, stamp_s): (f64, f64),
    ) -> LidarData {
        if let Some((_, last)) = self.last.as_ref().filter(|(last_s, _)| *last_s == scan_s) {
            return last.clone();
        }
        let measured = self.measure((world, true_poses), faults, (scan_s, stamp_s));
        // A fault happens in the lidar or its driver, which do not know the place of the lidar on the robot.
        let mut sent = self.faulty.sent(faults, tick_s, stamp_s, measured);
        if let Some(mount) = &self.mount {
            sent = sent.from_mount(mount);
        }
        self.last = self.settings.scan_rate_hz.map(|_| (scan_s, sent.clone()));
        sent
    }

    /// Measures a scan in the lidar's own frame.
    fn measure(
        &mut self,
        (world, true_poses): (&World, &PoseHistory),
        faults: &[FaultInjection],
        (scan_s, stamp_s): (f64, f64),
    ) -> LidarData {
        let (lidar, mount) = (&self.settings, self.mount);
        let pose_at = |time_s: f64| {
            let robot = true_poses.at(time_s).unwrap_or_default();
            mount.map_or(robot, |mount| robot.transform_pose(&mount))
        };
        let degraded = |time_s: f64, angle: f64, range: f64| {
            degraded_range(faults, time_s, lidar.mount_yaw_rad + angle, range)
        };
        if lidar.sweep_s > 0.0 {
            let mut sweep = lidar.sweep(world, pose_at, scan_s, &mut self.rng);
            for beam in &mut sweep.beams {
                beam.range = degraded(beam.time_s, beam.angle, beam.range);
                beam.time_s += stamp_s - scan_s;
            }
            return LidarData::TimedScan(sweep);
        }
        let mut scan = lidar.scan(world, &pose_at(scan_s), &mut self.rng).scan;
        for beam in 0..scan.ranges.len() {
            scan.ranges[beam] = degraded(scan_s, scan.angle(beam), scan.ranges[beam]);
        }
        let scan = LidarData::Scan(scan);
        // A scan of an earlier time needs its stamp.
        if lidar.scan_rate_hz.is_some() {
            return LidarData::TimedScan(scan.timed(stamp_s).into_owned());
        }
        scan
    }
}
