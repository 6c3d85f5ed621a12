//! Rolls out one sample and checks it for contacts. TWIN of `shaders/rollout.wgsl`: same names, same order, same bits.
//!
//! In the paper's motion model (eq. 27) the heading at a step does not depend on the speed, so the position is linear
//! in the speed: `x_k = x_0 + v C(k)`, where `C` is the sum of the cosines up to step `k`. One table per turn profile
//! serves all speeds, and a pose costs two multiplications. Where the speed at a step is the share `s` of the sample's
//! speed `v` and the rest of the profile's speed `u`, the position stays linear: `x_k = x_0 + u (C - S)(k) + v S(k)`,
//! where `S` is the sum of the cosines times their shares.

use super::kernel_inputs::{Header, ProfileSegment, QuantizedObstacle, TurnProfile, VxSample};
use super::{ClearanceField, QuantizedProblem, SampleStatus};
use crate::numeric::{ONE_Q20, cos_q20, isqrt32, mul_hi_i32, mul_hi_u32, shift_round, sin_q20};

/// Words of the table of one turn profile. For each step: the coarse displacement (2 words) and the centre of each disc
/// for a sample of speed zero (2 words each). At the end: the sums of cosines and sines times their shares in Q20 (2
/// words), and the final position of a sample of speed zero relative to the start, fine units (2 words).
#[must_use]
pub const fn table_words(header: &Header) -> usize {
    (header.steps * step_words(header) + 4) as usize
}

/// Words of one step in the table.
#[must_use]
pub const fn step_words(header: &Header) -> u32 {
    2 + 2 * header.disc_count
}

/// Fills the table of a row's turn profile.
pub fn tabulate(problem: &QuantizedProblem, row: usize, table: &mut [i32]) {
    let header = &problem.header;
    let profile = &problem.profiles[row];
    let mut segments = problem.segments(row).iter();
    let mut segment = ProfileSegment::default();
    let mut angle = header.heading;
    let mut cosine = cos_q20(angle);
    let mut sine = sin_q20(angle);
    let (mut sum_x, mut sum_y) = (0_i32, 0_i32);
    let (mut rest_x, mut rest_y) = (0_i32, 0_i32);
    let mut at = 0;
    for step in 0..header.steps {
        while step == segment.end
            && let Some(&next) = segments.next()
        {
            segment = next;
        }
        // The pose moves along the old heading, then turns (eq. 27).
        let own_x = mul_hi_i32(segment.share, cosine << 2);
        let own_y = mul_hi_i32(segment.share, sine << 2);
        sum_x += own_x;
        sum_y += own_y;
        rest_x += cosine - own_x;
        rest_y += sine - own_y;
        angle = angle.wrapping_add(segment.turn);
        segment.turn = segment.turn.wrapping_add(segment.turn_growth);
        segment.share += segment.share_growth;
        cosine = cos_q20(angle);
        sine = sin_q20(angle);
        table[at] = shift_round(sum_x, header.table_bits);
        table[at + 1] = shift_round(sum_y, header.table_bits);
        at += 2;
        let base_x = header.start_x + displacement(header, profile.coarse, rest_x);
        let base_y = header.start_y + displacement(header, profile.coarse, rest_y);
        let (cosine_q14, sine_q14) = (shift_round(cosine, 6), shift_round(sine, 6));
        for disc in &problem.discs {
            let x = shift_round(disc.x * cosine_q14 - disc.y * sine_q14, 14);
            let y = shift_round(disc.x * sine_q14 + disc.y * cosine_q14, 14);
            table[at] = base_x + x;
            table[at + 1] = base_y + y;
            at += 2;
        }
    }
    table[at] = sum_x;
    table[at + 1] = sum_y;
    table[at + 2] = shift_round(mul_hi_i32(profile.fine, rest_x), header.fine_bits);
    table[at + 3] = shift_round(mul_hi_i32(profile.fine, rest_y), header.fine_bits);
}

/// Displacement in units of a coarse speed over a sum of cosines.
#[must_use]
pub fn displacement(header: &Header, coarse: i32, sum: i32) -> i32 {
    shift_round(coarse * shift_round(sum, header.table_bits), header.coarse_bits)
}

/// The result of one step.
pub struct StepResult {
    /// Smallest clearance of any disc, units, at most the cap.
    pub clearance: i32,
    /// Whether a disc's centre is off the field, unless cells outside are free.
    pub outside: bool,
    /// Lower bound of the clearance, without the cap and the motion of obstacles, units; zero when unknown.
    pub static_clearance: i32,
    /// Lower bound of the distance from any disc's centre to the border of the field, units, unless cells outside are
    /// free.
    pub border: i32,
}

