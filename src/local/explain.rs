//! Answers in metres, radians and seconds, and the trajectory fan of a decision, for display and records.

use core::f64::consts::PI;

use serde::Serialize;

use super::cpu::scalar;
use super::{
    Counts, Evaluation, Normalization, Problem, QuantizedProblem, SampleStatus, Sampling, Terms,
    Totals, rollout,
};
use crate::geometry::{Pose, Twist, Vector, wrap_angle};
use crate::map::MovingDisc;

/// The four terms in SI units.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct TermsSi {
    /// Pi minus the angle between the final heading and the target, radians.
    pub heading: f64,
    /// Smallest clearance, metres.
    pub clearance: f64,
    /// Forward speed, m/s; zero for a reversing sample.
    pub velocity: f64,
    /// Distance from the final position to the key node, metres.
    pub path: f64,
}

impl TermsSi {
    fn to_array(self) -> [f64; 4] {
        [self.heading, self.clearance, self.velocity, self.path]
    }
}

/// The winner in SI units.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct WinnerSi {
    /// Sample index.
    pub index: u32,
    /// Forward speed, m/s.
    pub vx: f64,
    /// Turn rate, rad/s.
    pub vtheta: f64,
    /// Its terms.
    #[serde(flatten)]
    pub terms: TermsSi,
    /// Its score (eq. 35) with the problem's weights.
    pub score: f64,
}

/// A sample in SI units.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct SampleSi {
    /// Sample index.
    pub index: u32,
    /// Forward speed, m/s.
    pub vx: f64,
    /// Turn rate, rad/s.
    pub vtheta: f64,
    /// Whether the robot may drive it.
    pub admissible: bool,
    /// Its status, see [`SampleStatus::as_str`].
    pub status: &'static str,
    /// Its final pose, map frame.
    pub end: Pose,
    /// Its terms; zero unless admissible.
    #[serde(flatten)]
    pub terms: TermsSi,
    /// Its score; `None` unless admissible.
    pub score: Option<f64>,
}

/// The answer to one problem in SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Decision {
    /// The best sample; `None` when no sample is admissible. The robot must stop then.
    pub winner: Option<WinnerSi>,
    /// The number of samples of each status.
    pub counts: Counts,
}

impl Decision {
    /// The velocity command of the winner; zero velocity when no sample is admissible.
    #[must_use]
    pub fn command(&self) -> Twist {
        let velocity = |winner: WinnerSi| Twist::new(winner.vx, winner.vtheta);
        self.winner.map_or_else(Twist::default, velocity)
    }
}

/// Converts the answers to one problem.
pub struct Explainer<'a> {
    problem: &'a Problem,
    quantized: &'a QuantizedProblem,
    totals: Totals,
}

impl<'a> Explainer<'a> {
    /// Converts with the totals of an evaluation.
    #[must_use]
    pub const fn new(
        problem: &'a Problem,
        quantized: &'a QuantizedProblem,
        evaluation: &Evaluation,
    ) -> Self {
        Self { problem, quantized, totals: evaluation.totals }
    }

    /// Terms in SI units.
    #[must_use]
    pub fn terms(&self, terms: &Terms) -> TermsSi {
        self.scale(terms.to_array().map(f64::from))
    }

    /// Sums of the terms over the admissible samples, in SI units.
    #[must_use]
    pub fn sums(&self) -> TermsSi {
        self.scale(self.totals.sums.map(|sum| sum as f64))
    }

    /// The score of an admissible sample.
    #[must_use]
    pub fn score(&self, terms: &Terms) -> f64 {
        let weights = &self.problem.weights;
        let signed = [weights.heading, weights.clearance, weights.velocity, -weights.path];
        let value = self.terms(terms).to_array();
        let min = self.scale(self.totals.min.map(f64::from)).to_array();
        let max = self.scale(self.totals.max.map(f64::from)).to_array();
        let sums = self.sums().to_array();
        let share = |term: usize| {
            let (part, whole) = match self.problem.normalization {
                Normalization::Sum => (value[term], sums[term]),
                Normalization::MinMax => (value[term] - min[term], max[term] - min[term]),
            };
            if whole == 0.0 { 0.0 } else { signed[term] * part / whole }
        };
        (0..4).map(share).sum()
    }

    /// The winner of an evaluation.
    #[must_use]
    pub fn winner(&self, evaluation: &Evaluation) -> Option<WinnerSi> {
        evaluation.winner.as_ref().map(|winner| {
            let Twist { linear, angular } = self.problem.window.twist(winner.index);
            WinnerSi {
                index: winner.index,
                vx: linear,
                vtheta: angular,
                terms: self.terms(&winner.terms),
                score: self.score(&winner.terms),
            }
        })
    }

    /// The decision of an evaluation.
    #[must_use]
    pub fn decision(&self, evaluation: &Evaluation) -> Decision {
        Decision { winner: self.winner(evaluation), counts: evaluation.counts }
    }

