//! What an engine takes and gives, and what it promises.
//!
//! **The promise.** For one [`Prepared`] problem every engine on every machine returns equal [`Evaluation`]s: `==`,
//! bit for bit. A sample is judged as follows.
//!
//! - *Collision*: the smallest clearance of any disc at any checked step is not above zero.
//! - *Outside*: else, a disc's centre leaves the field at some step, and [`Outside::Obstacle`](super::Outside) is set.
//! - *Cannot stop*: else, the braking constraint (eq. 30) fails.
//! - *Ok*: else; it is admissible.
//!
//! With [`Stopping::Arc`](super::Stopping) the steps before the first contact or exit are the free steps: a sample
//! without any is a collision, or outside, by what came first (contact, if both at one step); one with too few to stop
//! in cannot stop; else it is admissible, and its clearance is taken over its free steps.
//!
//! The winner has the largest score; of equal scores, the lowest index.

use super::{EngineError, Incidents, Prepared};

/// The four terms of a sample, each below 2^24.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Terms {
    /// Half a turn less the angle between final heading and target: 2^23 is pi.
    pub heading: u32,
    /// Smallest clearance along the trajectory, capped, in units of length.
    pub clearance: u32,
    /// Forward speed in 2^-20 m/s; a reversing sample earns 0.
    pub velocity: u32,
    /// Distance from the end to the key node, in sixteenths of a unit of length.
    pub path: u32,
}

impl Terms {
    /// The terms as a list: heading, clearance, velocity, path.
    #[must_use]
    pub const fn to_array(self) -> [u32; 4] {
        [self.heading, self.clearance, self.velocity, self.path]
    }
}

/// Why a sample is admissible or not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Reason {
    /// Admissible.
    Ok = 0,
    /// It touches an obstacle.
    Collision = 1,
    /// It could not stop in time.
    CannotStop = 2,
    /// It leaves the field.
    Outside = 3,
}

impl Reason {
    /// The reason of a number, as the shaders write it.
    #[must_use]
    pub const fn from_number(number: u32) -> Self {
        match number & 3 {
            0 => Self::Ok,
            1 => Self::Collision,
            2 => Self::CannotStop,
            _ => Self::Outside,
        }
    }

    /// The word used in JSON.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::Collision => "collision",
            Self::CannotStop => "cannot_stop",
            Self::Outside => "outside",
        }
    }
}

/// One sample, judged. The terms of a sample that is not admissible are zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SampleRecord {
    /// Why it is admissible or not.
    pub reason: Reason,
    /// Its terms, all zero unless admissible.
    pub terms: Terms,
}

/// How many samples were judged how.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Admissible ones.
    pub admissible: u32,
    /// Those that touch an obstacle.
    pub collision: u32,
    /// Those that could not stop in time.
    pub cannot_stop: u32,
    /// Those that leave the field.
    pub outside: u32,
}

impl Counts {
    /// The counts as a list: admissible, collision, cannot stop, outside.
    #[must_use]
    pub const fn to_array(self) -> [u32; 4] {
        [
            self.admissible,
            self.collision,
            self.cannot_stop,
            self.outside,
        ]
    }
}

/// Sum, least and greatest of each term over the admissible samples; heading, clearance, velocity, path.
///
/// Without any admissible sample the sums and greatest are zero and the least are `u32::MAX`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Totals {
    /// Exact sums.
    pub sums: [u64; 4],
    /// Least values.
    pub least: [u32; 4],
    /// Greatest values.
    pub greatest: [u32; 4],
}

impl Default for Totals {
    fn default() -> Self {
        Self {
            sums: [0; 4],
            least: [u32::MAX; 4],
            greatest: [0; 4],
        }
    }
}

/// The best sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Winner {
    /// Sample index: `omega_index * v_count + v_index`.
    pub index: u32,
    /// Its score; weights that sum to one make a perfect share of every term 2^62.
    pub score: i64,
    /// Its terms.
    pub terms: Terms,
}

/// The answer to one problem.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Evaluation {
    /// How many samples were judged how.
    pub counts: Counts,
    /// What normalises the terms.
    pub totals: Totals,
    /// The best sample, or none when no sample is admissible.
    pub winner: Option<Winner>,
    /// Every sample in order of index, when asked for.
    pub samples: Option<Vec<SampleRecord>>,
}

/// How much of the answer to return.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Detail {
    /// The winner and the counts: what driving needs.
    Answer,
    /// Every sample as well.
    Samples,
}

/// Something that evaluates problems.
pub trait Engine: Send {
    /// What it runs on, for people: `CPU, 2 threads`, or the adapter's name.
    fn name(&self) -> String;

    /// `cpu` or `gpu`.
    fn kind(&self) -> &'static str;

    /// Threads of a CPU engine; zero for a GPU.
    fn threads(&self) -> usize;

    /// Evaluates every sample of a problem and chooses one.
    ///
    /// # Errors
    /// When the device behind the engine fails. An engine that has failed may be asked again.
    fn evaluate(&mut self, problem: &Prepared, detail: Detail) -> Result<Evaluation, EngineError>;

    /// Evaluates problems that have nothing to do with one another: other robots, worlds, weights, modes. The answers
    /// are in their order and equal those of [`Self::evaluate`], bit for bit; no problem, no answer.
    ///
    /// # Errors
    /// The first problem's that would be an error alone; no answer of the others is given then.
    fn evaluate_batch(
        &mut self,
        problems: &[Prepared],
        detail: Detail,
    ) -> Result<Vec<Evaluation>, EngineError> {
        let one = |problem| self.evaluate(problem, detail);
        problems.iter().map(one).collect()
    }

    /// What an engine with a stand-in has met so far; none for one without.
    fn incidents(&self) -> Option<&Incidents> {
        None
    }
}