/// Bound of the rate of change of a sample's clearance: the sum of the speeds of a disc's centre and of an obstacle.
pub struct ClearanceRate {
    /// Largest contribution of cells and rounding to a change, units.
    pub margin: i32,
    /// Smallest number of steps for a change of one unit, 2^-16 step.
    pub steps_per_unit: u32,
}

/// Returns the status of a sample and its clearance in units.
///
/// Steps that cannot change the result are skipped. [`Stopping::Arc`](super::Stopping) needs the first step that ends
/// the trajectory, so it starts at the first step. Otherwise the evaluation starts at the last step: most samples that
/// collide do so near the end, and a small clearance found early lets it skip many steps.
#[must_use]
pub fn evaluate_sample(
    problem: &QuantizedProblem,
    vx: &VxSample,
    profile: &TurnProfile,
    table: &[i32],
) -> (SampleStatus, u32) {
    let header = &problem.header;
    let by_arc = header.stop_by_arc == 1;
    let rate = clearance_rate(problem, vx, profile);
    let mut min_clearance = header.max_clearance as i32;
    let mut done = 0;
    let mut ended_by = SampleStatus::Ok;
    while done < header.steps {
        let step = if by_arc { done } else { header.steps - 1 - done };
        let step_result = step_clearance(problem, vx, table, step);
        if step_result.clearance <= 0 {
            ended_by = SampleStatus::Collision;
            break;
        }
        if step_result.outside {
            ended_by = SampleStatus::Outside;
            if by_arc {
                break;
            }
        }
        min_clearance = min_clearance.min(step_result.clearance);
        done += 1 + skippable_steps(&rate, &step_result, min_clearance);
    }
    let free_steps = done.min(header.steps);
    let status = classify(header, vx, profile, ended_by, free_steps, min_clearance);
    (status, if status == SampleStatus::Ok { min_clearance as u32 } else { 0 })
}

/// The status of a sample from what ended it, its free steps and its smallest clearance.
#[must_use]
pub fn classify(
    header: &Header,
    vx: &VxSample,
    profile: &TurnProfile,
    ended_by: SampleStatus,
    free_steps: u32,
    min_clearance: i32,
) -> SampleStatus {
    let available = if header.stop_by_arc == 1 { free_steps } else { min_clearance as u32 };
    let ends_trajectory = header.stop_by_arc == 0 || free_steps == 0;
    if ended_by != SampleStatus::Ok && ends_trajectory {
        return ended_by;
    }
    if available < vx.stopping_need || available < profile.stopping_need {
        SampleStatus::CannotStop
    } else {
        SampleStatus::Ok
    }
}

/// Bounds the change of the clearance of a sample in one step.
#[must_use]
pub fn clearance_rate(
    problem: &QuantizedProblem,
    vx: &VxSample,
    profile: &TurnProfile,
) -> ClearanceRate {
    let header = &problem.header;
    let mut lever_arm = 0;
    for disc in &problem.discs {
        lever_arm = lever_arm.max(disc.x.unsigned_abs() + disc.y.unsigned_abs());
    }
    let mut obstacle_step = 0;
    for body in &problem.obstacles {
        obstacle_step = obstacle_step.max(body.step_x.unsigned_abs() + body.step_y.unsigned_abs());
    }
    // Units per step, rounded down, so each gets one more unit: the length of a Q20 displacement is at most one, and a
    // turn of half a binary circle is pi, less than 7/2.
    let fastest = vx.coarse.unsigned_abs().max(profile.coarse.unsigned_abs());
    let along = (fastest * (ONE_Q20 as u32 >> header.table_bits)) >> header.coarse_bits;
    let around = mul_hi_u32(7 * lever_arm, profile.max_turn);
    let max_change = along + around + (obstacle_step >> 8) + 4;
    // Two positions in cells can be farther apart than the positions themselves, by up to a cell's diagonal, 1449/1024
    // of a side. A coarse displacement is rounded to 1/64 step or finer, twice along x and y: 1/32 covers that. All
    // other roundings, of positions, discs, obstacles and distances, stay below 16 units.
    // The position of a profile with its own speed has one more coarse displacement.
    let displacements = header.segment_count.min(2);
    let margin = ((1449 << header.cell_bits) >> 10) + (max_change >> (6 - displacements)) + 16;
    ClearanceRate { margin: margin as i32, steps_per_unit: 65_536 / max_change }
}

