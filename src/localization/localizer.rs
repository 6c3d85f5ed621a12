//! The localiser: odometry in, revolutions in, the pose and its worth out.

use nalgebra::Matrix3;

use super::agreement::walled_share;
use super::pose_ekf::PoseEkf;
use super::relocalization;
use super::scan_matcher::{Matched, matched, tolerance_m};
use super::signed_distance_field::SignedDistanceField;
use super::{
    Agreement, DeskewedScan, LocalizationError, LocalizationSettings, LocalizationStatus,
    LostReason, PoseEstimate, PoseHistory,
};
use crate::geometry::Pose;
use crate::map::{ObstacleGrid, TimedScan};

/// A pose that the map wants farther from odometry's than this many standard deviations, squared, is a jump: by chance once in
/// a million revolutions (chi-square of three).
const JUMP_SIGMAS2: f64 = 30.0;

/// Where the map has walls in a larger share of all directions than this, a lidar that sees hardly any is blind.
const WALLED: f64 = 0.3;

/// Follows a robot on a map.
#[derive(Clone, Debug)]
pub struct Localizer {
    walls: SignedDistanceField,
    settings: LocalizationSettings,
    ekf: PoseEkf,
    track: PoseHistory,
    view: DeskewedScan,
    /// Revolutions that speak against the pose, less those that do not.
    against: u32,
    /// Of a lost robot, the revolutions in a row that agree about another place.
    found: Option<u32>,
    estimate: PoseEstimate,
}

