//! The fields of a line, with errors that name the line.

use core::str::SplitWhitespace;

use super::LogError;
use crate::geometry::{Pose, wrap_angle};

/// Largest number of beams of a scan.
const MAX_BEAMS: usize = 100_000;

/// The fields of a line, from left to right.
#[derive(Clone, Debug)]
pub(super) struct Fields<'a> {
    /// Line number, from one.
    pub line: usize,
    /// The kind of the record, for messages.
    pub record: &'static str,
    words: SplitWhitespace<'a>,
}

impl<'a> Fields<'a> {
    /// The fields of a record after its name.
    pub const fn new(line: usize, record: &'static str, words: SplitWhitespace<'a>) -> Self {
        Self { line, record, words }
    }

    /// The next field as text.
    pub fn word(&mut self, field: &'static str) -> Result<&'a str, LogError> {
        let missing = LogError::Missing { line: self.line, record: self.record, field };
        self.words.next().ok_or(missing)
    }

    /// The next field as a finite number.
    pub fn number(&mut self, field: &'static str) -> Result<f64, LogError> {
        let word = self.word(field)?;
        let number = word.parse().ok().filter(|number: &f64| number.is_finite());
        number.ok_or_else(|| self.bad(field, word, "a finite number"))
    }

    /// The next field as a whole number.
    pub fn whole(&mut self, field: &'static str) -> Result<i64, LogError> {
        let word = self.word(field)?;
        word.parse().map_err(|_| self.bad(field, word, "a whole number"))
    }

    /// The next field as a number of entries.
    pub fn count(&mut self, field: &'static str) -> Result<usize, LogError> {
        let word = self.word(field)?;
        let count = word.parse().ok().filter(|count| *count <= MAX_BEAMS);
        count.ok_or_else(|| self.bad(field, word, "a whole number from 0 to 100000"))
    }

    /// The next fields as numbers.
    pub fn numbers(&mut self, count: usize, field: &'static str) -> Result<Vec<f64>, LogError> {
        (0..count).map(|_| self.number(field)).collect()
    }

    /// The next three fields as a pose, metres and radians.
    pub fn pose(&mut self, field: &'static str) -> Result<Pose, LogError> {
        let (x, y) = (self.number(field)?, self.number(field)?);
        Ok(Pose::new(x, y, wrap_angle(self.number(field)?)))
    }

    /// Whether all fields were read.
    pub fn is_empty(&self) -> bool {
        self.words.clone().next().is_none()
    }

    /// Skips fields that are not used.
    pub fn skip(&mut self, count: usize, field: &'static str) -> Result<(), LogError> {
        (0..count).try_for_each(|_| self.word(field).map(drop))
    }

    /// An error at a field.
    pub fn bad(&self, field: &'static str, value: &str, expected: &'static str) -> LogError {
        let value = value.chars().take(40).collect();
        LogError::BadField { line: self.line, record: self.record, field, value, expected }
    }
}
