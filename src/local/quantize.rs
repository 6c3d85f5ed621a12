//! Converts metres, seconds and radians to the integers that every engine computes with.
//!
//! All rounding of real numbers is here, once per problem, in f64 with `libm`: the result is the same on every
//! platform.

use std::sync::Arc;

use core::f64::consts::TAU;

use multiversion::multiversion;

use super::kernel_inputs::{
    Header, ProfileSegment, QuantizedDisc, QuantizedObstacle, TurnProfile, VxSample,
};
use super::problem::{
    MAX_CLEARANCE_UNITS, MAX_OFFSET_UNITS, MAX_REACH_UNITS, MAX_STEP_UNITS, at_most, check_numbers,
};
use super::sample_motions::SampleMotions;
use super::window::AxisValues;
use super::{ClearanceField, Normalization, Outside, Problem, ProblemError, Sampler, Stopping};
use crate::geometry::Point;
use crate::numeric::turn_size;

/// Fine units per unit of length. Final positions are in fine units.
pub const FINE_PER_UNIT: f64 = 16.0;

/// A whole share.
const ONE_Q30: i32 = 1 << 30;

/// Bound of coarse speeds: a product with a coarse displacement stays within 31 bits after rounding.
const MAX_COARSE_SPEED: f64 = 32_000.0;

/// A problem as integers, the input of every engine.
#[derive(Clone, Debug)]
pub struct QuantizedProblem {
    /// The scalars.
    #[doc(hidden)]
    pub header: Header,
    /// Forward speeds, in order.
    #[doc(hidden)]
    pub vx_samples: Vec<VxSample>,
    /// Turn profiles, one per row, in order.
    #[doc(hidden)]
    pub profiles: Vec<TurnProfile>,
    /// Segments of all profiles, [`Header::segment_count`] of each.
    #[doc(hidden)]
    pub segments: Vec<ProfileSegment>,
    /// Discs of the footprint.
    #[doc(hidden)]
    pub discs: Vec<QuantizedDisc>,
    /// Moving obstacles that can come near enough to matter.
    #[doc(hidden)]
    pub obstacles: Vec<QuantizedObstacle>,
    /// Static obstacles.
    #[doc(hidden)]
    pub field: Arc<ClearanceField>,
}

impl QuantizedProblem {
    /// Quantises a problem.
    ///
    /// # Errors
    /// Names the first quantity outside its range, see [`Problem`].
    pub fn new(problem: &Problem) -> Result<Self, ProblemError> {
        let empty = Self {
            header: Header::default(),
            vx_samples: Vec::new(),
            profiles: Vec::new(),
            segments: Vec::new(),
            discs: Vec::new(),
            obstacles: Vec::new(),
            field: Arc::clone(&problem.field),
        };
        empty.requantized(problem)
    }

    /// As [`Self::new`], in the memory of an old problem: allocates nothing if its lists have room.
    ///
    /// An error consumes `self` too, so no mixture of two problems is ever evaluated.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn requantized(mut self, problem: &Problem) -> Result<Self, ProblemError> {
        check_numbers(problem)?;
        let unit_m = problem.field.unit_m();
        let steps = f64::from(problem.steps);
        let motions = problem.motions();
        let step_units = motions.fastest() * problem.step_s / unit_m;
        let reach_units = step_units * steps;
        at_most("distance in one step", step_units, MAX_STEP_UNITS, unit_m)?;
        at_most("distance over the horizon", reach_units, MAX_REACH_UNITS, unit_m)?;
        let frame = problem.field.frame();
        let start = frame.origin.inverse_transform(&problem.pose.position());
        let relative = |point: &Point| (frame.origin.inverse_transform(point) - start) / unit_m;
        let target = relative(&problem.target);
        let key_node = relative(&problem.key_node);
        at_most("distance to the target", target.norm(), MAX_REACH_UNITS, unit_m)?;
        at_most("distance to the key node", key_node.norm(), MAX_REACH_UNITS, unit_m)?;
        let from_field = start.x.abs().max(start.y.abs()) / unit_m;
        at_most("distance to the field's corner", from_field, 2.0_f64.powi(29), unit_m)?;

