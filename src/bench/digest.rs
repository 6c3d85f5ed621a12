//! One short name for many evaluations.

use sha2::{Digest, Sha256};

use crate::local::Evaluation;

/// A SHA-256 over every bit of the evaluations added to it, in order.
#[derive(Clone, Default)]
pub struct EvaluationDigest(Sha256);

impl EvaluationDigest {
    /// Adds an evaluation; its samples count too, where it has them.
    pub fn add(&mut self, evaluation: &Evaluation) {
        let counts = &evaluation.counts;
        self.words(&[
            counts.admissible,
            counts.collision,
            counts.cannot_stop,
            counts.outside,
        ]);
        for sum in evaluation.totals.sums {
            self.0.update(sum.to_le_bytes());
        }
        self.words(&evaluation.totals.least);
        self.words(&evaluation.totals.greatest);
        if let Some(winner) = &evaluation.winner {
            self.words(&[winner.index]);
            self.0.update(winner.score.to_le_bytes());
            self.words(&winner.terms.to_array());
        }
        for sample in evaluation.samples.iter().flatten() {
            self.words(&[sample.reason as u32]);
            self.words(&sample.terms.to_array());
        }
    }

    /// The digest in hex.
    #[must_use]
    pub fn hex(self) -> String {
        self.0
            .finalize()
            .iter()
            .map(|byte| format!("{byte:02x}"))
            .collect()
    }

    fn words(&mut self, words: &[u32]) {
        for word in words {
            self.0.update(word.to_le_bytes());
        }
    }
}
