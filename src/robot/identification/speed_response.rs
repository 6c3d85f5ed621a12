//! Latency, acceleration and braking of a base by a bank of models.
//!
//! A model follows the commands by a ramp with shares of the nominal acceleration and deceleration, and shows the result after
//! a delay. The squared differences from the measured speed are summed for each model; models whose sum exceeds the smallest
//! one by little make up the interval of an estimate (a profile likelihood).

use std::collections::VecDeque;

use super::Interval;
use crate::robot::Limits;

/// Time step of the ramps, seconds.
const STEP_S: f64 = 0.01;
/// Delays of the bank: multiples of this many steps, up to the largest.
const DELAY_STEPS: usize = 2;
const DELAYS: usize = 41;
const LONGEST_STEPS: usize = DELAY_STEPS * (DELAYS - 1);
/// Shares of the nominal acceleration and deceleration, equally spaced. A base that can do more is not seen to, because the
/// commands do not ask for more.
const LEAST_SHARE: f64 = 0.4;
const SHARES: usize = 7;
const SHARE_STEP: f64 = 0.1;
const MODELS: usize = SHARES * SHARES;

/// Measurements count while the commands of the last moments differ by more than this, m/s. At a constant speed all delays
/// explain them alike.
const MIN_SPREAD: f64 = 0.03;
/// A measurement farther than this from every model does not count, m/s: the base does not follow the commands.
const MAX_RESIDUAL: f64 = 0.1;
/// Smallest standard deviation of a measurement from the true model, m/s: encoder resolution, ground, and the form of the
/// response.
const MIN_SIGMA: f64 = 0.01;
/// Standard deviation of the ratio of measured to commanded speed before the first measurement.
const RATIO_SIGMA: f64 = 0.03;
/// Squared number of standard deviations of an interval. Consecutive measurements are correlated.
const INTERVAL_SIGMAS2: f64 = 9.0;
/// A model with less than the nominal acceleration or braking must fit better by this standard deviation, m/s. A lag smooths the
/// steps of gentle commands, and so does a slow ramp.
const FORM_SIGMA: f64 = 0.012;
/// Error of a delay by the form of the response and by the times of commands and measurements, seconds.
const FORM_S: f64 = 0.02;
/// Share of the sums that is kept at each measurement: a memory of a hundred informative ones.
const KEPT: f64 = 0.99;
/// The ramps restart after a longer gap in time, seconds.
const LONGEST_GAP_S: f64 = 2.0;

/// Sums of a model and a delay.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    /// Measured times modelled speed, and modelled speed squared.
    product: f64,
    square: f64,
}

/// The bank of models.
#[derive(Clone, Debug)]
pub(super) struct SpeedResponse {
    limits: Limits,
    /// Speed of each model in the last moments without delay, the newest last; `MODELS` values for each step.
    ramps: VecDeque<[f64; MODELS]>,
    /// Time of the newest step, seconds; none before the first command or measurement.
    newest_s: Option<f64>,
    command: f64,
    measured_s: f64,
    sums: Vec<Sums>,
    /// Sum of the squared measurements, and their number, both forgetting.
    squares: f64,
    count: f64,
    unexplained: u64,
    /// The smallest squared error for each delay, and over all delays for each share.
    fit: Fit,
}

/// Squared errors of the bank after the last measurement.
#[derive(Clone, Debug)]
struct Fit {
    by_delay: [f64; DELAYS],
    by_acceleration: [f64; SHARES],
    by_braking: [f64; SHARES],
    ratio: f64,
    /// Information on the ratio: the squared modelled speeds.
    square: f64,
    /// Excess over the smallest error that still fits.
    tolerance: f64,
}

impl Fit {
    const EMPTY: Self = Self {
        by_delay: [0.0; DELAYS],
        by_acceleration: [0.0; SHARES],
        by_braking: [0.0; SHARES],
        ratio: 1.0,
        square: 0.0,
        tolerance: f64::INFINITY,
    };
}

impl SpeedResponse {
    pub fn new(limits: &Limits) -> Self {
        Self {
            limits: *limits,
            ramps: VecDeque::with_capacity(LONGEST_STEPS + 2),
            newest_s: None,
            command: 0.0,
            measured_s: f64::NEG_INFINITY,
            sums: vec![Sums::default(); MODELS * DELAYS],
            squares: 0.0,
            count: 0.0,
            unexplained: 0,
            fit: Fit::EMPTY,
        }
    }

