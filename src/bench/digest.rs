//! A digest of evaluations.

use crate::digest::BitDigest;
use crate::local::Evaluation;

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
