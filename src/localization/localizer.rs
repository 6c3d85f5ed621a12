//! The localizer: fuses odometry with matched scans.

mod continuation;
mod motion;
mod search;

use nalgebra::Matrix3;

use super::agreement::walled_fraction;
use super::change_detector::ChangeDetector;
use super::map_scores::MapScores;
use super::motion_check::MotionCheck;
use super::pose_filters::{OdometryNoise, PoseEkf, offset};
use super::scan_matcher::{ScanMatch, ScanMatcher};
use super::signed_distance_field::SignedDistanceField;
use super::{
    Agreement, DeskewedScan, LocalizationError, LocalizationSettings, LocalizationStatus,
    LostReason, MapChanges, PoseEstimate, PoseHistory,
};
use crate::geometry::{Pose, wrap_angle};
use crate::map::{ObstacleGrid, OccupancyGrid, TimedScan};
use motion::{MOVED_M, MOVED_RAD};
use search::{Searches, is_vague};

/// A correction by more than this many standard deviations, squared, is a jump. It occurs by chance once in a million
/// revolutions (chi-square distribution with three degrees of freedom).
const MAX_CORRECTION_SIGMAS2: f64 = 30.0;

/// Where walls were taken away, beams may pass through this share of as many mapped walls as agree.
const WALLS_SHARE: f64 = 0.5;

/// If the map has surfaces in a larger fraction of all directions than this, a lidar with few returns is occluded.
const MIN_WALLED_FRACTION: f64 = 0.3;

/// A robot is still at a place if this fraction of the beams agrees there.
const SAME_PLACE_AGREEMENT: f64 = 0.85;

/// Distance by odometry after which a relocalised pose is confirmed, metres. Until then, this many rejected revolutions lose it.
const CONFIRMED_M: f64 = 1.0;
const REJECTIONS_BEFORE: u32 = 2;

/// A jump shows that the filter was too sure of the pose, unless the robot was found just before: standard deviations that are
/// added, metres and radians.
const JUMP_SIGMA_M: f64 = 0.03;
const JUMP_SIGMA_RAD: f64 = 0.03;

/// A robot that was found and lost this many times at the same place is not found again.
const MAX_FOUND: u32 = 2;
/// The same place, and the distance driven on from it that makes earlier losses irrelevant, metres.
const SAME_PLACE_M: f64 = 1.0;
const DRIVEN_ON_M: f64 = 3.0;

/// The stamps of lidar and odometry differ by this at sparse scans, seconds (our choice).
const STAMPS_DIFFER_S: f64 = 0.15;

/// The last accepted revolution.
#[derive(Clone, Copy, Debug)]
struct Anchor {
    odometry: Pose,
    matched: Pose,
    agreement: f64,
}

/// The place at which the robot was found, in the grid's frame, and how often it was lost there after it drove.
#[derive(Clone, Copy, Debug)]
struct FoundPlace {
    pose: Pose,
    odometry: Pose,
    losses: u32,
}

fn distance_m(one: &Pose, other: &Pose) -> f64 {
    (one.position() - other.position()).norm()
}

fn has_moved(from: &Pose, to: &Pose, by_m: f64, by_rad: f64) -> bool {
    distance_m(from, to) > by_m || wrap_angle(to.yaw - from.yaw).abs() > by_rad
}

/// Tracks a robot on a map.
#[derive(Clone, Debug)]
pub struct Localizer {
    map: SignedDistanceField,
    /// The map of which the changes are reported, if the scans are matched to another one.
    original: Option<SignedDistanceField>,
    settings: LocalizationSettings,
    ekf: PoseEkf,
    /// The newest pose by odometry.
    odometry: Option<(f64, Pose)>,
    /// Odometry with its learned scales. Raw odometry of tracks with an uncalibrated width would distort a revolution that is
    /// measured while the robot turns.
    history: PoseHistory,
    scan: DeskewedScan,
    /// Number of rejected minus accepted revolutions, at least zero.
    rejections: u32,
    /// While relocalising: the number of consecutive revolutions that match the candidate pose.
    confirmations: Option<u32>,
    searches: Searches,
    /// Why the robot was lost at first. The status names what the searches found since.
    lost_by: Option<LostReason>,
    changes: ChangeDetector,
    anchor: Option<Anchor>,
    motion_check: MotionCheck,
    found: Option<FoundPlace>,
    /// Whether most beams agreed at a pose that no search has found since.
    is_proven: bool,
    /// Whether the robot is not searched again: it was lost too often at the same place, or odometry or lidar are set up wrong.
    has_given_up: bool,
    /// Whether a search precedes the scan matcher.
    has_sparse_scans: bool,
    /// Motion within the difference of the stamps at the last scan, metres and radians.
    stamp_noise: [f64; 2],
    estimate: PoseEstimate,
}

