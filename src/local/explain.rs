//! An answer in metres, radians and seconds, for people and records.

use core::f64::consts::PI;

use serde::Serialize;

use super::{Evaluation, Normalization, Prepared, Problem, Terms, Totals, rollout};
use crate::geometry::{Pose, Twist, wrap_angle};

/// The four terms in SI units, named as in the paper's eq. 35.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct TermsSi {
    /// Pi less the angle between final heading and target, radians.
    pub heading: f64,
    /// Smallest clearance, metres.
    pub dist: f64,
    /// Forward speed, m/s; zero for a reversing sample.
    pub vel: f64,
    /// Distance from the end to the key node, metres.
    pub combine: f64,
}

impl TermsSi {
    fn to_array(self) -> [f64; 4] {
        [self.heading, self.dist, self.vel, self.combine]
    }
}

/// The chosen sample in SI units.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct WinnerSi {
    /// Sample index.
    pub index: u32,
    /// Forward speed, m/s.
    pub v: f64,
    /// Turn rate, rad/s.
    pub omega: f64,
    /// Its terms.
    #[serde(flatten)]
    pub terms: TermsSi,
    /// Its score (eq. 35) with the weights as given.
    pub score: f64,
}

/// One sample in SI units.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SampleSi {
    /// Sample index.
    pub index: u32,
    /// Forward speed, m/s.
    pub v: f64,
    /// Turn rate, rad/s.
    pub omega: f64,
    /// Whether it may be driven.
    pub admissible: bool,
    /// Why, in a word.
    pub reason: &'static str,
    /// Where it ends, map frame.
    pub end: Pose,
    /// Its terms; zero unless admissible.
    #[serde(flatten)]
    pub terms: TermsSi,
    /// Its score; none unless admissible.
    pub score: Option<f64>,
}

/// Translates answers to one problem.
pub struct Explainer<'a> {
    problem: &'a Problem,
    prepared: &'a Prepared,
    totals: Totals,
}

impl<'a> Explainer<'a> {
    /// For the evaluation of a problem.
    #[must_use]
    pub const fn new(
        problem: &'a Problem,
        prepared: &'a Prepared,
        evaluation: &Evaluation,
    ) -> Self {
        Self {
            problem,
            prepared,
            totals: evaluation.totals,
        }
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
        let signed = [
            weights.heading,
            weights.clearance,
            weights.velocity,
            -weights.path,
        ];
        let value = self.terms(terms).to_array();
        let least = self.scale(self.totals.least.map(f64::from)).to_array();
        let greatest = self.scale(self.totals.greatest.map(f64::from)).to_array();
        let sums = self.sums().to_array();
        let share = |term: usize| {
            let (part, whole) = match self.problem.normalization {
                Normalization::Sum => (value[term], sums[term]),
                Normalization::MinMax => (value[term] - least[term], greatest[term] - least[term]),
            };
            if whole == 0.0 {
                0.0
            } else {
                signed[term] * part / whole
            }
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
                v: linear,
                omega: angular,
                terms: self.terms(&winner.terms),
                score: self.score(&winner.terms),
            }
        })
    }

    /// Every sample of an evaluation that has them.
    #[must_use]
    pub fn samples(&self, evaluation: &Evaluation) -> Vec<SampleSi> {
        let header = &self.prepared.header;
        let speeds = self.prepared.speeds.len();
        let mut table = vec![0; rollout::table_words(header)];
        let mut samples = Vec::with_capacity(self.prepared.len());
        for (index, record) in evaluation.samples.iter().flatten().enumerate() {
            let turn = &self.prepared.turns[index / speeds];
            if index % speeds == 0 {
                rollout::tabulate(header, turn, &self.prepared.discs, &mut table);
            }
            let speed = &self.prepared.speeds[index % speeds];
            let admissible = record.reason == super::Reason::Ok;
            let twist = self.problem.window.twist(index as u32);
            samples.push(SampleSi {
                index: index as u32,
                v: twist.linear,
                omega: twist.angular,
                admissible,
                reason: record.reason.word(),
                end: self.end_pose(rollout::end_position(header, speed, &table), twist.angular),
                terms: self.terms(&record.terms),
                score: admissible.then(|| self.score(&record.terms)),
            });
        }
        samples
    }

    fn end_pose(&self, (fine_x, fine_y): (i32, i32), turn_rate: f64) -> Pose {
        let fine_m = self.prepared.field.unit_m() / super::prepare::FINE_PER_UNIT;
        let origin = self.prepared.field.frame().origin;
        let moved = crate::geometry::Vector::new(f64::from(fine_x), f64::from(fine_y)) * fine_m;
        let end = self.problem.pose.position() + origin.isometry().rotation * moved;
        let horizon_s = f64::from(self.problem.steps) * self.problem.step_s;
        Pose::new(
            end.x,
            end.y,
            wrap_angle(self.problem.pose.yaw + turn_rate * horizon_s),
        )
    }

    fn scale(&self, [heading, clearance, velocity, path]: [f64; 4]) -> TermsSi {
        let unit_m = self.prepared.field.unit_m();
        TermsSi {
            heading: heading * PI / 2.0_f64.powi(23),
            dist: clearance * unit_m,
            vel: velocity / 2.0_f64.powi(20),
            combine: path * unit_m / super::prepare::FINE_PER_UNIT,
        }
    }
}