    /// Records a commanded speed from a time on.
    pub fn command(&mut self, time_s: f64, speed: f64) {
        self.advance(time_s, self.command);
        self.command = speed;
    }

    /// Compares a measured speed with the bank; returns whether the fit changed.
    pub fn observe(&mut self, time_s: f64, speed: f64) -> bool {
        if time_s == self.measured_s {
            return false;
        }
        self.measured_s = time_s;
        self.advance(time_s, speed);
        let Some(newest_s) = self.newest_s else {
            return false;
        };
        // A measurement may be older than the last command, but not older than the history.
        let age_steps = ((newest_s - time_s) / STEP_S).round().max(0.0);
        let last = self.ramps.len().saturating_sub(1);
        if age_steps > LONGEST_STEPS as f64 {
            return false;
        }
        let newest = last.saturating_sub(age_steps as usize);
        let row_at = |delay: usize| &self.ramps[newest.saturating_sub(delay * DELAY_STEPS)];
        let (mut lowest, mut highest) = (f64::INFINITY, f64::NEG_INFINITY);
        let mut residual = f64::INFINITY;
        for delay in 0..DELAYS {
            for modelled in row_at(delay) {
                (lowest, highest) = (lowest.min(*modelled), highest.max(*modelled));
                residual = residual.min((speed - modelled).abs());
            }
        }
        if highest - lowest < MIN_SPREAD {
            return false;
        }
        if residual > MAX_RESIDUAL {
            self.unexplained += 1;
            return true;
        }
        self.squares = KEPT * self.squares + speed * speed;
        self.count = KEPT * self.count + 1.0;
        for (delay, sums) in self.sums.chunks_exact_mut(MODELS).enumerate() {
            let row = &self.ramps[newest.saturating_sub(delay * DELAY_STEPS)];
            for (sums, modelled) in sums.iter_mut().zip(row) {
                sums.product = KEPT * sums.product + speed * modelled;
                sums.square = KEPT * sums.square + modelled * modelled;
            }
        }
        self.refit();
        true
    }

    /// Advances the ramps to a time. The first call, and one after a gap, fills them with a speed.
    fn advance(&mut self, time_s: f64, speed: f64) {
        let is_continuous = |newest_s: f64| {
            (-(LONGEST_STEPS as f64) * STEP_S..LONGEST_GAP_S).contains(&(time_s - newest_s))
        };
        let Some(newest_s) = self.newest_s.filter(|newest_s| is_continuous(*newest_s)) else {
            self.ramps.clear();
            self.ramps.resize(LONGEST_STEPS + 1, [speed; MODELS]);
            self.newest_s = Some(time_s);
            return;
        };
        let steps = ((time_s - newest_s) / STEP_S).round().max(0.0);
        for _ in 0..steps as u32 {
            let mut row = self.ramps.pop_front().unwrap_or([0.0; MODELS]);
            row = *self.ramps.back().unwrap_or(&row);
            for (model, value) in row.iter_mut().enumerate() {
                *value = self.ramp(*value, model);
            }
            self.ramps.push_back(row);
        }
        self.newest_s = Some(newest_s + steps * STEP_S);
    }

    /// A model's speed after a step.
    fn ramp(&self, speed: f64, model: usize) -> f64 {
        let up = self.limits.acc_lim_x * share(model / SHARES) * STEP_S;
        let down = -self.limits.decel_lim_x * share(model % SHARES) * STEP_S;
        let (rise, fall) = if speed >= 0.0 { (up, down) } else { (down, up) };
        self.command.max(speed - fall).min(speed + rise)
    }

