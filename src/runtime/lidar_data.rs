//! The lidar data of one tick, with or without a time for each beam.

use std::borrow::Cow;

use crate::geometry::Pose;
use crate::localization::{DeskewedScan, PoseHistory};
use crate::map::{Scan, TimedScan};

/// Lidar data of one tick.
#[derive(Clone, Debug, PartialEq)]
pub enum LidarData {
    /// All beams of one instant, that of the odometry.
    Scan(Scan),
    /// Beams that were measured one after the other. The same revolution may be delivered again; it is empty before the first.
    TimedScan(TimedScan),
}

impl LidarData {
    /// The ranges as measured, metres, in the order of the beams.
    #[must_use]
    pub fn ranges(&self) -> impl ExactSizeIterator<Item = f64> {
        let count = match self {
            Self::Scan(scan) => scan.ranges.len(),
            Self::TimedScan(scan) => scan.beams.len(),
        };
        (0..count).map(|beam| match self {
            Self::Scan(scan) => scan.ranges[beam],
            Self::TimedScan(scan) => scan.beams[beam].range,
        })
    }

    /// The ranges, metres, in the order of the beams.
    pub fn ranges_mut(&mut self) -> impl Iterator<Item = &mut f64> {
        let (ranges, beams) = match self {
            Self::Scan(scan) => (scan.ranges.as_mut_slice(), Default::default()),
            Self::TimedScan(scan) => (Default::default(), scan.beams.as_mut_slice()),
        };
        ranges.iter_mut().chain(beams.iter_mut().map(|beam| &mut beam.range))
    }

    /// Converts the data from the frame of a lidar to the robot's frame; `mount` is the pose of the lidar there.
    #[must_use]
    pub fn from_mount(self, mount: &Pose) -> Self {
        match self {
            Self::Scan(scan) => Self::Scan(scan.from_mount(mount)),
            Self::TimedScan(scan) => Self::TimedScan(scan.from_mount(mount)),
        }
    }

    /// Time of the newest beam, seconds, given that of the odometry; none before the first revolution.
    #[must_use]
    pub fn end_s(&self, odometry_s: f64) -> Option<f64> {
        match self {
            Self::Scan(_) => Some(odometry_s),
            Self::TimedScan(scan) => scan.end_s(),
        }
    }

    /// Returns the beams with their times, given that of the odometry, seconds.
    #[must_use]
    pub fn timed(&self, odometry_s: f64) -> Cow<'_, TimedScan> {
        match self {
            Self::Scan(scan) => Cow::Owned(TimedScan::from_scan(scan, odometry_s, 0.0)),
            Self::TimedScan(scan) => Cow::Borrowed(scan),
        }
    }
}

/// The scan of each tick as seen from the newest odometry, in the robot's frame.
#[derive(Clone, Debug)]
pub(crate) struct CompensatedScan {
    odometry: PoseHistory,
    deskewed: DeskewedScan,
}

impl CompensatedScan {
    pub fn new() -> Self {
        Self { odometry: PoseHistory::new(), deskewed: DeskewedScan::default() }
    }

    /// Takes the data of a tick: the lidar's, and the odometry's pose with its time, seconds.
    pub fn update(
        &mut self,
        (odometry_s, odometry): (f64, &Pose),
        lidar: Option<LidarData>,
    ) -> Scan {
        self.odometry.record(odometry_s, odometry);
        match lidar {
            Some(LidarData::Scan(scan)) => scan,
            Some(LidarData::TimedScan(sweep)) => {
                self.deskewed.deskew(&sweep, &self.odometry);
                self.deskewed.to_scan(sweep.beams.len())
            }
            None => Scan::default(),
        }
    }
}
