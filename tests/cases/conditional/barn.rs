//! The BARN and DynaBARN benchmarks: their worlds, rules and records.

use libtest_mimic::Trial;

mod driving;
mod dynabarn;
mod files;
mod ground;
mod moving_drives;
mod public;
mod records;
mod scoring;

use crate::support::trials::{Test, plain};

pub fn trials() -> Vec<Trial> {
    let mut trials = plain([
        driving::TESTS,
        dynabarn::TESTS,
        files::TESTS,
        ground::TESTS,
        moving_drives::TESTS,
        records::TESTS,
        scoring::TESTS,
    ]);
    trials.push(public::trial());
    trials.push(dynabarn::trial());
    trials.push(moving_drives::trial());
    trials
}
