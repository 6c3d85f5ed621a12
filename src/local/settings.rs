//! Settings of the local planner, with Nav2's names where Nav2 has them.

use serde::{Deserialize, Serialize};

use super::problem::check_counts;
use super::{Normalization, Outside, Sampler, Stopping, Weights};
use crate::robot::Limits;
use crate::settings::{require, settings};

settings! {
    /// Sampling density, horizon and weights. The defaults suit the default robot.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct LocalSettings {
        /// Number of forward speeds per decision; times `vtheta_samples` at most 4194304.
        pub vx_samples: u32 = 20, ["", at_least 1];
        /// Number of turn rates per decision.
        pub vtheta_samples: u32 = 40, ["", at_least 1];
        /// Motion of the samples: `arcs` of constant velocity; `ramps` with a constant acceleration; `two_segments`, a
        /// second velocity after the first; `sequences` with seeded noise.
        pub sampler: Sampler = Sampler::default();
        /// Duration of the acceleration of `ramps`: the window holds the velocities reachable within it.
        pub ramp_time_s: f64 = 0.5, ["s", above 0 to 1000];
        /// Seed of the noise of `sequences`.
        pub sampler_seed: u32 = 0, ["", at_least 0];
        /// Time between decisions: the window holds the velocities reachable within it.
        pub control_period_s: f64 = 0.1, ["s", 0.0001 to 1000];
        /// Horizon of the rollout, and at most 1023 steps.
        pub sim_time_s: f64 = 2.5, ["s", above 0 to 1000];
        /// Time between two checked poses, at most `sim_time_s`.
        pub sim_step_s: f64 = 0.1, ["s", above 0 to 1000];
        /// Cap of the clearance: more clearance does not improve the score. A drive uses a larger one, up to 3 m, where the robot needs
        /// more to stop: with `stopping = "clearance"` a smaller one would limit its speed. Together with the radii of the robot's
        /// discs and of moving obstacles at most 5.6 to 11.3 m, by the resolution of the map: 9 m for cells of 5 cm.
        pub max_clearance_m: f64 = 1.5, ["m", above 0 to 11];
        /// State of cells outside the local field: `obstacle` or `free`.
        pub outside: Outside = Outside::default();
        /// Weights of the terms.
        pub weights: Weights = Weights::default();
        /// Normalisation of the terms: `minmax` maps each to 0 at its minimum and 1 at its maximum, so that the weights mean the
        /// same at every speed; `sum` divides each by its sum, as the paper.
        pub normalization: Normalization = Normalization::MinMax;
        /// Distance within which a sample must be able to stop: `clearance`, the smallest along the trajectory, or
        /// `arc`, the arc before contact.
        pub stopping: Stopping = Stopping::default();
    }
    rule |settings| {
        let (step_s, horizon_s) = (settings.sim_step_s, settings.sim_time_s);
        require(step_s <= horizon_s, "sim_step_s", step_s, "at most sim_time_s")?;
        check_counts(settings.vx_samples, settings.vtheta_samples, settings.steps())
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
    /// The clearance, metres, that a robot with these limits needs at its highest speed or turn rate (eq. 30).
    pub(super) fn clearance_to_stop_m(&self, limits: &Limits) -> f64 {
        if self.stopping == Stopping::Arc {
            return 0.0;
        }
        let to_stop = |velocity: f64, braking: f64| velocity * velocity / (2.0 * braking.abs());
        to_stop(limits.max_vel_x, limits.decel_lim_x)
            .max(to_stop(limits.min_vel_x, limits.decel_lim_x))
            .max(to_stop(limits.max_vel_theta, limits.decel_lim_theta))
    }

    /// The sampling density of these settings.
    #[must_use]
    pub const fn sampling(&self) -> Sampling {
        Sampling { vx_samples: self.vx_samples, vtheta_samples: self.vtheta_samples }
    }

    /// Number of steps of the horizon, at least one.
    #[must_use]
    pub fn steps(&self) -> u32 {
        (self.sim_time_s / self.sim_step_s).round().max(1.0) as u32
    }
}
