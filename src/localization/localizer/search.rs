//! Searches of the whole map: by a localizer that is lost, and by one that doubts.

use nalgebra::Matrix3;

use super::{Localizer, MAX_CORRECTION_SIGMAS2, SAME_PLACE_AGREEMENT, distance_m, has_moved};
use crate::geometry::Pose;
use crate::localization::coarse_search::{search_along, search_map};
use crate::localization::map_scores::MapScores;
use crate::localization::pose_filters::offset;
use crate::localization::relocalization::{Found, GlobalSearch, SearchRegion};
use crate::localization::scan_matcher::ScanMatch;
use crate::localization::{LocalizationError, LocalizationStatus, LostReason, PoseHint};

/// A robot that stands does not move by more than this between two revolutions of a search, metres and radians.
const STANDING_M: f64 = 0.05;
const STANDING_RAD: f64 = 0.03;

/// The position is vague from this standard deviation on, metres: nothing has constrained it for long, as along a smooth roadway.
const VAGUE_SIGMA_M: f64 = 0.15;

/// Nodes of a search at each revolution: some ten milliseconds; and the part of them while the robot drives.
const NODES: usize = 450_000;
const DOUBT_SHARE: usize = 5;

/// Number of consecutive revolutions with poor agreement before a search.
const DOUBTFUL_SCANS: u32 = 15;

/// A robot whose pose was right agrees with ever fewer beams where walls are missing from the map, or new; one that was carried does so at
/// once. Before it is lost, this share more of the beams must agree at a better place. Then it is not found beyond this distance of its
/// predicted pose, metres.
const CHANGED_MAP_MARGIN: f64 = 0.35;
const ELSEWHERE_M: f64 = 2.0;

/// What the searches keep between revolutions.
#[derive(Clone, Debug, Default)]
pub(super) struct Searches {
    /// Of a lost robot.
    pub of_lost: Option<GlobalSearch>,
    /// Where a lost robot is searched first.
    pub hint: Option<HintedRegion>,
    /// Of a robot that is not lost.
    doubt: Option<Doubt>,
    doubtful: u32,
    /// The place is to be compared with those of the whole map: a hint found it, or the map was replaced during a comparison.
    is_unchecked: bool,
    /// Made for the first search.
    pub scores: Option<MapScores>,
}

/// The region of a hint, and the odometry at the time of the hint; `None` before the first odometry.
#[derive(Clone, Copy, Debug)]
pub(super) struct HintedRegion {
    pub region: SearchRegion,
    pub odometry: Option<Pose>,
}

impl HintedRegion {
    /// The region for a robot that has moved since.
    fn moved_to(&mut self, odometry: &Pose) -> SearchRegion {
        let before = self.odometry.get_or_insert(*odometry);
        let moved = before.inverse_transform_pose(odometry);
        SearchRegion { center: self.region.center.transform_pose(&moved), ..self.region }
    }
}

impl Searches {
    /// The same searches from their begin on another map, to whose grid a function converts poses. A candidate of a search must then
    /// agree as one that no search found.
    pub fn restarted(&self, converted: impl Fn(&Pose) -> Pose) -> Self {
        let hint = self.hint.map(|it| {
            let center = converted(&it.region.center);
            HintedRegion { region: SearchRegion { center, ..it.region }, ..it }
        });
        let is_unchecked = self.is_unchecked || self.doubt.is_some();
        Self { hint, doubtful: self.doubtful, is_unchecked, ..Self::default() }
    }

    /// Ends all searches: what they began with no longer holds.
    pub fn stop(&mut self) {
        *self = Self { scores: self.scores.take(), ..Self::default() };
    }

    /// The candidate of the search is confirmed. One near a hint may still be the wrong place: most of the beams may agree there too.
    pub fn confirm(&mut self) {
        self.of_lost = None;
        self.is_unchecked = self.hint.take().is_some();
    }
}

/// A search for a better place than the believed one.
#[derive(Clone, Debug)]
struct Doubt {
    search: GlobalSearch,
    /// The pose at the start of the search, in the grid's frame.
    believed: Pose,
}

/// The larger standard deviation of x and y, metres.
fn sigma_m(covariance: &Matrix3<f64>) -> f64 {
    covariance[(0, 0)].max(covariance[(1, 1)]).sqrt()
}

/// Whether the next feature of the walls may correct the position by far.
pub(super) fn is_vague(covariance: &Matrix3<f64>) -> bool {
    sigma_m(covariance) > VAGUE_SIGMA_M
}

impl Localizer {
    /// Matches the scan around the predicted pose of this covariance, and its inverse. Where that may be far off, a search comes first.
    pub(super) fn match_predicted(
        &self,
        covariance: &Matrix3<f64>,
        information: &Matrix3<f64>,
    ) -> ScanMatch {
        let (prior, sigma_m) = (self.ekf.pose, sigma_m(covariance));
        let begin = if self.has_sparse_scans {
            search_map(&self.map, &self.scan, &prior, (sigma_m, covariance[(2, 2)].sqrt()))
        } else if is_vague(covariance) {
            search_along(&self.map, &self.scan, &prior, covariance)
        } else {
            return self.matcher().match_scan(&prior, information, sigma_m);
        };
        self.matcher().match_scan_from(begin, &prior, information, 0.0)
    }

