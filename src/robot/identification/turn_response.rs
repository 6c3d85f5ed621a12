//! Ratio of the measured to the commanded turn rate: tracks with a larger effective width than calibrated turn less.

use std::collections::VecDeque;

use super::Interval;
use crate::robot::Limits;

/// Longest history of commands, seconds, and their largest number.
const HISTORY_S: f64 = 2.0;
const MAX_COMMANDS: usize = 256;
/// Measurements count from this modelled turn rate on, rad/s.
const MIN_RATE: f64 = 0.1;
/// Standard deviation of a measurement from the ratio's line, rad/s: changes of the command within the latency's error.
const SIGMA: f64 = 0.06;
/// Standard deviation of the ratio before the first measurement.
const PRIOR_SIGMA: f64 = 0.3;
/// Share of the sums that is kept at each measurement.
const KEPT: f64 = 0.995;
/// The ratio is known from this standard deviation on.
const MAX_SIGMA: f64 = 0.03;
/// Half the width of the interval in standard deviations.
const INTERVAL_SIGMAS: f64 = 3.0;

/// The commanded turn rates, ramped within the limits, and the sums of the regression.
#[derive(Clone, Debug)]
pub(super) struct TurnResponse {
    limits: Limits,
    /// Time of each command, the rate that the ramp had then, and the command.
    commands: VecDeque<(f64, f64, f64)>,
    product: f64,
    square: f64,
    measured_s: f64,
}

impl TurnResponse {
    pub const fn new(limits: &Limits) -> Self {
        Self {
            limits: *limits,
            commands: VecDeque::new(),
            product: 0.0,
            square: 0.0,
            measured_s: f64::NEG_INFINITY,
        }
    }

    pub fn command(&mut self, time_s: f64, rate: f64) {
        if self.commands.back().is_some_and(|last| last.0 >= time_s) {
            self.commands.clear();
        }
        let ramp = self.at(time_s).unwrap_or(0.0);
        self.commands.push_back((time_s, ramp, rate));
        while self.commands.len() > MAX_COMMANDS
            || self.commands.get(1).is_some_and(|next| time_s - next.0 > HISTORY_S)
        {
            self.commands.pop_front();
        }
    }

    /// The ramp at a time; none before the first command.
    fn at(&self, time_s: f64) -> Option<f64> {
        let &(from_s, from, to) = self.commands.iter().rev().find(|one| one.0 <= time_s)?;
        let (up, down) = (self.limits.acc_lim_theta, -self.limits.decel_lim_theta);
        let (rise, fall) = if from >= 0.0 { (up, down) } else { (down, up) };
        let elapsed_s = time_s - from_s;
        Some(to.max(from - fall * elapsed_s).min(from + rise * elapsed_s))
    }

    /// Adds a measured turn rate with the latency of the base, seconds.
    pub fn observe(&mut self, time_s: f64, rate: f64, delay_s: f64) {
        if time_s == self.measured_s {
            return;
        }
        self.measured_s = time_s;
        let Some(modelled) = self.at(time_s - delay_s).filter(|rate| rate.abs() >= MIN_RATE) else {
            return;
        };
        self.product = KEPT * self.product + modelled * rate;
        self.square = KEPT * self.square + modelled * modelled;
    }

    /// Measured over commanded turn rate; none until it is known.
    pub fn ratio(&self) -> Option<Interval> {
        let prior = (SIGMA / PRIOR_SIGMA) * (SIGMA / PRIOR_SIGMA);
        let square = self.square + prior;
        let value = (self.product + prior) / square;
        let sigma = SIGMA / square.sqrt();
        let half = INTERVAL_SIGMAS * sigma;
        (sigma <= MAX_SIGMA).then_some(Interval { value, low: value - half, high: value + half })
    }
}
