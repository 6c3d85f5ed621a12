//! Which run it is.

use core::fmt::{self, Display};

/// Which run: the world, and the seed of its noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct RunKey {
    /// The world's number.
    pub world: u32,
    /// The seed.
    pub seed: u64,
}

impl Display for RunKey {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "world {}, seed {}", self.world, self.seed)
    }
}
