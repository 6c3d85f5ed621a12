//! One outstanding request with timeout and retries.

/// Tracks the outstanding request, if there is one.
#[derive(Clone, Debug)]
pub(super) struct RequestTracker<Q> {
    /// Time until an answer counts as lost, seconds.
    answer_timeout_s: f64,
    /// Attempts of each request in total.
    max_attempts: u32,
    outstanding: Option<Outstanding<Q>>,
}

#[derive(Clone, Debug)]
struct Outstanding<Q> {
    request: Q,
    sent_s: f64,
    attempts_left: u32,
}

/// State of the outstanding request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RequestState<Q> {
    /// No request is outstanding.
    Idle,
    /// The answer is not overdue.
    Waiting,
    /// The answer is overdue: send the request again.
    Retry(Q),
    /// The last attempt failed; the request is dropped.
    GivenUp(Q),
}

impl<Q: Copy> RequestTracker<Q> {
    pub(super) const fn new(answer_timeout_s: f64, max_attempts: u32) -> Self {
        Self { answer_timeout_s, max_attempts, outstanding: None }
    }

    /// Starts a request.
    pub(super) fn start(&mut self, request: Q, now_s: f64) {
        let attempts_left = self.max_attempts - 1;
        self.outstanding = Some(Outstanding { request, sent_s: now_s, attempts_left });
    }

    /// The outstanding request.
    pub(super) fn outstanding(&self) -> Option<Q> {
        self.outstanding.as_ref().map(|outstanding| outstanding.request)
    }

    /// Ends the request: it was answered or is dropped.
    pub(super) fn finish(&mut self) {
        self.outstanding = None;
    }

    /// Returns the state now, and counts an attempt where a retry is due.
    pub(super) fn poll(&mut self, now_s: f64) -> RequestState<Q> {
        let Some(outstanding) = &mut self.outstanding else {
            return RequestState::Idle;
        };
        if now_s - outstanding.sent_s < self.answer_timeout_s {
            return RequestState::Waiting;
        }
        let request = outstanding.request;
        if outstanding.attempts_left == 0 {
            self.outstanding = None;
            return RequestState::GivenUp(request);
        }
        outstanding.attempts_left -= 1;
        outstanding.sent_s = now_s;
        RequestState::Retry(request)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn request_is_retried_then_given_up() {
        let mut tracker = RequestTracker::new(0.01, 3);
        assert_eq!(tracker.poll(0.0), RequestState::Idle);
        tracker.start('q', 0.0);
        let states = [0.005, 0.010, 0.015, 0.021, 0.025, 0.032, 0.04];
        let states = states.map(|now_s| tracker.poll(now_s));
        let retry = RequestState::Retry('q');
        let expected = [
            RequestState::Waiting,
            retry,
            RequestState::Waiting,
            retry,
            RequestState::Waiting,
            RequestState::GivenUp('q'),
            RequestState::Idle,
        ];
        assert_eq!(states, expected);
    }

    #[test]
    fn answered_request_is_not_retried() {
        let mut tracker = RequestTracker::new(0.01, 3);
        tracker.start(1, 0.0);
        assert_eq!(tracker.outstanding(), Some(1));
        tracker.finish();
        assert_eq!(tracker.poll(1.0), RequestState::Idle);
    }
}
