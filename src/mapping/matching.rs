//! Matching of a scan to surface points, with a check of the result.

use nalgebra::Matrix3;

use super::surfels::SurfelMap;
use crate::geometry::Pose;
use crate::localization::{DeskewedScan, LocalizationSettings, ScanMatcher, Surfaces};

/// A beam end within this distance of a surface agrees with it, metres.
const AGREES_M: f64 = 0.1;
/// A match needs this fraction of the beam ends near surfaces, and this fraction of those in agreement.
const MIN_OVERLAP: f64 = 0.3;
const MIN_AGREEMENT: f64 = 0.7;
/// A place that the odometry does not predict needs this fraction of the beam ends near surfaces.
const CERTAIN_OVERLAP: f64 = 0.5;
/// Smallest number of beam ends near surfaces.
const MIN_ENDS: usize = 20;

/// A matched scan in the frame of the surfaces.
#[derive(Clone, Copy, Debug)]
pub(super) struct Match {
    pub pose: Pose,
    /// Information of the beams on x, y and yaw.
    pub information: Matrix3<f64>,
    unobservable_directions: u8,
    /// Beam ends, those near surfaces, and those that agree with them.
    ends: usize,
    near: usize,
    agreeing: usize,
}

impl Match {
    /// Whether enough beams agree with the surfaces.
    pub fn is_good(&self) -> bool {
        self.overlaps(MIN_OVERLAP)
            && self.near >= MIN_ENDS
            && self.agreeing as f64 >= MIN_AGREEMENT * self.near as f64
    }

    /// Whether the beams determine the pose, and enough of them agree with the surfaces, so that the odometry does not count.
    pub fn is_certain(&self) -> bool {
        self.is_good() && self.overlaps(CERTAIN_OVERLAP) && self.unobservable_directions == 0
    }

    /// Whether at least this fraction of the beam ends is near surfaces.
    fn overlaps(&self, fraction: f64) -> bool {
        self.near as f64 >= fraction * self.ends as f64
    }
}

/// Matches a scan, beginning at a pose, with the information of a prior pose.
pub(super) fn match_scan(
    map: &SurfelMap,
    scan: &DeskewedScan,
    begin: Pose,
    prior: &Pose,
    prior_information: &Matrix3<f64>,
) -> Match {
    let settings = LocalizationSettings::default();
    let matcher = ScanMatcher { map, scan, settings: &settings };
    let matched = matcher.match_scan_from(begin, prior, prior_information, AGREES_M);
    let pose = matched.pose;
    let (sin, cos) = libm::sincos(pose.yaw);
    let (mut near, mut agreeing) = (0, 0);
    for hit in &scan.hits {
        let (x, y) = (cos * hit.end.x - sin * hit.end.y, sin * hit.end.x + cos * hit.end.y);
        if let Some(sample) = map.sample(pose.x + x, pose.y + y, (x, y)) {
            near += 1;
            agreeing += usize::from(sample.distance_m.abs() < AGREES_M);
        }
    }
    Match {
        pose,
        information: matched.information,
        unobservable_directions: matched.unobservable_directions,
        ends: scan.hits.len(),
        near,
        agreeing,
    }
}
