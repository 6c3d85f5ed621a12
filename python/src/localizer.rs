//! The pose from scans.

use inbye::map::TimedScan;
use pyo3::prelude::*;

use super::conversion::{pose, pose_tuple, raise, scan};
use super::map::Map;
use super::settings::settings;
use super::shared::Shared;

/// The pose after a revolution of the lidar, with its quality.
#[pyclass(frozen, get_all, module = "inbye")]
pub struct PoseEstimate {
    time_s: f64,
    pose: (f64, f64, f64),
    covariance: [[f64; 3]; 3],
    rms_m: f64,
    /// "tracking", "uncertain" or "lost".
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
pub struct Localizer(Shared<inbye::localization::Localizer>);

#[pymethods]
impl Localizer {
    #[new]
    #[pyo3(signature = (map, start, *, config=None))]
    fn new(
        py: Python<'_>,
        map: &Bound<'_, Map>,
        start: [f64; 3],
        config: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let config = settings(config)?;
        let (map, start) = (map.get(), pose(start)?);
        let localizer = py.detach(|| {
            let known = map.grid.obstacles(config.unknown);
            inbye::localization::Localizer::new(&known, config.localization, &start)
        });
        Ok(Self(Shared::new(localizer.map_err(raise)?)))
    }

    fn predict(&self, py: Python<'_>, time_s: f64, odometry: [f64; 3]) -> PyResult<()> {
        let odometry = pose(odometry)?;
        self.0.with(py, |localizer| localizer.predict(time_s, &odometry))
    }

    /// A revolution that ended at a time, seconds, and lasted `sweep_s`.
    #[pyo3(signature = (time_s, ranges, *, angle_min, angle_increment, range_max, sweep_s=0.0))]
    #[expect(clippy::too_many_arguments, reason = "Python names them")]
    fn update(
        &self,
        py: Python<'_>,
        time_s: f64,
        ranges: &Bound<'_, PyAny>,
        angle_min: f64,
        angle_increment: f64,
        range_max: f64,
        sweep_s: f64,
    ) -> PyResult<PoseEstimate> {
        let scan = scan(ranges, angle_min, angle_increment, range_max)?;
        let revolution = TimedScan::from_scan(&scan, time_s, sweep_s);
        self.0.with(py, |localizer| localizer.update(&revolution).into())
    }

    #[getter]
    fn estimate(&self, py: Python<'_>) -> PyResult<PoseEstimate> {
        self.0.with(py, |localizer| localizer.estimate().into())
    }

    /// Learned scales of odometry's distances and turns.
    #[getter]
    fn odometry_scale(&self, py: Python<'_>) -> PyResult<(f64, f64)> {
        self.0.with(py, |localizer| localizer.odometry_scale())
    }
}
