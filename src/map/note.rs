//! What a map file says that is no error, and may not be meant.

use core::fmt::{Display, Formatter, Result};

/// Something that somebody should know who wrote a map file; the map is read all the same.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MapWarning {
    /// A key without a meaning, which is passed over, spelled almost like one that has a meaning.
    MisspelledKey {
        /// Its line, from one.
        line: usize,
        /// As written.
        found: String,
        /// The key that it is like.
        meant: &'static str,
    },
}

impl Display for MapWarning {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> Result {
        let Self::MisspelledKey { line, found, meant } = self;
        write!(
            formatter,
            "line {line}: `{found}` has no meaning and is passed over: did you mean `{meant}`?"
        )
    }
}
