//! The motions of a decision's samples, step by step.
//!
//! A sample is a column (a forward speed) of a row (a turn profile). The turn rate at a step depends only on the row. The
//! forward speed at a step is a share of the column's speed and the rest of the row's speed. So one table per row
//! serves all columns, for every sampler.

use super::sample_profile::{Profile, Segment};
use super::sampler::MAX_SEGMENTS;
use super::window::AxisValues;
use super::{Axis, Sampler, SamplerInputs, Window};
use crate::geometry::Twist;

/// The golden ratio minus one: its multiples, modulo one, are spread evenly for any number of them.
const GOLDEN_SHARE: f64 = 0.618_033_988_749_894_9;

/// The rows and columns of a decision.
#[derive(Clone, Copy, Debug)]
pub(super) struct SampleMotions<'a> {
    pub sampler: Sampler,
    pub window: &'a Window,
    pub inputs: &'a SamplerInputs,
    /// Duration of a step, seconds.
    pub step_s: f64,
    /// Number of steps.
    pub steps: u32,
    /// First turn rates; those of [`Sampler::Arcs`] and [`Sampler::Ramps`] have one row each.
    first_rates: AxisValues,
    /// Number of rows for each of them.
    rows_per_rate: u32,
}

impl<'a> SampleMotions<'a> {
    /// The motions within `steps` steps of `step_s` seconds.
    pub fn new(
        sampler: Sampler,
        window: &'a Window,
        inputs: &'a SamplerInputs,
        step_s: f64,
        steps: u32,
    ) -> Self {
        let rows = window.vtheta.count.max(1);
        let rates = match sampler {
            Sampler::Arcs | Sampler::Ramps => rows,
            // Four values hold zero and the last command between the ends.
            Sampler::TwoSegments | Sampler::Sequences => {
                (libm::cbrt(f64::from(rows)).round().max(4.0) as u32).min(rows)
            }
        };
        let rows_per_rate = rows.div_ceil(rates);
        let count = rows.div_ceil(rows_per_rate);
        let first_rates = AxisValues::new(Axis { count, ..window.vtheta });
        Self { sampler, window, inputs, step_s, steps, first_rates, rows_per_rate }
    }

    /// The profile of a row.
    #[inline(always)]
    pub fn profile(&self, row: u32) -> Profile {
        match self.sampler {
            Sampler::Arcs => self.arc(self.first_rate(row)),
            Sampler::Ramps => self.ramp(row),
            Sampler::TwoSegments => self.two_segments(row),
            Sampler::Sequences => self.sequence(row),
        }
    }

    /// Speed of a sample's column, m/s, and profile of its row.
    pub fn sample(&self, index: u32) -> (f64, Profile) {
        let columns = self.window.vx.count;
        (self.window.vx.value(index % columns), self.profile(index / columns))
    }

    /// Velocity of a sample in its first control period: the command if it wins.
    pub fn command(&self, index: u32) -> Twist {
        let columns = self.window.vx.count;
        let row = index / columns;
        let vx = self.command_speed(self.window.vx.value(index % columns));
        let first = self.first_rate(row);
        let vtheta = match self.sampler {
            Sampler::Ramps => {
                let now = self.inputs.twist.angular;
                now + self.ramp_share() * (first - now)
            }
            Sampler::Arcs | Sampler::TwoSegments | Sampler::Sequences => first,
        };
        Twist::new(vx, vtheta)
    }

    /// Forward speed in the first control period of a column with this speed, m/s.
    pub fn command_speed(&self, vx: f64) -> f64 {
        if self.sampler != Sampler::Ramps {
            return vx;
        }
        let now = self.inputs.twist.linear;
        now + self.ramp_share() * (vx - now)
    }

    /// The part of a ramp that the first control period covers.
    fn ramp_share(&self) -> f64 {
        let ramp_s = f64::from(self.ramp_steps()) * self.step_s;
        (self.inputs.control_period_s / ramp_s).min(1.0)
    }

    /// Largest absolute forward speed of any sample at any step, m/s.
    pub fn fastest(&self) -> f64 {
        let limits = &self.inputs.limits;
        let window = self.window.vx.max_abs();
        match self.sampler {
            Sampler::Arcs => window,
            Sampler::Ramps => window.max(self.inputs.twist.linear.abs()),
            Sampler::TwoSegments | Sampler::Sequences => {
                window.max(limits.max_vel_x.abs()).max(limits.min_vel_x.abs())
            }
        }
    }

    /// Largest absolute turn rate of any sample at any step, rad/s.
    pub fn fastest_turn(&self) -> f64 {
        let window = self.window.vtheta.max_abs();
        match self.sampler {
            Sampler::Arcs => window,
            Sampler::Ramps => window.max(self.inputs.twist.angular.abs()),
            Sampler::TwoSegments | Sampler::Sequences => {
                window.max(self.inputs.limits.max_vel_theta)
            }
        }
    }

