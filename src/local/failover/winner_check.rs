//! The winner of another engine, judged again: one sample, by the scalar code that the shaders are twins of.

use crate::local::engine::{Detail, Evaluation, SampleRecord, SampleStatus, Terms, Totals, Winner};
use crate::local::{QuantizedProblem, rollout, score};

/// Every term is below this.
const TERM_BOUND: u32 = 1 << 24;

/// Judges winners. Keeps the memory of the last one.
#[derive(Default)]
pub struct WinnerCheck {
    table: Vec<i32>,
}

impl WinnerCheck {
    /// Whether the answer to a problem holds: its counts add up, its totals are possible, and its winner is admissible,
    /// with the terms and the score that it claims.
    ///
    /// # Errors
    /// What does not hold, for people.
    pub fn check(
        &mut self,
        problem: &QuantizedProblem,
        answer: &Evaluation,
        detail: Detail,
    ) -> Result<(), String> {
        let counts = answer.counts.to_array();
        let counted: u64 = counts.into_iter().map(u64::from).sum();
        let samples = problem.len();
        holds(counted == samples as u64, || {
            format!("{counted} samples were counted, not {samples}")
        })?;
        let listed = answer.samples.as_ref().map(Vec::len);
        let wanted = (detail == Detail::Samples).then_some(samples);
        holds(listed == wanted, || {
            format!("samples listed: {listed:?}, not {wanted:?}")
        })?;
        let admissible = answer.counts.admissible;
        let Some(winner) = &answer.winner else {
            return holds(
                admissible == 0 && answer.totals == Totals::default(),
                || format!("no winner among {admissible} admissible samples"),
            );
        };
        holds(are_possible(&answer.totals, admissible), || {
            format!(
                "totals that {admissible} samples cannot have: {:?}",
                answer.totals
            )
        })?;
        self.check_winner(problem, answer, winner)
    }

    /// Whether all answers hold.
    ///
    /// # Errors
    /// As [`Self::check`], or where there is not one answer for each problem.
    pub fn check_all(
        &mut self,
        problems: &[QuantizedProblem],
        answers: &[Evaluation],
        detail: Detail,
    ) -> Result<(), String> {
        holds(problems.len() == answers.len(), || {
            format!("{} answers to {} problems", answers.len(), problems.len())
        })?;
        let mut both = problems.iter().zip(answers);
        both.try_for_each(|(problem, answer)| self.check(problem, answer, detail))
    }

    fn check_winner(
        &mut self,
        problem: &QuantizedProblem,
        answer: &Evaluation,
        winner: &Winner,
    ) -> Result<(), String> {
        let index = winner.index as usize;
        holds(index < problem.len(), || {
            format!("the winner is sample {index} of {}", problem.len())
        })?;
        let truth = self.evaluate_sample(problem, index);
        let claim = SampleRecord {
            status: SampleStatus::Ok,
            terms: winner.terms,
        };
        holds(claim == truth, || {
            format!("sample {index} won as {claim:?} and is {truth:?}")
        })?;
        let totals = &answer.totals;
        let listed = answer.samples.as_ref().map(|samples| samples[index]);
        holds(listed.is_none_or(|listed| listed == truth), || {
            format!("sample {index} won and is listed as {listed:?}")
        })?;
        let within = (0..4).all(|term| {
            let value = truth.terms.to_array()[term];
            (totals.min[term]..=totals.max[term]).contains(&value)
        });
        holds(within, || {
            format!("sample {index} won beyond the totals {totals:?}")
        })?;
        let normalizers = score::normalizers(&problem.header, totals);
        let score = score::score(&truth.terms, &normalizers);
        holds(winner.score == score, || {
            format!(
                "sample {index} won with a score of {}, it is {score}",
                winner.score
            )
        })
    }

    fn evaluate_sample(&mut self, problem: &QuantizedProblem, index: usize) -> SampleRecord {
        let header = &problem.header;
        let vx_samples = problem.vx_samples.len();
        let (vx, vtheta) = (
            &problem.vx_samples[index % vx_samples],
            &problem.vtheta_samples[index / vx_samples],
        );
        self.table.resize(rollout::table_words(header), 0);
        rollout::tabulate(header, vtheta, &problem.discs, &mut self.table);
        let (status, clearance) = rollout::evaluate_sample(problem, vx, vtheta, &self.table);
        let terms = if status == SampleStatus::Ok {
            let end = rollout::end_position(header, vx, &self.table);
            let end_heading = rollout::end_heading(header, vtheta);
            score::terms(header, vx, end_heading, end, clearance)
        } else {
            Terms::default()
        };
        SampleRecord { status, terms }
    }
}

/// Whether so many samples can have such totals; others could overflow the score.
fn are_possible(totals: &Totals, admissible: u32) -> bool {
    (0..4).all(|term| {
        let (min, max) = (totals.min[term], totals.max[term]);
        let others = u64::from(admissible.saturating_sub(1));
        let (low, high) = (u64::from(min), u64::from(max));
        // One sample has the min and one the max, the same only where there is just one.
        let sums = high + others * low..=low + others * high;
        let bounded = admissible > 0 && min <= max && max < TERM_BOUND;
        bounded && sums.contains(&totals.sums[term])
    })
}

fn holds(holds: bool, message: impl FnOnce() -> String) -> Result<(), String> {
    if holds { Ok(()) } else { Err(message()) }
}
