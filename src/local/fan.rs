//! The dynamic window of a decision as people look at it: some of its arcs, each with its score.

use serde::Serialize;

use super::{Evaluation, Explainer, Prepared, Problem, Reason, Sampling, Terms, WinnerSi};
use super::{rollout, score};
use crate::geometry::{Pose, Twist};
use crate::map::MovingDisc;

/// Some of the samples of a decision, spread evenly over its window, and the one that was chosen.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Fan {
    /// Where all arcs begin: where the robot will be when the command begins to act.
    pub from: Pose,
    /// How long they are, seconds.
    pub horizon_s: f64,
    /// The samples, speeds first: the least and the greatest of each axis are among them.
    pub arcs: Vec<FanArc>,
    /// How many of them in a row differ in their speed.
    pub columns: usize,
    /// The sample that was chosen, if one was admissible.
    pub winner: Option<WinnerSi>,
    /// The moving obstacles at the beginning, with their velocities: where they are predicted to be at each later time.
    pub obstacles: Vec<MovingDisc>,
}

/// One sample.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FanArc {
    /// Its velocities.
    pub twist: Twist,
    /// Its score; none where it is not admissible.
    pub score: Option<f64>,
    /// Whether it is admissible, and if not, why.
    #[serde(skip)]
    pub reason: Reason,
}

impl Fan {
    /// At most so many samples along each axis of the decision on a problem.
    ///
    /// They are judged by the shaders' twins on the CPU, so that they are the engine's own to the bit; normalised by its
    /// answer, they have the scores that it compared.
    pub(super) fn new(
        problem: &Problem,
        prepared: &Prepared,
        answer: &Evaluation,
        most: Sampling,
    ) -> Self {
        let explainer = Explainer::new(problem, prepared, answer);
        let header = &prepared.header;
        let speeds = prepared.speeds.len();
        let mut table = vec![0; rollout::table_words(header)];
        let mut arcs = Vec::new();
        for row in spread(prepared.turns.len(), most.vtheta_samples) {
            let turn = &prepared.turns[row];
            rollout::tabulate(header, turn, &prepared.discs, &mut table);
            let heading = rollout::end_heading(header, turn);
            for column in spread(speeds, most.vx_samples) {
                let speed = &prepared.speeds[column];
                let (reason, clearance) = rollout::judge(prepared, speed, turn, &table);
                let terms = || -> Terms {
                    let end = rollout::end_position(header, speed, &table);
                    score::terms(header, speed, heading, end, clearance)
                };
                arcs.push(FanArc {
                    twist: problem.window.twist((row * speeds + column) as u32),
                    score: (reason == Reason::Ok).then(|| explainer.score(&terms())),
                    reason,
                });
            }
        }
        Self {
            from: problem.pose,
            horizon_s: f64::from(problem.steps) * problem.step_s,
            arcs,
            columns: spread(speeds, most.vx_samples).count(),
            winner: explainer.winner(answer),
            obstacles: problem.obstacles.clone(),
        }
    }
}

impl Fan {
    /// The worst and the best score of those shown; infinite, the wrong way round, where there is none.
    #[must_use]
    pub fn score_range(&self) -> (f64, f64) {
        let scores = || self.arcs.iter().filter_map(|arc| arc.score);
        (
            scores().fold(f64::INFINITY, f64::min),
            scores().fold(f64::NEG_INFINITY, f64::max),
        )
    }

    /// The place of each arc's score from the worst shown, 0, to the best, 1, and 1 where all are the same; none for an arc that
    /// is not admissible.
    pub fn shares(&self) -> impl Iterator<Item = Option<f64>> + '_ {
        let (worst, best) = self.score_range();
        let range = best - worst;
        let share = move |score: f64| {
            if range > 0.0 {
                (score - worst) / range
            } else {
                1.0
            }
        };
        self.arcs.iter().map(move |arc| arc.score.map(share))
    }
}

/// At most `most` of the numbers below `count`, evenly, the first and the last among them where there is room for two.
pub fn spread(count: usize, most: u32) -> impl Iterator<Item = usize> {
    let shown = count.min(most as usize);
    let gaps = shown.saturating_sub(1).max(1);
    (0..shown).map(move |place| place * (count - 1) / gaps)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_spread_from_end_to_end() {
        let spread = |count, most| spread(count, most).collect::<Vec<_>>();
        assert_eq!(spread(10, 4), [0, 3, 6, 9]);
        assert_eq!(spread(3, 9), [0, 1, 2]);
        assert_eq!(spread(7, 1), [0]);
        assert_eq!(spread(1, 5), [0]);
        assert!(spread(5, 0).is_empty());
    }
}
