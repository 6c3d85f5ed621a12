//! Operations that reduce all lanes to one number.

use super::operations::{Operation, any, stored, whole};
use inbye::local::internals::lanes::Lanes;

pub fn reductions<L: Lanes>() -> Vec<Operation<L>> {
    vec![
        whole(
            "least",
            any,
            |_, x, _, _| vec![x.reduce_min()],
            |cases, _| vec![cases.iter().map(|case| case[0]).fold(i32::MAX, i32::min)],
        ),
        whole(
            "greatest",
            any,
            |_, x, _, _| vec![x.reduce_max()],
            |cases, _| vec![cases.iter().map(|case| case[0]).fold(i32::MIN, i32::max)],
        ),
        whole(
            "reduce_sum_unsigned",
            any,
            |_, x, _, _| halves(x.reduce_sum_unsigned()),
            |cases, _| halves(cases.iter().map(|case| u64::from(case[0] as u32)).sum()),
        ),
        whole(
            "prefix_sums",
            any,
            |_, x, _, _| stored(x.prefix_sums()),
            |cases, _| {
                let sums = cases.iter().scan(0_i32, |sum, case| {
                    *sum = sum.wrapping_add(case[0]);
                    Some(*sum)
                });
                sums.collect()
            },
        ),
        whole(
            "last",
            any,
            |_, x, _, _| vec![x.last()],
            |cases, _| cases.iter().map(|case| case[0]).next_back().into_iter().collect(),
        ),
    ]
}

/// Lower half and upper half.
fn halves(word: u64) -> Vec<i32> {
    vec![word as i32, (word >> 32) as i32]
}
