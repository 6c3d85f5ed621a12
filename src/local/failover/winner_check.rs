//! Checks the winner of another engine: evaluates that one sample with the scalar reference, the twin of the shaders.

use crate::local::cpu::scalar;
use crate::local::engine::{Detail, Evaluation, SampleRecord, SampleStatus, Totals, Winner};
use crate::local::{QuantizedProblem, rollout, score};

/// Bound of every term.
const TERM_BOUND: u32 = 1 << 24;

/// Checks winners. Reuses the memory of the last check.
#[derive(Default)]
pub struct WinnerCheck {
    table: Vec<i32>,
}

impl WinnerCheck {
    /// Checks the answer to a problem: the counts add up, the totals are possible, and the winner is admissible with
    /// the claimed terms and score.
    ///
    /// # Errors
    /// Names the first contradiction.
    pub fn check(
        &mut self,
        problem: &QuantizedProblem,
        answer: &Evaluation,
        detail: Detail,
    ) -> Result<(), String> {
        let counts = answer.counts.to_array();
        let counted: u64 = counts.into_iter().map(u64::from).sum();
        let samples = problem.len();
        ensure(counted == samples as u64, || {
            format!("{counted} samples are counted, expected {samples}")
        })?;
        let listed = answer.samples.as_ref().map(Vec::len);
        let requested = (detail == Detail::Samples).then_some(samples);
        ensure(listed == requested, || {
            format!("samples listed: {listed:?}, expected {requested:?}")
        })?;
        let admissible = answer.counts.admissible;
        let Some(winner) = &answer.winner else {
            return ensure(admissible == 0 && answer.totals == Totals::default(), || {
                format!("no winner among {admissible} admissible samples")
            });
        };
        ensure(are_possible(&answer.totals, admissible), || {
            format!("impossible totals of {admissible} admissible samples: {:?}", answer.totals)
        })?;
        self.check_winner(problem, answer, winner)
    }

    /// Checks all answers.
    ///
    /// # Errors
    /// As [`Self::check`]; also when the number of answers differs from that of the problems.
    pub fn check_all(
        &mut self,
        problems: &[QuantizedProblem],
        answers: &[Evaluation],
        detail: Detail,
    ) -> Result<(), String> {
        ensure(problems.len() == answers.len(), || {
            format!("{} answers for {} problems", answers.len(), problems.len())
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
        ensure(index < problem.len(), || {
            format!("the winner is sample {index} of {}", problem.len())
        })?;
        let expected = self.evaluate_sample(problem, index);
        let claimed = SampleRecord { status: SampleStatus::Ok, terms: winner.terms };
        ensure(claimed == expected, || {
            format!("the winner, sample {index}, is {claimed:?}, expected {expected:?}")
        })?;
        let totals = &answer.totals;
        let listed = answer.samples.as_ref().map(|samples| samples[index]);
        ensure(listed.is_none_or(|listed| listed == expected), || {
            format!("the winner, sample {index}, is listed as {listed:?}")
        })?;
        let within = (0..4).all(|term| {
            let value = expected.terms.to_array()[term];
            (totals.min[term]..=totals.max[term]).contains(&value)
        });
        ensure(within, || format!("the winner, sample {index}, is outside the totals {totals:?}"))?;
        let normalizers = score::normalizers(&problem.header, totals);
        let score = score::score(&expected.terms, &normalizers);
        ensure(winner.score == score, || {
            format!("the winner, sample {index}, has the score {}, expected {score}", winner.score)
        })
    }

    fn evaluate_sample(&mut self, problem: &QuantizedProblem, index: usize) -> SampleRecord {
        let header = &problem.header;
        let vx_count = problem.vx_samples.len();
        let (vx, profile) =
            (&problem.vx_samples[index % vx_count], &problem.profiles[index / vx_count]);
        self.table.resize(rollout::table_words(header), 0);
        rollout::tabulate(problem, index / vx_count, &mut self.table);
        scalar::evaluate_sample(problem, vx, profile, &self.table)
    }
}

/// Whether this number of samples can have these totals. Impossible totals could overflow the score.
fn are_possible(totals: &Totals, admissible: u32) -> bool {
    (0..4).all(|term| {
        let (min, max) = (totals.min[term], totals.max[term]);
        let others = u64::from(admissible.saturating_sub(1));
        let (low, high) = (u64::from(min), u64::from(max));
        // One sample has the minimum and one the maximum; they are the same sample only when there is just one.
        let sums = high + others * low..=low + others * high;
        let bounded = admissible > 0 && min <= max && max < TERM_BOUND;
        bounded && sums.contains(&totals.sums[term])
    })
}

fn ensure(holds: bool, message: impl FnOnce() -> String) -> Result<(), String> {
    if holds { Ok(()) } else { Err(message()) }
}
