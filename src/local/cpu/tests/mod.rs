//! Compares every lane operation of every available instruction set with scalar arithmetic, bit for bit.

mod cases;
mod lookups;
mod operations;
mod reductions;
mod step_pruning;

use std::fmt::Write;

use super::lanes::{Lanes, MAX_LANES, Portable};
use cases::{Case, Group, Shared, groups};
use operations::{Operation, Way, operations};

/// Seed of the random cases.
const SEED: u64 = 37;

/// Number of differences reported per operation.
const MAX_REPORTED: usize = 4;

/// Expected and actual result of one vector of an operation.
struct Outcome<'a> {
    cases: &'a [Case],
    shared: &'a Shared,
    expected: Vec<i32>,
    found: Vec<i32>,
}

fn outcome<'a, L: Lanes>(
    token: L::FeatureToken,
    operation: &Operation<L>,
    cases: &'a [Case],
    shared: &'a Shared,
) -> Outcome<'a> {
    let column = |place: usize| {
        let values: Vec<i32> = cases.iter().map(|case| case[place]).collect();
        L::load(token, &values)
    };
    let (x, y) = (column(0), column(1));
    let (expected, found) = match operation.way {
        Way::Each(lanes, plain) => (
            cases.iter().map(|&[x, y]| plain(x, y, shared)).collect(),
            lanes(token, x, y, shared).to_array()[..L::COUNT].to_vec(),
        ),
        Way::Whole(lanes, plain) => (plain(cases, shared), lanes(token, x, y, shared)),
    };
    Outcome { cases, shared, expected, found }
}

/// Describes how an operation differs from scalar arithmetic: the number of differences and the first few in
/// hexadecimal. On demand it flips one bit of one vector first.
fn differences<L: Lanes>(
    token: L::FeatureToken,
    operation: &Operation<L>,
    groups: &[Group],
    flip_vector: Option<usize>,
) -> Option<String> {
    let (mut differing, mut all, mut messages) = (0, 0, String::new());
    let mut vector = 0;
    for group in groups {
        let shared = &group.shared;
        let fitted = group.cases.map(|case| (operation.fit)(case, shared));
        for cases in fitted.chunks_exact(L::COUNT) {
            let mut outcome = outcome(token, operation, cases, shared);
            if flip_vector == Some(vector) {
                outcome.found[0] ^= 1 << 31;
            }
            let wrong = differing_indices(&outcome);
            for place in wrong {
                if differing < MAX_REPORTED {
                    report(&outcome, &operation.way, place, &mut messages);
                }
                differing += 1;
            }
            all += outcome.expected.len();
            vector += 1;
        }
    }
    let name = operation.name;
    (differing > 0).then(|| format!("{name}: {differing} of {all} differ:{messages}"))
}

/// Indices at which the lists differ, also by length.
fn differing_indices(outcome: &Outcome<'_>) -> Vec<usize> {
    let Outcome { expected, found, .. } = outcome;
    (0..expected.len().max(found.len()))
        .filter(|&place| expected.get(place) != found.get(place))
        .collect()
}

fn report<L: Lanes>(outcome: &Outcome<'_>, way: &Way<L>, place: usize, messages: &mut String) {
    let Outcome { cases, shared, expected, found } = outcome;
    let written = match way {
        Way::Each(..) => write!(
            messages,
            "\n  {:x?}, {shared:x?} gives {:x}, not {:x}",
            cases[place], found[place], expected[place]
        ),
        Way::Whole(..) => {
            write!(messages, "\n  {cases:x?}, {shared:x?} gives {found:x?}, not {expected:x?}")
        }
    };
    written.expect("a string accepts all text");
}

/// Asserts that no operation differs.
fn assert_equal_scalar<L: Lanes>(token: L::FeatureToken) {
    let groups = groups(SEED);
    let wrong: Vec<String> = operations::<L>()
        .iter()
        .filter_map(|operation| differences(token, operation, &groups, None))
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn portable_lanes_equal_scalar_arithmetic() {
    assert_equal_scalar::<Portable>(());
}

#[cfg(target_arch = "x86_64")]
#[test]
fn avx2_lanes_equal_scalar_arithmetic() {
    match super::lanes::Avx2::detect() {
        Some(token) => assert_equal_scalar::<super::lanes::Avx2>(token),
        None => report_untested("AVX2"),
    }
}

#[cfg(target_arch = "x86_64")]
#[test]
fn avx512_lanes_equal_scalar_arithmetic() {
    match super::lanes::Avx512::detect() {
        Some(token) => assert_equal_scalar::<super::lanes::Avx512>(token),
        None => report_untested("AVX-512 F, BW and CD"),
    }
}

/// Bypasses the test harness, which captures the output of a passing test.
#[cfg(target_arch = "x86_64")]
fn report_untested(instructions: &str) {
    use std::io::Write as _;
    let line = format!("\nNOT TESTED: this processor lacks {instructions}\n");
    let written = std::io::stderr().write_all(line.as_bytes());
    written.expect("standard error accepts a line");
}

#[test]
fn one_flipped_bit_is_reported_for_every_operation() {
    let groups = groups(SEED);
    for operation in operations::<Portable>() {
        let quiet = differences::<Portable>((), &operation, &groups, None);
        assert_eq!(quiet, None, "nothing was flipped");
        let loud = differences::<Portable>((), &operation, &groups, Some(777));
        let start = format!("{}: 1 of ", operation.name);
        assert!(
            loud.as_ref().is_some_and(|loud| loud.starts_with(&start)),
            "{}: a flipped bit was reported as {loud:?}",
            operation.name
        );
    }
}

#[test]
fn groups_fill_whole_vectors_of_every_instruction_set() {
    assert_eq!(MAX_LANES % Portable::COUNT, 0);
    #[cfg(target_arch = "x86_64")]
    for count in [super::lanes::Avx2::COUNT, super::lanes::Avx512::COUNT] {
        assert_eq!(MAX_LANES % count, 0);
    }
}