impl Localizer {
    /// Creates a localizer at a start pose with the initial uncertainty of the settings.
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
            changes: ChangeDetector::new(&map),
            map,
            original: None,
            settings,
            ekf,
            odometry: None,
            history: PoseHistory::new(),
            scan: DeskewedScan::default(),
            rejections: 0,
            confirmations: None,
            searches: Searches::default(),
            lost_by: None,
            anchor: None,
            motion_check: MotionCheck::default(),
            found: None,
            is_proven: false,
            has_given_up: false,
            has_sparse_scans: false,
            stamp_noise: [0.0; 2],
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

    /// Creates a localizer that does not know the pose: it is lost until it has found the one place of the map that matches.
    ///
    /// # Errors
    /// Returns an error if a setting is out of range.
    pub fn without_pose(
        map: &ObstacleGrid,
        settings: LocalizationSettings,
    ) -> Result<Self, LocalizationError> {
        let mut localizer = Self::new(map, settings, &map.frame().origin)?;
        localizer.lose(LostReason::NoPose);
        localizer.searches.scores = Some(MapScores::new(&localizer.map));
        Ok(localizer)
    }

    /// Returns the localizer for scans that are a metre or half a radian apart and for odometry of wheels without a gyro. The
    /// predicted pose is less certain, and each scan is first matched by a search around it.
    #[must_use]
    pub const fn with_sparse_scans(mut self) -> Self {
        self.ekf.noise = OdometryNoise::WHEELS;
        self.has_sparse_scans = true;
        self
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

    /// What the scans have contradicted for minutes in the map of the localizer's creation, which must be given.
    ///
    /// # Panics
    /// Panics if the map has fewer cells.
    #[must_use]
    pub fn map_changes(&self, map: &OccupancyGrid) -> MapChanges {
        let original = self.original.as_ref().unwrap_or(&self.map);
        MapChanges::of(map, &self.changes.changed(original))
    }

    /// Predicts the pose from odometry: a pose in the odometry frame at a time, seconds. The first call only sets the
    /// reference. Values that are not finite are ignored.
    pub fn predict(&mut self, time_s: f64, odometry: &Pose) {
        if !(time_s.is_finite() && odometry.is_finite()) {
            return;
        }
        let mut corrected = *odometry;
        if let Some((previous_s, previous)) = self.odometry.replace((time_s, *odometry)) {
            let elapsed_s = (time_s - previous_s).max(0.0);
            self.ekf.predict(&previous, odometry, elapsed_s, &self.settings);
            let (distance, turn) = self.ekf.odometry_scale();
            let step = previous.inverse_transform_pose(odometry);
            let before = self.history.newest().map_or(previous, |(_, pose)| pose);
            let step = Pose::new(distance * step.x, distance * step.y, turn * wrap_angle(step.yaw));
            corrected = before.transform_pose(&step);
        }
        self.history.record(time_s, &corrected);
        self.estimate.time_s = time_s;
        self.update_estimate();
        if self.estimate.is_unknown(&self.settings) && self.estimate.status.lost_reason().is_none()
        {
            self.lose(LostReason::HighUncertainty);
        }
    }

    /// Matches a revolution to the map and returns the estimate at the time of the latest odometry. Each revolution is passed
    /// once; its beams lie within the second before that time.
    pub fn update(&mut self, scan: &TimedScan) -> &PoseEstimate {
        self.scan.deskew(scan, &self.history);
        self.scan.mark_narrow_objects();
        if self.has_given_up {
            return &self.estimate;
        }
        if self.has_sparse_scans {
            self.add_stamp_noise();
        }
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
        let prior = self.ekf.pose;
        let matched = self.match_predicted(&covariance, &prior_information);
        self.estimate.agreement = self.matcher().agreement(&matched.pose);
        self.estimate.rms_m = matched.rms_m;
        self.estimate.unobservable_directions = matched.unobservable_directions;
        self.estimate.iterations = matched.iterations;
        if let Some(reason) = self.rejection(&matched, &prior, &prior_information) {
            if self.is_at_anchor(&prior) {
                return self.lose_without_motion();
            }
            return self.reject(reason);
        }
        self.ekf.correct(&matched.pose, &matched.information);
        self.update_estimate();
        let odometry = self.odometry();
        let pose = self.ekf.pose;
        if is_vague(&covariance) {
            // The correction is no motion.
            self.motion_check.clear();
        }
        if self.motion_check.is_stuck(self.scan.time_s, &odometry, &pose) {
            return self.lose_without_motion();
        }
        if let Some(reason) = self.wrong_setup(&odometry, &pose) {
            self.has_given_up = true;
            return self.lose(reason);
        }
        let agreement = self.estimate.agreement.matching_fraction();
        self.anchor = Some(Anchor { odometry, matched: pose, agreement });
        let is_found = self.found.is_some() || self.confirmations.is_some();
        self.is_proven |= !is_found && agreement >= SAME_PLACE_AGREEMENT;
        if self.confirmations.is_none() && self.is_better_elsewhere() {
            return self.lose(LostReason::BetterElsewhere);
        }
        self.accept();
    }

    /// Adds the motion within the difference of the stamps at this scan and the one before.
    fn add_stamp_noise(&mut self) {
        let moved = self.history.motion_within(STAMPS_DIFFER_S);
        let last = core::mem::replace(&mut self.stamp_noise, moved);
        self.ekf.widen(moved[0].max(last[0]), moved[1].max(last[1]));
    }

    /// The newest pose by odometry.
    fn odometry(&self) -> Pose {
        self.odometry.map_or_else(Pose::default, |(_, pose)| pose)
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
        let through_walls = agreement.through_walls_fraction();
        if through_walls
            > settings.max_through_walls.max(WALLS_SHARE * agreement.matching_fraction())
        {
            return Some(LostReason::BeamsThroughWalls);
        }
        let min_agreement = match (self.confirmations, &self.searches.of_lost) {
            // The pose is the predicted one, which no search compared with other places.
            (Some(_), None) => settings.relocalized_agreement.max(SAME_PLACE_AGREEMENT),
            (Some(_), Some(_)) => settings.relocalized_agreement,
            (None, _) if self.is_unconfirmed() => settings.relocalized_agreement,
            (None, _) => settings.min_agreement,
        };
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
                self.searches.of_lost = None;
                self.estimate.status = LocalizationStatus::Lost(reason);
            }
        } else if self.rejections >= self.max_rejections() {
            self.lose(reason);
        } else {
            self.estimate.status = LocalizationStatus::Uncertain;
        }
    }

    /// Whether the robot was relocalised and has not yet driven far enough to confirm it.
    fn is_unconfirmed(&self) -> bool {
        let odometry = self.odometry();
        let is_near = |found: &FoundPlace| distance_m(&found.odometry, &odometry) < CONFIRMED_M;
        self.found.as_ref().is_some_and(is_near)
    }

    fn max_rejections(&self) -> u32 {
        let most = self.settings.lost_after_scans;
        if self.is_unconfirmed() { most.min(REJECTIONS_BEFORE) } else { most }
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
            self.searches.confirm();
            self.motion_check.clear();
            let (pose, odometry) = (self.ekf.pose, self.odometry());
            let before = self.found.filter(|found| distance_m(&found.pose, &pose) < SAME_PLACE_M);
            let losses = before.map_or(0, |found| found.losses);
            self.found = Some(FoundPlace { pose, odometry, losses });
        } else if self.found.is_some_and(|it| distance_m(&it.pose, &self.ekf.pose) > DRIVEN_ON_M) {
            self.found = None;
        }
        let Self { settings, estimate, .. } = &*self;
        let is_certain = estimate.sigma_m() <= settings.uncertain_sigma_m
            && estimate.sigma_rad() <= settings.uncertain_sigma_rad;
        self.estimate.status = if self.rejections == 0 && is_certain {
            LocalizationStatus::Tracking
        } else {
            LocalizationStatus::Uncertain
        };
        if self.estimate.status == LocalizationStatus::Tracking {
            let near_m = self.settings.outlier_distance_m + 0.5 * self.map.frame.resolution_m;
            let original = self.original.as_ref().unwrap_or(&self.map);
            self.changes.update(original, &self.scan, &self.ekf.pose, near_m);
        }
    }

    fn lose(&mut self, reason: LostReason) {
        self.confirmations = None;
        self.searches.stop();
        self.motion_check.clear();
        if reason == LostReason::PoseJump && !self.is_unconfirmed() {
            self.ekf.widen(JUMP_SIGMA_M, JUMP_SIGMA_RAD);
        }
        let (pose, odometry) = (self.ekf.pose, self.odometry());
        let is_same_place = |found: &FoundPlace| distance_m(&found.pose, &pose) < SAME_PLACE_M;
        let mut reason = reason;
        match self.found.as_mut().filter(|found| is_same_place(found)) {
            Some(found) if has_moved(&found.odometry, &odometry, MOVED_M, MOVED_RAD) => {
                found.losses += 1;
                if found.losses >= MAX_FOUND {
                    if !self.has_given_up && reason != LostReason::NotMoving {
                        reason = LostReason::LostAgain;
                    }
                    self.has_given_up = true;
                }
            }
            _ => {}
        }
        self.lost_by = Some(reason);
        self.estimate.status = LocalizationStatus::Lost(reason);
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