        let table_bits = bits_to_fit(steps * 2.0_f64.powi(20), 65_535.0);
        // At most 24 bits are shifted out of a coarse product, so rounding it cannot overflow.
        let coarse_scale = scale_to_fit(step_units, MAX_COARSE_SPEED, table_bits + 4);
        // MAX_STEP_UNITS keeps this at least 12.
        let fine_scale = scale_to_fit(step_units * FINE_PER_UNIT, 2.0_f64.powi(30), 40);
        let fine = |units: f64| round_i32(units * FINE_PER_UNIT);
        self.header = Header {
            vx_count: problem.window.vx.count,
            profile_count: problem.window.vtheta.count,
            steps: problem.steps,
            disc_count: problem.footprint.discs().len() as u32,
            obstacle_count: 0,
            width: frame.width as u32,
            height: frame.height as u32,
            cell_bits: problem.field.cell_bits(),
            start_x: round_i32(start.x / unit_m),
            start_y: round_i32(start.y / unit_m),
            heading: binary_angle(problem.pose.yaw - frame.origin.yaw),
            target_x: fine(target.x),
            target_y: fine(target.y),
            key_x: fine(key_node.x),
            key_y: fine(key_node.y),
            max_clearance: round_i32(problem.max_clearance_m / unit_m) as u32,
            table_bits,
            coarse_bits: coarse_scale + 20 - table_bits,
            fine_bits: fine_scale - 12,
            stop_by_arc: u32::from(problem.stopping == Stopping::Arc),
            outside_is_free: u32::from(problem.outside == Outside::Free),
            min_max: u32::from(problem.normalization == Normalization::MinMax),
            stamp: 0,
            segment_count: problem.sampler.segment_count() as u32,
            weights: weights(problem),
        };
        let scales = [coarse_scale, fine_scale].map(|bits| 2.0_f64.powi(bits as i32));
        fill_speeds(&mut self.vx_samples, problem, scales);
        if problem.sampler == Sampler::Ramps {
            let speeds = AxisValues::new(problem.window.vx);
            for (column, sample) in (0..).zip(&mut self.vx_samples) {
                sample.velocity_term = velocity_term(motions.command_speed(speeds.at(column)));
            }
        }
        if problem.sampler == Sampler::Arcs {
            fill_turns(&mut self.profiles, &mut self.segments, problem);
        } else {
            fill_profiles(&mut self.profiles, &mut self.segments, problem, &motions, scales);
        }
        fill_discs(&mut self.discs, problem)?;
        fill_obstacles(&mut self.obstacles, problem, reach_units)?;
        self.header.obstacle_count = self.obstacles.len() as u32;
        if !Arc::ptr_eq(&self.field, &problem.field) {
            self.field = Arc::clone(&problem.field);
        }
        Ok(self)
    }

    /// The segments of a row's profile.
    #[must_use]
    #[inline]
    pub(crate) fn segments(&self, row: usize) -> &[ProfileSegment] {
        let count = self.header.segment_count as usize;
        &self.segments[row * count..][..count]
    }

    /// Number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.vx_samples.len() * self.profiles.len()
    }

    /// Whether there is no sample. Always false for a quantised problem.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Uses the rounding instructions of AVX2 if available: it runs at every decision.
#[multiversion(targets("x86_64+avx2"))]
fn fill_speeds(vx_samples: &mut Vec<VxSample>, problem: &Problem, scales: [f64; 2]) {
    let units_per_step = problem.step_s / problem.field.unit_m();
    let axis = &problem.window.vx;
    vx_samples.clear();
    vx_samples.resize(axis.count as usize, VxSample::default());
    // A closure is not compiled for AVX2.
    for (index, entry) in (0..axis.count).zip(vx_samples.iter_mut()) {
        *entry = vx_sample(problem, axis.spaced(index), units_per_step, scales);
    }
    for (index, vx) in axis.replaced().into_iter().flatten() {
        vx_samples[index as usize] = vx_sample(problem, vx, units_per_step, scales);
    }
}

#[inline(always)]
fn vx_sample(
    problem: &Problem,
    vx: f64,
    units_per_step: f64,
    [coarse, fine]: [f64; 2],
) -> VxSample {
    VxSample {
        coarse: round_i32(vx * units_per_step * coarse),
        fine: round_i32(vx * units_per_step * FINE_PER_UNIT * fine),
        velocity_term: velocity_term(vx),
        stopping_need: stopping_need(problem, vx, problem.braking_x),
    }
}

#[multiversion(targets("x86_64+avx2"))]
fn fill_turns(
    profiles: &mut Vec<TurnProfile>,
    segments: &mut Vec<ProfileSegment>,
    problem: &Problem,
) {
    let axis = &problem.window.vtheta;
    profiles.clear();
    profiles.resize(axis.count as usize, TurnProfile::default());
    segments.clear();
    segments.resize(axis.count as usize, ProfileSegment::default());
    for ((index, profile), segment) in
        (0..axis.count).zip(profiles.iter_mut()).zip(segments.iter_mut())
    {
        (*profile, *segment) = arc(problem, axis.spaced(index));
    }
    for (index, rate) in axis.replaced().into_iter().flatten() {
        (profiles[index as usize], segments[index as usize]) = arc(problem, rate);
    }
}

