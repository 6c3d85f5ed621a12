//! The trajectory fan of a decision: some trajectories of its window with their scores, for display.

use serde::Serialize;

use super::{
    Evaluation, Explainer, Problem, QuantizedProblem, SampleStatus, Sampling, Terms, WinnerSi,
};
use super::{rollout, score};
use crate::geometry::{Pose, Twist};
use crate::map::MovingDisc;

/// Some samples of a decision, evenly spaced over its window, and the winner.
#[derive(Clone, Debug, PartialEq, Serialize)]
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
    pub(super) fn new(
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
            let heading = rollout::end_heading(header, vtheta);
            for column in evenly_spaced(vx_count, max.vx_samples) {
                let vx = &quantized.vx_samples[column];
                let (status, clearance) = rollout::evaluate_sample(quantized, vx, vtheta, &table);
                let terms = || -> Terms {
                    let end = rollout::end_position(header, vx, &table);
                    score::terms(header, vx, heading, end, clearance)
                };
                arcs.push(FanArc {
                    twist: problem.window.twist((row * vx_count + column) as u32),
                    score: (status == SampleStatus::Ok).then(|| explainer.score(&terms())),
                    status,
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

    /// The worst and the best score in the fan; `(inf, -inf)` when no arc is admissible.
    #[must_use]
    pub fn score_range(&self) -> (f64, f64) {
        let scores = || self.arcs.iter().filter_map(|arc| arc.score);
        (scores().fold(f64::INFINITY, f64::min), scores().fold(f64::NEG_INFINITY, f64::max))
    }

    /// The score of each arc, scaled to 0 for the worst and 1 for the best in the fan; 1 when all are equal. `None` for
    /// an arc that is not admissible.
    pub fn relative_scores(&self) -> impl Iterator<Item = Option<f64>> + '_ {
        let (worst, best) = self.score_range();
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
