//! When to try a lost GPU again: after waits that double, counted in decisions.

/// Decisions from a loss to the first attempt to open the GPU anew: a second at 10 Hz. Each loss or failed attempt
/// doubles the next wait.
pub const FIRST_RETRY: u32 = 10;

/// No wait is longer, decisions: about a minute at 10 Hz.
pub const LONGEST_RETRY: u32 = 640;

/// A device that gave so many good answers in a row is trusted as the first one was, and the waits begin anew.
const TRUSTED_AFTER: u32 = 100;

/// Waits between attempts.
#[derive(Clone, Debug)]
pub struct BackOff {
    next_wait: u32,
    left: u32,
    good: u32,
}

impl Default for BackOff {
    fn default() -> Self {
        Self {
            next_wait: FIRST_RETRY,
            left: 0,
            good: 0,
        }
    }
}

impl BackOff {
    /// Notes a loss, or an attempt in vain.
    pub fn failed(&mut self) {
        self.good = 0;
        self.left = self.next_wait;
        self.next_wait = (2 * self.next_wait).min(LONGEST_RETRY);
    }

    /// Counts one decision without a GPU; true when the wait is over, and from then on until the next failure.
    pub fn is_due(&mut self) -> bool {
        self.left = self.left.saturating_sub(1);
        self.left == 0
    }

    /// Notes a good answer.
    pub fn worked(&mut self) {
        self.good = self.good.saturating_add(1);
        if self.good >= TRUSTED_AFTER {
            self.next_wait = FIRST_RETRY;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Decisions until the next attempt.
    fn wait(back_off: &mut BackOff) -> u32 {
        let due = (1..=LONGEST_RETRY).find(|_| back_off.is_due());
        due.expect("no wait is longer")
    }

    #[test]
    fn waits_double_up_to_the_longest_and_begin_anew_after_a_hundred_good_answers() {
        let mut back_off = BackOff::default();
        let mut after_failure = |good| {
            (0..good).for_each(|_| back_off.worked());
            back_off.failed();
            wait(&mut back_off)
        };
        let waits: Vec<u32> = (0..9).map(|_| after_failure(TRUSTED_AFTER - 1)).collect();
        assert_eq!(waits, [10, 20, 40, 80, 160, 320, 640, 640, 640]);
        assert_eq!(after_failure(TRUSTED_AFTER), FIRST_RETRY);
        assert_eq!(after_failure(0), 2 * FIRST_RETRY);
    }

    #[test]
    fn it_stays_due_until_something_fails() {
        let mut back_off = BackOff::default();
        back_off.failed();
        wait(&mut back_off);
        assert!(back_off.is_due() && back_off.is_due());
        back_off.failed();
        assert!(!back_off.is_due());
    }
}
