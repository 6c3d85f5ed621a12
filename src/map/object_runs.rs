//! Runs of neighbouring returns of a scan that belong to one object.

use core::ops::Range;

/// Splits the returns of a scan, in the order of their beams, into runs: each return of a run belongs to the same object as the next
/// one. In a full turn the first return follows the last, so the first run may begin at the end of the list and continue at its
/// beginning, at index `count`.
pub(crate) fn object_runs(
    count: usize,
    is_full_turn: bool,
    belongs_to_next: impl Fn(usize) -> bool,
) -> impl Iterator<Item = Range<usize>> {
    let spans_seam = is_full_turn && count > 0 && belongs_to_next(count - 1);
    let before_seam = (1..count).rev().find(|&index| spans_seam && !belongs_to_next(index - 1));
    let begin = before_seam.unwrap_or(0);
    let all = begin + count;
    let is_end = move |&end: &usize| end == all || !belongs_to_next((end - 1) % count);
    (begin + 1..=all).filter(is_end).scan(begin, move |from, end| {
        let first = *from % count;
        let run = first..first + (end - *from);
        *from = end;
        Some(run)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The runs of these marks: equal neighbours belong together.
    fn runs(marks: &str, is_full_turn: bool) -> Vec<Range<usize>> {
        let marks = marks.as_bytes();
        let belongs_to_next = |index: usize| marks[index] == marks[(index + 1) % marks.len()];
        object_runs(marks.len(), is_full_turn, belongs_to_next).collect()
    }

    #[test]
    fn run_across_the_first_beam_of_a_full_turn_is_one() {
        assert_eq!(runs("aabca", true), [4..7, 2..3, 3..4]);
        assert_eq!(runs("aabca", false), [0..2, 2..3, 3..4, 4..5]);
        assert_eq!(runs("aabc", true), [0..2, 2..3, 3..4]);
    }

    #[test]
    fn one_object_all_around_is_one_run_and_no_return_is_none() {
        assert_eq!([runs("aaa", true), runs("aaa", false)].concat(), [0..3, 0..3]);
        assert!(runs("", true).is_empty());
    }
}
