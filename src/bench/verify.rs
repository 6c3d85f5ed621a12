//! Evaluates random problems on several engines, compares all bits, and pins a digest of them.

use serde::Serialize;

use super::{BenchError, random_problem};
use crate::digest::BitDigest;
use crate::local::{Detail, Engine, Evaluation, QuantizedProblem};

/// Seed of the problems whose digest is pinned.
pub const GOLDEN_SEED: u64 = 2026;
/// Number of those problems.
pub const GOLDEN_CASES: u64 = 64;
/// Digest over every bit of their evaluations, on any engine and machine. It changes only with the engines' specification
/// or with [`super::random_problem`]; document every such change.
pub const GOLDEN_DIGEST: &str = "36fa7e32ffde781081fa170bf07e05a3842b4523ca2450a5dd6836dc04039ae7";

/// A digest over every bit of the evaluations added to it, in order.
#[derive(Clone, Default)]
pub struct EvaluationDigest(BitDigest);

impl EvaluationDigest {
    /// Adds an evaluation; its samples count too, if it has them.
    pub fn add(&mut self, evaluation: &Evaluation) {
        self.words(&evaluation.counts.to_array());
        for sum in evaluation.totals.sums {
            self.0.wide(sum);
        }
        self.words(&evaluation.totals.min);
        self.words(&evaluation.totals.max);
        if let Some(winner) = &evaluation.winner {
            self.words(&[winner.index]);
            self.0.wide(winner.score as u64);
            self.words(&winner.terms.to_array());
        }
        for sample in evaluation.samples.iter().flatten() {
            self.words(&[sample.status as u32]);
            self.words(&sample.terms.to_array());
        }
    }

    /// The digest in hex.
    #[must_use]
    pub fn hex(self) -> String {
        self.0.hex()
    }

    fn words(&mut self, words: &[u32]) {
        words.iter().for_each(|&word| self.0.word(word));
    }
}

/// The name of the first engine and the digest of its answers, with which those of the others are compared.
#[derive(Default)]
pub(super) struct FirstAnswers(Option<(String, String)>);

impl FirstAnswers {
    /// Takes the answers of the first engine; those of a further one must be the same. `which` names the work.
    pub(super) fn check(
        &mut self,
        engine: &dyn Engine,
        answers: EvaluationDigest,
        which: impl FnOnce() -> String,
    ) -> Result<(), BenchError> {
        let (engine, digest) = (engine.name(), answers.hex());
        let (first, expected) = self.0.get_or_insert_with(|| (engine.clone(), digest.clone()));
        if *expected == digest {
            return Ok(());
        }
        Err(BenchError::Differs { which: which(), engine, first: first.clone() })
    }
}

/// The first bits in which two evaluations of one problem differ.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct Difference {
    /// The engine that differs from the first one.
    pub engine: String,
    /// Number of the problem.
    pub case: u64,
    /// Which quantity: `sample 12 heading`, `sum of clearance`, `winner`...
    pub what: String,
    /// The first engine's value, hexadecimal.
    pub expected: String,
    /// The differing engine's value, hexadecimal.
    pub found: String,
}

/// Result of a comparison of engines.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct Verification {
    /// Number of problems.
    pub cases: u64,
    /// Number of samples evaluated by each engine.
    pub samples: u64,
    /// One digest for each engine, in their order.
    pub digests: Vec<String>,
    /// Number of quantities that differed from the first engine's.
    pub difference_count: u64,
    /// The first few of them.
    pub differences: Vec<Difference>,
}

impl Verification {
    /// Whether every engine returned the same bits.
    #[must_use]
    pub fn agree(&self) -> bool {
        self.difference_count == 0
    }
}

/// Largest number of differences in a report.
const SHOWN: usize = 8;