impl Localizer {
    /// A robot that stands at a pose of the map, about as well known as the settings say. Cells that the map's obstacles cover are
    /// walls.
    ///
    /// # Errors
    /// When a setting is out of range or the pose is not finite.
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
        let walls = SignedDistanceField::new(map);
        let ekf = PoseEkf::new(walls.in_grid(start), &settings);
        let mut localizer = Self {
            walls,
            settings,
            ekf,
            track: PoseHistory::new(),
            view: DeskewedScan::default(),
            against: 0,
            found: None,
            estimate: PoseEstimate {
                time_s: 0.0,
                pose: *start,
                covariance: Matrix3::zeros(),
                agreement: Agreement::default(),
                rms_m: 0.0,
                unobservable_directions: 3,
                iterations: 0,
                status: LocalizationStatus::Uncertain,
            },
        };
        localizer.note_pose();
        Ok(localizer)
    }

    /// The newest word: of the last revolution, with the pose moved on by the odometry since.
    #[must_use]
    pub const fn estimate(&self) -> &PoseEstimate {
        &self.estimate
    }

    /// Where the robot is, in the map frame.
    #[must_use]
    pub const fn pose(&self) -> &Pose {
        &self.estimate.pose
    }

    /// What the last revolution saw, as from the pose of then.
    #[must_use]
    pub const fn view(&self) -> &DeskewedScan {
        &self.view
    }

    /// By what odometry's ways and turns are multiplied, as learned so far: below one for tracks that slip.
    #[must_use]
    pub const fn odometry_scale(&self) -> (f64, f64) {
        self.ekf.factors()
    }

    /// Takes in where odometry has the robot at a time, seconds, in its own frame, wherever that began. The first reading only sets
    /// where it began; one that is not finite is passed over.
    pub fn predict(&mut self, time_s: f64, odometry: &Pose) {
        if !(time_s.is_finite() && odometry.is_finite()) {
            return;
        }
        if let Some((before_s, before)) = self.track.newest() {
            let elapsed_s = (time_s - before_s).max(0.0);
            self.ekf
                .predict(&before, odometry, elapsed_s, &self.settings);
        }
        self.track.record(time_s, odometry);
        self.estimate.time_s = time_s;
        self.note_pose();
        if self.is_unsure() && self.estimate.status.lost_reason().is_none() {
            self.lose(LostReason::HighUncertainty);
        }
    }

    /// Takes in a revolution, of which each is to be given once, and says where the robot is at the newest odometry's time. Its beams
    /// were measured within the second before that.
    pub fn update(&mut self, sweep: &TimedScan) -> &PoseEstimate {
        self.view.take(sweep, &self.track);
        if self.estimate.status.lost_reason().is_some() && self.found.is_none() {
            self.search();
        } else {
            self.follow();
        }
        self.note_pose();
        &self.estimate
    }

    /// Corrects the pose by the view, unless the view speaks against it.
    fn follow(&mut self) {
        let covariance = self.ekf.pose_covariance();
        let Some(certainty) = covariance.try_inverse() else {
            return self.lose(LostReason::HighUncertainty);
        };
        let sigma_m = covariance[(0, 0)].max(covariance[(1, 1)]).sqrt();
        let prior = self.ekf.pose;
        let there = matched(
            &self.walls,
            &self.view.hits,
            &prior,
            &certainty,
            sigma_m,
            &self.settings,
        );
        let tolerance_m = tolerance_m(&self.walls, &self.settings);
        self.estimate.agreement = Agreement::of(&self.walls, &self.view, &there.pose, tolerance_m);
        self.estimate.rms_m = there.rms_m;
        self.estimate.unobservable_directions = there.unobservable_directions;
        self.estimate.iterations = there.iterations;
        if let Some(why) = self.speaks_against(&there, &prior, &certainty) {
            return self.doubt(why);
        }
        self.ekf.correct(&there.pose, &there.information);
        self.note_pose();
        self.believe();
    }

    /// Why the view speaks against the pose that it was laid on the map at.
    fn speaks_against(
        &self,
        there: &Matched,
        prior: &Pose,
        certainty: &Matrix3<f64>,
    ) -> Option<LostReason> {
        let Self { settings, view, .. } = self;
        let agreement = &self.estimate.agreement;
        let expects_walls = || walled_share(&self.walls, &there.pose, view.range_max) > WALLED;
        if view.hits.len() < settings.min_returns {
            // In the open nothing is to be seen, and nothing speaks against it.
            return expects_walls().then_some(LostReason::NoReturns);
        }
        if agreement.through_walls_fraction() > settings.max_through_walls {
            return Some(LostReason::BeamsThroughWalls);
        }
        if agreement.matching_fraction() < self.least_agreement() {
            return Some(LostReason::PoorMatch);
        }
        let off = nalgebra::Vector3::new(
            there.pose.x - prior.x,
            there.pose.y - prior.y,
            crate::geometry::wrap_angle(there.pose.yaw - prior.yaw),
        );
        ((off.transpose() * certainty * off)[0] > JUMP_SIGMAS2).then_some(LostReason::PoseJump)
    }

    /// Of a robot that was lost more is asked.
    const fn least_agreement(&self) -> f64 {
        if self.found.is_some() {
            self.settings.relocalized_agreement
        } else {
            self.settings.min_agreement
        }
    }

    fn doubt(&mut self, why: LostReason) {
        self.against += 1;
        let is_candidate = self.found.take().is_some();
        if self.estimate.status.lost_reason().is_some() {
            if is_candidate {
                self.estimate.status = LocalizationStatus::Lost(why);
            }
        } else if self.against >= self.settings.lost_after_scans {
            self.lose(why);
        } else {
            self.estimate.status = LocalizationStatus::Uncertain;
        }
    }

    fn believe(&mut self) {
        self.against = self.against.saturating_sub(1);
        if let Some(found) = &mut self.found {
            *found += 1;
            if *found < self.settings.relocalized_after_scans {
                return;
            }
            self.found = None;
            self.against = 0;
        }
        self.estimate.status = if self.against == 0 && !self.is_uncertain() {
            LocalizationStatus::Tracking
        } else {
            LocalizationStatus::Uncertain
        };
    }

    fn lose(&mut self, why: LostReason) {
        self.estimate.status = LocalizationStatus::Lost(why);
        self.found = None;
    }

    /// Looks for a lost robot. What is found has to hold in the next revolutions.
    fn search(&mut self) {
        let Self { settings, view, .. } = self;
        if view.hits.len() < settings.min_returns {
            return;
        }
        let found = relocalization::find(&self.walls, view, &self.ekf.pose, settings);
        if let Some(pose) = found {
            self.ekf = self.ekf.reset_pose(pose, &self.settings);
            self.found = Some(0);
            self.follow();
        }
    }

    fn is_uncertain(&self) -> bool {
        self.estimate.sigma_m() > self.settings.uncertain_sigma_m
            || self.estimate.sigma_rad() > self.settings.uncertain_sigma_rad
    }

    fn is_unsure(&self) -> bool {
        self.estimate.sigma_m() > self.settings.lost_sigma_m
            || self.estimate.sigma_rad() > self.settings.lost_sigma_rad
    }

    /// Brings the belief into the map frame.
    fn note_pose(&mut self) {
        self.estimate.pose = self.walls.in_map(&self.ekf.pose);
        let (sin, cos) = libm::sincos(self.walls.grid_yaw());
        let turn = Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0);
        self.estimate.covariance = turn * self.ekf.pose_covariance() * turn.transpose();
    }
}
