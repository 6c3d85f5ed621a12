//! Whether the reports of a base show a standstill.

/// Time for which every report must show a standstill, seconds. A single report of zero may be a swing's reversal.
const STILL_S: f64 = 0.3;

/// Largest turn rate of a standstill, rad/s.
const STILL_RAD_S: f64 = 0.1;

/// The standstill of a base. Times in seconds from one origin.
#[derive(Clone, Copy, Debug)]
pub(super) struct Standstill {
    /// Time of the first of the latest reports that all show a standstill.
    since_s: Option<f64>,
    /// Time of a report that no longer counts.
    forgotten_s: f64,
    is_still: bool,
    moves: bool,
}

impl Standstill {
    /// A base that stands.
    pub(super) const fn new() -> Self {
        let (since_s, forgotten_s) = (Some(f64::NEG_INFINITY), f64::NEG_INFINITY);
        Self { since_s, forgotten_s, is_still: true, moves: false }
    }

    /// Forgets all reports up to the latest one, with its time: the base may have moved since, or be about to.
    pub(super) const fn forget(&mut self, latest_s: f64) {
        (self.since_s, self.forgotten_s, self.is_still) = (None, latest_s, false);
    }

    /// Takes the speed of the faster track, m/s, the speed below which a track stands, the turn rate, rad/s, and the time of the latest
    /// report. A report that comes again has the same time, and shows nothing new.
    pub(super) fn update(&mut self, (fastest, least): (f64, f64), turn_rate: f64, stamp_s: f64) {
        self.moves = !(fastest < least && turn_rate.abs() < STILL_RAD_S);
        if self.moves {
            self.since_s = None;
        } else if stamp_s != self.forgotten_s {
            // A clock that ran backwards starts again.
            let since_s = self.since_s.filter(|since_s| *since_s <= stamp_s);
            self.since_s = since_s.or(Some(stamp_s));
        }
        self.is_still = self.since_s.is_some_and(|since_s| stamp_s - since_s >= STILL_S);
    }

    /// Whether the base has stood for long enough.
    pub(super) const fn is_still(&self) -> bool {
        self.is_still
    }

    /// Whether the latest report shows motion.
    pub(super) const fn moves(&self) -> bool {
        self.moves
    }
}
