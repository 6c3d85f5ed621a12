//! The measured time between two ticks of a control loop, and what it permits.

/// Difference from the period up to which a tick is punctual, seconds: the rounding of times since 1970 is below it.
const PUNCTUAL_S: f64 = 1e-6;

/// A tick is late if the time since the one before is longer than this many periods.
pub const LATE_PERIODS: f64 = 2.0;

/// The time since the tick before, as measured: by how much a ramp may change a command.
///
/// A late tick brakes for the whole time, so that the mean deceleration is that of the limits. It accelerates for one period at
/// most: the base of a loop that stalled must not jump ahead. A punctual tick has exactly one period for both.
///
/// ```
/// use inbye::geometry::Twist;
/// use inbye::robot::{Limits, TickTime};
///
/// let (limits, now) = (Limits::default(), Twist::new(0.5, 0.0));
/// let late = TickTime::between(Some(7.0), 7.4, 0.1);
/// assert!((limits.reachable(&now, &Twist::STOP, late).linear - 0.1).abs() < 1e-9);
/// assert!((limits.reachable(&now, &Twist::new(1.0, 0.0), late).linear - 0.6).abs() < 1e-9);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TickTime {
    period_s: f64,
    elapsed_s: f64,
}

impl TickTime {
    /// The time between two ticks of a loop with a period, all in seconds; one period for the first tick. It is negative where the
    /// clock ran backwards.
    #[must_use]
    pub fn between(before_s: Option<f64>, now_s: f64, period_s: f64) -> Self {
        let elapsed_s = before_s.map_or(period_s, |before_s| now_s - before_s);
        let is_punctual = (elapsed_s - period_s).abs() <= PUNCTUAL_S;
        Self { period_s, elapsed_s: if is_punctual { period_s } else { elapsed_s } }
    }

    /// The same for a command that is kept for one period at least, as that of a planner is.
    #[must_use]
    pub const fn at_least_a_period(self) -> Self {
        Self { elapsed_s: self.elapsed_s.max(self.period_s), ..self }
    }

    /// The planned time between two ticks, seconds.
    #[must_use]
    pub const fn period_s(&self) -> f64 {
        self.period_s
    }

    /// Measured time since the tick before, seconds.
    #[must_use]
    pub const fn elapsed_s(&self) -> f64 {
        self.elapsed_s
    }

    /// Time by which the elapsed one exceeds the period, seconds; zero for a punctual tick.
    #[must_use]
    pub const fn late_s(&self) -> f64 {
        (self.elapsed_s - self.period_s).max(0.0)
    }

    /// Time for which a command may brake, seconds.
    #[must_use]
    pub const fn braking_s(&self) -> f64 {
        self.elapsed_s.max(0.0)
    }

    /// Time for which a command may accelerate, seconds.
    #[must_use]
    pub const fn accelerating_s(&self) -> f64 {
        self.braking_s().min(self.period_s)
    }

    /// Whether the tick is late by more than a period: by [`LATE_PERIODS`].
    #[must_use]
    pub fn is_late(&self) -> bool {
        self.elapsed_s > LATE_PERIODS * self.period_s
    }

    /// Describes a late tick in one sentence; none for one that is not.
    #[must_use]
    pub fn warning(&self) -> Option<String> {
        let Self { period_s, elapsed_s } = self;
        self.is_late().then(|| {
            format!(
                "{elapsed_s:.3} s passed since the tick before, the control period is {period_s} s"
            )
        })
    }
}

/// A time that passes as planned, seconds: the same for braking and accelerating.
impl From<f64> for TickTime {
    fn from(time_s: f64) -> Self {
        Self { period_s: time_s, elapsed_s: time_s }
    }
}

/// Measures the time between the ticks of a control loop. It holds no clock: the loop gives it the time of each tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TickClock {
    period_s: f64,
    last_s: Option<f64>,
    last: TickTime,
    late_ticks: u64,
}

impl TickClock {
    /// The clock of a loop with a period, seconds, before its first tick.
    #[must_use]
    pub fn new(period_s: f64) -> Self {
        Self { period_s, last_s: None, last: period_s.into(), late_ticks: 0 }
    }

    /// Measures the tick at a time, seconds. After a time that is not finite no time has passed, as far as is known.
    pub fn tick(&mut self, now_s: f64) -> TickTime {
        self.last = if now_s.is_finite() {
            TickTime::between(self.last_s.replace(now_s), now_s, self.period_s)
        } else {
            TickTime { period_s: self.period_s, elapsed_s: f64::NAN }
        };
        self.late_ticks += u64::from(self.last.is_late());
        self.last
    }

    /// Time of the last tick, seconds; none before the first.
    #[must_use]
    pub const fn last_s(&self) -> Option<f64> {
        self.last_s
    }

    /// The time between the last two ticks.
    #[must_use]
    pub const fn last(&self) -> &TickTime {
        &self.last
    }

    /// Number of late ticks: [`TickTime::is_late`].
    #[must_use]
    pub const fn late_ticks(&self) -> u64 {
        self.late_ticks
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn punctual_ticks_have_exactly_one_period_and_late_ones_their_measured_time() {
        for tick in 0..40_000 {
            let [before_s, now_s] = [tick, tick + 1].map(|tick| 1.7e9 + 0.1 * f64::from(tick));
            assert_eq!(TickTime::between(Some(before_s), now_s, 0.1), TickTime::from(0.1));
        }
        let late = TickTime::between(Some(1.0), 1.5, 0.1);
        assert_eq!((late.braking_s(), late.accelerating_s(), late.late_s()), (0.5, 0.1, 0.4));
        assert_eq!(TickTime::between(None, 7.0, 0.1), TickTime::from(0.1));
    }

    #[test]
    fn early_tick_has_less_than_a_period_and_a_clock_that_runs_backwards_none() {
        let early = TickTime::between(Some(1.0), 1.03125, 0.1);
        assert_eq!((early.braking_s(), early.accelerating_s()), (0.03125, 0.03125));
        assert_eq!(early.at_least_a_period(), TickTime::from(0.1));
        let backwards = TickTime::between(Some(1.0), 0.0, 0.1);
        assert_eq!((backwards.braking_s(), backwards.accelerating_s()), (0.0, 0.0));
        assert_eq!(backwards.elapsed_s(), -1.0);
    }

    #[test]
    fn clock_counts_late_ticks_and_ignores_a_time_that_is_not_finite() {
        let mut clock = TickClock::new(0.1);
        for now_s in [5.0, 5.1, 5.6, f64::NAN, 5.7] {
            let tick = clock.tick(now_s);
            assert!(tick.braking_s() >= 0.0 && tick.accelerating_s() <= 0.1, "{now_s}: {tick:?}");
        }
        assert_eq!((clock.late_ticks(), clock.last_s()), (1, Some(5.7)));
        let unknown = clock.tick(f64::NAN);
        assert_eq!((unknown.braking_s(), unknown.accelerating_s()), (0.0, 0.0));
        assert_eq!(unknown.at_least_a_period(), TickTime::from(0.1));
    }

    #[test]
    fn tick_is_late_after_more_than_two_periods() {
        let tick = |elapsed_s| TickTime::between(Some(0.0), elapsed_s, 0.125);
        assert!(!tick(0.25).is_late() && tick(0.25).warning().is_none());
        let warning = tick(0.5).warning().expect("a late tick");
        assert_eq!(warning, "0.500 s passed since the tick before, the control period is 0.125 s");
    }
}
