//! The engine interface: its input, its answer and its guarantee.
//!
//! **The guarantee.** For one [`QuantizedProblem`] every engine on every machine returns equal [`Evaluation`]s: `==`,
//! bit for bit. The status of a sample is the first that applies:
//!
//! - *Collision*: the smallest clearance of any disc at any checked step is not above zero.
//! - *Outside*: a disc's centre leaves the field at some step, and [`Outside::Obstacle`](super::Outside) is set.
//! - *Cannot stop*: the braking constraint (eq. 30) fails.
//! - *Ok*: the sample is admissible.
//!
//! With [`Stopping::Arc`](super::Stopping) the free steps are those before the first contact or exit. A sample without
//! a free step has the status of what ends it, contact before exit within one step. A sample with too few free steps to
//! stop in has the status *cannot stop*. Any other sample is admissible, with the smallest clearance of its free steps.
//!
//! The winner has the largest score; of equal scores the lowest index wins.

use super::{
    Decision, DecisionError, EngineError, Explainer, Incidents, Problem, QuantizedProblem,
};

/// The four terms of a sample, each below 2^24.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Terms {
    /// Half a turn minus the angle between the final heading and the target; 2^23 is pi.
    pub heading: u32,
    /// Smallest clearance along the trajectory, capped, in units of length.
    pub clearance: u32,
    /// Forward speed of the command in 2^-20 m/s; zero for a reversing sample.
    pub velocity: u32,
    /// Distance from the final position to the key node, in sixteenths of a unit of length.
    pub path: u32,
}

impl Terms {
    /// The terms as an array: heading, clearance, velocity, path.
    #[must_use]
    pub const fn to_array(self) -> [u32; 4] {
        [self.heading, self.clearance, self.velocity, self.path]
    }
}

/// The status of a sample: admissible, or the cause of its rejection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum SampleStatus {
    /// The sample is admissible.
    Ok = 0,
    /// It touches an obstacle.
    Collision = 1,
    /// It cannot stop in time.
    CannotStop = 2,
    /// It leaves the field.
    Outside = 3,
}

impl SampleStatus {
    /// Converts the number that the shaders write; only its lowest two bits count.
    pub(crate) const fn from_u32(number: u32) -> Self {
        match number & 3 {
            0 => Self::Ok,
            1 => Self::Collision,
            2 => Self::CannotStop,
            _ => Self::Outside,
        }
    }

    /// The name in JSON.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::Collision => "collision",
            Self::CannotStop => "cannot_stop",
            Self::Outside => "outside",
        }
    }
}

/// An evaluated sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SampleRecord {
    /// Admissible, or the cause of the rejection.
    pub status: SampleStatus,
    /// Its terms; all zero unless admissible.
    pub terms: Terms,
}

/// The number of samples of each status.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Admissible samples.
    pub admissible: u32,
    /// Samples that touch an obstacle.
    pub collision: u32,
    /// Samples that cannot stop in time.
    pub cannot_stop: u32,
    /// Samples that leave the field.
    pub outside: u32,
}

impl Counts {
    /// The counts as an array: admissible, collision, cannot stop, outside.
    #[must_use]
    pub const fn to_array(self) -> [u32; 4] {
        [self.admissible, self.collision, self.cannot_stop, self.outside]
    }
}

/// Sum, minimum and maximum of each term over the admissible samples, in the order heading, clearance, velocity, path.
///
/// Without an admissible sample the sums and maxima are zero and the minima are `u32::MAX`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Totals {
    /// Exact sums.
    pub sums: [u64; 4],
    /// Minima.
    pub min: [u32; 4],
    /// Maxima.
    pub max: [u32; 4],
}

impl Default for Totals {
    fn default() -> Self {
        Self { sums: [0; 4], min: [u32::MAX; 4], max: [0; 4] }
    }
}

/// The best sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Winner {
    /// Sample index, see [`Window`](super::Window).
    pub index: u32,
    /// Its score: 2^62 for a sample with a full share of every term, when the weights sum to one.
    pub score: i64,
    /// Its terms.
    pub terms: Terms,
}

/// The answer to one problem.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Evaluation {
    /// The number of samples of each status.
    pub counts: Counts,
    /// The totals that normalise the terms.
    pub totals: Totals,
    /// The best sample; `None` when no sample is admissible.
    pub winner: Option<Winner>,
    /// Every sample in order of index, with [`Detail::Samples`].
    pub samples: Option<Vec<SampleRecord>>,
}

/// The extent of an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Detail {
    /// The winner, the counts and the totals: enough to drive.
    Answer,
    /// Every sample as well.
    Samples,
}

/// Evaluates problems on the CPU or on a GPU.
pub trait Engine: Send {
    /// The processor for display: `CPU, 2 threads, AVX2`, or the adapter's name.
    fn name(&self) -> String;

    /// Number of threads of a CPU engine; zero for a GPU.
    fn threads(&self) -> usize {
        0
    }

    /// `cpu` or `gpu`, by the number of threads.
    fn kind(&self) -> &'static str {
        if self.threads() == 0 { "gpu" } else { "cpu" }
    }

    /// Evaluates every sample of a problem and selects the winner.
    ///
    /// # Errors
    /// When the device behind the engine fails. The engine accepts further calls after an error.
    fn evaluate(
        &mut self,
        problem: &QuantizedProblem,
        detail: Detail,
    ) -> Result<Evaluation, EngineError>;

    /// Evaluates independent problems: of other robots, worlds, weights or modes. The answers are in the order of the
    /// problems and equal those of [`Self::evaluate`], bit for bit.
    ///
    /// # Errors
    /// The error of the first problem that fails; there is no answer to the other problems then.
    fn evaluate_batch(
        &mut self,
        problems: &[QuantizedProblem],
        detail: Detail,
    ) -> Result<Vec<Evaluation>, EngineError> {
        let one = |problem| self.evaluate(problem, detail);
        problems.iter().map(one).collect()
    }

    /// Takes one decision: quantises the problem, evaluates it and returns the winner in SI units.
    ///
    /// A robot that decides at every tick uses a [`LocalPlanner`](super::LocalPlanner), which reuses its memory.
    ///
    /// # Errors
    /// When a quantity is out of range (see [`Problem`]) or the engine fails.
    fn decide(&mut self, problem: &Problem) -> Result<Decision, DecisionError> {
        let quantized = QuantizedProblem::new(problem)?;
        let evaluation = self.evaluate(&quantized, Detail::Answer)?;
        Ok(Explainer::new(problem, &quantized, &evaluation).decision(&evaluation))
    }

    /// GPU failures so far, for an engine with a CPU fallback; `None` for any other engine.
    fn incidents(&self) -> Option<Incidents> {
        None
    }
}