#[inline(always)]
fn arc(problem: &Problem, rate: f64) -> (TurnProfile, ProfileSegment) {
    let turn = binary_angle(rate * problem.step_s);
    let profile = TurnProfile {
        coarse: 0,
        fine: 0,
        stopping_need: stopping_need(problem, rate, problem.braking_theta),
        max_turn: turn_size(turn),
        end_turn: turn.wrapping_mul(problem.steps),
    };
    let segment = ProfileSegment {
        end: problem.steps,
        turn,
        turn_growth: 0,
        share: ONE_Q30,
        share_growth: 0,
    };
    (profile, segment)
}

/// Quantises the profiles of a sampler other than [`Sampler::Arcs`]. Uses the rounding instructions of AVX2 if available.
#[multiversion(targets("x86_64+avx2"))]
fn fill_profiles(
    profiles: &mut Vec<TurnProfile>,
    segments: &mut Vec<ProfileSegment>,
    problem: &Problem,
    motions: &SampleMotions<'_>,
    scales: [f64; 2],
) {
    let units_per_step = problem.step_s / problem.field.unit_m();
    let rows = problem.window.vtheta.count as usize;
    profiles.clear();
    profiles.reserve(rows);
    segments.clear();
    segments.reserve(rows * problem.sampler.segment_count());
    for row in 0..problem.window.vtheta.count {
        let motion = motions.profile(row);
        let base = vx_sample(problem, motion.vx, units_per_step, scales);
        let mut profile = TurnProfile {
            coarse: base.coarse,
            fine: base.fine,
            stopping_need: base.stopping_need,
            max_turn: 0,
            end_turn: 0,
        };
        let (mut begin, mut fastest) = (0, 0.0_f64);
        for part in motion.segments() {
            let steps = part.end - begin;
            let segment = ProfileSegment {
                end: part.end,
                turn: binary_angle(part.vtheta * problem.step_s),
                turn_growth: binary_angle(part.vtheta_growth * problem.step_s),
                share: round_i32(part.share * f64::from(ONE_Q30)),
                share_growth: round_i32(part.share_growth * f64::from(ONE_Q30)),
            };
            begin = part.end;
            segments.push(segment);
            if steps == 0 {
                continue;
            }
            // The turn rate changes evenly, so one of its ends is the largest.
            let last = steps - 1;
            let last_turn = segment.turn.wrapping_add(segment.turn_growth.wrapping_mul(last));
            let all_growth = segment.turn_growth.wrapping_mul(steps * last / 2);
            let turned = segment.turn.wrapping_mul(steps).wrapping_add(all_growth);
            profile.end_turn = profile.end_turn.wrapping_add(turned);
            for turn in [segment.turn, last_turn] {
                profile.max_turn = profile.max_turn.max(turn_size(turn));
            }
            let last_rate = part.vtheta + f64::from(last) * part.vtheta_growth;
            fastest = fastest.max(part.vtheta.abs()).max(last_rate.abs());
        }
        // The requirement grows with the rate, so that of the fastest is the largest.
        let turning_need = stopping_need(problem, fastest, problem.braking_theta);
        profile.stopping_need = profile.stopping_need.max(turning_need);
        profiles.push(profile);
    }
}

/// Forward speed in 2^-20 m/s; zero in reverse.
#[inline(always)]
fn velocity_term(vx: f64) -> u32 {
    (vx.max(0.0) * 2.0_f64.powi(20)).round() as u32
}

/// Solves eq. 30 for the requirement: `rate^2 <= 2 dist a` is `dist >= rate^2 / (2 a)`; with the arc, `dist = |rate| n
/// step` gives `n >= |rate| / (2 a step)`. Rounds up, so that a sample at the limit is rejected.
#[inline(always)]
fn stopping_need(problem: &Problem, rate: f64, braking: f64) -> u32 {
    let need = match problem.stopping {
        Stopping::Clearance => rate * rate / (2.0 * braking) / problem.field.unit_m(),
        Stopping::Arc => rate.abs() / (2.0 * braking * problem.step_s),
    };
    need.ceil().min(2.0_f64.powi(30)) as u32
}

/// Names of sums in errors.
pub(crate) const CLEARANCE_AND_DISC: &str = "max_clearance_m plus disc radius";
pub(crate) const CLEARANCE_AND_DISCS: &str = "max_clearance_m plus disc and obstacle radius";

