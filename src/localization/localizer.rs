//! The localiser: odometry in, revolutions in, the pose and its worth out.

use nalgebra::Matrix3;

use super::agreement::walled_share;
use super::belief::Belief;
use super::matching::{Matched, matched, tolerance_m};
use super::search;
use super::walls::Walls;
use super::{
    Agreement, Fix, LocalizationError, LocalizationSettings, Lost, PoseTrack, State, View,
};
use crate::geometry::Pose;
use crate::map::{ObstacleGrid, Sweep};

/// A pose that the map wants farther from odometry's than this many standard deviations, squared, is a jump: by chance once in
/// a million revolutions (chi-square of three).
const JUMP_SIGMAS2: f64 = 30.0;

/// Where the map has walls in a larger share of all directions than this, a lidar that sees hardly any is blind.
const WALLED: f64 = 0.3;

/// Follows a robot on a map.
#[derive(Clone, Debug)]
pub struct Localizer {
    walls: Walls,
    settings: LocalizationSettings,
    belief: Belief,
    track: PoseTrack,
    view: View,
    /// Revolutions that speak against the pose, less those that do not.
    against: u32,
    /// Of a lost robot, the revolutions in a row that agree about another place.
    found: Option<u32>,
    fix: Fix,
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
        let walls = Walls::new(map);
        let belief = Belief::new(walls.in_grid(start), &settings);
        let mut localizer = Self {
            walls,
            settings,
            belief,
            track: PoseTrack::new(),
            view: View::default(),
            against: 0,
            found: None,
            fix: Fix {
                time_s: 0.0,
                pose: *start,
                covariance: Matrix3::zeros(),
                agreement: Agreement::default(),
                rms_m: 0.0,
                unseen_directions: 3,
                rounds: 0,
                state: State::Uncertain,
            },
        };
        localizer.note_pose();
        Ok(localizer)
    }

    /// The newest word: of the last revolution, with the pose moved on by the odometry since.
    #[must_use]
    pub const fn fix(&self) -> &Fix {
        &self.fix
    }

    /// Where the robot is, in the map frame.
    #[must_use]
    pub const fn pose(&self) -> &Pose {
        &self.fix.pose
    }

    /// What the last revolution saw, as from the pose of then.
    #[must_use]
    pub const fn view(&self) -> &View {
        &self.view
    }

    /// By what odometry's ways and turns are multiplied, as learned so far: below one for tracks that slip.
    #[must_use]
    pub const fn odometry_factors(&self) -> (f64, f64) {
        self.belief.factors()
    }

    /// Takes in where odometry has the robot at a time, seconds, in its own frame, wherever that began. The first reading only sets
    /// where it began; one that is not finite is passed over.
    pub fn moved(&mut self, time_s: f64, odometry: &Pose) {
        if !(time_s.is_finite() && odometry.is_finite()) {
            return;
        }
        if let Some((before_s, before)) = self.track.newest() {
            let elapsed_s = (time_s - before_s).max(0.0);
            self.belief
                .moved(&before, odometry, elapsed_s, &self.settings);
        }
        self.track.record(time_s, odometry);
        self.fix.time_s = time_s;
        self.note_pose();
        if self.is_unsure() && self.fix.state.lost().is_none() {
            self.lose(Lost::Unsure);
        }
    }

    /// Takes in a revolution, of which each is to be given once, and says where the robot is at the newest odometry's time. Its beams
    /// were measured within the second before that.
    pub fn look(&mut self, sweep: &Sweep) -> &Fix {
        self.view.take(sweep, &self.track);
        if self.fix.state.lost().is_some() && self.found.is_none() {
            self.search();
        } else {
            self.follow();
        }
        self.note_pose();
        &self.fix
    }

    /// Corrects the pose by the view, unless the view speaks against it.
    fn follow(&mut self) {
        let covariance = self.belief.pose_covariance();
        let Some(certainty) = covariance.try_inverse() else {
            return self.lose(Lost::Unsure);
        };
        let sigma_m = covariance[(0, 0)].max(covariance[(1, 1)]).sqrt();
        let prior = self.belief.pose;
        let there = matched(
            &self.walls,
            &self.view.hits,
            &prior,
            &certainty,
            sigma_m,
            &self.settings,
        );
        let tolerance_m = tolerance_m(&self.walls, &self.settings);
        self.fix.agreement = Agreement::of(&self.walls, &self.view, &there.pose, tolerance_m);
        self.fix.rms_m = there.rms_m;
        self.fix.unseen_directions = there.unseen_directions;
        self.fix.rounds = there.rounds;
        if let Some(why) = self.speaks_against(&there, &prior, &certainty) {
            return self.doubt(why);
        }
        self.belief.matched(&there.pose, &there.information);
        self.note_pose();
        self.believe();
    }

    /// Why the view speaks against the pose that it was laid on the map at.
    fn speaks_against(
        &self,
        there: &Matched,
        prior: &Pose,
        certainty: &Matrix3<f64>,
    ) -> Option<Lost> {
        let Self { settings, view, .. } = self;
        let agreement = &self.fix.agreement;
        let expects_walls = || walled_share(&self.walls, &there.pose, view.range_max) > WALLED;
        if view.hits.len() < settings.least_returns {
            // In the open nothing is to be seen, and nothing speaks against it.
            return expects_walls().then_some(Lost::Blind);
        }
        if agreement.through_share() > settings.most_through {
            return Some(Lost::ThroughWalls);
        }
        if agreement.agree_share() < self.least_agreement() {
            return Some(Lost::Unexplained);
        }
        let off = nalgebra::Vector3::new(
            there.pose.x - prior.x,
            there.pose.y - prior.y,
            crate::geometry::wrap_angle(there.pose.yaw - prior.yaw),
        );
        ((off.transpose() * certainty * off)[0] > JUMP_SIGMAS2).then_some(Lost::Jumped)
    }

    /// Of a robot that was lost more is asked.
    const fn least_agreement(&self) -> f64 {
        if self.found.is_some() {
            self.settings.found_agreement
        } else {
            self.settings.least_agreement
        }
    }

    fn doubt(&mut self, why: Lost) {
        self.against += 1;
        let is_candidate = self.found.take().is_some();
        if self.fix.state.lost().is_some() {
            if is_candidate {
                self.fix.state = State::Lost(why);
            }
        } else if self.against >= self.settings.lost_after {
            self.lose(why);
        } else {
            self.fix.state = State::Uncertain;
        }
    }

    fn believe(&mut self) {
        self.against = self.against.saturating_sub(1);
        if let Some(found) = &mut self.found {
            *found += 1;
            if *found < self.settings.found_after {
                return;
            }
            self.found = None;
            self.against = 0;
        }
        self.fix.state = if self.against == 0 && !self.is_uncertain() {
            State::Tracking
        } else {
            State::Uncertain
        };
    }

    fn lose(&mut self, why: Lost) {
        self.fix.state = State::Lost(why);
        self.found = None;
    }

    /// Looks for a lost robot. What is found has to hold in the next revolutions.
    fn search(&mut self) {
        let Self { settings, view, .. } = self;
        if view.hits.len() < settings.least_returns {
            return;
        }
        let found = search::find(&self.walls, view, &self.belief.pose, settings);
        if let Some(pose) = found {
            self.belief = self.belief.moved_to(pose, &self.settings);
            self.found = Some(0);
            self.follow();
        }
    }

    fn is_uncertain(&self) -> bool {
        self.fix.sigma_m() > self.settings.uncertain_sigma_m
            || self.fix.sigma_rad() > self.settings.uncertain_sigma_rad
    }

    fn is_unsure(&self) -> bool {
        self.fix.sigma_m() > self.settings.lost_sigma_m
            || self.fix.sigma_rad() > self.settings.lost_sigma_rad
    }

    /// Brings the belief into the map frame.
    fn note_pose(&mut self) {
        self.fix.pose = self.walls.in_map(&self.belief.pose);
        let (sin, cos) = libm::sincos(self.walls.grid_yaw());
        let turn = Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0);
        self.fix.covariance = turn * self.belief.pose_covariance() * turn.transpose();
    }
}