/// The number of steps after the evaluated one that can neither lower the clearance below `min_clearance`, which is
/// above zero, nor leave the field.
#[must_use]
pub fn skippable_steps(rate: &ClearanceRate, step_result: &StepResult, min_clearance: i32) -> u32 {
    let slack =
        (step_result.static_clearance - min_clearance).min(step_result.border) - rate.margin;
    (slack.max(0) as u32 * rate.steps_per_unit) >> 16
}

/// Evaluates one step of a sample.
#[must_use]
pub fn step_clearance(
    problem: &QuantizedProblem,
    vx: &VxSample,
    table: &[i32],
    step: u32,
) -> StepResult {
    let header = &problem.header;
    let mut at = (step * step_words(header)) as usize;
    let moved_x = shift_round(vx.coarse * table[at], header.coarse_bits);
    let moved_y = shift_round(vx.coarse * table[at + 1], header.coarse_bits);
    let mut result = StepResult {
        clearance: header.max_clearance as i32,
        outside: false,
        static_clearance: 65_535,
        border: 65_535,
    };
    for disc in &problem.discs {
        at += 2;
        let x = table[at] + moved_x;
        let y = table[at + 1] + moved_y;
        if let Some(distance) = clearance_at(header, &problem.field, x, y) {
            result.clearance = result.clearance.min(distance - disc.radius);
            result.static_clearance = result.static_clearance.min(distance - disc.radius);
        } else {
            result.outside |= header.outside_is_free == 0;
            result.static_clearance = 0;
        }
        if header.outside_is_free == 0 {
            result.border = result.border.min(border_distance(header, x, y));
        }
        for body in &problem.obstacles {
            let reach = result.clearance + disc.radius + body.radius;
            let distance = capped_distance(header, body, x, y, step, reach);
            result.clearance = result.clearance.min(distance - disc.radius - body.radius);
        }
    }
    if header.obstacle_count > 0 {
        result.static_clearance = result.static_clearance.min(result.clearance);
    }
    result
}

/// Distance to the nearest static obstacle at a position in units from the field's corner; `None` off the field.
fn clearance_at(header: &Header, field: &ClearanceField, x: i32, y: i32) -> Option<i32> {
    let column = (x >> header.cell_bits) as u32;
    let row = (y >> header.cell_bits) as u32;
    (column < header.width && row < header.height)
        .then(|| i32::from(field.units()[(row * header.width + column) as usize]))
}

/// Lower bound of the distance from a position to the border of the field, units: counts whole cells; zero off the
/// field.
fn border_distance(header: &Header, x: i32, y: i32) -> i32 {
    let column = x >> header.cell_bits;
    let row = y >> header.cell_bits;
    let across = column.min(header.width as i32 - 1 - column);
    let along = row.min(header.height as i32 - 1 - row);
    across.min(along).clamp(0, 65_535 >> header.cell_bits) << header.cell_bits
}

/// Distance to the centre of a moving obstacle, units, capped at `reach`. The cap avoids the square root where it
/// cannot matter. A `reach` that is not above zero is returned unchanged.
fn capped_distance(
    header: &Header,
    body: &QuantizedObstacle,
    x: i32,
    y: i32,
    step: u32,
    reach: i32,
) -> i32 {
    let steps = step as i32 + 1;
    let body_x = shift_round(body.x + steps * body.step_x, 8);
    let body_y = shift_round(body.y + steps * body.step_y, 8);
    // Two squares of this bound fit in a u32; `reach` never exceeds it.
    let across = (x - header.start_x - body_x).clamp(-46_340, 46_340);
    let along = (y - header.start_y - body_y).clamp(-46_340, 46_340);
    let squared = (across * across) as u32 + (along * along) as u32;
    if reach > 0 && squared < (reach * reach) as u32 { isqrt32(squared) as i32 } else { reach }
}

/// Final position relative to the start, fine units, along x and y.
#[must_use]
pub fn end_position(header: &Header, vx: &VxSample, table: &[i32]) -> (i32, i32) {
    let at = (header.steps * step_words(header)) as usize;
    (
        shift_round(mul_hi_i32(vx.fine, table[at]), header.fine_bits) + table[at + 2],
        shift_round(mul_hi_i32(vx.fine, table[at + 1]), header.fine_bits) + table[at + 3],
    )
}

/// Final heading, binary angle.
#[must_use]
pub const fn end_heading(header: &Header, profile: &TurnProfile) -> u32 {
    header.heading.wrapping_add(profile.end_turn)
}
