//! The BARN benchmark: its worlds, its rules, and the file that a campaign of runs goes on from.

use libtest_mimic::Trial;

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

pub fn trials() -> Vec<Trial> {
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
    trials
}

fn trial(&(name, test): &Test) -> Trial {
    Trial::test(name, move || {
        test();
        Ok(())
    })
}
