//! Samplers: the kinds of motions that a decision compares.

use serde::{Deserialize, Serialize};

use crate::geometry::Twist;
use crate::robot::Limits;
use crate::settings::{choices, setting_schema, words};

/// Largest number of segments of a profile.
pub(super) const MAX_SEGMENTS: usize = 4;

words! {
    /// How the samples of a decision move over the horizon.
    ///
    /// Turning in place, standing, reversing and the last command are samples of every sampler where limits and window
    /// permit them.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
    pub enum Sampler {
        /// A constant forward speed and turn rate, reached at once (eq. 27).
        #[default]
        Arcs = "arcs",
        /// A constant acceleration from the present velocity, then a constant velocity. The window holds the velocities that
        /// are reachable within the ramp.
        Ramps = "ramps",
        /// A first velocity, then a second one that is reached with the limits' acceleration. The ends of the second segments are spread
        /// evenly (C-Uniform, arXiv 2409.12266).
        TwoSegments = "two_segments",
        /// A first velocity, then turn rates and speeds that change by seeded noise (as in MPPI).
        Sequences = "sequences",
    }
}

setting_schema! {
    Sampler: choices::<Self>();
}

impl Sampler {
    /// Number of segments of every profile.
    pub(super) const fn segment_count(self) -> usize {
        match self {
            Self::Arcs => 1,
            Self::Ramps => 2,
            Self::TwoSegments => 3,
            Self::Sequences => MAX_SEGMENTS,
        }
    }
}

/// What the motions of [`Sampler::Ramps`], [`Sampler::TwoSegments`] and [`Sampler::Sequences`] depend on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SamplerInputs {
    /// Velocity of the robot at the start.
    pub twist: Twist,
    /// Limits of the later velocities and of the accelerations.
    pub limits: Limits,
    /// Time for which the command of the decision applies, seconds.
    pub control_period_s: f64,
    /// Time in which a ramp reaches its velocity, seconds; rounded to whole steps.
    pub ramp_time_s: f64,
    /// Seed of the noise of sequences.
    pub seed: u32,
}

impl Default for SamplerInputs {
    fn default() -> Self {
        Self {
            twist: Twist::default(),
            limits: Limits::default(),
            control_period_s: 0.1,
            ramp_time_s: 0.5,
            seed: 0,
        }
    }
}
