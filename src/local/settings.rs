//! Settings of the local planner, with Nav2's names where Nav2 has them.

use serde::{Deserialize, Serialize};

use super::ranges::{check_counts, in_range};
use super::{Normalization, Outside, ProblemError, Stopping, Weights};
use crate::documented::documented;

documented! {
    /// Sampling density, horizon and weights. The defaults suit the default robot.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    #[non_exhaustive]
    pub struct LocalSettings {
        /// Number of forward speeds per decision, at least 1; times `vtheta_samples` at most 4194304.
        pub vx_samples: u32,
        /// Number of turn rates per decision, at least 1.
        pub vtheta_samples: u32,
        /// Time between decisions, seconds, 0.0001 to 1000: the window holds the velocities reachable within it.
        pub control_period_s: f64,
        /// Horizon of the rollout, seconds, above zero and at most 1000, and at most 1023 steps.
        pub sim_time_s: f64,
        /// Time between two checked poses, seconds, above zero and at most 1000.
        pub sim_step_s: f64,
        /// Cap of the clearance, metres, above zero and at most 1000: more clearance does not improve the score.
        pub max_clearance_m: f64,
        /// State of cells outside the local field: `obstacle` or `free`.
        pub outside: Outside,
        /// Weights of the terms.
        pub weights: Weights,
        /// Normalisation of the terms: `sum` divides each by its sum, `minmax` maps each to 0 at its minimum and 1 at
        /// its maximum.
        pub normalization: Normalization,
        /// Distance within which a sample must be able to stop: `clearance`, the smallest along the trajectory, or
        /// `arc`, the arc before contact.
        pub stopping: Stopping,
    }
}

impl Default for LocalSettings {
    fn default() -> Self {
        Self {
            vx_samples: 20,
            vtheta_samples: 40,
            control_period_s: 0.1,
            sim_time_s: 3.0,
            sim_step_s: 0.1,
            max_clearance_m: 3.0,
            outside: Outside::default(),
            weights: Weights::default(),
            normalization: Normalization::default(),
            stopping: Stopping::default(),
        }
    }
}

/// Sampling density of the window.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Sampling {
    /// Number of forward speeds.
    pub vx_samples: u32,
    /// Number of turn rates.
    pub vtheta_samples: u32,
}

impl LocalSettings {
    /// The sampling density of these settings.
    #[must_use]
    pub const fn sampling(&self) -> Sampling {
        Sampling {
            vx_samples: self.vx_samples,
            vtheta_samples: self.vtheta_samples,
        }
    }

    /// Number of steps of the horizon, at least one.
    #[must_use]
    pub fn steps(&self) -> u32 {
        (self.sim_time_s / self.sim_step_s).round().max(1.0) as u32
    }
}

/// Largest horizon and step, seconds, and largest clearance, metres.
const LONGEST: f64 = 1000.0;
/// Shortest control period, seconds.
const SHORTEST_PERIOD_S: f64 = 1e-4;

impl LocalSettings {
    /// Checks the numbers that do not depend on a problem.
    ///
    /// # Errors
    /// Names the first number out of range.
    pub fn validate(&self) -> Result<(), ProblemError> {
        for (quantity, count) in [
            ("vx_samples", self.vx_samples),
            ("vtheta_samples", self.vtheta_samples),
        ] {
            in_range(quantity, f64::from(count), "", count > 0, "at least 1")?;
        }
        for (quantity, value, unit) in [
            ("control_period_s", self.control_period_s, "s"),
            ("sim_time_s", self.sim_time_s, "s"),
            ("sim_step_s", self.sim_step_s, "s"),
            ("max_clearance_m", self.max_clearance_m, "m"),
        ] {
            let fits = value > 0.0 && value <= LONGEST;
            in_range(quantity, value, unit, fits, "above zero and at most 1000")?;
        }
        let period_s = self.control_period_s;
        let fits = period_s >= SHORTEST_PERIOD_S;
        in_range("control_period_s", period_s, "s", fits, "at least 0.0001 s")?;
        check_counts(self.vx_samples, self.vtheta_samples, self.steps())?;
        self.weights.validate()
    }
}