/// Evaluates problems 0 to `cases` of a seed on every engine and compares all bits with the first engine's. `progress` is
/// called after each problem with the number done.
///
/// # Errors
/// Fails when an engine gives no answer.
pub fn verify(
    engines: &mut [Box<dyn Engine>],
    cases: u64,
    seed: u64,
    mut progress: impl FnMut(u64),
) -> Result<Verification, BenchError> {
    let mut verification = Verification { cases, ..Verification::default() };
    let mut digests = vec![EvaluationDigest::default(); engines.len()];
    for case in 0..cases {
        let problem = QuantizedProblem::new(&random_problem(seed, case))
            .map_err(|error| BenchError::Problem { which: format!("case {case}"), error })?;
        verification.samples += problem.len() as u64;
        let mut first: Option<Evaluation> = None;
        for (engine, digest) in engines.iter_mut().zip(&mut digests) {
            let evaluation = engine
                .evaluate(&problem, Detail::Samples)
                .map_err(|error| BenchError::Engine { which: format!("case {case}"), error })?;
            digest.add(&evaluation);
            match &first {
                None => first = Some(evaluation),
                Some(first) => {
                    let note = |what: String, expected: String, found: String| {
                        verification.difference_count += 1;
                        if verification.differences.len() < SHOWN {
                            let engine = engine.name();
                            let difference = Difference { engine, case, what, expected, found };
                            verification.differences.push(difference);
                        }
                    };
                    compare(first, &evaluation, note);
                }
            }
        }
        progress(case + 1);
    }
    verification.digests = digests.into_iter().map(EvaluationDigest::hex).collect();
    Ok(verification)
}

/// Evaluates the problems of the golden digest on every engine.
///
/// # Errors
/// Fails when an engine gives no answer.
pub fn verify_golden(engines: &mut [Box<dyn Engine>]) -> Result<Verification, BenchError> {
    verify(engines, GOLDEN_CASES, GOLDEN_SEED, |_| {})
}

/// Calls `note(what, expected, found)` for each quantity in which two evaluations differ, values in hex.
pub fn compare(
    expected: &Evaluation,
    found: &Evaluation,
    mut note: impl FnMut(String, String, String),
) {
    const TERMS: [&str; 4] = ["heading", "clearance", "velocity", "path"];
    let mut check = |what: String, expected: u64, found: u64| {
        if expected != found {
            note(what, format!("{expected:#x}"), format!("{found:#x}"));
        }
    };
    let names = ["admissible", "collision", "cannot_stop", "outside"];
    let (one, other) = (expected.counts.to_array(), found.counts.to_array());
    for (place, name) in names.iter().enumerate() {
        let (one, other) = (one[place].into(), other[place].into());
        check(format!("count of {name}"), one, other);
    }
    for (term, name) in TERMS.iter().enumerate() {
        let (one, other) = (&expected.totals, &found.totals);
        check(format!("sum of {name}"), one.sums[term], other.sums[term]);
        check(format!("least {name}"), one.min[term].into(), other.min[term].into());
        check(format!("greatest {name}"), one.max[term].into(), other.max[term].into());
    }
    let winner = |evaluation: &Evaluation| {
        evaluation.winner.map_or((u64::MAX, 0, [0; 4]), |winner| {
            (u64::from(winner.index), winner.score as u64, winner.terms.to_array())
        })
    };
    let (one, other) = (winner(expected), winner(found));
    check("winner".to_owned(), one.0, other.0);
    check("winning score".to_owned(), one.1, other.1);
    for (term, name) in TERMS.iter().enumerate() {
        check(format!("winner's {name}"), one.2[term].into(), other.2[term].into());
    }
    let one = expected.samples.as_deref().unwrap_or_default();
    let other = found.samples.as_deref().unwrap_or_default();
    check("number of samples".to_owned(), one.len() as u64, other.len() as u64);
    for (index, (one, other)) in one.iter().zip(other).enumerate() {
        check(format!("sample {index} reason"), one.status as u64, other.status as u64);
        let terms = one.terms.to_array().into_iter().zip(other.terms.to_array());
        for (name, (one, other)) in TERMS.iter().zip(terms) {
            check(format!("sample {index} {name}"), one.into(), other.into());
        }
    }
}