    /// Finds the smallest squared errors.
    fn refit(&mut self) {
        let prior = (MIN_SIGMA / RATIO_SIGMA) * (MIN_SIGMA / RATIO_SIGMA);
        let mut fit = Fit {
            by_delay: [f64::INFINITY; DELAYS],
            by_acceleration: [f64::INFINITY; SHARES],
            by_braking: [f64::INFINITY; SHARES],
            ..Fit::EMPTY
        };
        let mut best = f64::INFINITY;
        let form = FORM_SIGMA * FORM_SIGMA * self.count;
        let handicap = |index: usize| if index + 1 == SHARES { 0.0 } else { form };
        for (index, sums) in self.sums.iter().enumerate() {
            let (delay, model) = (index / MODELS, index % MODELS);
            let (acceleration, braking) = (model / SHARES, model % SHARES);
            // The ratio that fits this model best, drawn to one as by an earlier measurement.
            let ratio = (sums.product + prior) / (sums.square + prior);
            let off = ratio - 1.0;
            let error = self.squares - ratio * (2.0 * sums.product - ratio * sums.square)
                + prior * off * off
                + handicap(acceleration)
                + handicap(braking);
            fit.by_delay[delay] = fit.by_delay[delay].min(error);
            let by_acceleration = &mut fit.by_acceleration[acceleration];
            *by_acceleration = by_acceleration.min(error);
            let by_braking = &mut fit.by_braking[braking];
            *by_braking = by_braking.min(error);
            if error < best {
                (best, fit.ratio, fit.square) = (error, ratio, sums.square + prior);
            }
        }
        let variance = (best / (self.count - 3.0).max(1.0)).max(MIN_SIGMA * MIN_SIGMA);
        fit.tolerance = INTERVAL_SIGMAS2 * variance;
        self.fit = fit;
    }

    /// The interval of the delay, seconds. Without information it holds all delays of the bank.
    pub fn delay_s(&self) -> Interval {
        let spacing_s = DELAY_STEPS as f64 * STEP_S;
        let errors = &self.fit.by_delay;
        let (value, low, high) = minimum(errors, self.fit.tolerance);
        Interval {
            value: value * spacing_s,
            low: (low * spacing_s - FORM_S).max(0.0),
            high: high * spacing_s + FORM_S,
        }
    }

    /// Acceleration and deceleration, m/s^2: nominal, unless the measurements contradict it.
    pub fn accelerations(&self, limits: &Limits) -> (f64, f64) {
        let of = |errors: &[f64; SHARES]| {
            let (value, _, high) = minimum(errors, self.fit.tolerance);
            let is_nominal = high >= (SHARES - 1) as f64;
            if is_nominal { 1.0 } else { LEAST_SHARE + SHARE_STEP * value }
        };
        let fit = &self.fit;
        (limits.acc_lim_x * of(&fit.by_acceleration), -limits.decel_lim_x * of(&fit.by_braking))
    }

    /// Measured over commanded speed.
    pub fn ratio(&self) -> Interval {
        let value = self.fit.ratio;
        let half = (self.fit.tolerance / self.fit.square).sqrt();
        Interval { value, low: value - half, high: value + half }
    }

    pub const fn unexplained(&self) -> u64 {
        self.unexplained
    }
}

fn share(index: usize) -> f64 {
    LEAST_SHARE + SHARE_STEP * index as f64
}

/// Index of the smallest error, and the first and last index within a tolerance of it, all interpolated.
fn minimum(errors: &[f64], tolerance: f64) -> (f64, f64, f64) {
    let mut best = 0;
    for (index, error) in errors.iter().enumerate() {
        if *error < errors[best] {
            best = index;
        }
    }
    let bound = errors[best] + tolerance;
    let mut value = best as f64;
    if best > 0 && best + 1 < errors.len() {
        let (left, right) = (errors[best - 1] - errors[best], errors[best + 1] - errors[best]);
        if left + right > 0.0 {
            value += 0.5 * (left - right) / (left + right);
        }
    }
    // The bound lies between the last index within it and the next one.
    let end = |indices: &mut dyn Iterator<Item = usize>, direction: f64| {
        let mut within = best;
        for index in indices {
            if errors[index] > bound {
                let rise = errors[index] - errors[within];
                let share = if rise > 0.0 { (bound - errors[within]) / rise } else { 0.0 };
                return within as f64 + direction * share.clamp(0.0, 1.0);
            }
            within = index;
        }
        within as f64
    };
    let high = end(&mut (best + 1..errors.len()), 1.0);
    let low = end(&mut (0..best).rev(), -1.0);
    (value, low, high)
}
