//! What behaviours propose, and how one overrides another.

use super::super::state::State;
use super::super::{Decision, Fault};

/// What a behaviour proposes.
#[derive(Debug)]
pub(super) enum Proposal {
    /// The behaviours with lower priority keep below this forward speed, m/s.
    SpeedLimit(f64),
    /// A decision, and how it may be overridden.
    Decide(Decision, Override),
}

/// Which behaviours may override a decision.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Override {
    /// None: the robot drives on, or has arrived.
    Never,
    /// Evasion: the robot is so slow that an approaching obstacle may hit it.
    ByEvasion,
    /// Evasion, then rotation in place: the robot creeps along its path.
    ByEvasionOrRotation,
}

/// A behaviour that proposes what to do.
pub(super) trait Behaviour {
    /// Proposes a decision; nothing where the behaviour does not apply.
    ///
    /// # Errors
    /// When the mission must end.
    fn propose(&mut self, state: &State<'_>) -> Result<Option<Proposal>, Fault>;

    /// Updates the memory with the decision of the tick.
    fn observe(&mut self, _state: &State<'_>, _decision: &Decision) {}
}

/// A behaviour that replaces the decision of another one.
pub(super) trait Overriding {
    /// Returns the replacement of a decision; nothing where that decision stands.
    fn replace(&mut self, state: &State<'_>, allowed: Override) -> Option<Decision>;
}
