//! Detects a base that keeps its speed although its commands change.

use super::{STUCK_SHARE, SymptomTimer};
use crate::robot::{Side, TrackSpeeds};

/// Time for which both tracks follow their commands at one speed before that speed can be a held one, seconds: a track that
/// reaches its limit on a ramp follows there for a moment only.
const FOLLOWED_S: f64 = 0.3;

/// The speeds that both tracks keep.
///
/// A motor at its limit keeps its speed too: uphill, with a weak battery, or if the settings promise too much. So a kept speed
/// counts only if the base followed its commands at this speed before. For faster commands, the tracks must also have been
/// faster before.
#[derive(Clone, Debug, Default)]
pub(super) struct HeldSpeed {
    /// Measured speeds from which no track has moved since, m/s.
    held: TrackSpeeds,
    /// Time for which both tracks followed their commands at these speeds, seconds.
    followed_s: f64,
    /// Fastest measured speeds in either direction, m/s.
    fastest: TrackSpeeds,
    ignored: SymptomTimer,
}

impl HeldSpeed {
    /// Takes commanded and measured speeds, m/s, after a time step, seconds. Returns whether the base has held its speeds for
    /// the given time, seconds, while both commands differed from them by at least `least`, m/s.
    pub(super) fn update(
        &mut self,
        (commanded, measured): (TrackSpeeds, TrackSpeeds),
        (time_s, for_s): (f64, f64),
        least: f64,
    ) -> bool {
        let same = STUCK_SHARE * least;
        self.fastest = self.fastest.zip(measured, |fastest, now| fastest.max(now.abs()));
        if !are_within(same, self.held, measured) {
            *self = Self { held: measured, fastest: self.fastest, ..Self::default() };
        }
        if are_within(same, commanded, measured) {
            let followed_s = self.followed_s + time_s;
            if self.followed_s < FOLLOWED_S && followed_s >= FOLLOWED_S {
                // Until now the speeds may still have settled.
                self.held = measured;
            }
            self.followed_s = followed_s;
        }
        let ignores = [Side::Left, Side::Right].into_iter().all(|side| {
            let (held, now) = (self.held.of(side), commanded.of(side));
            let is_slower = now * held.signum() < held.abs();
            let can_follow = is_slower || self.fastest.of(side) >= held.abs() + least;
            (now - held).abs() >= least && can_follow
        });
        self.ignored.elapsed(ignores && self.is_held(same), time_s, for_s)
    }

    /// Whether both commands have left the speeds that the base followed, and the base keeps these speeds, at least for now.
    pub(super) fn has_left(&self, commanded: TrackSpeeds, least: f64) -> bool {
        let same = STUCK_SHARE * least;
        let differs = self.held.zip(commanded, |held, now| (now - held).abs());
        // A track whose command has not changed does not show that it ignores commands.
        let (smaller, greater) = (differs.left.min(differs.right), differs.left.max(differs.right));
        self.is_held(same) && smaller > same && greater >= least
    }

    /// Whether the base followed a command at its present speed, and moves.
    fn is_held(&self, same: f64) -> bool {
        self.followed_s >= FOLLOWED_S && !are_within(same, self.held, TrackSpeeds::default())
    }
}

/// Whether the speeds of each track differ by at most this, m/s.
fn are_within(most: f64, one: TrackSpeeds, other: TrackSpeeds) -> bool {
    let near = one.zip(other, |one, other| (one - other).abs() <= most);
    near.left && near.right
}
