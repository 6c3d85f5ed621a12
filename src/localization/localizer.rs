//! The localiser: fuses odometry with matched scans.

use nalgebra::Matrix3;

use super::agreement::walled_fraction;
use super::pose_filters::{PoseEkf, offset};
use super::scan_matcher::{ScanMatch, ScanMatcher};
use super::signed_distance_field::SignedDistanceField;
use super::{
    Agreement, DeskewedScan, LocalizationError, LocalizationSettings, LocalizationStatus,
    LostReason, PoseEstimate, PoseHistory,
};
use crate::geometry::Pose;
use crate::map::{ObstacleGrid, TimedScan};

/// A correction by more than this many standard deviations, squared, is a jump. It occurs by chance once in a million
/// revolutions (chi-square distribution with three degrees of freedom).
const MAX_CORRECTION_SIGMAS2: f64 = 30.0;

/// If the map has surfaces in a larger fraction of all directions than this, a lidar with few returns is occluded.
const MIN_WALLED_FRACTION: f64 = 0.3;

/// Tracks a robot on a map.
#[derive(Clone, Debug)]
pub struct Localizer {
    map: SignedDistanceField,
    settings: LocalizationSettings,
    ekf: PoseEkf,
    history: PoseHistory,
    scan: DeskewedScan,
    /// Number of rejected minus accepted revolutions, at least zero.
    rejections: u32,
    /// While relocalising: the number of consecutive revolutions that match the candidate pose.
    confirmations: Option<u32>,
    estimate: PoseEstimate,
}

impl Localizer {
    /// Creates a localiser at a start pose with the initial uncertainty of the settings.
    ///
    /// # Errors
    /// Returns an error if a setting is out of range or the pose is not finite.
    pub fn new(
        map: &ObstacleGrid,
        settings: LocalizationSettings,
        start: &Pose,
    ) -> Result<Self, LocalizationError> {
        settings.validate()?;
        if !start.is_finite() {
            let Pose { x, y, yaw } = *start;
            return Err(LocalizationError::BadStart { x, y, yaw });
        }
        let map = SignedDistanceField::new(map);
        let ekf = PoseEkf::new(map.to_grid(start), &settings);
        let mut localizer = Self {
            map,
            settings,
            ekf,
            history: PoseHistory::new(),
            scan: DeskewedScan::default(),
            rejections: 0,
            confirmations: None,
            estimate: PoseEstimate {
                time_s: 0.0,
                pose: *start,
                covariance: [[0.0; 3]; 3],
                agreement: Agreement::default(),
                rms_m: 0.0,
                unobservable_directions: 3,
                iterations: 0,
                status: LocalizationStatus::Uncertain,
            },
        };
        localizer.update_estimate();
        Ok(localizer)
    }

    /// The latest estimate: of the last revolution, predicted by the odometry since.
    #[must_use]
    pub const fn estimate(&self) -> &PoseEstimate {
        &self.estimate
    }

    /// The latest pose in the map frame.
    #[must_use]
    pub const fn pose(&self) -> &Pose {
        &self.estimate.pose
    }

    /// The last revolution, relative to the pose at its time.
    #[must_use]
    pub const fn scan(&self) -> &DeskewedScan {
        &self.scan
    }

    /// Learned scale factors of odometry's distances and turns; below one for slipping tracks.
    #[must_use]
    pub const fn odometry_scale(&self) -> (f64, f64) {
        self.ekf.odometry_scale()
    }

    /// Predicts the pose from odometry: a pose in the odometry frame at a time, seconds. The first call only sets the
    /// reference. Values that are not finite are ignored.
    pub fn predict(&mut self, time_s: f64, odometry: &Pose) {
        if !(time_s.is_finite() && odometry.is_finite()) {
            return;
        }
        if let Some((previous_s, previous)) = self.history.newest() {
            let elapsed_s = (time_s - previous_s).max(0.0);
            self.ekf.predict(&previous, odometry, elapsed_s, &self.settings);
        }
        self.history.record(time_s, odometry);
        self.estimate.time_s = time_s;
        self.update_estimate();
        let Self { settings, estimate, .. } = &*self;
        let is_unknown = estimate.sigma_m() > settings.lost_sigma_m
            || estimate.sigma_rad() > settings.lost_sigma_rad;
        if is_unknown && self.estimate.status.lost_reason().is_none() {
            self.lose(LostReason::HighUncertainty);
        }
    }

    /// Matches a revolution to the map and returns the estimate at the time of the latest odometry. Each revolution is passed
    /// once; its beams lie within the second before that time.
    pub fn update(&mut self, scan: &TimedScan) -> &PoseEstimate {
        self.scan.deskew(scan, &self.history);
        if self.estimate.status.lost_reason().is_some() && self.confirmations.is_none() {
            self.relocalize();
        } else {
            self.track();
        }
        self.update_estimate();
        &self.estimate
    }

