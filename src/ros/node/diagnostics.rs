//! When the statuses of the node go to `diagnostics`.

use crate::ros::msg::{DiagnosticArray, DiagnosticStatus, Header, Time};

/// Interval of statuses that do not change, seconds.
const INTERVAL_S: f64 = 1.0;

/// What was published last, and when.
#[derive(Debug, Default)]
pub struct Diagnostics {
    published: Option<(Vec<&'static str>, f64)>,
}

impl Diagnostics {
    /// The message at a time, seconds: when a state changes, and once a second. Each status comes with the names of its states.
    pub fn message(
        &mut self,
        now_s: f64,
        statuses: Vec<(DiagnosticStatus, Vec<&'static str>)>,
    ) -> Option<DiagnosticArray> {
        let (status, states): (Vec<_>, Vec<_>) = statuses.into_iter().unzip();
        let states = states.concat();
        if self.published.as_ref().is_some_and(|(before, published_s)| {
            *before == states && (0.0..INTERVAL_S).contains(&(now_s - published_s))
        }) {
            return None;
        }
        self.published = Some((states, now_s));
        let header = Header { stamp: Time::from_seconds(now_s), ..Header::default() };
        Some(DiagnosticArray { header, status })
    }
}
