//! One sample's trajectory and what it meets. TWIN of `shaders/rollout.wgsl`: same names, same order, same bits.
//!
//! With the paper's motion model (eq. 27) the heading at a step does not depend on the speed, so the position is
//! linear in it: `x_k = x_0 + v C(omega, k)` with `C` the sum of the cosines so far. One table for each turn rate
//! serves all speeds, and a pose costs two multiplications.

use super::inputs::{BodyDisc, Header, MovingBody, Speed, Turn};
use super::{ClearanceField, Prepared, Reason};
use crate::numeric::{cos_q20, isqrt32, mul_hi_i32, shift_round, sin_q20};

/// Words of the table of one turn rate: for each step the coarse displacement (2) and each disc's centre for a robot
/// that did not move (2 each), then the sums of cosines and sines in Q20 (2).
#[must_use]
pub const fn table_words(header: &Header) -> usize {
    (header.steps * step_words(header) + 2) as usize
}

/// Words of one step in the table.
#[must_use]
pub const fn step_words(header: &Header) -> u32 {
    2 + 2 * header.disc_count
}

/// Fills the table of one turn rate.
pub fn tabulate(header: &Header, turn: &Turn, discs: &[BodyDisc], table: &mut [i32]) {
    let mut angle = header.heading;
    let mut cosine = cos_q20(angle);
    let mut sine = sin_q20(angle);
    let (mut sum_x, mut sum_y) = (0_i32, 0_i32);
    let mut at = 0;
    for _ in 0..header.steps {
        // The pose moves along the old heading, then turns (eq. 27).
        sum_x += cosine;
        sum_y += sine;
        angle = angle.wrapping_add(turn.per_step);
        cosine = cos_q20(angle);
        sine = sin_q20(angle);
        table[at] = shift_round(sum_x, header.table_bits);
        table[at + 1] = shift_round(sum_y, header.table_bits);
        at += 2;
        let (cosine_q14, sine_q14) = (shift_round(cosine, 6), shift_round(sine, 6));
        for disc in discs {
            let x = shift_round(disc.x * cosine_q14 - disc.y * sine_q14, 14);
            let y = shift_round(disc.x * sine_q14 + disc.y * cosine_q14, 14);
            table[at] = header.start_x + x;
            table[at + 1] = header.start_y + y;
            at += 2;
        }
    }
    table[at] = sum_x;
    table[at + 1] = sum_y;
}

/// What one step meets.
struct StepResult {
    /// Smallest clearance of any disc, units, at most the cap.
    clearance: i32,
    /// Whether a disc's centre is off the field, and that matters.
    outside: bool,
}

/// Whether a sample is admissible, and its clearance in units.
#[must_use]
pub fn judge(problem: &Prepared, speed: &Speed, turn: &Turn, table: &[i32]) -> (Reason, u32) {
    let header = &problem.header;
    let mut least = header.max_clearance as i32;
    let mut free_steps = 0;
    let mut ended_by = Reason::Ok;
    for step in 0..header.steps {
        let met = step_clearance(problem, speed, table, step);
        if met.clearance <= 0 {
            ended_by = Reason::Collision;
            break;
        }
        if met.outside {
            ended_by = Reason::Outside;
            if header.stop_by_arc == 1 {
                break;
            }
        }
        least = least.min(met.clearance);
        free_steps += 1;
    }
    let reason = verdict(header, speed, turn, ended_by, free_steps, least);
    (
        reason,
        if reason == Reason::Ok {
            least as u32
        } else {
            0
        },
    )
}

fn verdict(
    header: &Header,
    speed: &Speed,
    turn: &Turn,
    ended_by: Reason,
    free_steps: u32,
    least: i32,
) -> Reason {
    let has = if header.stop_by_arc == 1 {
        free_steps
    } else {
        least as u32
    };
    let ends_it = header.stop_by_arc == 0 || free_steps == 0;
    if ended_by != Reason::Ok && ends_it {
        return ended_by;
    }
    if has < speed.needs || has < turn.needs {
        Reason::CannotStop
    } else {
        Reason::Ok
    }
}

fn step_clearance(problem: &Prepared, speed: &Speed, table: &[i32], step: u32) -> StepResult {
    let header = &problem.header;
    let mut at = (step * step_words(header)) as usize;
    let moved_x = shift_round(speed.coarse * table[at], header.coarse_bits);
    let moved_y = shift_round(speed.coarse * table[at + 1], header.coarse_bits);
    let mut result = StepResult {
        clearance: header.max_clearance as i32,
        outside: false,
    };
    for disc in &problem.discs {
        at += 2;
        let x = table[at] + moved_x;
        let y = table[at + 1] + moved_y;
        match clearance_at(header, &problem.field, x, y) {
            Some(distance) => result.clearance = result.clearance.min(distance - disc.radius),
            None => result.outside |= header.outside_is_free == 0,
        }
        for body in &problem.obstacles {
            let reach = result.clearance + disc.radius + body.radius;
            let distance = distance_below(header, body, x, y, step, reach);
            result.clearance = result.clearance.min(distance - disc.radius - body.radius);
        }
    }
    result
}

/// Distance to the nearest static obstacle at a position in units from the field's corner; none off the field.
fn clearance_at(header: &Header, field: &ClearanceField, x: i32, y: i32) -> Option<i32> {
    let column = (x >> header.cell_bits) as u32;
    let row = (y >> header.cell_bits) as u32;
    (column < header.width && row < header.height)
        .then(|| i32::from(field.units()[(row * header.width + column) as usize]))
}

/// Distance to a moving obstacle's centre, units, where it is below `reach`; `reach` where it is not, so that the
/// square root is taken only when it can matter. A `reach` not above zero is returned as it is.
fn distance_below(
    header: &Header,
    body: &MovingBody,
    x: i32,
    y: i32,
    step: u32,
    reach: i32,
) -> i32 {
    let steps = step as i32 + 1;
    let body_x = shift_round(body.x + steps * body.step_x, 8);
    let body_y = shift_round(body.y + steps * body.step_y, 8);
    // Two squares of this bound still fit in a u32; a reach is never beyond it.
    let across = (x - header.start_x - body_x).clamp(-46_340, 46_340);
    let along = (y - header.start_y - body_y).clamp(-46_340, 46_340);
    let squared = (across * across) as u32 + (along * along) as u32;
    if reach > 0 && squared < (reach * reach) as u32 {
        isqrt32(squared) as i32
    } else {
        reach
    }
}

/// Final position from the start, fine units, along x and y.
#[must_use]
pub fn end_position(header: &Header, speed: &Speed, table: &[i32]) -> (i32, i32) {
    let at = (header.steps * step_words(header)) as usize;
    (
        shift_round(mul_hi_i32(speed.fine, table[at]), header.fine_bits),
        shift_round(mul_hi_i32(speed.fine, table[at + 1]), header.fine_bits),
    )
}

/// Final heading, binary angle.
#[must_use]
pub const fn end_heading(header: &Header, turn: &Turn) -> u32 {
    header
        .heading
        .wrapping_add(turn.per_step.wrapping_mul(header.steps))
}