    const fn matcher(&self) -> ScanMatcher<'_> {
        ScanMatcher { map: &self.map, scan: &self.scan, settings: &self.settings }
    }

    /// Corrects the pose by the scan, unless the scan contradicts it.
    fn track(&mut self) {
        let covariance = self.ekf.pose_covariance();
        let Some(prior_information) = covariance.try_inverse() else {
            return self.lose(LostReason::HighUncertainty);
        };
        let sigma_m = covariance[(0, 0)].max(covariance[(1, 1)]).sqrt();
        let prior = self.ekf.pose;
        let matched = self.matcher().match_scan(&prior, &prior_information, sigma_m);
        self.estimate.agreement = self.matcher().agreement(&matched.pose);
        self.estimate.rms_m = matched.rms_m;
        self.estimate.unobservable_directions = matched.unobservable_directions;
        self.estimate.iterations = matched.iterations;
        if let Some(reason) = self.rejection(&matched, &prior, &prior_information) {
            return self.reject(reason);
        }
        self.ekf.correct(&matched.pose, &matched.information);
        self.update_estimate();
        self.accept();
    }

    /// Why the scan contradicts the matched pose, if it does.
    fn rejection(
        &self,
        matched: &ScanMatch,
        prior: &Pose,
        prior_information: &Matrix3<f64>,
    ) -> Option<LostReason> {
        let Self { settings, scan, .. } = self;
        let agreement = &self.estimate.agreement;
        let expects_returns =
            || walled_fraction(&self.map, &matched.pose, scan.range_max) > MIN_WALLED_FRACTION;
        if scan.hits.len() < settings.min_returns {
            // In open terrain, a scan without returns is consistent with the map.
            return expects_returns().then_some(LostReason::NoReturns);
        }
        if agreement.through_walls_fraction() > settings.max_through_walls {
            return Some(LostReason::BeamsThroughWalls);
        }
        let is_candidate = self.confirmations.is_some();
        let min_agreement =
            if is_candidate { settings.relocalized_agreement } else { settings.min_agreement };
        if agreement.matching_fraction() < min_agreement {
            return Some(LostReason::PoorMatch);
        }
        let correction = offset(prior, &matched.pose);
        ((correction.transpose() * prior_information * correction)[0] > MAX_CORRECTION_SIGMAS2)
            .then_some(LostReason::PoseJump)
    }

    fn reject(&mut self, reason: LostReason) {
        self.rejections += 1;
        let is_candidate = self.confirmations.take().is_some();
        if self.estimate.status.lost_reason().is_some() {
            if is_candidate {
                self.estimate.status = LocalizationStatus::Lost(reason);
            }
        } else if self.rejections >= self.settings.lost_after_scans {
            self.lose(reason);
        } else {
            self.estimate.status = LocalizationStatus::Uncertain;
        }
    }

    fn accept(&mut self) {
        self.rejections = self.rejections.saturating_sub(1);
        if let Some(confirmations) = &mut self.confirmations {
            *confirmations += 1;
            if *confirmations < self.settings.relocalized_after_scans {
                return;
            }
            self.confirmations = None;
            self.rejections = 0;
        }
        let Self { settings, estimate, .. } = &*self;
        let is_certain = estimate.sigma_m() <= settings.uncertain_sigma_m
            && estimate.sigma_rad() <= settings.uncertain_sigma_rad;
        self.estimate.status = if self.rejections == 0 && is_certain {
            LocalizationStatus::Tracking
        } else {
            LocalizationStatus::Uncertain
        };
    }

    fn lose(&mut self, reason: LostReason) {
        self.estimate.status = LocalizationStatus::Lost(reason);
        self.confirmations = None;
    }

    /// Searches for the pose of a lost robot. The next revolutions must confirm a candidate.
    fn relocalize(&mut self) {
        if self.scan.hits.len() < self.settings.min_returns {
            return;
        }
        if let Some(pose) = self.matcher().relocalize(&self.ekf.pose) {
            self.ekf = self.ekf.reset_pose(pose, &self.settings);
            self.confirmations = Some(0);
            self.track();
        }
    }

    /// Converts the filter's pose and covariance to the map frame.
    fn update_estimate(&mut self) {
        self.estimate.pose = self.map.to_map(&self.ekf.pose);
        let (sin, cos) = libm::sincos(self.map.frame.origin.yaw);
        let turn = Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0);
        let covariance = turn * self.ekf.pose_covariance() * turn.transpose();
        // An array of nalgebra holds the columns.
        self.estimate.covariance = covariance.transpose().into();
    }
}
