//! Localization over the log of a real robot.

use serde::Serialize;

use super::percentiles;
use crate::geometry::Pose;
use crate::lidar_log::{LidarLog, LogFormat, LogRecord};
use crate::localization::{LocalizationError, LocalizationSettings, LocalizationStatus, Localizer};
use crate::map::ObstacleGrid;
use crate::trajectory::{
    AbsoluteError, LoggedPose, Relation, RelationError, RelativeError, TimedPose, absolute_error,
    bridge, definite_relations, relation_error, relative_error,
};

/// Largest difference between the time of a relation and that of a pose, seconds. Logs print times with six digits, which is
/// 0.01 s after a quarter of an hour.
const SAME_TIME_S: f64 = 0.02;

/// Ground truth of a log besides its corrected poses.
#[derive(Clone, Debug)]
pub struct LogRelations {
    relations: Vec<Relation>,
    /// Those whose times name one record of the log each.
    definite: Vec<Relation>,
    offset_s: f64,
}

impl LogRelations {
    /// The relations of a log. `offset_s` is added to the times of the log to get those of the relations, seconds.
    #[must_use]
    pub fn new(log: &LidarLog, relations: Vec<Relation>, offset_s: f64) -> Self {
        let odometry =
            log.records.iter().map(|it| TimedPose { time_s: it.time_s, pose: it.odometry });
        let definite = definite_relations(&odometry.collect::<Vec<_>>(), &relations, offset_s);
        Self { relations, definite, offset_s }
    }

    /// Whether there is no relation.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.relations.is_empty()
    }

    /// Errors of estimated poses, one or none for each record of the log. Between two estimates, the trajectory follows odometry.
    /// None if the stamps of the log do not advance, or no relation has both of its times on the log.
    #[must_use]
    pub fn errors(&self, log: &LidarLog, estimates: &[Option<Pose>]) -> Option<RelationErrors> {
        let logged = |(record, estimate): (&LogRecord, &Option<Pose>)| LoggedPose {
            time_s: record.time_s,
            odometry: record.odometry,
            estimate: *estimate,
        };
        let poses: Vec<LoggedPose> = log.records.iter().zip(estimates).map(logged).collect();
        let bridged = bridge(&poses);
        let error = |relations: &[Relation]| {
            relation_error(&bridged, relations, self.offset_s, SAME_TIME_S)
        };
        let all = error(&self.relations).filter(|_| log.has_times)?;
        Some(RelationErrors { all, definite: error(&self.definite) })
    }
}

/// What a localizer achieved over a log. Figures are null where the log has nothing to compare with.
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct LogLocalization {
    /// Format of the log.
    pub format: LogFormat,
    /// Number of scans.
    pub scans: usize,
    /// Time from the first scan to the last, seconds; null for a log without usable stamps.
    pub duration_s: Option<f64>,
    /// Number of scans after which the localizer reported that it was lost.
    pub lost_scans: usize,
    /// Whether it was lost after the last scan.
    pub is_lost_at_end: bool,
    /// Time in which it was lost, seconds; null for a log without usable stamps.
    pub lost_s: Option<f64>,
    /// Absolute error of the poses at the scans while not lost, after rigid alignment, against the corrected poses.
    pub absolute: Option<AbsoluteError>,
    /// Relative error from scan to scan while not lost, against the corrected poses.
    pub relative: Option<RelativeError>,
    /// Errors against the relations.
    pub relations: Option<RelationErrors>,
    /// Errors of the log's own corrected poses against the relations: what a comparison with them is worth.
    pub corrected_relations: Option<RelationErrors>,
    /// Median and 99th percentile of the time per scan with the odometry before it, microseconds.
    pub scan_us: [Option<f64>; 2],
}

/// Errors against all relations, and against those alone whose times name one record of the log each.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct RelationErrors {
    /// Errors against all relations.
    #[serde(flatten)]
    pub all: RelationError,
    /// Errors against the definite ones; see [`definite_relations`]. None without any.
    pub definite: Option<RelationError>,
}

/// Localizes the robot on a map from its pose at the first scan by the odometry and the scans of a log. `clock` returns seconds and serves
/// the times per scan alone.
///
/// # Errors
/// Returns an error if a setting is out of range or the start is not finite.
pub fn localize_log(
    log: &LidarLog,
    map: &ObstacleGrid,
    start: &Pose,
    settings: LocalizationSettings,
    truth: Option<&LogRelations>,
    clock: &mut dyn FnMut() -> f64,
) -> Result<LogLocalization, LocalizationError> {
    let mut localizer = Localizer::new(map, settings, start)?.with_sparse_scans();
    let mut estimates: Vec<Option<Pose>> = Vec::with_capacity(log.records.len());
    let (mut times_us, mut spent_s) = (Vec::new(), 0.0);
    let (mut lost_scans, mut lost_s, mut was_lost_at) = (0, 0.0, None);
    let first = log.records.iter().position(|record| record.scan.is_some());
    let first = first.unwrap_or(log.records.len());
    estimates.resize(first, None);
    for record in &log.records[first..] {
        let before_s = clock();
        localizer.predict(record.time_s, &record.odometry);
        let Some(scan) = &record.scan else {
            spent_s += clock() - before_s;
            estimates.push(None);
            continue;
        };
        let estimate = localizer.update(&scan.beams);
        times_us.push((spent_s + clock() - before_s) * 1e6);
        spent_s = 0.0;
        if let Some(since_s) = was_lost_at.take() {
            let since_s: f64 = since_s;
            lost_s += (record.time_s - since_s).max(0.0);
        }
        let is_lost = matches!(estimate.status, LocalizationStatus::Lost(_));
        estimates.push((!is_lost).then_some(estimate.pose));
        if is_lost {
            lost_scans += 1;
            was_lost_at = Some(record.time_s);
        }
    }
    let pairs = corrected_pairs(log, &estimates);
    let corrected: Vec<Option<Pose>> = log.records.iter().map(|record| record.corrected).collect();
    Ok(LogLocalization {
        format: log.format,
        scans: times_us.len(),
        duration_s: duration_s(log),
        lost_scans,
        is_lost_at_end: was_lost_at.is_some(),
        lost_s: log.has_times.then_some(lost_s),
        absolute: absolute_error(&pairs),
        relative: relative_error(&pairs),
        relations: truth.and_then(|truth| truth.errors(log, &estimates)),
        corrected_relations: truth.and_then(|truth| truth.errors(log, &corrected)),
        scan_us: percentiles(times_us, [0.5, 0.99]),
    })
}

/// The estimated poses of a log that have a corrected one, each with it.
#[must_use]
pub fn corrected_pairs(log: &LidarLog, estimates: &[Option<Pose>]) -> Vec<(Pose, Pose)> {
    let pair =
        |(record, estimate): (&LogRecord, &Option<Pose>)| Some(((*estimate)?, record.corrected?));
    log.records.iter().zip(estimates).filter_map(pair).collect()
}

/// Time from the earliest to the latest scan. The stamps of a log may run backwards.
fn duration_s(log: &LidarLog) -> Option<f64> {
    let times = || log.records.iter().filter_map(|it| it.scan.is_some().then_some(it.time_s));
    let (first_s, last_s) = (times().reduce(f64::min)?, times().reduce(f64::max)?);
    log.has_times.then_some(last_s - first_s)
}