    /// Discards the pose. The robot is searched near the hint first, and on the whole map if nothing matches there. Within the
    /// hint's region too it is found only where one place matches better than all others a metre away: a hint of less than 0.15 m
    /// leaves no other.
    ///
    /// # Errors
    /// Returns an error if the pose is not finite or a standard deviation is out of range.
    pub fn search_near(&mut self, hint: &PoseHint) -> Result<(), LocalizationError> {
        let region = hint.region()?;
        self.found = None;
        (self.is_proven, self.has_given_up) = (false, false);
        self.lose(LostReason::NoPose);
        let center = self.map.to_grid(&hint.pose);
        let odometry = self.odometry.map(|(_, pose)| pose);
        let region = SearchRegion { center, ..region };
        self.searches.hint = Some(HintedRegion { region, odometry });
        self.ekf = self.ekf.reset_pose(center, &self.settings);
        self.update_estimate();
        Ok(())
    }

    /// Searches for the pose of a lost robot while it stands: where odometry predicts it, then near a hint, and then on the whole
    /// map. The next revolutions must confirm a candidate.
    pub(super) fn relocalize(&mut self) {
        if self.scan.hits.len() < self.settings.min_returns {
            return;
        }
        // Where the scans do not constrain the pose, a match at the predicted one is no evidence.
        let reason = self.lost_by;
        let is_unconstrained =
            matches!(reason, Some(LostReason::HighUncertainty | LostReason::NoPose));
        if !is_unconstrained && self.is_at_predicted_pose() {
            self.searches.of_lost = None;
            self.confirmations = Some(0);
            return self.track();
        }
        let odometry = self.odometry();
        let stands = |search: &GlobalSearch| {
            !has_moved(&search.odometry, &odometry, STANDING_M, STANDING_RAD)
        };
        let scores = self.searches.scores.get_or_insert_with(|| MapScores::new(&self.map));
        let search = self.searches.of_lost.take().filter(stands);
        let hint = &mut self.searches.hint;
        let mut search = search.unwrap_or_else(|| {
            let search = GlobalSearch::new(&self.scan, &odometry, scores);
            match hint {
                Some(hint) => search.within(hint.moved_to(&odometry)),
                None => search,
            }
        });
        match search.step(&self.map, scores, &self.settings, NODES) {
            None => self.searches.of_lost = Some(search),
            Some(Found::Unique(pose)) if !self.is_twin(&pose) => {
                let moved = search.odometry.inverse_transform_pose(&odometry);
                let pose = pose.transform_pose(&moved);
                self.ekf = self.ekf.reset_pose(pose, &self.settings);
                (self.anchor, self.is_proven) = (None, false);
                self.confirmations = Some(0);
                self.searches.of_lost = Some(search);
                self.track();
            }
            // The next revolution starts another search: people may have moved.
            Some(Found::Unique(_) | Found::Ambiguous(_)) => {
                if reason != Some(LostReason::HighUncertainty) {
                    self.estimate.status = LocalizationStatus::Lost(LostReason::Ambiguous);
                }
            }
            Some(Found::Nothing) => {
                if search.is_restricted() {
                    self.searches.hint = None;
                }
            }
        }
    }

    /// Whether another place of the map matches much better than the present one. While too few beams agree, the map is searched
    /// now and then; a wrong place may agree with half of them. It is also searched once for a robot that was found by a hint.
    pub(super) fn is_better_elsewhere(&mut self) -> bool {
        let odometry = self.odometry();
        let Self { settings, map, scan, searches, .. } = self;
        let is_doubtful =
            self.estimate.agreement.matching_fraction() < settings.relocalized_agreement;
        searches.doubtful = if is_doubtful { searches.doubtful + 1 } else { 0 };
        if searches.doubt.is_none() {
            if searches.doubtful < DOUBTFUL_SCANS && !searches.is_unchecked {
                return false;
            }
            (searches.doubtful, searches.is_unchecked) = (0, false);
        }
        let scores = searches.scores.get_or_insert_with(|| MapScores::new(map));
        let mut doubt = searches.doubt.take().unwrap_or_else(|| Doubt {
            search: GlobalSearch::new(scan, &odometry, scores),
            believed: self.ekf.pose,
        });
        let found = doubt.search.step(map, scores, settings, NODES / DOUBT_SHARE);
        match found {
            None => {
                searches.doubt = Some(doubt);
                false
            }
            Some(Found::Unique(pose) | Found::Ambiguous(Some(pose))) => {
                let margin = if self.is_proven {
                    CHANGED_MAP_MARGIN
                } else {
                    settings.relocalization_margin
                };
                let gain = doubt.search.gain_over(map, settings, &pose, &doubt.believed);
                gain.is_some_and(|gain| gain >= margin)
            }
            Some(Found::Ambiguous(None) | Found::Nothing) => false,
        }
    }

    /// Whether a place that matches alone most likely only looks like that of the robot: its pose was right, fewer and fewer beams agreed
    /// with the map until it was lost, and the place is far from the predicted one.
    fn is_twin(&self, place: &Pose) -> bool {
        let agreed = self.anchor.map(|anchor| anchor.agreement);
        self.is_proven
            && agreed.is_some_and(|share| share < self.settings.relocalized_agreement)
            && distance_m(place, &self.ekf.pose) > ELSEWHERE_M
    }

    /// Whether the scan matches at the predicted pose so well that the robot is still there.
    fn is_at_predicted_pose(&self) -> bool {
        let covariance = self.ekf.pose_covariance();
        let Some(information) = covariance.try_inverse() else {
            return false;
        };
        let prior = self.ekf.pose;
        let matched = self.matcher().match_scan(&prior, &information, sigma_m(&covariance));
        let correction = offset(&prior, &matched.pose);
        let agreement = self.matcher().agreement(&matched.pose);
        agreement.matching_fraction() >= SAME_PLACE_AGREEMENT
            && agreement.through_walls_fraction() <= self.settings.max_through_walls / 2.0
            && (correction.transpose() * information * correction)[0] <= MAX_CORRECTION_SIGMAS2
    }
}
