//! The pose from scans.

use inbye::geometry::Point;
use inbye::map::TimedScan;
use pyo3::prelude::*;

use super::conversion::{Numbers, pose, pose_tuple, raise, scan};
use super::map::Map;
use super::settings::settings;
use super::shared::Shared;

/// The pose after a revolution of the lidar, with its quality.
#[pyclass(frozen, get_all, module = "inbye")]
pub struct PoseEstimate {
    /// Time of the pose.
    time_s: f64,
    /// The pose.
    pose: (f64, f64, f64),
    /// Covariance of x, y and yaw.
    covariance: [[f64; 3]; 3],
    /// Mean distance of beam ends from the surfaces of the map.
    rms_m: f64,
    /// How reliable it is: "tracking", "uncertain" or "lost".
    status: &'static str,
    /// Why the pose is lost.
    reason: Option<String>,
}

impl From<&inbye::localization::PoseEstimate> for PoseEstimate {
    fn from(estimate: &inbye::localization::PoseEstimate) -> Self {
        use inbye::localization::LocalizationStatus;
        Self {
            time_s: estimate.time_s,
            pose: pose_tuple(&estimate.pose),
            covariance: estimate.covariance,
            rms_m: estimate.rms_m,
            status: match estimate.status {
                LocalizationStatus::Tracking => "tracking",
                LocalizationStatus::Uncertain => "uncertain",
                _ => "lost",
            },
            reason: estimate.status.lost_reason().map(|reason| reason.to_string()),
        }
    }
}

/// Estimates the pose from odometry, and from scans that are matched to the map.
#[pyclass(frozen, module = "inbye")]
pub struct Localizer(Shared<State>);

struct State {
    localizer: inbye::localization::Localizer,
    /// Times of the last prediction and of the last revolution, seconds.
    predicted_s: f64,
    updated_s: f64,
}

/// Largest coordinate of the odometry, metres: its squares are finite.
const MAX_ODOMETRY_M: f64 = 1e9;

/// Longest revolution, seconds: older poses are not kept.
const MAX_SWEEP_S: f64 = 1.0;

/// Replaces a time, seconds, by a later one or the same.
fn advance(last_s: &mut f64, time_s: f64) -> PyResult<()> {
    if !time_s.is_finite() {
        return Err(raise(format!("time_s is {time_s}: it must be finite")));
    }
    if time_s < *last_s {
        return Err(raise(format!("time_s is {time_s}: it must not be before the last, {last_s}")));
    }
    *last_s = time_s;
    Ok(())
}

#[pymethods]
impl Localizer {
    #[new]
    #[pyo3(signature = (map, start, *, config=None))]
    fn new(
        py: Python<'_>,
        map: &Bound<'_, Map>,
        start: Numbers<3>,
        config: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let config = settings(config)?;
        let (map, start) = (map.get(), pose(start)?);
        if map.grid.frame().cell_of(&start.position()).is_none() {
            let Point { x, y } = start.position();
            return Err(raise(format!("start ({x:.2}, {y:.2}) is outside the map")));
        }
        let localizer = py.detach(|| {
            let known = map.grid.obstacles(config.unknown);
            inbye::localization::Localizer::new(&known, config.localization, &start)
        });
        let localizer = localizer.map_err(raise)?;
        let (predicted_s, updated_s) = (f64::NEG_INFINITY, f64::NEG_INFINITY);
        Ok(Self(Shared::new(State { localizer, predicted_s, updated_s })))
    }

    /// Predicts by a pose of the odometry. The first one is the reference.
    fn predict(&self, py: Python<'_>, time_s: f64, odometry: Numbers<3>) -> PyResult<()> {
        let odometry = pose(odometry)?;
        if odometry.x.abs().max(odometry.y.abs()) > MAX_ODOMETRY_M {
            return Err(raise(format!("odometry: a coordinate is above {MAX_ODOMETRY_M:e} m")));
        }
        self.0.with(py, |state| {
            advance(&mut state.predicted_s, time_s)?;
            state.localizer.predict(time_s, &odometry);
            Ok(())
        })?
    }

    /// Matches a revolution that ended at a time, seconds, and lasted `sweep_s`, at most 1 s.
    #[pyo3(signature = (time_s, ranges, *, angle_min, angle_increment, range_max, lidar_position=None, sweep_s=0.0))]
    #[expect(clippy::too_many_arguments, reason = "Python names them")]
    fn update(
        &self,
        py: Python<'_>,
        time_s: f64,
        ranges: &Bound<'_, PyAny>,
        angle_min: f64,
        angle_increment: f64,
        range_max: f64,
        lidar_position: Option<Numbers<2>>,
        sweep_s: f64,
    ) -> PyResult<PoseEstimate> {
        let scan = scan(ranges, lidar_position, angle_min, angle_increment, range_max)?;
        if !(0.0..=MAX_SWEEP_S).contains(&sweep_s) {
            return Err(raise(format!("sweep_s is {sweep_s}: it must be 0 to {MAX_SWEEP_S}")));
        }
        let revolution = TimedScan::from_scan(&scan, time_s, sweep_s);
        self.0.with(py, |state| {
            advance(&mut state.updated_s, time_s)?;
            Ok(state.localizer.update(&revolution).into())
        })?
    }

    /// The latest estimate.
    #[getter]
    fn estimate(&self, py: Python<'_>) -> PyResult<PoseEstimate> {
        self.0.with(py, |state| state.localizer.estimate().into())
    }

    /// Learned scales of odometry's distances and turns.
    #[getter]
    fn odometry_scale(&self, py: Python<'_>) -> PyResult<(f64, f64)> {
        self.0.with(py, |state| state.localizer.odometry_scale())
    }
}
