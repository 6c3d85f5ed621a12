//! One sample after the other, with the twins of the shaders: the reference for the kernels in lanes.

use super::course::Course;
use super::row::REASON_BITS;
use super::tally::Tally;
use crate::local::inputs::Turn;
use crate::local::{Prepared, Reason, rollout, score, select};

/// Judges every sample of a turn rate. `table` is room for it; for `samples` see [`super::row::judge_row`].
pub fn judge_row(
    problem: &Prepared,
    course: &Course,
    turn: &Turn,
    table: &mut Vec<i32>,
    samples: &mut [i32],
) -> Tally {
    let header = &problem.header;
    table.resize(rollout::table_words(header), 0);
    rollout::tabulate(header, turn, &problem.discs, table);
    let end_heading = rollout::end_heading(header, turn);
    let mut tally = Tally::default();
    for (index, speed) in problem.speeds.iter().enumerate() {
        let (reason, clearance) = rollout::judge(problem, speed, turn, table);
        select::count(&mut tally.counts, reason);
        let mut words = [(reason as i32) << REASON_BITS, 0, 0];
        if reason == Reason::Ok {
            let end = rollout::end_position(header, speed, table);
            let terms = score::terms(header, speed, end_heading, end, clearance);
            select::gather(&mut tally.totals, terms.to_array());
            words = [
                terms.heading as i32,
                terms.clearance as i32,
                terms.path as i32,
            ];
        }
        for (column, word) in words.into_iter().enumerate() {
            samples[column * course.stride + index] = word;
        }
    }
    tally
}
