//! How the local planner samples and weighs, under the names that ROS users know.

use serde::{Deserialize, Serialize};

use super::ranges::{check_counts, in_range};
use super::{Normalization, Outside, ProblemError, Stopping, Weights};
use crate::documented::documented;

documented! {
    /// Sampling density, horizon and weights. The defaults drive the default robot.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct LocalSettings {
        /// Forward speeds tried at each decision, at least 1; times `vtheta_samples` at most 4194304.
        pub vx_samples: u32,
        /// VthetaSample rates tried at each decision, at least 1.
        pub vtheta_samples: u32,
        /// Time from one decision to the next, seconds, 0.0001 to 1000: the window spans what can be reached within it.
        pub control_period_s: f64,
        /// Horizon, seconds, above zero and at most 1000, and at most 1023 steps.
        pub sim_time_s: f64,
        /// Time between two checked poses, seconds, above zero and at most 1000.
        pub sim_step_s: f64,
        /// Clearance beyond which more is not better, metres, above zero and at most 1000.
        pub max_clearance_m: f64,
        /// What lies beyond the local field: `obstacle` or `free`.
        pub outside: Outside,
        /// How much each term counts.
        pub weights: Weights,
        /// How the terms are brought to one scale: `sum`, each over its sum, or `minmax`, each by its place between its
        /// least and greatest.
        pub normalization: Normalization,
        /// What a sample must be able to stop within: `clearance`, the smallest along the trajectory, or `arc`, the way
        /// left before contact.
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

/// How densely the window is sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Sampling {
    /// Forward speeds.
    pub vx_samples: u32,
    /// VthetaSample rates.
    pub vtheta_samples: u32,
}

impl LocalSettings {
    /// How densely these settings sample.
    #[must_use]
    pub const fn sampling(&self) -> Sampling {
        Sampling {
            vx_samples: self.vx_samples,
            vtheta_samples: self.vtheta_samples,
        }
    }

    /// Steps of the horizon, at least one.
    #[must_use]
    pub fn steps(&self) -> u32 {
        (self.sim_time_s / self.sim_step_s).round().max(1.0) as u32
    }
}

/// The longest horizon or step that makes sense, seconds, and the largest clearance, metres.
const LONGEST: f64 = 1000.0;
/// A loop cannot turn faster, seconds.
const SHORTEST_PERIOD_S: f64 = 1e-4;

impl LocalSettings {
    /// Checks the numbers that do not depend on a problem.
    ///
    /// # Errors
    /// Names the first that is out of range.
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
