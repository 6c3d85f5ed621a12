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
    /// The frame of the newest map; empty before the first one.
    frame: String,
    /// On a map in that frame.
    localizer: Option<Localizer>,
    /// Prepares a localizer for a new map: that takes time in proportion to the map's area.
    preparation: Option<JoinHandle<Result<Localizer, LocalizationError>>>,
    /// A hint for a map that is not prepared yet.
    hint: Option<WaitingHint>,
    /// Frame, time and pose of the newest odometry.
    odometry: Option<(String, f64, Pose)>,
    waiting: VecDeque<TimedScan>,
    /// End of the last scan that was matched.
    matched_s: Option<f64>,
}

/// A hint with its frame, and frame and pose of the odometry at its time.
#[derive(Debug)]
struct WaitingHint {
    frame: String,
    hint: PoseHint,
    odometry: Option<(String, Pose)>,
}

impl WaitingHint {
    /// The hint for a robot that has moved since.
    fn moved_to(&self, odometry: Option<&(String, f64, Pose)>) -> PoseHint {
        let (Some((frame, before)), Some((newest_frame, _, newest))) = (&self.odometry, odometry)
        else {
            return self.hint;
        };
        if frame != newest_frame {
            return self.hint;
        }
        let moved = before.inverse_transform_pose(newest);
        PoseHint { pose: self.hint.pose.transform_pose(&moved), ..self.hint }
    }
}

impl NodeLocalization {
    /// A localisation without a map.
    pub const fn new(settings: LocalizationSettings, unknown: UnknownPolicy) -> Self {
        Self {
            settings,
            unknown,
            frame: String::new(),
            localizer: None,
            preparation: None,
            hint: None,
            odometry: None,
            waiting: VecDeque::new(),
            matched_s: None,
        }
    }

    /// Prepares a new map on its own thread. Until then the present map is used, if it has the same frame: a pose in another one is
    /// no pose on the new map.
    pub fn set_map(&mut self, map: &OccupancyGrid, frame: &str) {
        if self.frame != frame {
            (self.localizer, self.matched_s) = (None, None);
            frame.clone_into(&mut self.frame);
        }
        self.hint.take_if(|hint| hint.frame != frame);
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
        // A map that is being prepared may show another place: there the present one finds nothing.
        let is_waiting = self.localizer.is_none() || self.preparation.is_some();
        let odometry = self.odometry.as_ref().map(|(frame, _, pose)| (frame.clone(), *pose));
        self.hint = is_waiting.then(|| WaitingHint { frame: frame.to_owned(), hint, odometry });
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
        // The present map may have found the robot by the hint.
        let is_lost = localizer.estimate().status.lost_reason().is_some();
        if let Some(hint) = self.hint.take().filter(|_| is_lost) {
            // It was checked when it came.
            let _ = localizer.search_near(&hint.moved_to(self.odometry.as_ref()));
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

#[cfg(test)]
mod tests {
    use core::f64::consts::TAU;
    use std::thread;
    use std::time::Duration;

    use super::*;
    use crate::map::{Beam, RayCaster, RayEnd};

    const HINT: PoseHint =
        PoseHint { pose: Pose { x: 2.8, y: 2.1, yaw: 0.1 }, sigma_m: 0.2, sigma_rad: 0.1 };

    /// A room of 6 by 4 m with two blocks.
    fn room() -> OccupancyGrid {
        let is_block = |column: usize, row: usize| {
            (20..26).contains(&column) && (5..9).contains(&row)
                || (45..48).contains(&column) && (25..33).contains(&row)
        };
        let row = |row: usize| -> String {
            let is_wall = |column: usize| [0, 59].contains(&column) || [0, 39].contains(&row);
            let cell = |it| if is_wall(it) || is_block(it, row) { '#' } else { '.' };
            (0..60).map(cell).collect()
        };
        let rows: Vec<String> = (0..40).map(row).collect();
        let rows: Vec<&str> = rows.iter().map(String::as_str).collect();
        OccupancyGrid::from_rows(&rows, 0.1, Pose::default()).expect("a map")
    }

    fn localization() -> NodeLocalization {
        NodeLocalization::new(LocalizationSettings::default(), UnknownPolicy::Free)
    }

    fn until_prepared(localization: &mut NodeLocalization) {
        while localization.preparation.as_ref().is_some_and(|it| !it.is_finished()) {
            thread::sleep(Duration::from_millis(1));
        }
        localization.tick();
    }

    fn pose(localization: &NodeLocalization) -> Pose {
        *localization.localizer.as_ref().expect("a localizer").pose()
    }

    /// The robot drives from (3, 2) along x, and its odometry has the origin there.
    fn drive_to(localization: &mut NodeLocalization, ticks: core::ops::Range<u32>, speed_m_s: f64) {
        let obstacles = room().obstacles(UnknownPolicy::Free);
        let caster = RayCaster::new(&obstacles);
        for tick in ticks {
            let time_s = 0.1 * f64::from(tick);
            let driven = Pose::new(speed_m_s * time_s, 0.0, 0.0);
            let from = Pose::new(3.0 + driven.x, 2.0, 0.0).position();
            let beam = |index: u32| {
                let angle = TAU * f64::from(index) / 180.0;
                let range = match caster.cast(&from, angle, 10.0) {
                    RayEnd::Blocked(range_m) => range_m,
                    _ => f64::INFINITY,
                };
                Beam { angle, range, time_s }
            };
            let beams = (0..180).map(beam).collect();
            localization.update_odometry("odom", time_s, &driven);
            localization.update_scan(TimedScan { beams, range_max: 10.0, ..TimedScan::default() });
        }
    }

    #[test]
    fn hint_that_found_the_robot_is_not_used_again_on_the_next_map() {
        let mut localization = localization();
        localization.set_map(&room(), "map");
        until_prepared(&mut localization);
        localization.set_map(&room(), "map");
        localization.update_odometry("odom", 0.0, &Pose::default());
        localization.set_hint("map", HINT).expect("a valid hint");
        assert_eq!(localization.state(), "lost");
        drive_to(&mut localization, 0..40, 0.1);
        assert_eq!(localization.state(), "tracking");
        until_prepared(&mut localization);
        assert_eq!(localization.state(), "tracking");
        assert!((pose(&localization).x - 3.39).abs() < 0.05, "{:?}", pose(&localization));
    }

    #[test]
    fn hint_before_the_map_moves_with_the_robot() {
        let mut localization = localization();
        localization.update_odometry("odom", 0.0, &Pose::new(5.0, 1.0, 0.6));
        localization.set_hint("map", HINT).expect("a valid hint");
        localization.update_odometry("odom", 1.0, &Pose::new(5.0, 1.0, 1.1));
        localization.set_map(&room(), "map");
        until_prepared(&mut localization);
        let found = pose(&localization);
        assert!((found.position() - HINT.pose.position()).norm() < 1e-9, "{found:?}");
        assert!((found.yaw - HINT.pose.yaw - 0.5).abs() < 1e-9, "{found:?}");
    }

    #[test]
    fn pose_is_not_carried_to_a_map_in_another_frame() {
        let mut localization = localization();
        localization.update_odometry("odom", 0.0, &Pose::default());
        localization.set_map(&room(), "map");
        until_prepared(&mut localization);
        for frame in ["map", "floor_2"] {
            localization.set_map(&room(), frame);
            assert_eq!(localization.odometry_frame().is_ok(), frame == "map");
            until_prepared(&mut localization);
            assert!(localization.odometry_frame().is_ok());
        }
    }
}