    #[inline]
    const fn arc(&self, vtheta: f64) -> Profile {
        let mut segments = [Segment::constant(self.steps, 0.0, 1.0); MAX_SEGMENTS];
        segments[0] = Segment::constant(self.steps, vtheta, 1.0);
        Profile { vx: 0.0, segments, count: self.sampler.segment_count() }
    }

    #[inline(always)]
    fn ramp_steps(&self) -> u32 {
        ramp_steps(self.inputs.ramp_time_s, self.step_s)
    }

    /// From the present velocity to that of row and column.
    #[inline(always)]
    fn ramp(&self, row: u32) -> Profile {
        let now = self.inputs.twist;
        let target = self.first_rate(row);
        let mut profile = self.arc(target);
        let steps = self.ramp_steps();
        let end = steps.min(self.steps);
        profile.vx = now.linear;
        profile.segments[0] = Segment::ramp(end, steps, [now.angular, target], [0.0, 1.0]);
        profile.segments[1] = Segment::constant(self.steps, target, 1.0);
        profile
    }

    /// First turn rate of a row.
    #[inline]
    fn first_rate(&self, row: u32) -> f64 {
        self.first_rates.at(row / self.rows_per_rate)
    }

    /// Steps of the first velocity: those of a control period, at least one.
    #[inline(always)]
    fn command_steps(&self) -> u32 {
        let steps = (self.inputs.control_period_s / self.step_s).round().max(1.0) as u32;
        steps.min(self.steps)
    }

    /// From the first velocity to the second one.
    #[inline(always)]
    fn two_segments(&self, row: u32) -> Profile {
        let first = self.first_rate(row);
        let Some(Second { vx, vtheta, begin }) = self.second(row) else {
            return self.arc(first);
        };
        let limits = &self.inputs.limits;
        let middle = 0.5 * (self.window.vx.low + self.window.vx.high);
        let change = vx.map_or(0.0, |vx| vx - middle);
        let rate = if change < 0.0 { -limits.decel_lim_x } else { limits.acc_lim_x };
        let turn_s = (vtheta - first).abs() / limits.acc_lim_theta;
        let change_s = turn_s.max(change.abs() / rate);
        let steps = (change_s / self.step_s).ceil().clamp(1.0, 65_536.0) as u32;
        let share = if vx.is_some() { 0.0 } else { 1.0 };
        let end = begin.saturating_add(steps).min(self.steps);
        let mut profile = self.arc(first);
        profile.vx = vx.unwrap_or_default();
        profile.segments[0].end = begin;
        profile.segments[1] = Segment::ramp(end, steps, [first, vtheta], [1.0, share]);
        profile.segments[2] = Segment::constant(self.steps, vtheta, share);
        profile
    }

    /// The second velocity of a row; `None` for the first velocity over the whole horizon.
    ///
    /// The turn rate grows with the place of a row, so that neighbouring rows turn alike. The speed is the square root of
    /// the place times the golden ratio, modulo one: so the ends fill the reachable area evenly. All first turn rates have the same second velocities, so that
    /// their comparison does not depend on the places.
    #[inline(always)]
    fn second(&self, row: u32) -> Option<Second> {
        let limits = &self.inputs.limits;
        let begin = self.command_steps();
        let turn = limits.max_vel_theta;
        let (rate, number) = (row / self.rows_per_rate, row % self.rows_per_rate);
        let second = |vx, vtheta| Some(Second { vx, vtheta, begin });
        match number {
            0 => return None,
            1 => return second(None, 0.0),
            _ => {}
        }
        // Standing, turning in place and reversing follow the middle turn rate only: after one control period the first
        // turn rate makes little difference to them.
        if rate == self.first_rates.axis.count / 2 {
            match number {
                2 => return second(Some(0.0), 0.0),
                3 => return second(Some(0.0), turn),
                4 => return second(Some(0.0), -turn),
                5 if limits.min_vel_x < 0.0 => return second(Some(limits.min_vel_x), 0.0),
                _ => {}
            }
        }
        let place = f64::from(number - 2) + 0.5;
        let places = f64::from(self.rows_per_rate - 2);
        let vtheta = turn * (2.0 * place / places - 1.0);
        let along = place * GOLDEN_SHARE;
        let vx = limits.max_vel_x * (along - along.floor()).sqrt();
        // Early, after a quarter and after half of the horizon.
        let begin = begin.max(self.steps * (number % 3) / 4);
        Some(Second { vx: Some(vx), vtheta, begin })
    }

