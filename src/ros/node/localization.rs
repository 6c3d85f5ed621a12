//! The node's own localisation: the frame of the odometry in the map, from scans.

use std::collections::VecDeque;
use std::thread::{Builder, JoinHandle};

use super::latest_inputs::OdometryFrame;
use super::notices::MissingInput;
use crate::geometry::Pose;
use crate::localization::{
    LocalizationError, LocalizationSettings, LocalizationStatus, Localizer, MapChanges,
    PoseEstimate, PoseHint, SignedDistanceField,
};
use crate::map::{OccupancyGrid, TimedScan, UnknownPolicy};
use crate::ros::convert::key_value;
use crate::ros::msg::DiagnosticStatus;

/// Scans that wait for the odometry of their time. More mean that odometry is a second late: the oldest goes.
const MAX_WAITING: usize = 16;

/// A localizer on the newest map. Times are seconds by the node's clock.
#[derive(Debug)]
pub struct NodeLocalization {
    settings: LocalizationSettings,
    unknown: UnknownPolicy,
    localizer: Option<Localizer>,
    /// Prepares a localizer for a new map: that takes time in proportion to the map's area.
    preparation: Option<JoinHandle<Result<Localizer, LocalizationError>>>,
    /// A hint that came before the map, with its frame.
    hint: Option<(String, PoseHint)>,
    /// Frame, time and pose of the newest odometry.
    odometry: Option<(String, f64, Pose)>,
    waiting: VecDeque<TimedScan>,
    /// End of the last scan that was matched.
    matched_s: Option<f64>,
}

impl NodeLocalization {
    /// A localisation without a map.
    pub const fn new(settings: LocalizationSettings, unknown: UnknownPolicy) -> Self {
        Self {
            settings,
            unknown,
            localizer: None,
            preparation: None,
            hint: None,
            odometry: None,
            waiting: VecDeque::new(),
            matched_s: None,
        }
    }

    /// Prepares a new map on its own thread. Until then the present map is used.
    pub fn set_map(&mut self, map: &OccupancyGrid, frame: &str) {
        self.hint.take_if(|(found, _)| found != frame);
        let (map, settings, unknown) = (map.clone(), self.settings, self.unknown);
        let prepare = move || Localizer::without_pose(&map.obstacles(unknown), settings);
        // A thread that prepares an older map ends by itself.
        self.preparation = Builder::new().name("inbye-localizer".to_owned()).spawn(prepare).ok();
    }

    /// Matches the scans to the present map with its changes.
    pub fn adopt_changes(&mut self, changed: SignedDistanceField) {
        if let Some(localizer) = &mut self.localizer {
            localizer.adopt_changes(changed);
        }
    }

    /// Discards the pose and searches near a hint in a frame, which must be that of the newest map.
    ///
    /// # Errors
    /// When a number of the hint is out of range.
    pub fn set_hint(&mut self, frame: &str, hint: PoseHint) -> Result<(), LocalizationError> {
        hint.validate()?;
        if let Some(localizer) = &mut self.localizer {
            localizer.search_near(&hint)?;
        }
        // A map that is being prepared may be in another place.
        let is_waiting = self.localizer.is_none() || self.preparation.is_some();
        self.hint = is_waiting.then(|| (frame.to_owned(), hint));
        Ok(())
    }

    /// Takes odometry of a time, and matches the scans that waited for it.
    pub fn update_odometry(&mut self, frame: &str, time_s: f64, pose: &Pose) {
        let continues = self.odometry.as_ref().is_some_and(|(before, ..)| before == frame);
        self.odometry = Some((frame.to_owned(), time_s, *pose));
        let Some(localizer) = &mut self.localizer else {
            return;
        };
        if !continues {
            localizer.restart_odometry();
        }
        localizer.predict(time_s, pose);
        self.match_scans();
    }

    /// Takes a new scan as measured, in the robot's frame.
    pub fn update_scan(&mut self, scan: TimedScan) {
        if self.waiting.len() == MAX_WAITING {
            self.waiting.pop_front();
        }
        self.waiting.push_back(scan);
        self.match_scans();
    }

