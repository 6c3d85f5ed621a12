//! Whether the reports of a base show a standstill.

/// Time for which every report must show a standstill, seconds. A single report of zero may be a swing's reversal.
const STILL_S: f64 = 0.3;

/// Largest turn rate of a standstill, rad/s.
const STILL_RAD_S: f64 = 0.1;

/// The standstill of a base. Times in seconds from one origin.
#[derive(Clone, Copy, Debug)]
pub(super) struct Standstill {
    /// Start of the time in which every report showed a standstill.
    since_s: Option<f64>,
    is_still: bool,
}

impl Standstill {
    /// A base that stands.
    pub(super) const fn new() -> Self {
        Self { since_s: Some(f64::NEG_INFINITY), is_still: true }
    }

    /// Forgets all reports: the base may have been pushed since.
    pub(super) const fn forget(&mut self) {
        *self = Self { since_s: None, is_still: false };
    }

    /// Takes the speed of the faster track, m/s, the speed below which a track stands, and the turn rate, rad/s, of a report.
    pub(super) fn update(&mut self, (fastest, least): (f64, f64), turn_rate: f64, now_s: f64) {
        let stands = fastest < least && turn_rate.abs() < STILL_RAD_S;
        self.since_s = stands.then(|| self.since_s.unwrap_or(now_s));
        self.is_still = self.since_s.is_some_and(|since_s| now_s - since_s >= STILL_S);
    }

    /// Whether the base has stood for long enough.
    pub(super) const fn is_still(&self) -> bool {
        self.is_still
    }

    /// Whether the last report shows motion, or there is none.
    pub(super) const fn moves(&self) -> bool {
        self.since_s.is_none()
    }
}
