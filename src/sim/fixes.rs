//! Position fixes that correct the drift of odometry: poses in the map, as from a scan matcher or a total station.

use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use super::fault_injection::active_faults;
use super::{FaultInjection, Fixes, RngStream, SimError, generator, normal};
use crate::geometry::{Pose, wrap_angle};
use crate::localization::{PoseFilter, PoseMeasurement};

/// Smallest standard deviation in the filter, metres and radians: it must not divide by zero.
const MIN_SIGMA: f64 = 1e-6;

/// The fixes of one run.
#[derive(Clone, Debug)]
pub struct FixSource {
    fixes: Fixes,
    rng: Pcg64Mcg,
    /// Number of the next fix, which is due at this multiple of the period.
    next: f64,
}

impl FixSource {
    /// Creates a source whose first fix is due at time zero. The same seed gives the same fixes.
    ///
    /// # Errors
    /// [`SimError::Setting`] names the first setting that is out of range.
    pub fn new(fixes: Fixes, seed: u64) -> Result<Self, SimError> {
        fixes.validate()?;
        Ok(Self { fixes, rng: generator(seed, RngStream::Fixes), next: 0.0 })
    }

    /// Returns the fix of a robot at a true pose at a time, seconds, if one is due; its yaw is in (-pi, pi].
    ///
    /// Times must ascend from call to call. One fix is due at each multiple of the period. If several became due since the
    /// last call, only the newest counts.
    pub fn fix(&mut self, time_s: f64, truth: &Pose) -> Option<Pose> {
        // A time that is a multiple of the period to rounding counts as one.
        let due = (time_s * self.fixes.rate_hz + 1e-6).floor();
        if self.fixes.rate_hz <= 0.0 || due < self.next || !due.is_finite() {
            return None;
        }
        self.next = due + 1.0;
        if self.fixes.dropout > 0.0 && self.rng.random::<f64>() < self.fixes.dropout {
            return None;
        }
        Some(Pose {
            x: truth.x + normal(&mut self.rng, self.fixes.sigma_m),
            y: truth.y + normal(&mut self.rng, self.fixes.sigma_m),
            yaw: wrap_angle(truth.yaw + normal(&mut self.rng, self.fixes.sigma_rad)),
        })
    }
}

/// Positioning of the simulated robot: a filter of odometry and fixes.
pub(super) struct SimulatedPositioning {
    source: FixSource,
    filter: PoseFilter,
    accuracy: PoseMeasurement,
    /// Time of the last fix, seconds; none before the first.
    fixed_s: Option<f64>,
}

impl SimulatedPositioning {
    pub fn new(fixes: Fixes, start: Pose, seed: u64) -> Result<Self, SimError> {
        let accuracy = PoseMeasurement {
            pose: start,
            sigma_m: fixes.sigma_m.max(MIN_SIGMA),
            sigma_rad: fixes.sigma_rad.max(MIN_SIGMA),
        };
        Ok(Self {
            source: FixSource::new(fixes, seed)?,
            filter: PoseFilter::new(&accuracy),
            accuracy,
            fixed_s: None,
        })
    }

    /// Time of the last fix, seconds; none before the first.
    pub const fn fixed_s(&self) -> Option<f64> {
        self.fixed_s
    }

    /// Returns the filtered pose at a time, seconds, that ascends from call to call.
    pub fn pose(
        &mut self,
        faults: &[FaultInjection],
        time_s: f64,
        odometry: &Pose,
        truth: &Pose,
    ) -> Pose {
        let (mut is_frozen, mut has_fixes) = (false, true);
        for fault in active_faults(faults, time_s) {
            is_frozen |= matches!(fault, FaultInjection::PoseFrozen { .. });
            has_fixes &= !matches!(fault, FaultInjection::NoFixes { .. });
        }
        if is_frozen {
            return *self.filter.pose();
        }
        self.filter.predict(odometry);
        let fix = self.source.fix(time_s, truth).filter(|_| has_fixes);
        if let Some(pose) = fix {
            self.fixed_s = Some(time_s);
            self.filter.correct(&PoseMeasurement { pose, ..self.accuracy });
        }
        *self.filter.pose()
    }
}