    /// The transport was lost: scans that wait are old when odometry returns.
    pub fn forget_scans(&mut self) {
        self.waiting.clear();
    }

    /// Uses a prepared map. Call it at each tick.
    pub fn tick(&mut self) {
        let Some(finished) = self.preparation.take_if(|running| running.is_finished()) else {
            return;
        };
        // The settings were checked, so that only a panic of the thread leaves no localizer.
        let Ok(Ok(mut localizer)) = finished.join() else {
            return;
        };
        if let Some(before) = &self.localizer {
            localizer.continue_from(before);
        } else if let Some((_, time_s, pose)) = &self.odometry {
            localizer.predict(*time_s, pose);
        }
        if let Some((_, hint)) = self.hint.take() {
            // It was checked when it came.
            let _ = localizer.search_near(&hint);
        }
        self.localizer = Some(localizer);
    }

    /// The frame of the odometry in the map.
    ///
    /// # Errors
    /// While the first map is being prepared.
    pub fn odometry_frame(&self) -> Result<OdometryFrame, MissingInput> {
        let (Some(localizer), Some((_, _, odometry))) = (&self.localizer, &self.odometry) else {
            return Err(MissingInput::PreparedMap);
        };
        let back = odometry.inverse_transform_pose(&Pose::default());
        Ok(OdometryFrame::Measured {
            pose: localizer.pose().transform_pose(&back),
            time_s: self.matched_s.unwrap_or(f64::NEG_INFINITY),
            lost: localizer.estimate().status.lost_reason(),
        })
    }

    /// What the scans have contradicted for minutes in the map, which must be the newest.
    pub fn map_changes(&self, map: &OccupancyGrid) -> Option<MapChanges> {
        let localizer = self.localizer.as_ref().filter(|_| self.preparation.is_none())?;
        Some(localizer.map_changes(map))
    }

    /// The name of its state.
    pub fn state(&self) -> &'static str {
        match self.localizer.as_ref().map(|localizer| localizer.estimate().status) {
            None => "no map",
            Some(LocalizationStatus::Tracking) => "tracking",
            Some(LocalizationStatus::Uncertain) => "uncertain",
            Some(LocalizationStatus::Lost(_)) => "lost",
        }
    }

    /// The status for `diagnostics`.
    pub fn status(&self) -> DiagnosticStatus {
        let estimate = self.localizer.as_ref().map(Localizer::estimate);
        let (level, message) = match estimate.map(|estimate| estimate.status) {
            None => (DiagnosticStatus::WARN, "no map is prepared".to_owned()),
            Some(LocalizationStatus::Tracking) => {
                (DiagnosticStatus::OK, "the scans match the map".to_owned())
            }
            Some(LocalizationStatus::Uncertain) => {
                let message = "recent scans do not match, or the pose is not yet certain";
                (DiagnosticStatus::WARN, message.to_owned())
            }
            Some(LocalizationStatus::Lost(reason)) => {
                (DiagnosticStatus::ERROR, format!("the pose is searched: {reason}"))
            }
        };
        let number = |value: fn(&PoseEstimate) -> f64| {
            estimate.map_or_else(String::new, |estimate| format!("{:.3}", value(estimate)))
        };
        DiagnosticStatus {
            level,
            name: "inbye: localization".to_owned(),
            message,
            hardware_id: String::new(),
            values: vec![
                key_value("status", self.state()),
                key_value("agreement", number(|it| it.agreement.matching_fraction())),
                key_value("sigma_m", number(PoseEstimate::sigma_m)),
                key_value("sigma_rad", number(PoseEstimate::sigma_rad)),
            ],
        }
    }

    /// Matches the waiting scans whose last beam is not newer than the odometry.
    fn match_scans(&mut self) {
        let (Some(localizer), Some((_, newest_s, _))) = (&mut self.localizer, &self.odometry)
        else {
            return;
        };
        while let Some(end_s) = self.waiting.front().map(TimedScan::end_s) {
            if end_s.is_some_and(|end_s| end_s > *newest_s) {
                return;
            }
            if let Some(scan) = self.waiting.pop_front() {
                localizer.update(&scan);
                self.matched_s = end_s.or(self.matched_s);
            }
        }
    }
}
