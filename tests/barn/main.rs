//! The BARN benchmark: its worlds, its rules, and the file that a campaign of runs goes on from.

use std::process::ExitCode;

use libtest_mimic::{Arguments, Trial};

mod driving;
mod dynabarn;
mod files;
mod ground;
mod ledger;
mod moving_drives;
mod public;
mod scoring;

/// A test by its name.
type Test = (&'static str, fn());

fn main() -> ExitCode {
    let tests = [
        driving::TESTS,
        dynabarn::TESTS,
        files::TESTS,
        ground::TESTS,
        ledger::TESTS,
        moving_drives::TESTS,
        scoring::TESTS,
    ];
    let mut trials: Vec<Trial> = tests.into_iter().flatten().map(trial).collect();
    trials.push(public::trial());
    trials.push(dynabarn::trial());
    trials.push(moving_drives::trial());
    libtest_mimic::run(&Arguments::from_args(), trials).exit_code()
}

fn trial(&(name, test): &Test) -> Trial {
    Trial::test(name, move || {
        test();
        Ok(())
    })
}
