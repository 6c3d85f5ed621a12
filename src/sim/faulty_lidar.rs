//! The lidar of a simulated robot with injected faults.

use core::f64::consts::TAU;

use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use super::fault_injection::active_faults;
use super::recent_measurements::RecentMeasurements;
use super::{FaultInjection, LidarChange, RngStream, generator};
use crate::runtime::LidarData;

/// Returns a range that was measured at a time, seconds, in a direction of the robot's frame, radians, as the faults change
/// it.
pub(super) fn degraded_range(
    faults: &[FaultInjection],
    time_s: f64,
    direction: f64,
    range: f64,
) -> f64 {
    let mut range = range;
    for fault in active_faults(faults, time_s) {
        match fault {
            FaultInjection::LidarOccluded { .. } => range = f64::INFINITY,
            FaultInjection::LidarSectorOccluded { from_rad, width_rad, .. }
                if (direction - from_rad).rem_euclid(TAU) < *width_rad =>
            {
                range = f64::INFINITY;
            }
            FaultInjection::LidarSilent { .. } => range = f64::NAN,
            _ => {}
        }
    }
    range
}

/// Changes the revolutions of a lidar by faults.
#[derive(Clone, Debug)]
pub(super) struct FaultyLidar {
    rng: Pcg64Mcg,
    /// The revolution at the begin of a freeze.
    frozen: Option<LidarData>,
    /// The last revolution before the lidar stopped, with its stamps.
    last: Option<LidarData>,
    /// Recent revolutions; only for a lidar with late ones.
    recent: RecentMeasurements<LidarData>,
}

impl FaultyLidar {
    /// Creates a lidar whose random faults the seed determines.
    pub fn new(seed: u64) -> Self {
        Self {
            rng: generator(seed, RngStream::Lidar),
            frozen: None,
            last: None,
            recent: RecentMeasurements::default(),
        }
    }

    /// Returns the revolution that a lidar sends when it measured this at a time, seconds; a scan without stamps is of the time
    /// `stamp_s`.
    pub fn sent(
        &mut self,
        faults: &[FaultInjection],
        time_s: f64,
        stamp_s: f64,
        measured: LidarData,
    ) -> LidarData {
        let late_s = |fault: &FaultInjection| match fault {
            FaultInjection::Lidar { change: LidarChange::Late(late_s), .. } => Some(*late_s),
            _ => None,
        };
        let stamped_now = || stamped(&measured, stamp_s);
        let arriving = self.recent.arriving(faults, time_s, late_s, stamped_now);
        let mut sent = arriving.unwrap_or(measured);
        let (mut is_frozen, mut is_stopped) = (false, false);
        for fault in active_faults(faults, time_s) {
            match fault {
                FaultInjection::LidarFrozen { .. } => {
                    is_frozen = true;
                    sent = repeated(self.frozen.get_or_insert_with(|| sent.clone()), sent);
                }
                FaultInjection::ClockJump { by_s, .. } => shift_stamps(&mut sent, *by_s),
                FaultInjection::Lidar { change: LidarChange::Stopped, .. } => {
                    is_stopped = true;
                    sent = self.last.get_or_insert_with(|| stamped(&sent, stamp_s)).clone();
                }
                FaultInjection::Lidar { change: LidarChange::Ahead(by_s), .. } => {
                    sent = stamped(&sent, stamp_s);
                    shift_stamps(&mut sent, *by_s);
                }
                FaultInjection::Lidar { change, .. } => self.change(&mut sent, *change),
                _ => {}
            }
        }
        self.frozen = self.frozen.take().filter(|_| is_frozen);
        self.last = self.last.take().filter(|_| is_stopped);
        sent
    }

    /// Changes the beams of a revolution.
    fn change(&mut self, data: &mut LidarData, change: LidarChange) {
        match change {
            LidarChange::Dropout(share) => data.ranges_mut().for_each(|range| {
                if self.rng.random::<f64>() < share {
                    *range = f64::NAN;
                }
            }),
            LidarChange::Ghosts(share) => data.ranges_mut().for_each(|range| {
                let (is_dust, part) = (self.rng.random::<f64>() < share, self.rng.random::<f64>());
                if is_dust && range.is_finite() {
                    *range *= part;
                }
            }),
            LidarChange::Negative => data.ranges_mut().for_each(|range| *range = -*range),
            LidarChange::Empty => match data {
                LidarData::Scan(scan) => scan.ranges.clear(),
                LidarData::TimedScan(scan) => scan.beams.clear(),
            },
            LidarChange::EveryNth(count) => match data {
                LidarData::Scan(scan) => {
                    scan.angle_increment *= count as f64;
                    scan.ranges = scan.ranges.iter().step_by(count).copied().collect();
                }
                LidarData::TimedScan(scan) => {
                    scan.beams = scan.beams.iter().step_by(count).copied().collect();
                }
            },
            LidarChange::AngleScale(ratio) => match data {
                LidarData::Scan(scan) => {
                    scan.angle_min *= ratio;
                    scan.angle_increment *= ratio;
                }
                LidarData::TimedScan(scan) => {
                    scan.beams.iter_mut().for_each(|beam| beam.angle *= ratio);
                }
            },
            // The revolution that arrives is late already; the others replace it or its stamps.
            LidarChange::Late(_) | LidarChange::Ahead(_) | LidarChange::Stopped => {}
        }
    }
}

/// The beams with their times; those of a scan without times have this one, seconds.
fn stamped(data: &LidarData, stamp_s: f64) -> LidarData {
    LidarData::TimedScan(data.timed(stamp_s).into_owned())
}

/// A scan without stamps has those of the odometry, which jump too.
fn shift_stamps(data: &mut LidarData, by_s: f64) {
    if let LidarData::TimedScan(scan) = data {
        scan.beams.iter_mut().for_each(|beam| beam.time_s += by_s);
    }
}

/// The ranges of a kept revolution with the stamps of a new one.
fn repeated(kept: &LidarData, measured: LidarData) -> LidarData {
    match (kept, measured) {
        (LidarData::TimedScan(kept), LidarData::TimedScan(mut sent)) => {
            for (sent, kept) in sent.beams.iter_mut().zip(&kept.beams) {
                (sent.angle, sent.range) = (kept.angle, kept.range);
            }
            LidarData::TimedScan(sent)
        }
        (kept, _) => kept.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::Scan;

    #[test]
    fn late_revolutions_have_the_changes_listed_before_and_after() {
        let (from_s, to_s) = (0.0, f64::INFINITY);
        let fault = |change| FaultInjection::Lidar { from_s, to_s, change };
        let changes = [LidarChange::Negative, LidarChange::Late(0.5), LidarChange::EveryNth(2)];
        let (faults, mut lidar) = (changes.map(fault), FaultyLidar::new(0));
        for tick in 0..20 {
            let time_s = 0.25 * f64::from(tick);
            let scan = Scan { ranges: vec![1.0 + time_s; 4], ..Scan::default() };
            let sent = lidar.sent(&faults, time_s, time_s, LidarData::Scan(scan));
            let LidarData::TimedScan(sent) = sent else { panic!("late scans have stamps") };
            let measured_s = (time_s - 0.5).max(0.0);
            let beams: Vec<(f64, f64)> =
                sent.beams.iter().map(|beam| (beam.time_s, beam.range)).collect();
            assert_eq!(beams, [(measured_s, -1.0 - measured_s); 2], "at {time_s}");
        }
    }
}
