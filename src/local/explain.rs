//! Answers in metres, radians and seconds, and the trajectory fan of a decision, for display and records.

use core::f64::consts::{PI, TAU};

use serde::Serialize;

use super::cpu::scalar;
use super::{
    Counts, Evaluation, Normalization, Problem, QuantizedProblem, SampleStatus, Sampler, Sampling,
    Terms, Totals, rollout,
};
use crate::geometry::{Point, Pose, Twist, Vector, wrap_angle};
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
    /// Its status, see [`SampleStatus::name`].
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
            let Twist { linear, angular } = self.problem.command(winner.index);
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
            let profile = &self.quantized.profiles[index / vx_count];
            if index % vx_count == 0 {
                rollout::tabulate(self.quantized, index / vx_count, &mut table);
            }
            let vx = &self.quantized.vx_samples[index % vx_count];
            let admissible = record.status == SampleStatus::Ok;
            let twist = self.problem.command(index as u32);
            samples.push(SampleSi {
                index: index as u32,
                vx: twist.linear,
                vtheta: twist.angular,
                admissible,
                status: record.status.name(),
                end: self.end_pose(rollout::end_position(header, vx, &table), profile.end_turn),
                terms: self.terms(&record.terms),
                score: admissible.then(|| self.score(&record.terms)),
            });
        }
        samples
    }

    fn end_pose(&self, (fine_x, fine_y): (i32, i32), end_turn: u32) -> Pose {
        let fine_m = self.quantized.field.unit_m() / super::quantize::FINE_PER_UNIT;
        let origin = self.quantized.field.frame().origin;
        let displacement = Vector::new(f64::from(fine_x), f64::from(fine_y)) * fine_m;
        let turn = libm::sincos(origin.yaw);
        let end = self.problem.pose.position() + displacement.rotated(turn);
        let turn = f64::from(end_turn as i32) / 2.0_f64.powi(32) * TAU;
        Pose::new(end.x, end.y, wrap_angle(self.problem.pose.yaw + turn))
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
    /// Position of the winner after each step, map frame; empty as [`FanArc::path`].
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub winner_path: Vec<Point>,
    /// The moving obstacles at the start with their velocities, which predict their later positions.
    pub obstacles: Vec<MovingDisc>,
}

/// One sample of a [`TrajectoryFan`].
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct FanArc {
    /// Its velocity in the first control period.
    pub twist: Twist,
    /// Its score; `None` unless admissible.
    pub score: Option<f64>,
    /// Admissible, or the cause of the rejection.
    #[serde(skip)]
    pub status: SampleStatus,
    /// Its position after each step, map frame; empty where it keeps its velocity over the whole horizon.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub path: Vec<Point>,
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
        for row in evenly_spaced(quantized.profiles.len(), max.vtheta_samples) {
            let profile = &quantized.profiles[row];
            rollout::tabulate(quantized, row, &mut table);
            for column in evenly_spaced(vx_count, max.vx_samples) {
                let vx = &quantized.vx_samples[column];
                let sample = scalar::evaluate_sample(quantized, vx, profile, &table);
                let is_admissible = sample.status == SampleStatus::Ok;
                let index = (row * vx_count + column) as u32;
                arcs.push(FanArc {
                    twist: problem.command(index),
                    score: is_admissible.then(|| explainer.score(&sample.terms)),
                    status: sample.status,
                    path: drawn_path(problem, index),
                });
            }
        }
        Self {
            from: problem.pose,
            horizon_s: f64::from(problem.steps) * problem.step_s,
            arcs,
            columns: evenly_spaced(vx_count, max.vx_samples).count(),
            winner: explainer.winner(answer),
            winner_path: answer
                .winner
                .as_ref()
                .map_or_else(Vec::new, |winner| drawn_path(problem, winner.index)),
            obstacles: problem.obstacles.clone(),
        }
    }

    /// At most `parts + 1` positions along a sample, from the start to its end, for display.
    #[must_use]
    pub fn points(&self, arc: &FanArc, parts: u32) -> Vec<Point> {
        self.along(&arc.twist, &arc.path, parts)
    }

    /// At most `parts + 1` positions along the winner; empty when no sample is admissible.
    #[must_use]
    pub fn winner_points(&self, parts: u32) -> Vec<Point> {
        self.winner.as_ref().map_or_else(Vec::new, |winner| {
            self.along(&Twist::new(winner.vx, winner.vtheta), &self.winner_path, parts)
        })
    }

    fn along(&self, twist: &Twist, path: &[Point], parts: u32) -> Vec<Point> {
        if path.is_empty() {
            return self.from.arc(twist, self.horizon_s, parts).collect();
        }
        let later = evenly_spaced(path.len() + 1, parts + 1).skip(1);
        core::iter::once(self.from.position()).chain(later.map(|step| path[step - 1])).collect()
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

/// The path of a sample; empty where it keeps its velocity.
fn drawn_path(problem: &Problem, index: u32) -> Vec<Point> {
    if problem.sampler == Sampler::Arcs { Vec::new() } else { problem.path(index) }
}

/// At most `max` evenly spaced indices below `count`; with at least two, the first and the last are among them.
pub fn evenly_spaced(count: usize, max: u32) -> impl Iterator<Item = usize> {
    let shown = count.min(max as usize);
    let gaps = shown.saturating_sub(1).max(1);
    (0..shown).map(move |place| place * (count - 1) / gaps)
}