    /// Every sample of an evaluation; empty for one without [`Detail::Samples`](super::Detail).
    #[must_use]
    pub fn samples(&self, evaluation: &Evaluation) -> Vec<SampleSi> {
        let header = &self.quantized.header;
        let vx_count = self.quantized.vx_samples.len();
        let mut table = vec![0; rollout::table_words(header)];
        let mut samples = Vec::with_capacity(self.quantized.len());
        for (index, record) in evaluation.samples.iter().flatten().enumerate() {
            let vtheta = &self.quantized.vtheta_samples[index / vx_count];
            if index % vx_count == 0 {
                rollout::tabulate(header, vtheta, &self.quantized.discs, &mut table);
            }
            let vx = &self.quantized.vx_samples[index % vx_count];
            let admissible = record.status == SampleStatus::Ok;
            let twist = self.problem.window.twist(index as u32);
            samples.push(SampleSi {
                index: index as u32,
                vx: twist.linear,
                vtheta: twist.angular,
                admissible,
                status: record.status.as_str(),
                end: self.end_pose(rollout::end_position(header, vx, &table), twist.angular),
                terms: self.terms(&record.terms),
                score: admissible.then(|| self.score(&record.terms)),
            });
        }
        samples
    }

    fn end_pose(&self, (fine_x, fine_y): (i32, i32), turn_rate: f64) -> Pose {
        let fine_m = self.quantized.field.unit_m() / super::quantize::FINE_PER_UNIT;
        let origin = self.quantized.field.frame().origin;
        let displacement = Vector::new(f64::from(fine_x), f64::from(fine_y)) * fine_m;
        let turn = libm::sincos(origin.yaw);
        let end = self.problem.pose.position() + displacement.rotated(turn);
        let horizon_s = f64::from(self.problem.steps) * self.problem.step_s;
        Pose::new(end.x, end.y, wrap_angle(self.problem.pose.yaw + turn_rate * horizon_s))
    }

    fn scale(&self, [heading, clearance, velocity, path]: [f64; 4]) -> TermsSi {
        let unit_m = self.quantized.field.unit_m();
        TermsSi {
            heading: heading * PI / 2.0_f64.powi(23),
            clearance: clearance * unit_m,
            velocity: velocity / 2.0_f64.powi(20),
            path: path * unit_m / super::quantize::FINE_PER_UNIT,
        }
    }
}

/// Some samples of a decision, evenly spaced over its window, and the winner.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct TrajectoryFan {
    /// Start of all arcs: the predicted pose at the time at which the command takes effect.
    pub from: Pose,
    /// Duration of the arcs, seconds.
    pub horizon_s: f64,
    /// The samples, row-major: the forward speed varies first. Both ends of each axis are among them.
    pub arcs: Vec<FanArc>,
    /// Number of arcs in a row.
    pub columns: usize,
    /// The winner; `None` when no sample is admissible.
    pub winner: Option<WinnerSi>,
    /// The moving obstacles at the start with their velocities, which predict their later positions.
    pub obstacles: Vec<MovingDisc>,
}

/// One sample of a [`TrajectoryFan`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct FanArc {
    /// Its velocity.
    pub twist: Twist,
    /// Its score; `None` unless admissible.
    pub score: Option<f64>,
    /// Admissible, or the cause of the rejection.
    #[serde(skip)]
    pub status: SampleStatus,
}

impl TrajectoryFan {
    /// Evaluates at most `max` samples along each axis.
    ///
    /// The scalar reference on the CPU evaluates them: its bits equal those of every engine. The totals of `answer`
    /// normalise the scores, so they equal the scores that the engine compared.
    #[must_use]
    pub fn new(
        problem: &Problem,
        quantized: &QuantizedProblem,
        answer: &Evaluation,
        max: Sampling,
    ) -> Self {
        let explainer = Explainer::new(problem, quantized, answer);
        let header = &quantized.header;
        let vx_count = quantized.vx_samples.len();
        let mut table = vec![0; rollout::table_words(header)];
        let mut arcs = Vec::new();
        for row in evenly_spaced(quantized.vtheta_samples.len(), max.vtheta_samples) {
            let vtheta = &quantized.vtheta_samples[row];
            rollout::tabulate(header, vtheta, &quantized.discs, &mut table);
            for column in evenly_spaced(vx_count, max.vx_samples) {
                let vx = &quantized.vx_samples[column];
                let sample = scalar::evaluate_sample(quantized, vx, vtheta, &table);
                let is_admissible = sample.status == SampleStatus::Ok;
                arcs.push(FanArc {
                    twist: problem.window.twist((row * vx_count + column) as u32),
                    score: is_admissible.then(|| explainer.score(&sample.terms)),
                    status: sample.status,
                });
            }
        }
        Self {
            from: problem.pose,
            horizon_s: f64::from(problem.steps) * problem.step_s,
            arcs,
            columns: evenly_spaced(vx_count, max.vx_samples).count(),
            winner: explainer.winner(answer),
            obstacles: problem.obstacles.clone(),
        }
    }

    /// The score of each arc, scaled to 0 for the worst and 1 for the best in the fan; 1 when all are equal. `None` for
    /// an arc that is not admissible.
    pub fn relative_scores(&self) -> impl Iterator<Item = Option<f64>> + '_ {
        let scores = || self.arcs.iter().filter_map(|arc| arc.score);
        let worst = scores().fold(f64::INFINITY, f64::min);
        let best = scores().fold(f64::NEG_INFINITY, f64::max);
        let range = best - worst;
        let relative = move |score: f64| {
            if range > 0.0 { (score - worst) / range } else { 1.0 }
        };
        self.arcs.iter().map(move |arc| arc.score.map(relative))
    }
}

/// At most `max` evenly spaced indices below `count`; with at least two, the first and the last are among them.
pub fn evenly_spaced(count: usize, max: u32) -> impl Iterator<Item = usize> {
    let shown = count.min(max as usize);
    let gaps = shown.saturating_sub(1).max(1);
    (0..shown).map(move |place| place * (count - 1) / gaps)
}