    /// The first velocity, then three changes by noise. The first row of each rate has none.
    #[inline(always)]
    fn sequence(&self, row: u32) -> Profile {
        let first = self.first_rate(row);
        let mut profile = self.arc(first);
        if row.is_multiple_of(self.rows_per_rate) {
            return profile;
        }
        let limits = &self.inputs.limits;
        let knot = |place: u32| self.command_steps().max(self.steps * place / MAX_SEGMENTS as u32);
        let noise = |place| noise(self.inputs.seed, row, place);
        let middle = 0.5 * (self.window.vx.low + self.window.vx.high);
        let horizon_s = f64::from(self.steps.saturating_sub(knot(0))) * self.step_s;
        // The speed at the end of the horizon: reachable with the limits' accelerations, from any column.
        let change = noise(0);
        let change =
            horizon_s * change * if change < 0.0 { -limits.decel_lim_x } else { limits.acc_lim_x };
        profile.vx = (middle + change).clamp(limits.min_vel_x.min(0.0), limits.max_vel_x.max(0.0));
        profile.segments[0].end = knot(0);
        let (mut vtheta, mut share) = (first, 1.0);
        for place in 1..MAX_SEGMENTS as u32 {
            let (begin, end) = (knot(place - 1), if place == 3 { self.steps } else { knot(place) });
            let steps = end.saturating_sub(begin).max(1);
            let most = limits.acc_lim_theta * f64::from(steps) * self.step_s;
            let turn = limits.max_vel_theta;
            let next = (vtheta + most * noise(place)).clamp(-turn, turn);
            // The share falls evenly to zero over the steps after the first command.
            let left = f64::from(self.steps.saturating_sub(end));
            let all = f64::from(self.steps.saturating_sub(knot(0)).max(1));
            let later = left / all;
            profile.segments[place as usize] =
                Segment::ramp(end, steps, [vtheta, next], [share, later]);
            (vtheta, share) = (next, later);
        }
        profile
    }
}

/// A second velocity.
#[derive(Clone, Copy, Debug)]
struct Second {
    /// Forward speed, m/s; `None` for the column's own.
    vx: Option<f64>,
    /// Turn rate, rad/s.
    vtheta: f64,
    /// The step at which the change begins.
    begin: u32,
}

/// Duration of a ramp in steps, at least one.
pub(super) fn ramp_steps(ramp_time_s: f64, step_s: f64) -> u32 {
    (ramp_time_s / step_s).round().clamp(1.0, 65_536.0) as u32
}