fn fill_discs(discs: &mut Vec<QuantizedDisc>, problem: &Problem) -> Result<(), ProblemError> {
    let unit_m = problem.field.unit_m();
    discs.clear();
    discs.reserve(problem.footprint.discs().len());
    for disc in problem.footprint.discs() {
        at_most("disc offset", disc.x.abs().max(disc.y.abs()) / unit_m, MAX_OFFSET_UNITS, unit_m)?;
        let sum = (problem.max_clearance_m + disc.radius) / unit_m;
        at_most(CLEARANCE_AND_DISC, sum, MAX_CLEARANCE_UNITS, unit_m)?;
        discs.push(QuantizedDisc {
            x: round_i32(disc.x / unit_m),
            y: round_i32(disc.y / unit_m),
            radius: round_i32(disc.radius / unit_m),
        });
    }
    Ok(())
}

/// Keeps the moving obstacles that can come within the clearance cap of the robot. The others change no bit of the
/// answer.
fn fill_obstacles(
    bodies: &mut Vec<QuantizedObstacle>,
    problem: &Problem,
    reach_units: f64,
) -> Result<(), ProblemError> {
    let unit_m = problem.field.unit_m();
    let origin = problem.field.frame().origin;
    let start = origin.inverse_transform(&problem.pose.position());
    let (sin, cos) = libm::sincos(origin.yaw);
    let time_s = f64::from(problem.steps) * problem.step_s;
    let largest_disc = problem.footprint.max_disc_radius_m();
    let reach_m = reach_units * unit_m + problem.footprint.circumscribed_radius_m();
    bodies.clear();
    // Reserves for all obstacles, because the number of near ones changes from one decision to the next.
    bodies.reserve(problem.obstacles.len());
    for (index, disc) in problem.obstacles.iter().enumerate() {
        if !disc.is_valid() {
            return Err(ProblemError::BadObstacle { index });
        }
        let center = origin.inverse_transform(&disc.center()) - start;
        let velocity = crate::geometry::Vector::new(disc.vx, disc.vy).rotated((-sin, cos));
        let comes_within =
            reach_m + velocity.norm() * time_s + problem.max_clearance_m + disc.radius;
        // One metre covers all rounding.
        if center.norm() > comes_within + 1.0 {
            continue;
        }
        let sum = (problem.max_clearance_m + largest_disc + disc.radius) / unit_m;
        at_most(CLEARANCE_AND_DISCS, sum, MAX_CLEARANCE_UNITS, unit_m)?;
        let moved = (center.norm() + velocity.norm() * time_s) / unit_m;
        at_most("distance of a moving obstacle", moved, 2.0_f64.powi(22), unit_m)?;
        let in_256ths = |metres: f64| round_i32(metres / unit_m * 256.0);
        bodies.push(QuantizedObstacle {
            x: in_256ths(center.x),
            y: in_256ths(center.y),
            step_x: in_256ths(velocity.x * problem.step_s),
            step_y: in_256ths(velocity.y * problem.step_s),
            radius: round_i32(disc.radius / unit_m),
        });
    }
    Ok(())
}

/// Weights as shares of 2^30. If all are zero, they stay zero.
fn weights(problem: &Problem) -> [u32; 4] {
    let weights = &problem.weights;
    let list = [weights.heading, weights.clearance, weights.velocity, weights.path];
    let sum: f64 = list.iter().sum();
    if sum == 0.0 {
        return [0; 4];
    }
    list.map(|weight| (weight / sum * 2.0_f64.powi(30)).round() as u32)
}

/// The smallest number of dropped bits for which `largest` does not exceed `limit`.
fn bits_to_fit(largest: f64, limit: f64) -> u32 {
    let mut bits = 0;
    while largest / 2.0_f64.powi(bits) > limit {
        bits += 1;
    }
    bits as u32
}

/// The largest number of bits, at most `most`, by which `largest` can be scaled up without exceeding `limit`.
fn scale_to_fit(largest: f64, limit: f64, most: u32) -> u32 {
    let mut bits = most;
    while bits > 0 && largest * 2.0_f64.powi(bits as i32) > limit {
        bits -= 1;
    }
    bits
}

/// Converts radians to a binary angle.
#[inline(always)]
fn binary_angle(radians: f64) -> u32 {
    let turns = radians / TAU;
    let within_a_turn = turns - turns.floor();
    // Integers below 2^52 stand in the last bits of their sum with 2^52: fewer instructions than a saturating conversion.
    let angle = (within_a_turn * 2.0_f64.powi(32)).round() + 2.0_f64.powi(52);
    angle.to_bits() as u32
}

/// Rounds to the nearest integer; the range checks of the callers keep it within 32 bits.
#[inline(always)]
fn round_i32(value: f64) -> i32 {
    value.round() as i32
}
