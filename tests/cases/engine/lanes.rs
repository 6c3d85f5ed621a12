//! Compares every lane operation of every available instruction set with scalar arithmetic, bit for bit.

mod cases;
mod lookups;
mod operations;
mod reductions;

use std::fmt::Write;

use cases::{Case, Group, Shared, groups};
use inbye::local::InstructionSet;
use inbye::local::internals::lanes::{LaneTask, Lanes, MAX_LANES};
use operations::{Operation, Way, operations, stored};

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
            stored(lanes(token, x, y, shared)),
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

/// The instruction sets with lanes.
const WITH_LANES: [InstructionSet; 4] =
    [InstructionSet::Portable, InstructionSet::Neon, InstructionSet::Avx2, InstructionSet::Avx512];

/// Describes all operations that differ from scalar arithmetic.
struct DifferencesOfAll;

impl LaneTask for DifferencesOfAll {
    type Output = Vec<String>;

    #[inline(always)]
    fn run<L: Lanes>(self, token: L::FeatureToken) -> Vec<String> {
        let groups = groups(SEED);
        operations::<L>()
            .iter()
            .filter_map(|operation| differences(token, operation, &groups, None))
            .collect()
    }
}

#[test]
fn lanes_of_every_instruction_set_equal_scalar_arithmetic() {
    for instructions in WITH_LANES {
        match instructions.run(DifferencesOfAll) {
            Some(wrong) => assert!(wrong.is_empty(), "{instructions:?}: {}", wrong.join("\n")),
            None => report_untested(instructions.name()),
        }
    }
}

/// Bypasses the test harness, which captures the output of a passing test.
fn report_untested(instructions: &str) {
    use std::io::Write as _;
    let line = format!("\nNOT TESTED: this processor lacks {instructions}\n");
    let written = std::io::stderr().write_all(line.as_bytes());
    written.expect("standard error accepts a line");
}

/// Describes each operation without and with a flipped bit.
struct FlippedBits;

impl LaneTask for FlippedBits {
    type Output = Vec<(&'static str, Option<String>, Option<String>)>;

    #[inline(always)]
    fn run<L: Lanes>(self, token: L::FeatureToken) -> Self::Output {
        let groups = groups(SEED);
        let both = |operation: Operation<L>| {
            let quiet = differences(token, &operation, &groups, None);
            (operation.name, quiet, differences(token, &operation, &groups, Some(777)))
        };
        operations::<L>().into_iter().map(both).collect()
    }
}

#[test]
fn one_flipped_bit_is_reported_for_every_operation() {
    let portable = InstructionSet::Portable.run(FlippedBits);
    for (name, quiet, loud) in portable.expect("every processor has portable lanes") {
        assert_eq!(quiet, None, "nothing was flipped");
        let start = format!("{name}: 1 of ");
        assert!(
            loud.as_ref().is_some_and(|loud| loud.starts_with(&start)),
            "{name}: a flipped bit was reported as {loud:?}"
        );
    }
}

/// Counts the lanes.
struct Count;

impl LaneTask for Count {
    type Output = usize;

    #[inline(always)]
    fn run<L: Lanes>(self, _: L::FeatureToken) -> usize {
        L::COUNT
    }
}

#[test]
fn groups_fill_whole_vectors_of_every_instruction_set() {
    for count in WITH_LANES.into_iter().filter_map(|one| one.run(Count)) {
        assert_eq!(MAX_LANES % count, 0);
    }
}
