//! The delays before a lost GPU is reopened: they double, and count decisions.

/// Decisions from a failure to the first attempt to reopen the GPU: one second at 10 Hz. Each further failure doubles
/// the delay.
pub const FIRST_RETRY: u32 = 10;

/// Longest delay, decisions: about a minute at 10 Hz.
pub const LONGEST_RETRY: u32 = 640;

/// Number of correct answers in a row after which the delay is reset.
const TRUSTED_AFTER: u32 = 100;

/// The delay before the next attempt.
#[derive(Clone, Debug)]
pub struct BackOff {
    next_delay: u32,
    remaining: u32,
    successes: u32,
}

impl Default for BackOff {
    fn default() -> Self {
        Self { next_delay: FIRST_RETRY, remaining: 0, successes: 0 }
    }
}

impl BackOff {
    /// Records a failure of the GPU or of an attempt to reopen it.
    pub fn record_failure(&mut self) {
        self.successes = 0;
        self.remaining = self.next_delay;
        self.next_delay = (2 * self.next_delay).min(LONGEST_RETRY);
    }

    /// Counts one decision without a GPU. Returns true when the delay has passed, and from then on until the next
    /// failure.
    pub fn is_due(&mut self) -> bool {
        self.remaining = self.remaining.saturating_sub(1);
        self.remaining == 0
    }

    /// Records a correct answer.
    pub fn record_success(&mut self) {
        self.successes = self.successes.saturating_add(1);
        if self.successes >= TRUSTED_AFTER {
            self.next_delay = FIRST_RETRY;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Decisions until the next attempt.
    fn delay(back_off: &mut BackOff) -> u32 {
        let due = (1..=LONGEST_RETRY).find(|_| back_off.is_due());
        due.expect("no delay is longer")
    }

    #[test]
    fn delays_double_up_to_the_longest_and_reset_after_100_successes() {
        let mut back_off = BackOff::default();
        let mut after_failure = |successes| {
            (0..successes).for_each(|_| back_off.record_success());
            back_off.record_failure();
            delay(&mut back_off)
        };
        let delays: Vec<u32> = (0..9).map(|_| after_failure(TRUSTED_AFTER - 1)).collect();
        assert_eq!(delays, [10, 20, 40, 80, 160, 320, 640, 640, 640]);
        assert_eq!(after_failure(TRUSTED_AFTER), FIRST_RETRY);
        assert_eq!(after_failure(0), 2 * FIRST_RETRY);
    }

    #[test]
    fn back_off_stays_due_until_next_failure() {
        let mut back_off = BackOff::default();
        back_off.record_failure();
        delay(&mut back_off);
        assert!(back_off.is_due() && back_off.is_due());
        back_off.record_failure();
        assert!(!back_off.is_due());
    }
}
