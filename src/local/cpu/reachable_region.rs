//! The region of the field that the samples of a decision can reach.

use super::arithmetic::cos_q20;
use super::lanes::{Lanes, MAX_LANES};
use crate::local::QuantizedProblem;
use crate::local::kernel_inputs::{Header, ProfileSegment, QuantizedDisc, VxSample};
use crate::local::rollout::displacement;
use crate::numeric::{HALF_TURN, ONE_Q20, QUARTER_TURN};

/// Bound of the error in the order of two rounded cosines, Q20: each is within 0.63 of the true one.
const ROUNDING_Q20: i32 = 2;

/// A rectangle of cells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Region {
    /// First column.
    pub column: i32,
    /// First row.
    pub row: i32,
    /// Columns.
    pub width: i32,
    /// Rows.
    pub height: i32,
}

impl Region {
    /// All cells of the field that a disc's centre can be in for any sample at any step, and a small margin. Empty when
    /// none is on the field.
    #[inline(always)]
    pub fn new<L: Lanes>(token: L::FeatureToken, problem: &QuantizedProblem) -> Self {
        let header = &problem.header;
        let discs = max_disc_offset(problem) + 2;
        let across = displacement_range::<L>(token, problem, header.heading);
        let along =
            displacement_range::<L>(token, problem, header.heading.wrapping_sub(QUARTER_TURN));
        let cells = |start: i32, (min, max): (i32, i32), cells: u32| {
            let cell = |displacement_range: i32| {
                start.saturating_add(displacement_range) >> header.cell_bits
            };
            let first = cell(min - discs).clamp(0, cells as i32);
            (first, (cell(max + discs) + 1).clamp(first, cells as i32))
        };
        let columns = cells(header.start_x, across, header.width);
        let rows = cells(header.start_y, along, header.height);
        Self {
            column: columns.0,
            row: rows.0,
            width: columns.1 - columns.0,
            height: rows.1 - rows.0,
        }
    }

    /// Number of cells.
    pub const fn cells(&self) -> usize {
        self.width as usize * self.height as usize
    }
}

/// Largest distance of a disc's centre from the robot's origin, units.
pub fn max_disc_offset(problem: &QuantizedProblem) -> i32 {
    let reach = |disc: &QuantizedDisc| disc.x.abs() + disc.y.abs();
    problem.discs.iter().map(reach).max().unwrap_or_default()
}

/// Smallest and largest displacement of any sample at any step, along the axis from which the heading is measured.
#[inline(always)]
fn displacement_range<L: Lanes>(
    token: L::FeatureToken,
    problem: &QuantizedProblem,
    heading: u32,
) -> (i32, i32) {
    let header = &problem.header;
    let (least_turn, most_turn) = turn_range(problem);
    let apart = most_turn.wrapping_sub(least_turn);
    // Profiles with several segments change their speed: then each step has its own range.
    let changes_speed = header.segment_count > 1;
    let speeds = speed_range(problem);
    let (mut min, mut max) = (0, 0);
    let (mut min_sum, mut max_sum) = (0, 0);
    let (mut least, mut most) = (0, 0);
    for begin in (0..header.steps).step_by(L::COUNT) {
        let (min_cosines, max_cosines) = cosines::<L>(token, begin, heading, (least_turn, apart));
        let left = (header.steps - begin) as usize;
        for (one, other) in min_cosines.iter().zip(&max_cosines).take(left.min(L::COUNT)) {
            let (one, other) = (one - ROUNDING_Q20, other + ROUNDING_Q20);
            if changes_speed {
                let steps = [one, other]
                    .map(|cosine| speeds.map(|coarse| i64::from(coarse) * i64::from(cosine)));
                let products = steps.as_flattened();
                least += products.iter().copied().min().unwrap_or_default();
                most += products.iter().copied().max().unwrap_or_default();
                // Both displacements of a position are rounded: at most one unit each, and the rounding of the table.
                let units = |sum: i64| (sum >> (header.table_bits + header.coarse_bits)) as i32;
                let rounding = 4 + coarse_rounding(header, speeds);
                min = min.min(units(least) - rounding);
                max = max.max(units(most) + rounding);
                continue;
            }
            min_sum += one;
            max_sum += other;
            for sum in [min_sum, max_sum] {
                for coarse in speeds {
                    let distance = displacement(header, coarse, sum);
                    min = min.min(distance);
                    max = max.max(distance);
                }
            }
        }
    }
    (min, max)
}

/// Bound of the displacement that the rounding of two table entries changes, units.
fn coarse_rounding(header: &Header, speeds: [i32; 2]) -> i32 {
    let [least, most] = speeds.map(i32::unsigned_abs);
    ((2 * least.max(most)) >> header.coarse_bits) as i32 + 1
}

/// Smallest and largest turn in any step of any row, binary angles that differ by less than a full turn.
fn turn_range(problem: &QuantizedProblem) -> (u32, u32) {
    if problem.header.segment_count == 1 {
        // Turn rates increase from the first to the last, and differ by less than a full turn per step.
        let turn = |segment: Option<&ProfileSegment>| segment.map_or(0, |segment| segment.turn);
        return (turn(problem.segments.first()), turn(problem.segments.last()));
    }
    // A turn in one step is less than half a turn.
    let most = problem.profiles.iter().map(|profile| profile.max_turn).max().unwrap_or_default();
    (most.wrapping_neg(), most)
}

/// The smallest and the largest coarse speed of any sample at any step.
fn speed_range(problem: &QuantizedProblem) -> [i32; 2] {
    let coarse = |vx: Option<&VxSample>| vx.map_or(0, |vx| vx.coarse);
    let mut range = [coarse(problem.vx_samples.first()), coarse(problem.vx_samples.last())];
    if problem.header.segment_count > 1 {
        for profile in &problem.profiles {
            range = [range[0].min(profile.coarse), range[1].max(profile.coarse)];
        }
    }
    range
}

/// Minima and maxima of the cosines of all headings at the steps from `begin`. The first row turns by `angle_per_step`
/// per step, the last by `apart` more.
#[inline(always)]
fn cosines<L: Lanes>(
    token: L::FeatureToken,
    begin: u32,
    heading: u32,
    (angle_per_step, apart): (u32, u32),
) -> ([i32; MAX_LANES], [i32; MAX_LANES]) {
    let (mut from, mut beyond) = ([0; MAX_LANES], [0; MAX_LANES]);
    for (step, (from, beyond)) in (begin..).zip(from.iter_mut().zip(&mut beyond)) {
        *from = heading.wrapping_add(angle_per_step.wrapping_mul(step)) as i32;
        // The range of headings is at most a full turn.
        *beyond = (u64::from(apart) * u64::from(step)).min(u64::from(u32::MAX)) as u32 as i32;
    }
    let (from, beyond) = (L::load(token, &from), L::load(token, &beyond));
    let one = cos_q20(token, from);
    let other = cos_q20(token, from.add(beyond));
    let zero = L::splat(token, 0);
    let max_passed = beyond.less_unsigned(zero.sub(from));
    let min_passed = beyond.less_unsigned(L::splat(token, HALF_TURN as i32).sub(from));
    let full = L::splat(token, ONE_Q20);
    let (mut min, mut max) = ([0; MAX_LANES], [0; MAX_LANES]);
    L::select(min_passed, one.min(other), zero.sub(full)).store(&mut min);
    L::select(max_passed, one.max(other), full).store(&mut max);
    (min, max)
}