/// Noise from -1 to 1 with a triangular distribution: the sum of two 16-bit numbers, exact in f64.
#[inline]
fn noise(seed: u32, row: u32, place: u32) -> f64 {
    // The mixing function of SplitMix64.
    let mut word = (u64::from(seed) << 32 | u64::from(row))
        .wrapping_mul(4)
        .wrapping_add(u64::from(place))
        .wrapping_add(1)
        .wrapping_mul(0x9E37_79B9_7F4A_7C15);
    word = (word ^ (word >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    word = (word ^ (word >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    word ^= word >> 31;
    let sum = (word & 0xFFFF) as i32 + (word >> 16 & 0xFFFF) as i32 - 0xFFFF;
    f64::from(sum) / f64::from(0xFFFF)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::local::Sampling;
    use crate::robot::Limits;

    const STEP_S: f64 = 0.1;
    const STEPS: u32 = 20;

    fn limits() -> Limits {
        Limits::default().min_vel_x(-0.3)
    }

    /// Calls `check` with the motions of a sampler, from a moderate speed.
    fn with_motions(sampler: Sampler, check: impl Fn(&SampleMotions<'_>)) {
        let twist = Twist::new(0.4, 0.2);
        let inputs = SamplerInputs { twist, limits: limits(), ..SamplerInputs::default() };
        let sampling = Sampling { vx_samples: 8, vtheta_samples: 128 };
        let window_s = if sampler == Sampler::Ramps { inputs.ramp_time_s } else { 0.1 };
        let window = Window::new(&inputs.limits, &twist, window_s, sampling).through(&twist);
        check(&SampleMotions::new(sampler, &window, &inputs, STEP_S, STEPS));
    }

    /// Speed and turn rate of a sample in every step.
    fn velocities(motions: &SampleMotions<'_>, row: u32, column: u32) -> Vec<[f64; 2]> {
        let (profile, vx) = (motions.profile(row), motions.window.vx.value(column));
        let at = |step| {
            let (vtheta, share) = profile.at(step);
            [share * vx + (1.0 - share) * profile.vx, vtheta]
        };
        (0..STEPS).map(at).collect()
    }

    fn each_sample(motions: &SampleMotions<'_>, mut check: impl FnMut(u32, u32, Vec<[f64; 2]>)) {
        for row in 0..motions.window.vtheta.count {
            for column in 0..motions.window.vx.count {
                check(row, column, velocities(motions, row, column));
            }
        }
    }

    #[test]
    fn every_profile_has_segments_in_order_up_to_the_last_step() {
        for sampler in Sampler::ALL {
            with_motions(sampler, |motions| {
                for row in 0..motions.window.vtheta.count {
                    let profile = motions.profile(row);
                    assert_eq!(profile.segments().len(), sampler.segment_count());
                    assert!(profile.segments().is_sorted_by_key(|segment| segment.end));
                    assert_eq!(profile.segments().last().map(|segment| segment.end), Some(STEPS));
                }
            });
        }
    }

    #[test]
    fn velocities_change_within_the_limits_and_stay_within_them() {
        for sampler in Sampler::ALL {
            with_motions(sampler, |motions| {
                let limits = limits();
                each_sample(motions, |row, column, velocities| {
                    for &[vx, vtheta] in &velocities {
                        assert!((limits.min_vel_x - 1e-9..=limits.max_vel_x + 1e-9).contains(&vx));
                        assert!(vtheta.abs() <= limits.max_vel_theta + 1e-9, "{row} {vtheta}");
                    }
                    for pair in velocities.windows(2) {
                        let [from, to] = [pair[0], pair[1]];
                        // Columns are up to 0.1 m/s from the middle one, which sets the duration of a change.
                        let change = (to[0] - from[0]).abs() - 0.1;
                        assert!(change <= 1.0 * STEP_S + 1e-9, "{sampler:?} {row} {column}");
                        assert!((to[1] - from[1]).abs() <= 2.0 * STEP_S + 1e-9, "{row}");
                    }
                });
            });
        }
    }

    #[test]
    fn last_command_standing_and_turning_in_place_are_samples() {
        let is_near = |one: [f64; 2], other: [f64; 2]| {
            (one[0] - other[0]).abs() < 1e-9 && (one[1] - other[1]).abs() < 1e-9
        };
        for sampler in Sampler::ALL {
            with_motions(sampler, |motions| {
                let mut keeps = false;
                let mut ends = Vec::new();
                each_sample(motions, |_, _, velocities| {
                    keeps |= velocities.iter().all(|&velocity| is_near(velocity, [0.4, 0.2]));
                    ends.push(velocities[STEPS as usize - 1]);
                });
                assert!(keeps, "{sampler:?} keeps the last command");
                if sampler == Sampler::TwoSegments {
                    let turn = limits().max_vel_theta;
                    for end in [[0.0, 0.0], [0.0, turn], [0.0, -turn], [-0.3, 0.0]] {
                        assert!(ends.iter().any(|&other| is_near(other, end)), "{end:?}");
                    }
                }
            });
        }
    }

    #[test]
    fn commands_are_reachable_in_one_control_period() {
        for sampler in Sampler::ALL {
            with_motions(sampler, |motions| {
                for index in 0..motions.window.len() as u32 {
                    let command = motions.command(index);
                    assert!((command.linear - 0.4).abs() <= 0.1 + 1e-9, "{sampler:?} {command:?}");
                    assert!((command.angular - 0.2).abs() <= 0.2 + 1e-9, "{sampler:?} {command:?}");
                }
            });
        }
    }

    /// Each quarter of the reachable distances and directions has its share of second velocities.
    #[test]
    fn second_velocities_are_spread_evenly() {
        with_motions(Sampler::TwoSegments, |motions| {
            let mut counts = [[0; 2]; 2];
            for row in 0..motions.window.vtheta.count {
                let profile = motions.profile(row);
                let (vtheta, share) = profile.at(STEPS - 1);
                if share == 0.0 && profile.vx > 0.0 {
                    // Half of the area is within 0.71 of the largest distance.
                    let is_far = usize::from(profile.vx > 0.707);
                    counts[is_far][usize::from(vtheta > 0.0)] += 1;
                }
            }
            let counts = counts.as_flattened();
            let (least, most) = (counts.iter().min(), counts.iter().max());
            assert!(
                least.zip(most).is_some_and(|(least, most)| 2 * most <= 3 * least),
                "{counts:?}"
            );
        });
    }

    #[test]
    fn noise_depends_on_seed_row_and_place_and_is_centred() {
        let all: Vec<f64> = (0..4000).map(|row| noise(7, row, 1)).collect();
        let mean = all.iter().sum::<f64>() / 4000.0;
        assert!(mean.abs() < 0.03, "{mean}");
        assert!(all.iter().all(|value| (-1.0..=1.0).contains(value)));
        assert_eq!(noise(7, 3, 1), all[3]);
        assert!(noise(7, 3, 2) != all[3] && noise(8, 3, 1) != all[3]);
    }
}
