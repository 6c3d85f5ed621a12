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

/// Sums of a delay, for each model.
#[derive(Clone, Debug)]
struct Sums {
    /// Measured times modelled speed.
    products: [f64; MODELS],
    /// Modelled speed squared.
    squares: [f64; MODELS],
}

impl Sums {
    const ZERO: Self = Self { products: [0.0; MODELS], squares: [0.0; MODELS] };

    /// Adds a measured speed and those of the models.
    fn add(&mut self, speed: f64, modelled: &[f64; MODELS]) {
        for (product, modelled) in self.products.iter_mut().zip(modelled) {
            *product = KEPT * *product + speed * modelled;
        }
        for (square, modelled) in self.squares.iter_mut().zip(modelled) {
            *square = KEPT * *square + modelled * modelled;
        }
    }
}

/// The speeds of the models at a step, and their least and largest.
#[derive(Clone, Debug)]
struct Ramps {
    speeds: [f64; MODELS],
    lowest: f64,
    highest: f64,
}

impl Ramps {
    fn new(speeds: &[f64; MODELS]) -> Self {
        Self {
            lowest: speeds.iter().copied().fold(f64::INFINITY, f64::min),
            highest: speeds.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            speeds: *speeds,
        }
    }
}

/// The bank of models.
#[derive(Clone, Debug)]
pub(super) struct SpeedResponse {
    limits: Limits,
    /// Speeds of the models in the last moments without delay, the newest last.
    ramps: VecDeque<Ramps>,
    /// Time of the newest step, seconds; none before the first command or measurement.
    newest_s: Option<f64>,
    command: f64,
    measured_s: f64,
    /// For each delay.
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
            sums: vec![Sums::ZERO; DELAYS],
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
        let rows = || (0..DELAYS).map(row_at);
        let lowest = rows().map(|row| row.lowest).fold(f64::INFINITY, f64::min);
        let highest = rows().map(|row| row.highest).fold(f64::NEG_INFINITY, f64::max);
        if highest - lowest < MIN_SPREAD {
            return false;
        }
        let explains = |modelled: &f64| (speed - modelled).abs() <= MAX_RESIDUAL;
        if !rows().any(|row| row.speeds.iter().any(explains)) {
            self.unexplained += 1;
            return true;
        }
        self.squares = KEPT * self.squares + speed * speed;
        self.count = KEPT * self.count + 1.0;
        for (sums, row) in self.sums.iter_mut().zip((0..DELAYS).map(row_at)) {
            sums.add(speed, &row.speeds);
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
            self.ramps.resize(LONGEST_STEPS + 1, Ramps::new(&[speed; MODELS]));
            self.newest_s = Some(time_s);
            return;
        };
        let steps = ((time_s - newest_s) / STEP_S).round().max(0.0);
        for _ in 0..steps as u32 {
            let mut speeds = self.ramps.back().map_or([0.0; MODELS], |newest| newest.speeds);
            for (model, speed) in speeds.iter_mut().enumerate() {
                *speed = self.ramp(*speed, model);
            }
            self.ramps.pop_front();
            self.ramps.push_back(Ramps::new(&speeds));
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
        let handicaps: [(f64, f64); MODELS] =
            core::array::from_fn(|model| (handicap(model / SHARES), handicap(model % SHARES)));
        let mut by_model = [f64::INFINITY; MODELS];
        for (delay, sums) in self.sums.iter().enumerate() {
            let mut errors = [0.0; MODELS];
            for (model, error) in errors.iter_mut().enumerate() {
                let (product, square) = (sums.products[model], sums.squares[model]);
                // The ratio that fits this model best, drawn to one as by an earlier measurement.
                let ratio = (product + prior) / (square + prior);
                let off = ratio - 1.0;
                let (acceleration, braking) = handicaps[model];
                *error = self.squares - ratio * (2.0 * product - ratio * square)
                    + prior * off * off
                    + acceleration
                    + braking;
            }
            for (least, error) in by_model.iter_mut().zip(&errors) {
                *least = if error < least { *error } else { *least };
            }
            let least = errors.iter().copied().fold(f64::INFINITY, f64::min);
            fit.by_delay[delay] = least;
            if least < best
                && let Some(model) = errors.iter().position(|error| *error == least)
            {
                best = least;
                fit.square = sums.squares[model] + prior;
                fit.ratio = (sums.products[model] + prior) / fit.square;
            }
        }
        for (model, error) in by_model.into_iter().enumerate() {
            let by_acceleration = &mut fit.by_acceleration[model / SHARES];
            *by_acceleration = by_acceleration.min(error);
            let by_braking = &mut fit.by_braking[model % SHARES];
            *by_braking = by_braking.min(error);
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
